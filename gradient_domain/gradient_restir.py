"""Gradient with ReSTIR: pairs of paths are reused together, over frames and edges."""

from collections.abc import Iterator

import numpy as np

from extensions.area_donor import AreaShift
from extensions.area_restir import area_drawn, area_reused
from extensions.frame_loop import Moment, path_frames
from extensions.windows import Window, resample_past
from gradient_domain.candidates import choose_pair, paired
from gradient_domain.edges import across_edges, looks
from gradient_domain.frame import (
    BySign,
    GradientFrame,
    estimate,
    gradient_frame,
    inner_shift,
)
from gradient_domain.motion import pair_windows
from gradient_domain.pair_donor import PairDonor
from gradient_domain.paired_domain import MINUS, PLUS, WHOLE, target
from gradient_domain.pairs import Pairs, pixel_pairs
from gradient_domain.search import draw_around, find_alike
from gradient_domain.settings import GradientSettings
from gradient_domain.shifts import OuterShift
from reference.arrays import Indices, Masks, Scalars
from reference.records import NONE, cut, put, take
from reference.resampling.generalized import resample
from reference.resampling.reservoir import Reservoirs
from reference.rng import Stream, Uniforms
from reference.scene.animation import Animation
from reference.schedule import Schedule, in_bands
from reference.world import World


def render_gradient_frames(
    world: World,
    settings: GradientSettings,
    bounces: int,
    seed: int,
    schedule: Schedule,
    animation: Animation | None = None,
) -> Iterator[GradientFrame]:
    """Frames of pixels by Area ReSTIR and of differences by ReSTIR, without end.

    [Wang25, sections 4.2 to 4.4].

    Pixels and differences begin with the same new paths.

    Parameters
    ----------
    world : World; the scene in frame 0
    bounces : int; bounces of indirect light, 1 to 30
    seed : int; runs of different seeds are independent
    schedule : Schedule; bands and threads; no influence on the result
    """
    return path_frames(_frame, world, settings, bounces, seed, schedule, animation)


def _frame(
    moment: Moment, last: GradientFrame | None, schedule: Schedule
) -> GradientFrame:
    camera, s = moment.world.camera, settings_of(moment)
    pairs = pixel_pairs(camera.width, camera.height)
    drawn = in_bands(schedule, moment.pixels, lambda r: area_drawn(moment, r))
    primal = area_reused(moment, last, lambda r: cut(drawn, r), schedule)
    past = last if s.temporal else None
    held = in_bands(
        schedule, len(pairs), lambda r: _temporal(moment, past, pairs, drawn, r)
    )
    if s.spatial and s.around != "none":
        # Every pair's reservoirs are complete before another one reads them.
        fresh, across = held, across_edges(looks(moment.visible), pairs)
        around = in_bands(
            schedule, len(pairs), lambda r: _around(moment, pairs, across, r)
        )
        held = in_bands(
            schedule, len(pairs), lambda r: _spatial(moment, pairs, around, fresh, r)
        )
    return gradient_frame(moment, primal, pairs, estimate(held.parts), held)


def settings_of(moment: Moment) -> GradientSettings:
    """Settings of a moment of this method."""
    assert isinstance(moment.settings, GradientSettings)
    return moment.settings


def _signs(s: GradientSettings) -> tuple[int, ...]:
    return (WHOLE,) if s.signs == "without" else (PLUS, MINUS)


def _by_sign(found: list[Reservoirs]) -> BySign:
    return BySign(found[0], found[1] if len(found) > 1 else None)


def _lenders(s: GradientSettings, sign: int) -> tuple[int, ...]:
    """Signs of the reservoirs of other pairs that one of a sign asks, its own first."""
    return (sign, -sign) if s.signs == "across" else (sign,)


# ------------------------------------------------------------------ the last frame


def _temporal(
    moment: Moment,
    last: GradientFrame | None,
    pairs: Pairs,
    drawn: Reservoirs,
    rows: slice,
) -> BySign:
    s, some = settings_of(moment), cut(pairs, rows)
    inner = inner_shift(moment, moment.world)
    both = [paired(inner, drawn, some, k, WHOLE) for k in (0, 1)]
    uniforms = moment.uniforms(rows, Stream.PAIRS)
    choices = uniforms.draw(0)
    past = [] if last is None else pair_windows(last, moment, some)
    found = []
    for slot, sign in enumerate(_signs(s)):
        new = choose_pair(both, sign, choices[slot])
        if last is not None:
            decisions = _numbers(uniforms, 1 + 3 * slot, 9)
            new = _with_past(moment, last, pairs, rows, sign, past, new, decisions)
        found.append(new)
    return _by_sign(found)


def _with_past(
    moment: Moment,
    last: GradientFrame,
    pairs: Pairs,
    rows: slice,
    sign: int,
    past: list[Window],
    new: Reservoirs,
    decisions: list[Scalars],
) -> Reservoirs:
    s, some = settings_of(moment), cut(pairs, rows)
    assert last.pairs is not None
    inner, inner_then = (inner_shift(moment, w) for w in (moment.world, last.world))
    between = AreaShift(moment.shift, s.primary, last.world, moment.world)
    forward, backward = OuterShift(between, inner), OuterShift(between.back, inner_then)
    stands = last.world is moment.world
    own = _own(moment, some, new, sign)
    before, shares = [], []
    for lender in _lenders(s, sign):
        # What the same pair holds of the other sign has that sign here as well.
        if lender != sign and stands:
            continue
        lent = last.pairs.of(lender)
        for part in past:
            way = some, pairs, lent, part.rows, part.dx, part.dy, sign, lender, stands
            before.append(PairDonor(forward, backward, *way))
            # It is one past, however many reservoirs know of it.
            shares.append(part.share if lender == sign else 0.0 * part.share)
    decisions = decisions[: len(before) + 1]
    return resample_past(own, before, shares, decisions, s, target)


# ------------------------------------------------------------------ pairs around


def _spatial(
    moment: Moment, pairs: Pairs, around: Indices, fresh: BySign, rows: slice
) -> BySign:
    # Most pairs ask nobody, and keep what they have.
    at = rows.start + np.flatnonzero(around[rows] != NONE)
    s, some, row = settings_of(moment), take(pairs, at), around[at]
    inner, width = inner_shift(moment, moment.world), moment.world.camera.width
    outer, from_row = OuterShift(inner.within, inner), pairs.first[row]
    dx = (some.first % width - from_row % width).astype(float)
    dy = (some.first // width - from_row // width).astype(float)
    uniforms = moment.uniforms(rows, Stream.PAIRS_AROUND).rows(at - rows.start)
    found = []
    for slot, sign in enumerate(_signs(s)):
        held = fresh.of(sign)
        donors = [_own(moment, some, take(held, at), sign)]
        for lender in _lenders(s, sign):
            way = some, pairs, fresh.of(lender), row, dx, dy, sign, lender
            donors.append(PairDonor(outer, outer, *way))
        decisions = _numbers(uniforms, slot, len(donors))
        kept = resample(donors, decisions, s.mis, s.spatial_cap, target)
        found.append(put(cut(held, rows), at - rows.start, kept))
    return _by_sign(found)


def _around(moment: Moment, pairs: Pairs, across: Masks, rows: slice) -> Indices:
    """The pair that lends its samples to each, or ``NONE``."""
    s, camera = settings_of(moment), moment.world.camera
    size = camera.width, camera.height
    here = np.arange(rows.start, rows.stop)
    radius = int(max(s.radius * camera.width, s.min_radius))
    uniforms = moment.uniforms(rows, Stream.SEARCH)
    if s.around == "random":
        return draw_around(pairs, here, radius, *size, uniforms.draw(0)[0])
    at, seen = np.flatnonzero(across[rows]), looks(moment.visible)
    found = np.full(len(here), NONE)
    asking = here[at], radius, camera.width, s.tries, uniforms.rows(at)
    found[at] = find_alike(seen, pairs, across, *asking)
    return found


def _own(moment: Moment, pairs: Pairs, held: Reservoirs, sign: int) -> PairDonor:
    inner, none = inner_shift(moment, moment.world), np.zeros(len(pairs))
    outer, at = OuterShift(inner.within, inner), np.arange(len(pairs))
    way = pairs, pairs, held, at, none, none, sign, sign
    return PairDonor(outer, outer, *way, same_domain=True)


def _numbers(uniforms: Uniforms, dimension: int, count: int) -> list[Scalars]:
    """So many numbers in [0, 1), from a dimension on."""
    draws = (uniforms.draw(dimension + k) for k in range(-(-count // 4)))
    return [lane for draw in draws for lane in draw][:count]

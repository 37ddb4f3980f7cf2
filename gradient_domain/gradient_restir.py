"""Gradient with ReSTIR: pairs of paths are resampled for the differences of pixels.

The page follows [Wang25]: the paired-pixel domain and its integrand (sections 4.2.1 and
4.2.2), positivization (4.4), the two shifts (4.2.3), new samples (4.4), reuse over
frames (4.3.1) and along edges (4.3.2), and the frame (5).  Equations 18 and 20 are
those of any resampling: `restir_gi.reference.resampling.generalized.resample`.

A sample (x, k) is a base path x of one pixel of a pair (i, j), k says which, and with
it goes its offset path T(x) in the other pixel.  What is computed from samples alone
runs on any dtype.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from restir_gi.extensions.area_restir import (
    Window,
    area_drawn,
    area_reused,
    resample_past,
)
from restir_gi.extensions.area_shift import AreaPaths, AreaShift, PlacedValue
from restir_gi.extensions.frame_loop import PathFrame, path_frames, path_shift
from restir_gi.extensions.pt_settings import PathSettings
from restir_gi.gradient_domain.ablations import (
    random_neighbors,
    reused_signs,
    reused_windows,
)
from restir_gi.gradient_domain.pairs import (
    Pairs,
    as_differences,
    draw_around,
    pair_windows,
    pixel_pairs,
)
from restir_gi.gradient_domain.reconstruction import Differences
from restir_gi.gradient_domain.settings import GradientSettings
from restir_gi.reference.frame import FrameContext
from restir_gi.reference.numerics.arrays import (
    Indices,
    Masks,
    Scalars,
    Vec3s,
    divide_or_zero,
    dot,
    plus,
    saturate,
)
from restir_gi.reference.numerics.records import NONE, cut, put, scatter, take
from restir_gi.reference.numerics.rng import Stream, Uniforms
from restir_gi.reference.numerics.schedule import Schedule, in_bands
from restir_gi.reference.resampling.generalized import Target, resample
from restir_gi.reference.resampling.reservoir import (
    Candidates,
    Reservoirs,
    finalize,
    merge,
)
from restir_gi.reference.resampling.target import luminance
from restir_gi.reference.scene.animation import Animation
from restir_gi.reference.scene.surface import VisiblePoints
from restir_gi.reference.transport.world import World

# ------------------------------------- 4.2.1: the domain (Ω_i × {0}) ∪ (Ω_j × {1})

WHOLE, PLUS, MINUS = 0, 1, -1
"""What of a difference a reservoir estimates: its magnitude, or the part of a sign."""


@dataclass(frozen=True, slots=True)
class PairValue:
    """What of N samples depends on the pair that they belong to.

    Attributes
    ----------
    k : (N,) int8; 0 where the base path is one of pixel i, 1 where of j
    base : PlacedValue; the base path in its pixel
    offset : (N, 3)
        Contribution f of the offset path, 0 where the inner shift does not exist.
    inner : (N,); Jacobian |∂T| of the inner shift, 0 there as well
    sign : (N,) int8; of the reservoir: ``WHOLE``, ``PLUS`` or ``MINUS``
    """

    k: Indices
    base: PlacedValue
    offset: Vec3s
    inner: Scalars
    sign: Indices


@dataclass(frozen=True, slots=True)
class PairedPaths:
    """N samples of pairs.

    Attributes
    ----------
    k : (N,) int8; 0 where the base path is one of pixel i, 1 where of j
    offset : (N, 3) float64, W/(m² sr); contribution f of the offset path
    inner : (N,) float64; Jacobian of the inner shift
    sign : (N,) int8; of the reservoir
    """

    k: Indices
    base: AreaPaths
    offset: Vec3s
    inner: Scalars
    sign: Indices

    @property
    def value(self) -> PairValue:
        """N rows, in the pair that they are in."""
        return PairValue(self.k, self.base.value, self.offset, self.inner, self.sign)

    def moved(self, value: PairValue, jacobian: Scalars) -> "PairedPaths":
        """The same samples in other pairs: k remains, offset paths are those there.

        Parameters
        ----------
        jacobian : (N,) float64, sr/sr; of the outer shift
        """
        base = self.base.moved(value.base, jacobian)
        return PairedPaths(value.k, base, value.offset, value.inner, value.sign)


def difference(value: PairValue) -> Vec3s:
    """Contribution G of N samples to the differences of their pairs, (N, 3).

    Where the inner shift does not exist it is ±f of the base path alone [Wang25,
    Eq. 15].
    """
    # Eq. 15: f_i(x) − f_j(T(x)) |∂T| where k = 0, f_i(T(x)) |∂T| − f_j(x) where k = 1.
    own = value.base.value - value.offset * value.inner[:, None]
    found: Vec3s = np.where((value.k == 0)[:, None], own, -own)
    return found


def share_of_base(p_base: Scalars, p_offset: Scalars, jacobian: Scalars) -> Scalars:
    """MIS weight ω of a base path beside the same two paths, drawn the other way round.

    [Wang25, Eq. 4, and Eq. 13 with targets].

    Parameters
    ----------
    p_base, p_offset : (N,)
        Densities of the paths in their pixels; or, where these are not known, targets
        in their place.
    jacobian : (N,), sr/sr; |∂T| of the inner shift, 0 where it does not exist

    Returns
    -------
    (N,); 1 where there is no offset path, 0 where the base path cannot be
    """
    # Eqs. 4 and 13: p(x) / (p(x) + p_offset(T(x)) |∂T|).
    with np.errstate(over="ignore"):
        other = saturate(p_offset * jacobian)
    shared = divide_or_zero(p_base, plus(p_base, other))
    # Alone there is nothing to divide by: p / p would make floats of whole numbers.
    return np.where(jacobian > 0, shared, (p_base > 0) + 0 * jacobian)


def integrand(value: PairValue) -> Vec3s:
    """ω* G of N samples, whose integral is Δ_ij = F_i − F_j, (N, 3).

    Densities are those of primary sample space: both are 1 [Wang25, Eqs. 14 and 16].
    """
    one = np.ones_like(value.inner)
    # Eqs. 14 and 16: ω* is ω_ij where k = 0, ω_ji where k = 1.
    return difference(value) * share_of_base(one, one, value.inner)[:, None]


# ------------------------------------- 4.4: positivization, and the target


def contribution(value: PairValue) -> Vec3s:
    """What N samples add to Δ_ij for the sign of their reservoir, before W, (N, 3).

    Those of both signs together are ω* G [Wang25, Eqs. 17, 23 and 24].
    """
    signed, sign = integrand(value), value.sign[:, None]
    # Eqs. 23 to 26: p̂_+ = max(ω* G, 0), or −p̂_− = −max(−ω* G, 0).
    one_sided = sign * np.maximum(sign * signed, 0 * signed)
    # Eq. 17: ω* G, in one reservoir of both signs.
    found: Vec3s = np.where(sign == WHOLE, signed, one_sided)
    return found


def target(value: PairValue) -> Scalars:
    """Target p̂ of N samples, (N,): luminance of the magnitude of what they contribute.

    Magnitudes are taken by channel, so that channels of both signs do not cancel
    [Wang25, Eqs. 19, 25 and 26].
    """
    # Eqs. 19, 25 and 26.
    return luminance(np.abs(contribution(value)))


def estimate(reservoirs: Iterable[Reservoirs]) -> Vec3s:
    """Estimate of Δ_ij, by reservoirs that cover it together, (P, 3).

    [Wang25, Eqs. 17 and 24].
    """
    terms = [contribution(r.y.value) * r.W[:, None] for r in reservoirs]
    return sum(terms[1:], terms[0])


# ------------------------------------- 4.2.3: the inner and the outer shift


def inner_shift(
    between: AreaShift, base: AreaPaths, k: Indices, pairs: Pairs
) -> tuple[Vec3s, Scalars]:
    """From N base paths to their offset paths, in the other pixels of their pairs.

    [Wang25, section 4.2.1].

    Parameters
    ----------
    between : AreaShift
        To the image that holds the pairs; within it x_1 moves with its place.
    k : (N,) int8; T_ij where it is 0, T_ji where it is 1

    Returns
    -------
    (N, 3) and (N,) float64
        f of the offset paths, and |∂T|; both 0 where the shift does not exist.
    """
    within = replace(between, primary="move", world_from=between.world_to)
    other = np.where(k == 0, pairs.second, pairs.first)
    dx, dy = (np.where(k == 0, step, -step) for step in (pairs.dx, pairs.dy))
    offset, jacobian = within(base, other, dx, dy)
    return offset.value, jacobian


def outer_shift(
    between: AreaShift,
    samples: PairedPaths,
    *,
    pairs: Pairs,
    dx: Scalars,
    dy: Scalars,
    sign: int,
) -> tuple[PairValue, Scalars]:
    """T*(x, k) = (τ(x), k): N samples in other pairs, for reservoirs of a sign.

    [Wang25, Eqs. 21 and 22].

    Parameters
    ----------
    between : AreaShift; τ, between two images or within one
    dx, dy : (N,) float64, pixels; how far places move, if x_1 moves

    Returns
    -------
    PairValue, (N,) float64
        Values there, and |∂T*|; both 0 where the base path has no place there.
    """
    k, size = samples.k, len(samples.k)
    # Eq. 21: k remains, and the base path goes to the pixel that has this k.
    pixel = np.where(k == 0, pairs.first, pairs.second)
    placed, jacobian = between(samples.base, pixel, dx, dy)
    # Figure 4: the offset path is rebuilt there.
    at = np.flatnonzero(jacobian > 0)
    k, placed, pairs = k[at], take(placed, at), take(pairs, at)
    base = take(samples.base, at).moved(placed, jacobian[at])
    offset, inner = inner_shift(between, base, k, pairs)
    value = PairValue(k, placed, offset, inner, np.full(len(at), sign, np.int8))
    # Eq. 22: the Jacobian is that of the base path alone.
    return scatter(at, value, size), jacobian


# ------------------------------------- 4.2.2: neighbours, for Equations 18 and 20


@dataclass(frozen=True, slots=True, eq=False)
class PairNeighbor:
    """Source reservoirs of pairs, of which K receivers are offered one each.

    Attributes
    ----------
    shift : AreaShift; of base paths, from the sources to the receivers
    pairs, pairs_from : Pairs; K receivers, and P sources
    reservoirs : Reservoirs; P rows of `PairedPaths`
    rows : (K,) int; the source of each receiver, or ``NONE``
    dx, dy : (K,) float64, pixels; from source to receiver
    sign, sign_from : int; of the receivers' reservoirs, and of the sources'
    same_domain : bool
        Source and receiver are one pair of one image, and nothing is shifted.
    """

    shift: AreaShift
    pairs: Pairs
    pairs_from: Pairs
    reservoirs: Reservoirs
    rows: Indices
    dx: Scalars
    dy: Scalars
    sign: int
    sign_from: int
    same_domain: bool = False

    def unshifted(self, at: Indices) -> PairValue:
        """Integrand of the sources' samples where they are, (A,)."""
        value: PairValue = take(self.reservoirs.y.value, self.rows[at])
        return value

    def shifted(self, at: Indices) -> tuple[PairValue, Scalars]:
        """Integrand and Jacobian of the sources' samples at the receivers, (A,).

        Parameters
        ----------
        at : (A,) int; receivers, none without a source
        """
        return outer_shift(
            self.shift,
            take(self.reservoirs.y, self.rows[at]),
            pairs=take(self.pairs, at),
            dx=self.dx[at],
            dy=self.dy[at],
            sign=self.sign,
        )

    def inverse(self, samples: Any, at: Indices) -> tuple[PairValue, Scalars]:
        """The same of the receivers' samples, (A,), at their sources, for their sign.

        Parameters
        ----------
        samples : PairedPaths; K rows, at the receivers
        at : (A,) int; which of them, none without a source
        """
        return outer_shift(
            self.shift.inverse,
            take(samples, at),
            pairs=take(self.pairs_from, self.rows[at]),
            dx=-self.dx[at],
            dy=-self.dy[at],
            sign=self.sign_from,
        )


def _own(shift: AreaShift, pairs: Pairs, own: Reservoirs, sign: int) -> PairNeighbor:
    """What pairs have already, as the canonical candidate."""
    none = np.zeros(len(pairs))
    return PairNeighbor(
        shift=shift,
        pairs=pairs,
        pairs_from=pairs,
        reservoirs=own,
        rows=np.arange(len(pairs)),
        dx=none,
        dy=none,
        sign=sign,
        sign_from=sign,
        same_domain=True,
    )


# ------------------------------------- 4.4: new samples


def paired(
    between: AreaShift, paths: Reservoirs, pairs: Pairs, k: int, rows: slice
) -> Reservoirs:
    """Paths of the pixels of index k as samples of some pairs.

    Parameters
    ----------
    paths : Reservoirs
        Of `AreaPaths`, a pixel each: a path is a sample of up to four pairs.
    """
    some = cut(pairs, rows)
    own, size = take(paths, some.first if k == 0 else some.second), len(some)
    ks, signs = np.full(size, k, np.int8), np.full(size, WHOLE, np.int8)
    at = np.flatnonzero(own.W > 0)
    offset, inner = inner_shift(between, take(own.y, at), ks[at], take(some, at))
    offset, inner = scatter(at, offset, size), scatter(at, inner, size)
    return Reservoirs(PairedPaths(ks, own.y, offset, inner, signs), own.W, own.M)


def paired_both(
    frame: FrameContext[PathSettings], paths: Reservoirs, pairs: Pairs
) -> list[Reservoirs]:
    """Paths of pixels as samples of all pairs: those of k = 0, and of k = 1."""
    within = AreaShift(path_shift(frame), "move", frame.world, frame.world)
    of = partial(paired, within, paths, pairs)
    return [in_bands(frame.schedule, len(pairs), partial(of, k)) for k in (0, 1)]


def choose_pair(
    both: list[Reservoirs], sign: int, u: Scalars, target: Target = target
) -> Reservoirs:
    """New reservoirs of a sign, from new samples that both signs share; M = 1.

    [Wang25, section 4.4].

    Parameters
    ----------
    both : list of Reservoirs; of `PairedPaths`, for k = 0 and 1
    u : (P,) float64; in [0, 1)
    """
    candidates = []
    for r in both:
        y = replace(r.y, sign=np.full(len(r.M), sign, np.int8))
        p_hat = target(y.value)
        # Other k are other parts of the domain: each sample has the weight m = 1.
        candidates.append(Candidates(y, p_hat, p_hat * r.W, r.M))
    kept = merge(candidates[0], candidates[1], u)
    one = np.ones_like(kept.w)
    # Eq. 18.
    return finalize(replace(kept, M=one), one)


# ------------------------------------- 4.3.1: reuse over frames


def _numbers(uniforms: Uniforms, dimension: int, count: int) -> list[Scalars]:
    """So many numbers in [0, 1) a row, from a dimension on."""
    draws = (uniforms.draw(dimension + k) for k in range(-(-count // 4)))
    return [lane for draw in draws for lane in draw][:count]


def _temporal(
    frame: FrameContext[GradientSettings],
    last: "GradientFrame | None",
    pairs: Pairs,
    rows: slice,
    *,
    windows: list[Window],
    both: list[Reservoirs],
    sign: int,
) -> Reservoirs:
    """Reservoirs of a sign, of new samples and of those from the last frame."""
    s, some = frame.settings, cut(pairs, rows)
    # Each sign has random numbers of its own.
    uniforms, slot = frame.uniforms(Stream.PAIRS, rows), int(sign == MINUS)
    new = choose_pair([cut(r, rows) for r in both], sign, uniforms.draw(0)[slot])
    if last is None or not windows:
        return new
    between = AreaShift(path_shift(frame), s.primary, last.world, frame.world)
    same = last.world is frame.world
    own = _own(between, some, new, sign)
    before, shares = [], []
    for sign_from, whole in reused_windows(s.signs, sign, windows, same):
        window = cut(whole, rows)
        source = PairNeighbor(
            shift=between,
            pairs=some,
            pairs_from=pairs,
            reservoirs=last.pairs[sign_from],
            rows=window.rows,
            dx=window.dx,
            dy=window.dy,
            sign=sign,
            sign_from=sign_from,
            same_domain=same,
        )
        before.append(source)
        shares.append(window.share)
    numbers = _numbers(uniforms, 1 + 3 * slot, len(before) + 1)
    # Eqs. 18 and 20.
    return resample_past(own, before, shares, numbers, s, target)


# ------------------------------------- 4.3.2: reuse along edges


@dataclass(frozen=True, slots=True)
class EdgeLimits:
    """How much pixels may differ that look alike; [Wang25, section 4.3.2] by default.

    Attributes
    ----------
    albedo : float; in any channel
    cosine : float; of their normals, at least
    depth : float; of the larger depth
    either_side : bool; whether normals may be turned round
    """

    albedo: float = 0.1
    cosine: float = 0.9
    depth: float = 0.1
    either_side: bool = False


PAPER_LIMITS = EdgeLimits()

AT_ONCE = 16
"""Tries that are made for all rows before those that have found a pair leave."""


def unlike(
    visible: VisiblePoints, a: Indices, b: Indices, limits: EdgeLimits = PAPER_LIMITS
) -> Masks:
    """Whether pixels look unlike, told by the G-buffer, never by a sample.

    [Wang25, section 4.3.2]: albedos (here in any channel) that differ by more than 0.1,
    normals at a cosine *below* 0.9 (printed is above), or depths that differ by more
    than a tenth of the larger one (printed is the first).

    Parameters
    ----------
    a, b : (K,) int; rows of the image

    Returns
    -------
    (K,) bool; symmetric; True where one of them sees nothing, false where neither does
    """
    surface = visible.surface
    albedos, normals, hits, depths = (
        [np.take(of, pixel, axis=0) for pixel in (a, b)]
        for of in (surface.color, surface.shading, surface.hit, visible.depth)
    )
    albedo = np.abs(albedos[0] - albedos[1]).max(axis=1) > limits.albedo
    facing = dot(normals[0], normals[1])
    facing = np.abs(facing) if limits.either_side else facing
    normal = facing < limits.cosine
    farther = np.maximum(depths[0], depths[1])
    depth = np.abs(depths[0] - depths[1]) > limits.depth * farther
    differ = hits[0] & hits[1] & (albedo | normal | depth)
    alone: Masks = hits[0] != hits[1]
    found: Masks = differ | alone
    return found


def edge_neighbors(frame: FrameContext[GradientSettings], pairs: Pairs) -> Indices:
    """For each edge pair the first of some tries that looks like it, pixel by pixel.

    Both are edge pairs, and have the edge in the same order: k means the same to both.

    [Wang25, section 4.3.2].

    Returns
    -------
    (P,) int; row of a pair; ``NONE`` where none was found, and for interior pairs
    """
    visible, tries = frame.visible, frame.settings.tries
    is_edge = unlike(visible, pairs.first, pairs.second)
    edges = np.flatnonzero(is_edge)
    uniforms = frame.uniforms(Stream.SEARCH, slice(0, len(pairs)))

    def drawn(rows: Indices, first: int, count: int) -> Indices:
        u = np.concatenate(_numbers(uniforms.rows(rows), first // 4, count))
        return draw_around(frame, pairs, np.tile(rows, count), u)

    def search(rows: slice) -> Indices:
        return first_alike(visible, pairs, is_edge, edges[rows], tries, drawn)

    neighbor = np.full(len(pairs), NONE)
    neighbor[edges] = in_bands(frame.schedule, len(edges), search)
    return neighbor


def first_alike(
    visible: VisiblePoints,
    pairs: Pairs,
    is_edge: Masks,
    rows: Indices,
    tries: int,
    drawn: Callable[[Indices, int, int], Indices],
    limits: EdgeLimits = PAPER_LIMITS,
) -> Indices:
    """For each of K edge pairs the first of its tries that is one too, and looks alike.

    Parameters
    ----------
    is_edge : (P,) bool; of ``pairs``
    rows : (K,) int; of the edge pairs
    drawn : callable
        From rows, the number of a try and a count of tries to rows of pairs, or
        ``NONE``, try after try.

    Returns
    -------
    (K,) int; row of a pair, or ``NONE``
    """
    i, j = pairs.first, pairs.second
    found = np.full(len(rows), NONE)
    for first in range(0, tries, AT_ONCE):
        searching = np.flatnonzero(found == NONE)
        if len(searching) == 0:
            break
        own, count = rows[searching], min(AT_ONCE, tries - first)
        other = drawn(own, first, count)
        own = np.tile(own, count)
        at = np.flatnonzero((other != NONE) & is_edge[other])
        own, other = own[at], other[at]
        apart = unlike(visible, i[own], i[other], limits)
        apart |= unlike(visible, j[own], j[other], limits)
        at, other = at[~apart], other[~apart]
        # Tries follow one another: the first of each row is that of its first slot.
        row, slot = np.unique(at % len(searching), return_index=True)
        found[searching[row]] = other[slot]
    return found


def _spatial(
    frame: FrameContext[GradientSettings],
    fresh: Mapping[int, Reservoirs],
    pairs: Pairs,
    rows: slice,
    *,
    neighbor: Indices,
    sign: int,
) -> Reservoirs:
    """Reservoirs of a sign, of their own samples and of those of a neighbour."""
    s, width, own = frame.settings, frame.world.camera.width, cut(fresh[sign], rows)
    # Interior pairs have no neighbour, and keep what they have.
    at = np.flatnonzero(neighbor[rows] != NONE)
    some, row = take(cut(pairs, rows), at), neighbor[rows][at]
    within = AreaShift(path_shift(frame), "move", frame.world, frame.world)
    neighbors, first = [_own(within, some, take(own, at), sign)], pairs.first[row]
    for sign_from in reused_signs(s.signs, sign):
        source = PairNeighbor(
            shift=within,
            pairs=some,
            pairs_from=pairs,
            reservoirs=fresh[sign_from],
            rows=row,
            dx=(some.first % width - first % width).astype(float),
            dy=(some.first // width - first // width).astype(float),
            sign=sign,
            sign_from=sign_from,
        )
        neighbors.append(source)
    uniforms = frame.uniforms(Stream.PAIRS_AROUND, rows).rows(at)
    u = _numbers(uniforms, int(sign == MINUS), len(neighbors))
    # Eqs. 18 and 20.
    return put(own, at, resample(neighbors, u, s.mis, s.spatial_cap, target))


# ------------------------------------- 5: the frame


@dataclass(frozen=True, slots=True, eq=False)
class GradientFrame(PathFrame):
    """A frame of pixels, and of differences: what an image is reconstructed from.

    Attributes
    ----------
    differences : Differences; of neighbouring pixels, N rows
    pairs : mapping of int to Reservoirs
        What pairs keep for each sign, P rows; nothing where they are not resampled.
    """

    differences: Differences
    pairs: Mapping[int, Reservoirs]

    @property
    def estimates(self) -> Vec3s:
        """(N, 9): pixels, and differences to the right and down.

        Their means over frames are what an image is best reconstructed from.
        """
        d = self.differences
        return np.concatenate([self.color, d.x, d.y], axis=1)


def shaded(value: Vec3s, W: Scalars) -> Vec3s:
    """Indirect light of N pixels by their own samples, before an image is made, (N, 3).

    Emission seen directly is added to the image: no lamp's edge is reconstructed.

    Parameters
    ----------
    value : (N, 3); contribution f / p of each sample
    """
    found: Vec3s = value * W[:, None]
    return found


def gradient_frame(
    frame: FrameContext[PathSettings],
    primal: Reservoirs,
    pairs: Pairs,
    delta: Vec3s,
    kept: Mapping[int, Reservoirs] | None = None,
) -> GradientFrame:
    """A frame from reservoirs of pixels, and estimates of the differences of all pairs.

    Parameters
    ----------
    delta : (P, 3) float64; Δ_ij of each pair
    kept : mapping of int to Reservoirs
        What pairs keep for each sign, where they are resampled.
    """
    return GradientFrame(
        number=frame.number,
        world=frame.world,
        visible=frame.visible,
        reservoirs=primal,
        color=shaded(primal.y.paths.value, primal.W),
        differences=as_differences(pairs, delta, frame.pixels),
        pairs=kept or {},
    )


def render_gradient_frames(
    world: World,
    settings: GradientSettings,
    bounces: int,
    seed: int,
    schedule: Schedule,
    animation: Animation | None = None,
) -> Iterator[GradientFrame]:
    """Frames of pixels by Area ReSTIR and of differences by ReSTIR, without end.

    Arguments as of `path_frames` [Wang25, sections 4.2 to 5].
    """
    return path_frames(_frame, world, settings, bounces, seed, schedule, animation)


NEIGHBORS = {"edges": edge_neighbors, "random": random_neighbors}


def _frame(
    frame: FrameContext[GradientSettings], last: GradientFrame | None
) -> GradientFrame:
    s, camera, schedule = frame.settings, frame.world.camera, frame.schedule
    pairs = pixel_pairs(camera.width, camera.height)
    # Section 5: pixels by Area ReSTIR; pixels and pairs share their new paths.
    paths = in_bands(schedule, frame.pixels, lambda r: area_drawn(frame, r))
    primal = area_reused(frame, last, lambda r: cut(paths, r))
    # Section 4.4: r_+ and r_−, which share their new samples.
    both = paired_both(frame, paths, pairs)
    signs = (WHOLE,) if s.signs == "without" else (PLUS, MINUS)
    # Section 4.3.1.
    windows = pair_windows(frame, last, pairs) if last and s.temporal else []
    over_frames = partial(_temporal, frame, last, pairs, windows=windows, both=both)
    kept = {
        sign: in_bands(schedule, len(pairs), partial(over_frames, sign=sign))
        for sign in signs
    }
    # Section 4.3.2: all reservoirs are complete before a neighbour reads them.
    if s.spatial and s.around != "none":
        neighbor = NEIGHBORS[s.around](frame, pairs)
        around = partial(_spatial, frame, kept, pairs, neighbor=neighbor)
        kept = {
            sign: in_bands(schedule, len(pairs), partial(around, sign=sign))
            for sign in signs
        }
    # Eq. 24.
    delta = estimate(kept.values())
    return gradient_frame(frame, primal, pairs, delta, kept=kept)

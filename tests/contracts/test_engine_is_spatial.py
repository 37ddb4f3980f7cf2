"""The general engine with weights 1/Z is Algorithm 4, to the last bit.

Both resample the same candidates with the same numbers.  In fractions they agree for
every outcome of the toy domain and every number at once.  On float64 they agree too:
weights go through the same kernels in the same order, and Z adds the same confidences.
An empty reservoir has W = 0 in both; which null it holds is nobody's business.
"""

from dataclasses import dataclass, replace
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from restir_gi.reference import restir_gi
from restir_gi.reference.numerics.records import take
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.options.weights import (
    OwnSource,
    itself,
    resample_weighted,
    weighed,
)
from restir_gi.reference.passes.spatial import spatial_resampling
from restir_gi.reference.resampling.generalized import resample
from restir_gi.reference.resampling.reservoir import Reservoirs, Samples, one_over_z
from restir_gi.reference.scene.animation import Animation
from restir_gi.reference.scene.catalogue.registry import find_animation
from restir_gi.reference.settings import Settings
from restir_gi.reference.transport.world import build_world
from tests.exact import claims, pages
from tests.exact.domain import PIXELS


def by_the_engine(q, past, own, neighbors, u_own, *, cap, mis="1/Z"):
    """In place of `spatial_resampling`."""
    return resample_weighted(q, [(past, u_own), (own, u_own), *neighbors], mis, cap)


# ---------------------------------------------------------------- in fractions


@dataclass(frozen=True, slots=True)
class BothKept:
    """What both keep."""

    page: Any
    engine: Any


def law_of_both(i, mis, then, **settings):
    """Law of what pixel i keeps by the page and by the engine, of the same numbers."""
    s, j = Settings(**settings), (i + 1) % len(PIXELS)

    def program(rows, uniform):
        own, other = (claims.trust(claims.alone(k, uniform), k + 2) for k in (i, j))
        past = claims.frame_ago(uniform) if then else claims.alone(i, uniform)
        q = pages.receivers(i, len(own.W), s)
        given = q, pages.past_of(q, past, then), own.opened()
        around, u = pages.neighbors(q, {j: other}, uniform), uniform()
        passes = spatial_resampling, by_the_engine
        kept = [run(*given, around, u, cap=4, mis=mis) for run in passes]
        return BothKept(*map(pages.closed, kept))

    return claims.explored(program, claims.NOWHERE)


def differ(pair):
    """Whether page and engine differ in any outcome."""
    columns = ("cell", "W", "M")
    a, b = pair.page, pair.engine
    return any((getattr(a, c) != getattr(b, c)).any() for c in columns)


@pytest.mark.parametrize("i", PIXELS)
@pytest.mark.parametrize("mis", ["1/M", "1/Z"])
@pytest.mark.parametrize("then", [False, True], ids=["own past", "moved past"])
@pytest.mark.parametrize(
    "settings",
    [{}, {"visibility": "chosen"}, {"jacobian_limit": Fraction(3)}],
    ids=["default", "late visibility", "mirrored limit"],
)
def test_the_engine_is_the_page_in_fractions(i, mis, then, settings):
    assert not differ(law_of_both(i, mis, then, **settings).outcomes)


def test_control_another_z_is_told(monkeypatch):
    def without_the_last(M_k, holds_k):
        return one_over_z(M_k[:-1], holds_k[:-1])

    monkeypatch.setattr(
        "restir_gi.reference.resampling.reuse.one_over_z", without_the_last
    )
    assert differ(law_of_both(0, "1/Z", then=False).outcomes)


# ---------------------------------------------------------------- in float64


def compared(scene, **settings):
    """Rows of both, spatial pass by spatial pass, over a few frames."""
    found = []

    def both(*given, **how):
        kept = [run(*given, **how) for run in (spatial_resampling, by_the_engine)]
        found.append(kept)
        return kept[0]

    animation = small(scene)
    world = build_world(animation(0))
    given = Settings(**settings), 2, 3, Schedule(), animation
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(restir_gi, "spatial_resampling", both)
        frames = restir_gi.render_frames(world, *given)
        for _ in range(3):
            next(frames)
    return found


def small(name):
    animation = find_animation(name)

    def at(frame):
        scene = animation(frame)
        return replace(scene, camera=replace(scene.camera, width=32, height=24))

    return Animation(at, animation.changes)


STILL, MOVING = ("cornell-box", "glossy-floor"), ("moving-camera", "moving-block")


@pytest.mark.parametrize("scene", STILL + MOVING)
@pytest.mark.parametrize("target", ["scattered", "outgoing"])
@pytest.mark.parametrize("visibility", ["all", "chosen"])
def test_the_engine_is_the_page_on_frames(scene, target, visibility):
    found = compared(scene, target=target, visibility=visibility)
    assert len(found) >= 3
    for page, engine in found:
        full = np.flatnonzero(page.W > 0)
        assert len(full) > 0
        np.testing.assert_array_equal(page.W, engine.W)
        np.testing.assert_array_equal(page.M, engine.M)
        for column in ("position", "normal", "radiance"):
            a, b = (getattr(take(r.y, full), column) for r in (page, engine))
            np.testing.assert_array_equal(a, b)


# ---------------------------------------------------------------- own sources


def own_of(rows, seed):
    """Reservoirs of pixels' own, weighed, and the numbers that decide."""
    rng = np.random.default_rng(seed)
    y = Samples(*rng.normal(size=(2, rows, 3)), rng.random((rows, 3)))
    q = SimpleNamespace(points=range(rows), target=lambda y: y.radiance.sum(axis=1))
    W, M = rng.random(rows) * (rng.random(rows) < 0.8), np.ceil(9 * rng.random(rows))
    return weighed(q, Reservoirs(y, W, M)), rng.random(rows)


def as_if_shifted(first, kind=OwnSource):
    """What is kept of two own sources, of which the first goes through its shift."""
    (a, u), (b, v) = first, own_of(50, 2)
    moved = kind(a.reservoirs, a.rows, same_domain=False)
    return (
        lambda mis, source: resample([source, b], [u, v], mis, 30.0, itself),
        a,
        moved,
    )


@pytest.mark.parametrize("mis", ["1/M", "1/Z", "balance", "pairwise", "defensive"])
def test_the_shift_of_an_own_source_is_the_identity(mis):
    """Exact: a Jacobian of 1 multiplies and divides without rounding."""
    run, own, moved = as_if_shifted(own_of(50, 1))
    one, other = run(mis, own), run(mis, moved)
    assert np.array_equal(one.W, other.W)
    assert np.array_equal(one.M, other.M)
    assert (one.W > 0).any()


def test_control_another_jacobian_is_seen():
    class Twice(OwnSource):
        __slots__ = ()

        def shifted(self, at):
            value, jacobian = OwnSource.shifted(self, at)
            return value, 2.0 * jacobian

    run, own, moved = as_if_shifted(own_of(50, 1), Twice)
    assert not np.array_equal(run("1/Z", own).W, run("1/Z", moved).W)

"""Shifted paths are paths that the other pixel draws, from the numbers of the shift."""

from types import SimpleNamespace

import numpy as np
import pytest

from restir_gi.extensions.candidates import draw_paths
from restir_gi.extensions.shifting import Technique
from restir_gi.reference.numerics.records import take
from restir_gi.reference.numerics.rng import TabledUniforms
from tests.mutants.plant import planted
from tests.properties.path_numbers import BOUNCES, DIMENSIONS, SOLVED, solved
from tests.properties.path_scenes import SIZE, UNIT, drawn, neighbors, shifted
from tests.properties.test_path_jacobians import each_case
from tests.properties.test_path_shifts import each_scene, relative, shiftable

REPLAYED = 20 * UNIT
"""At most eight factors each way, in another order, and two quotients apart."""

CLOSE = 1e-2
"""Joints are met again where float32 puts them, 2^-22 of the scene away.

A value changes by δ / d times what is steep in it: some 10 for most paths, and a
hundred times as much where a cosine or a distance is a hundredth.
"""

MEDIAN = 1e-5
FAR = 0.01
"""Largest share of paths that may be further off than `CLOSE`."""


def drawn_again(w, x, paths, criterion, table):
    """Of the trees with these numbers the branches that end as the paths do."""
    rows, end = np.arange(len(paths)), paths.end.astype(int)
    met = np.flatnonzero(paths.technique == Technique.EMITTER_HIT)
    # Lanes 3 choose: 0 takes a light, 1 leaves it, if there is another.
    table = table.copy()
    table[:, 3] = 1.0
    table[2 * end - 1, 3, rows] = 0.0
    table[2 * (end[met] - 1), 3, met] = 0.0
    uniforms = TabledUniforms(table)
    return draw_paths(w, x, BOUNCES, criterion, paths.number, uniforms).y


def same(a, b):
    """(N,) bool: the paths are joined, end, and find their light in the same way."""
    alike = (a.joint == b.joint) & (a.end == b.end)
    return alike & (a.technique == b.technique) & a.value.any(axis=1)


def compared(name, kind, solving=solved):
    """Which joined paths are drawn as they were shifted, and errors of their values."""
    found, _, v, error = solving(name, kind, 0)
    table = found.table
    for place, numbers in zip(found.places(), v.T, strict=True):
        table[place] = numbers % 1.0
    rows = np.flatnonzero(error < SOLVED)
    there = take(found.there, rows)
    w, criterion = found.joints.world, found.shift.criterion
    y = drawn_again(w, take(found.x_to, rows), there, criterion, table[:, :, rows])
    return same(y, there), relative(y.value, there.value)


@each_case
def test_the_other_pixel_draws_the_joined_path(name, kind):
    alike, error = compared(name, kind)
    assert len(alike) > 50
    assert alike.all()
    assert np.median(error) < MEDIAN
    assert np.mean(error > CLOSE) < FAR


def replays(name, kind, frame=0):
    """Of paths without joint: shifted or not, drawn or not, and the values' errors."""
    w, x, found, shift = drawn(name, kind, frame, BOUNCES)
    x_to = take(x, neighbors(SIZE, 5, 3))
    lit = shiftable(found.y, kind) & (found.y.joint == 0) & x_to.hit
    there, jacobian = shifted(shift, w, x_to, found.y, lit)
    rows = np.flatnonzero(lit)
    paths, there = take(found.y, rows), take(there, rows)
    uniforms = shift.uniforms(paths.number)
    table = np.array([uniforms.draw(d) for d in range(DIMENSIONS)])
    y = drawn_again(w, take(x_to, rows), paths, shift.criterion, table)
    assert set(jacobian) <= {0.0, 1.0}
    return jacobian[rows] > 0, same(y, paths), relative(there.value, y.value)


@each_scene
def test_a_path_is_replayed_if_and_only_if_the_other_pixel_draws_it(name):
    parts = [replays(name, "replay", frame) for frame in range(3)]
    arrives, exists, error = (np.concatenate(part) for part in zip(*parts, strict=True))
    assert arrives.any()
    np.testing.assert_array_equal(arrives, exists)
    assert error[arrives].max() < REPLAYED


@pytest.mark.parametrize(
    "name", ["mirror", "glass", "glossy metal", "smooth coat", "bright"]
)
def test_so_is_one_without_joint_where_others_are_joined(name):
    for frame in range(4):
        arrives, exists, error = replays(name, "hybrid", frame)
        np.testing.assert_array_equal(arrives, exists)
        assert error[arrives].max(initial=0.0) < REPLAYED


# ------------------------------------------------------------ controls


@pytest.mark.parametrize(
    "change",
    [
        ("np.where(last, share, 1.0)[:, None]", "1.0"),
        ("* paths.incoming", "* paths.incoming * 1.1"),
        ("weight * divide_or_zero(onward, p_onward[:, None])", "weight"),
        ('shines, "reuse")', 'shines, "reuse") | fits'),
    ],
    ids=["without weight of the light", "a tenth more", "one factor less", "hidden"],
)
def test_control_other_values_at_a_joint_are_refuted(change):
    with planted(SimpleNamespace(edits=[("restir_gi.extensions.shifting", *change)])):
        # What is kept was found without the mistake.
        alike, error = compared("glossy metal", "hybrid", solved.__wrapped__)
    assert not alike.all() or np.mean(error > CLOSE) > 10 * FAR


@pytest.mark.parametrize(
    "change",
    [
        ("chosen & x.hit & ~step.joinable", "chosen & x.hit"),
        ("~chosen & ~(step.joinable & ~bsdf.delta)", "~chosen"),
        ("~(step.joinable & ~leaving.bsdf.delta)", "np.ones(len(rows), bool)"),
    ],
    ids=["light chosen", "light met", "on the way"],
)
def test_control_replay_past_what_can_be_joined_is_refuted(change):
    with planted(SimpleNamespace(edits=[("restir_gi.extensions.shifting", *change)])):
        found = (replays("bright", "hybrid", frame)[:2] for frame in range(12))
        assert any((arrives != exists).any() for arrives, exists in found)

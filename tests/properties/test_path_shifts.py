"""Shift mappings of paths: their own inverse, and of the Jacobian that they state."""

import numpy as np
import pytest

from restir_gi.extensions.pt_settings import CRITERIA
from restir_gi.extensions.shifting import Technique, advance, leave, start
from restir_gi.reference.numerics.arrays import cross, dot, length
from restir_gi.reference.numerics.records import take
from restir_gi.reference.scene.materials.table import pdf
from restir_gi.reference.scene.origins import contact
from restir_gi.reference.scene.surface import direction_and_distance
from tests.properties.path_scenes import (
    FLOORS,
    SIZE,
    drawn,
    points,
    shifted,
    uniforms,
    world,
)

KINDS = tuple(CRITERIA)
SCENES = (*FLOORS, "door-ajar", "glossy-floor", "many-lights", "grazing-light")

ROUNDING = 1e-12
"""Some hundred operations, of which cosines down to 1e-2 magnify a few."""

each_kind = pytest.mark.parametrize("kind", KINDS)
each_scene = pytest.mark.parametrize("name", SCENES)


def elsewhere(step):
    """Each pixel's neighbour, `step` to the right and as many down."""
    rows = np.arange(SIZE * SIZE).reshape(SIZE, SIZE)
    return np.roll(rows, (step, step), axis=(0, 1)).ravel()


def shiftable(paths, kind):
    light = paths.value.any(axis=1)
    return light & (paths.joint == 2) if kind == "reconnection" else light


def relative(a, b):
    return np.abs(a - b).max(axis=1) / np.maximum(np.abs(b).max(axis=1), 1e-300)


@each_kind
@each_scene
def test_to_where_it_is_a_path_stays_what_it_is(name, kind):
    w, x, found, shift = drawn(name, kind)
    rows = shiftable(found.y, kind)
    assert rows.any()
    there, jacobian = shifted(shift, w, x, found.y, rows)
    np.testing.assert_allclose(jacobian[rows], 1.0, rtol=ROUNDING)
    assert relative(there.value, found.y.value)[rows].max() < ROUNDING


@each_kind
@each_scene
@pytest.mark.parametrize("step", [1, 5])
def test_there_and_back_leads_to_where_it_came_from(name, kind, step):
    """A shift that has no way back would bring light twice."""
    w, x, found, shift = drawn(name, kind, frame=step)
    x_to = take(x, elsewhere(step))
    there, forth = shifted(shift, w, x_to, found.y, shiftable(found.y, kind))
    rows = forth > 0
    assert rows.any()
    back, home = shifted(shift, w, x, there, rows)
    assert (home[rows] > 0).all()
    np.testing.assert_allclose(forth[rows] * home[rows], 1.0, rtol=ROUNDING)
    assert relative(back.value, found.y.value)[rows].max() < ROUNDING


@pytest.mark.parametrize("name", FLOORS)
def test_both_techniques_and_late_joints_occur(name):
    """Else the tests above would prove nothing."""
    found = [drawn(name, "hybrid", frame)[2].y for frame in range(4)]
    joint = np.concatenate([y.joint[y.value.any(axis=1)] for y in found])
    technique = np.concatenate([y.technique[y.value.any(axis=1)] for y in found])
    assert {Technique.NEXT_EVENT, Technique.EMITTER_HIT} <= set(technique)
    assert 2 in joint
    if name in ("mirror", "glossy metal", "glass"):
        assert {0, 3} <= set(joint)


@each_kind
def test_a_shift_that_fails_gives_nothing(kind):
    w, x, found, shift = drawn("glass", kind)
    x_to = take(x, elsewhere(3))
    there, jacobian = shifted(shift, w, x_to, found.y, found.y.there)
    failed = jacobian == 0
    assert failed.any()
    assert not there.value[failed].any()
    assert np.isfinite(jacobian).all()
    assert np.isfinite(there.value).all()


def test_replay_alone_has_jacobian_one():
    w, x, found, shift = drawn("paint", "replay")
    _, jacobian = shifted(shift, w, take(x, elsewhere(1)), found.y, found.y.there)
    assert set(jacobian) == {0.0, 1.0}


# ------------------------------------------------------------ finite differences


class Nudged:
    """Uniforms of which one lane of the first direction is moved a little."""

    def __init__(self, base, lane, by):
        lanes = list(base)
        lanes[lane] = lanes[lane] + by
        self._lanes = tuple(lanes)

    def draw(self, dimension):
        """The same numbers for each dimension."""
        return self._lanes


def first_meeting(w, x, u):
    step = start(x)
    everyone = np.ones(len(x), bool)
    criterion = CRITERIA["reconnection"]  # whatever is not a delta lobe
    return advance(w, criterion, step, 1, leave(w, step, 1, u, everyone))


def misfits(name, density_of):
    """Share of the paths whose density is not |∂u/∂x_2| by central differences."""
    w = world(name)
    x = points(w)
    base = uniforms(len(x))(np.arange(len(x))).draw(0)
    # Away from the ends of the map, where its derivatives are large.
    base = tuple(0.1 + 0.8 * lane for lane in base)
    h = 1e-4
    middle = first_meeting(w, x, Nudged(base, 1, 0.0))
    tangents, same = [], middle.points.hit & middle.joinable
    for lane in (1, 2):
        ends = [first_meeting(w, x, Nudged(base, lane, s * h)) for s in (1, -1)]
        places = [contact(w.geometry, end.points) for end in ends]
        for end in ends:
            same &= end.points.primitive == middle.points.primitive
        tangents.append((places[0] - places[1]) / (2 * h))
    area = length(cross(*tangents))
    density = density_of(middle)
    rows = same & (density > 0)
    assert rows.sum() > 100
    error = np.abs(area * density - 1)[rows]
    # A hit is rounded to 2^-22 of the scene, by float32 barycentrics and rays; over h
    # that is the error of a tangent, and times the other tangent that of the area.
    # What h leaves of the third derivatives is below a thousandth.
    rounding = 2.0**-22 * w.geometry.extent / h
    sides = sum(length(tangent) for tangent in tangents)
    allowed = rounding * (sides / np.maximum(area, 1e-300))[rows] + 1e-3
    assert np.median(allowed) < 0.02
    return (error > allowed).mean()


@pytest.mark.parametrize(
    "name",
    [
        "paint",
        "rough metal",
        "glossy metal",
        "mirror",
        "glass",
        "door-ajar",
        "many-lights",
        "checker",
    ],
)
def test_the_density_is_that_of_the_map_from_random_numbers_to_points(name):
    """P cos φ / d², wherever x_2 lies."""
    assert misfits(name, lambda step: step.pdf * step.came.spread) == 0


@pytest.mark.parametrize(
    "wrong",
    [
        lambda step: step.pdf,
        lambda step: step.pdf / step.came.distance**2,
        lambda step: step.pdf * step.came.spread * step.came.distance,
        lambda step: step.came.spread,
    ],
    ids=["per solid angle", "without cosine", "distance once", "without density"],
)
def test_control_another_density_is_refuted(wrong):
    assert misfits("paint", wrong) > 0.5


@pytest.mark.parametrize("name", ["paint", "rough metal", "many-lights"])
def test_the_jacobian_is_the_ratio_of_densities_of_one_point(name):
    """Of u from either pixel to the same point: |∂u_to/∂x| / |∂u_from/∂x|."""
    w, x, found, shift = drawn(name, "hybrid")
    rows = np.flatnonzero(found.y.value.any(axis=1) & (found.y.joint == 2))
    paths, x_to = take(found.y, rows), take(x, elsewhere(1)[rows])
    everyone = np.arange(len(rows))
    _, jacobian = shift(w, x_to, everyone, paths, everyone)
    ok = jacobian > 0
    x_s = contact(w.geometry, paths.surface)
    densities = []
    for viewer in (take(x, rows), x_to):
        omega, d = direction_and_distance(viewer.position, x_s)
        per_area = pdf(w.materials, viewer, omega)
        per_area = per_area * np.abs(dot(paths.surface.normal, omega)) / d**2
        densities.append(per_area)
    # Paint at x_2 with light chosen by next-event estimation leaves p(ω_2) alone.
    chosen = paths.technique == Technique.NEXT_EVENT
    ok &= chosen & (paths.end == 2)
    wanted = densities[1][ok] / densities[0][ok]
    np.testing.assert_allclose(jacobian[ok], wanted, rtol=1e-10)
    assert ok.sum() > 20

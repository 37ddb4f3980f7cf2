"""There and back, a million times: what can be shifted can be shifted home.

A path that arrives must be one that the other pixel would have drawn and joined at the
same point: else two base paths lead to it, and bring its light twice.
"""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

from restir_gi.reference.numerics.records import scatter, take
from restir_gi.reference.scene.origins import contact
from tests.mutants.plant import planted
from tests.properties.path_scenes import (
    SIZE,
    UNIT,
    drawn,
    joints,
    neighbors,
    seen_from,
    shifted,
    steepness,
    walked,
)
from tests.properties.test_path_shifts import (
    KINDS,
    SCENES,
    each_kind,
    each_scene,
    relative,
    shiftable,
)

BOUNCES = 4
OFFSETS = ((1, 0), (0, 1), (-1, 1), (3, -2), (-5, 4), (8, 8), (-13, 2))
"""Pixels to the right and down, one after the other, a frame each."""

LARGE = 64
"""Pixels a side of the frames of the slow test."""

LEAST = 30_400
"""Round trips of each kind in each scene, in the slow test."""

MOST = 1000
"""Frames in which they must be found."""

JACOBIAN = 4 * UNIT
"""The density is divided, multiplied and divided again; then their product."""

VALUE = 20 * UNIT
"""At most eight factors each way, in another order, and two quotients apart."""

STRAY = 1e-3
"""Largest share of round trips that need more than `JACOBIAN`.

A point that is taken off its surface and put back is the same, but where a coordinate
passes a power of two, or is a tie: seldom.  Only then the condition counts.
"""


@dataclass(frozen=True)
class Trips:
    """What became of the paths of one frame that arrived."""

    home: np.ndarray
    jacobian: np.ndarray
    density: np.ndarray
    value: np.ndarray
    same_joint: np.ndarray
    allowed: np.ndarray

    def __len__(self):
        """How many arrived."""
        return len(self.home)

    @property
    def failed(self):
        """(N,) bool: lost, changed, or never drawn like that."""
        changed = self.jacobian > JACOBIAN + self.allowed
        changed |= self.density > JACOBIAN + self.allowed
        changed |= self.value > VALUE + self.allowed
        return ~self.home | changed | ~self.same_joint


def round_trips(name, kind, frame, size):
    """Shift the paths of a frame to a neighbour, and home."""
    w, x, found, shift = drawn(name, kind, frame, BOUNCES, size)
    x_to = take(x, neighbors(size, *OFFSETS[frame % len(OFFSETS)]))
    there, forth = shifted(shift, w, x_to, found.y, shiftable(found.y, kind))
    back, home = shifted(shift, w, x, there, forth > 0)
    at = np.flatnonzero(forth > 0)
    base, there, back = (take(paths, at) for paths in (found.y, there, back))
    walks = [walks_of(w, shift, take(points, at), base) for points in (x, x_to)]
    joined = base.joint > 0
    density = back.density[joined] / base.density[joined]
    return Trips(
        home[at] > 0,
        np.abs(forth[at] * home[at] - 1),
        scatter(np.flatnonzero(joined), np.abs(density - 1), len(at)),
        relative(back.value, base.value),
        joints(w, shift.criterion, walks[1], there) == there.joint,
        sum(condition(w, visited, base) for visited in walks),
    )


def walks_of(w, shift, x, paths):
    last = int(paths.end.max(initial=2))
    return walked(w, shift.criterion, x, paths.number, shift.uniforms, last)


def condition(w, visited, paths):
    """Relative error of the density at the joint, if x_c is rounded once more.

    It is taken off its surface twice: four roundings in each of three coordinates move
    it by δ, and turn the direction to it by δ / d, which changes d² by twice that,
    and cosines and lobes as they are steep.
    """
    error = np.zeros(len(paths))
    x_s = contact(w.geometry, paths.surface)
    for v, (x, _) in enumerate(visited, start=1):
        there, d = seen_from(w, x, paths.surface, x_s)
        delta = 8 * UNIT * np.abs(x_s).max(axis=1) / np.where(d > 0, d, 1.0)
        steep = steepness(w, x, -there.wo, x.wo)
        steep = steep + steepness(w, there, there.wo, paths.wi)
        error = np.where(paths.joint == v + 1, delta * (2.0 + steep), error)
    return error


@each_kind
@each_scene
def test_what_arrives_comes_home(name, kind):
    trips = [round_trips(name, kind, frame, SIZE) for frame in (0, 3)]
    assert sum(map(len, trips)) > 10
    assert not any(trip.failed.any() for trip in trips)


def test_the_slow_test_makes_a_million_round_trips():
    assert LEAST * len(KINDS) * len(SCENES) >= 1_000_000


@pytest.mark.slow
@each_kind
@each_scene
def test_what_arrives_comes_home_a_million_times(name, kind):
    made, stray, worst = 0, 0, np.zeros(4)
    for frame in range(MOST):
        trips = round_trips(name, kind, frame, LARGE)
        assert not trips.failed.any()
        made += len(trips)
        stray += np.count_nonzero(trips.jacobian > JACOBIAN)
        errors = (trips.jacobian, trips.density, trips.value, trips.allowed)
        worst = np.maximum(worst, [error.max(initial=0.0) for error in errors])
        if made >= LEAST:
            break
    count = f"{name}, {kind}: {made} round trips, {frame + 1} frames, {stray} stray"
    print(count, *(f"{error:.2g}" for error in worst))  # noqa: T201
    assert made >= LEAST
    assert stray <= STRAY * made


# ------------------------------------------------------------ controls

JOINED = ("came.joinable & ~step.joinable &", "came.joinable &")
REPLAYED = ("~(step.joinable & ~leaving.bsdf.delta)", "np.ones(len(rows), bool)")
ENDED = ("~chosen & ~(step.joinable & ~bsdf.delta)", "~chosen")
CHOSEN = ("chosen & x.hit & ~step.joinable", "chosen & x.hit")
SPREAD = ("p_left * came.spread * p_onward", "p_left * p_onward")
ONWARD = ("came.spread * p_onward, 0.0", "came.spread, 0.0")


@pytest.mark.parametrize(
    "changes",
    [
        (JOINED, REPLAYED),
        (JOINED,),
        (REPLAYED,),
        (ENDED,),
        (CHOSEN,),
        (SPREAD,),
        (ONWARD,),
    ],
    ids=[
        "joinable earlier on the offset side",
        "there, at the last step",
        "there, while numbers are replayed",
        "there, at an emitter hit",
        "there, at a light chosen",
        "without geometry",
        "without the second density",
    ],
)
def test_control_a_shift_without_its_domain_or_density_is_refuted(changes):
    edits = [("restir_gi.extensions.shifting", *change) for change in changes]
    with planted(SimpleNamespace(edits=edits)):
        trips = (round_trips("bright", "hybrid", frame, SIZE) for frame in range(12))
        assert any(trip.failed.any() for trip in trips)

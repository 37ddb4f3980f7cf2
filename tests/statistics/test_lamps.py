"""All unbiased methods on a room with a textured lamp of two sides and a spot.

The path tracer, whose lamps `tests/analytic/test_lights.py` holds against closed forms,
is the truth.  A replicate is a run under its own seed; the image means of RUNS runs are
judged by Student's t.  A right method fails with probability 1e-6.  The standard error
is required to be below 4 %, so that a bias of 27 % of the image would have been found:
these are tests of which light is meant, not of weights.
Control: the same room with a lamp of one side is rejected.
"""

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest
from scipy import stats

from restir_gi.reference.methods import Job, method_named
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.scene.validation import validate
from restir_gi.reference.transport.world import build_world
from tests.properties.path_scenes import lamps

UNBIASED = ("restir-gi-unbiased", "restir-pt", "world-reservoirs")
RUNS, FRAMES, SIZE = 36, 3, 24
ALARM = 1e-6


def world(scene):
    camera = replace(scene.camera, width=SIZE, height=SIZE)
    return build_world(validate(replace(scene, camera=camera)))


def runs(name, made, first):
    """Image mean over the frames of each run."""
    method, found = method_named(name), []
    for seed in range(first, first + RUNS):
        job = Job(
            world=made,
            light="indirect",
            bounces=2,
            seed=seed,
            counts={"frames": FRAMES, "spp": 16},
            settings=method.settings,
            aovs=(),
            schedule=Schedule(),
        )
        frames = islice(method.frames(job), FRAMES)
        found.append(np.mean([frame.color.mean() for frame in frames]))
    return np.array(found)


@pytest.fixture(scope="module")
def truth():
    return runs("path", world(lamps()), 1000)


def t_of(found, truth):
    difference = found.mean() - truth.mean()
    error = np.hypot(found.std(ddof=1), truth.std(ddof=1)) / np.sqrt(RUNS)
    assert error < 0.04 * truth.mean()
    return abs(difference) / error


BOUND = stats.t.isf(ALARM / 2, RUNS - 1)


@pytest.mark.slow
@pytest.mark.parametrize("name", UNBIASED)
def test_methods_see_textured_lamps_and_spots_alike(name, truth):
    assert t_of(runs(name, world(lamps()), 0), truth) < BOUND


@pytest.mark.slow
def test_a_lamp_of_one_side_is_another(truth):
    found = lamps()
    meshes = tuple(replace(mesh, two_sided_emission=False) for mesh in found.meshes)
    other = runs("path", world(replace(found, meshes=meshes)), 2000)
    assert t_of(other, truth) > BOUND

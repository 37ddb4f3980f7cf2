"""The words of Mitsuba's scenes give the light that Mitsuba's own `path` gives.

Evidence: statistics, and an independent renderer.  `test_mitsuba_room` shows ray by ray
that surfaces are the same; here are the lights too, and Beckmann's metal.  Light of at
most one bounce by our path tracer must agree with Mitsuba's paths of at most three
segments within 1 % in the image mean, and each tile of 8 x 8 pixels within its band.  A
correct loader fails the tiles with probability 1e-4, and the mean with the probability
that is printed.  The controls are rooms with one word taken otherwise, each of which
must fail.  The mask is left out: Mitsuba counts its holes as segments.
"""

import re

import numpy as np
import pytest
from scipy import stats

from restir_gi.reference.numerics.rng import KeyedUniforms, Stream
from restir_gi.reference.scene.loaders.load import load_scene
from restir_gi.reference.transport.path_tracer import camera_radiance
from tests.contracts.test_mitsuba_room import (
    HEIGHT,
    OTHERWISE,
    WIDTH,
    furnish,
    written,
)
from tests.statistics.replicates import (
    BATCHES,
    Means,
    in_batches,
    means,
    small_world,
    threshold,
)

mitsuba = pytest.importorskip("mitsuba", reason="Mitsuba renders the truth")

FAMILY = 1e-4
LIMIT = 0.01
MASK = re.compile(r'<shape type="rectangle">(?:(?!</shape>).)*"mask".*?</shape>', re.S)


def without_mask(path):
    text, count = MASK.subn("", path.read_text())
    assert count == 1
    path.write_text(text)
    return path


def ours(path) -> Means:
    world = small_world(load_scene(path), WIDTH, HEIGHT)

    def color(points, pixel, number):
        u = KeyedUniforms(pixel, number, 3, Stream.PATH)
        return camera_radiance(world, points, "full", 1, u)

    return in_batches(world, 640, color, np.random.default_rng(5))


def theirs(path, samples) -> Means:
    mitsuba.set_variant("scalar_rgb")
    scene = mitsuba.load_file(str(path))
    options = {"type": "path", "max_depth": 3, "rr_depth": 1000}
    integrator = mitsuba.load_dict(options)
    rows = []
    for batch in range(BATCHES):
        picture = mitsuba.render(scene, integrator=integrator, seed=batch, spp=samples)
        rows.append(np.array(picture, np.float64)[..., :3].reshape(-1, 3))
    return means(rows, WIDTH)


def judge(a: Means, b: Means) -> tuple[float, float, float]:
    """Relative difference of the image means, its error, and the tiles' largest |t|."""
    difference, scale = a.mean - b.mean, b.mean[0]
    error = np.sqrt(a.error**2 + b.error**2).clip(1e-300)
    t = np.abs(difference / error)[1:].max()
    return float(difference[0] / scale), float(error[0] / scale), float(t)


@pytest.mark.slow
def test_a_room_of_words(tmp_path):
    furnish(tmp_path)
    truth = theirs(without_mask(written(tmp_path)), 40)
    bias, error, t = judge(ours(without_mask(written(tmp_path))), truth)
    false_alarm = 2 * stats.norm.sf(LIMIT / error)
    print(
        f"bias {bias:+.3%} +- {error:.3%}, largest |t| {t:.2f}; a correct loader's mean"
        f" would fail with probability {false_alarm:.0e}"
    )
    bound = threshold(len(truth.mean) - 1, FAMILY, BATCHES)
    assert t <= bound
    assert abs(bias) <= LIMIT
    for word in ("moved", "clamped", "shining", "first"):
        path = without_mask(written(tmp_path, **{word: OTHERWISE[word]}))
        wrong, _, worst = judge(ours(path), truth)
        print(f"{word} otherwise: {wrong:+.3%}, largest |t| {worst:.2f}")
        assert worst > bound or abs(wrong) > LIMIT

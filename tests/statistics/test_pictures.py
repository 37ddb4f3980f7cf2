"""How often a right renderer is accused by its pictures, and a wrong one passes.

Pictures are drawn, with replacement, from some thousand real ones of 16 x 16 pixels,
whose mean is then the exact truth: light that comes rarely, noise that reuse has spread
over many pixels, and light that hardly ever comes at all.  What the oracle knows of the
truth has an error of its own in each verdict.
"""

from functools import cache

import numpy as np
import pytest

from restir_gi.reference.numerics.moments import Moments
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.oracle.blackbox.convention import Convention
from restir_gi.reference.oracle.blackbox.evidence import Tolerance
from restir_gi.reference.oracle.blackbox.judge import judge_pictures
from restir_gi.reference.oracle.blackbox.truth import Truth, rows_of
from restir_gi.reference.scene.catalogue.registry import find_scene
from restir_gi.reference.settings import Settings
from restir_gi.reference.transport.accumulate import path_samples
from tests.statistics.replicates import apart, frame_colors, g_buffer, small_world, tall

pytestmark = pytest.mark.slow

SIZE, ASKED = 16, Convention()
SAMPLES = 200_000
"""Of the truth: its errors are some thousandths then."""

NEVER = Tolerance(1e-9, 1e-9)
"""So that no verdict ends early with PASS."""

VERDICTS, MOST = 1000, 100


@cache
def path_traced(scene, count):
    """Pictures of one path a pixel."""
    scenery = small_world(find_scene(scene), SIZE, SIZE)
    whole = Schedule(band=SIZE**2 + 1)
    samples = path_samples(scenery, whole, light="indirect", bounces=1, seed=5)
    every = slice(0, SIZE**2)
    return pictures_of([samples.radiance(every, k) for k in range(count)])


@cache
def reused(scene, count, together=16):
    """Sixth frames of unbiased ReSTIR GI, with weights 1/Z."""
    scenery = small_world(find_scene(scene), SIZE, SIZE)
    column, seen = tall(scenery, [g_buffer(scenery)] * together)
    found = []
    for seed in range(count // together):
        last = frame_colors(column, Settings(), 6, 1000 + seed, seen)[-1]
        found.extend(apart(last, scenery, together))
    return pictures_of(found)


def rare(count, share=0.02):
    """Sixteen lamps that are seen in one of fifty pictures each."""
    rng = np.random.default_rng(4)
    lamps = (rng.random((count, 4, 4)) < share) / share
    return np.repeat(lamps.repeat(4, 1).repeat(4, 2)[..., None], 3, 3)


def pictures_of(rows):
    return np.array(rows, np.float32).reshape(-1, SIZE, SIZE, 3)


POOLS = {
    "door-ajar, path traced": lambda: (path_traced("door-ajar", 4000), "door-ajar"),
    "door-ajar, ReSTIR GI": lambda: (reused("door-ajar", 1600), "door-ajar"),
    "cornell-box, ReSTIR GI": lambda: (reused("cornell-box", 1600), "cornell-box"),
    "lamps that are rarely seen": lambda: (rare(4000), ""),
}


def noise_of(pool, scene):
    """Variances of the path tracer where there is one, else those of the pool."""
    known = path_traced(scene, 4000) if scene else pool
    return np.var([rows_of(picture) for picture in known], axis=0)


class KnownPictures:
    """Pictures whose truth is known, and what an oracle knows of it."""

    def __init__(self, name):
        self.pool, scene = POOLS[name]()
        self.mean = np.mean([rows_of(picture) for picture in self.pool], axis=0)
        self.variance = noise_of(self.pool, scene)

    def truth(self, rng):
        """Truth with an error of its own; light is not negative."""
        error = np.sqrt(self.variance / SAMPLES) * rng.standard_normal(self.mean.shape)
        mean = np.maximum(self.mean + error, 0.0)
        return Truth(Moments(SAMPLES, mean, self.variance * SAMPLES), (SIZE, SIZE))

    def verdict(self, seed, alpha, tolerance=NEVER, factor=1.0, most=MOST):
        """Verdict on pictures drawn by a seed, so many times too bright."""
        rng = np.random.default_rng(seed)
        chosen = rng.integers(0, len(self.pool), most)
        # Pictures of two seeds are never the same to the last bit.
        tiny = 1 + 1e-7 * rng.standard_normal(most)
        made = (factor * f * self.pool[k] for f, k in zip(tiny, chosen, strict=True))
        truth = self.truth(rng)
        return judge_pictures(made, lambda _: truth, ASKED, tolerance, alpha=alpha)


pictures_from = cache(KnownPictures)


@pytest.mark.parametrize("name", POOLS)
def test_right_renderers_are_not_accused(name):
    """None of 1,000 at the default level; at 1e-2 more than 22 are a chance of 3e-4."""
    known = pictures_from(name)
    verdicts = [known.verdict(seed, 1e-2) for seed in range(VERDICTS)]
    accused = [v for v in verdicts if v.status == "FAIL"]
    assert len(accused) <= 22
    again = [known.verdict(k, 5e-7) for k, v in enumerate(verdicts) if v in accused]
    assert [v.sentence for v in again if v.status == "FAIL"] == []


# Of a lamp that is seen in two of a hundred pictures nobody can tell so much.
@pytest.mark.parametrize("name", list(POOLS)[:3])
def test_control_what_is_too_bright_is_accused(name):
    verdicts = [
        pictures_from(name).verdict(seed, 5e-7, factor=4.0) for seed in range(20)
    ]
    assert [v.status for v in verdicts] == ["FAIL"] * 20


@pytest.mark.parametrize("name", POOLS)
@pytest.mark.parametrize("factor", [1.3, 1 / 1.3])
def test_what_is_off_by_the_tolerance_hardly_ever_passes(name, factor):
    """In at most one of 20 verdicts: more than 19 of 200 are a chance of 2e-3."""
    off = Tolerance(abs(factor - 1), 10.0)
    verdicts = [
        pictures_from(name).verdict(seed, 1e-300, off, factor) for seed in range(200)
    ]
    assert sum(v.status == "PASS" for v in verdicts) <= 19


def test_control_what_is_right_passes():
    """Of as many pictures, within the same tolerance."""
    known = pictures_from("cornell-box, ReSTIR GI")
    verdicts = [known.verdict(k, 5e-7, Tolerance(0.3, 10.0)) for k in range(20)]
    assert [v.status for v in verdicts] == ["PASS"] * 20


def test_control_noise_that_nobody_expects_would_be_accused():
    """Dark tiles accuse right renderers, where the path tracer's noise is not known."""
    known = pictures_from("lamps that are rarely seen")
    blind = with_variance(known, 0.0)
    verdicts = [blind.verdict(seed, 5e-7) for seed in range(20)]
    assert sum(v.status == "FAIL" for v in verdicts) > 10


def with_variance(known, factor):
    other = KnownPictures.__new__(KnownPictures)
    other.pool, other.mean = known.pool, known.mean
    other.variance = factor * known.variance
    return other

"""ReSTIR GI through a floor of rough glass: what is not reused is traced apart.

Evidence: statistics.  Initial samples against the path tracer, and reuse against its
own initial samples; no 8 x 8 tile may leave its band.  A correct estimator fails each
of the tests with probability 1e-4.  The control takes rough glass for a surface whose
light is reused, and still traces it apart: what is reflected then counts twice.
"""

from dataclasses import replace

import numpy as np
import pytest

from restir_gi.reference.resampling import source, target
from restir_gi.reference.scene.catalogue.speculars import glass_floor
from restir_gi.reference.scene.materials.kinds import Dielectric
from restir_gi.reference.scene.validation import validate
from restir_gi.reference.settings import UNBIASED
from restir_gi.reference.transport import not_reused
from tests.statistics.replicates import (
    BATCHES,
    g_buffer,
    initially_sampled,
    largest_t,
    means,
    path_traced,
    runs_at_once,
    small_world,
    threshold,
)

FAMILY, SIZE, RUNS, SAMPLES = 1e-4, 24, 24, 256


def frosted():
    """The room on a pane of glass, now rough."""
    glass = Dielectric(1.5, 0.3, "beckmann")
    scene = glass_floor()
    meshes = tuple(
        replace(mesh, material=glass) if mesh.name == "pane" else mesh
        for mesh in scene.meshes
    )
    return small_world(validate(replace(scene, meshes=meshes)), SIZE, SIZE)


def what_reuse_changes(world):
    pairs = []
    for first in range(0, RUNS, 8):
        pairs += runs_at_once(world, UNBIASED, 4, first, [g_buffer(world)] * 8)
    return means([a - b for a, b in pairs], SIZE)


def off(source):
    """Largest |t| of initial samples against the path tracer, and its threshold."""
    world = frosted()
    expected = path_traced(world, SAMPLES)
    found = initially_sampled(world, replace(UNBIASED, source=source), SAMPLES)
    error = np.hypot(found.error, expected.error).clip(1e-300)
    t = np.abs((found.mean - expected.mean) / error)
    print(f"{source}: largest |t| {t.max():.2f}, mean ± {error[0] / found.mean[0]:.2%}")
    return t.max(), threshold(len(t), FAMILY, BATCHES)


@pytest.mark.slow
@pytest.mark.parametrize("source", ["cosine", "bsdf"])
def test_initial_samples_agree_with_the_path_tracer(source):
    t, limit = off(source)
    assert t <= limit


@pytest.mark.slow
def test_control_what_is_reused_and_traced_apart_counts_twice(monkeypatch):
    def everyone(table, points):
        return np.ones(len(points), bool)

    for module in (target, source, not_reused):
        monkeypatch.setattr(module, "is_shared", everyone)
    t, limit = off("cosine")
    assert t > limit


@pytest.mark.slow
def test_reuse_brings_no_bias():
    reuse = what_reuse_changes(frosted())
    print(f"largest |t| {largest_t(reuse):.2f}")
    assert largest_t(reuse) <= threshold(len(reuse.mean) - 1, FAMILY, RUNS)

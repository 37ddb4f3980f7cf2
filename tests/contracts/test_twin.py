"""The twin of sixty lines makes the frames of the renderer, to the last bit."""

import importlib.util
from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np
import pytest

from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.restir_gi import render_frames
from restir_gi.reference.scene.catalogue.registry import find_scene
from restir_gi.reference.scene.validation import validate
from restir_gi.reference.settings import UNBIASED
from restir_gi.reference.transport.world import build_world

PATH = Path(__file__).parents[2] / "docs/examples/restir_gi_60_lines.py"
FRAMES = 12
MOST_LINES = 70


@pytest.fixture(scope="module")
def twin():
    spec = importlib.util.spec_from_file_location("restir_gi_60_lines", PATH)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def small(name):
    scene = find_scene(name)
    return build_world(
        validate(replace(scene, camera=replace(scene.camera, width=24, height=24)))
    )


@pytest.mark.parametrize("name", ["cornell-box", "glossy-floor", "half-lit-sphere"])
def test_every_frame_is_the_renderers(twin, name):
    """Many frames: pixels whose spatial M has grown try fewer neighbours."""
    world = small(name)
    settings = replace(UNBIASED, spatial_cap=40.0)
    twin.s = settings
    theirs = render_frames(world, settings, 2, 5, Schedule())
    for ours, frame in zip(
        islice(twin.frames(world, 2, 5), FRAMES), theirs, strict=False
    ):
        assert np.array_equal(ours, frame.color)
    few = settings.spatial_cap / 2 <= frame.spatial.M
    assert few.any()


def test_control_another_seed_is_another_frame(twin):
    world = small("cornell-box")
    first, other = (next(twin.frames(world, 2, seed)) for seed in (5, 6))
    assert not np.array_equal(first, other)


def test_it_is_about_sixty_lines():
    """Statements and comments of ``frames``, without blank lines."""
    text = PATH.read_text("utf-8")
    body = text[text.index("def frames(") : text.index('if __name__ == "__main__"')]
    assert sum(bool(line.strip()) for line in body.splitlines()) <= MOST_LINES

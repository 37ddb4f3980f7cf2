"""Reservoirs at a lower resolution: a pixel of each square has one, all are shaded.

Evidence: properties.  Inside an evenly glowing sphere all samples are worth as much, so
that pixels without a reservoir are as exact as those with one, to rounding.
"""

from dataclasses import replace
from functools import partial
from itertools import islice

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from restir_gi.reference.methods import method_named
from restir_gi.reference.methods.setting_values import with_values
from restir_gi.reference.numerics.records import NONE
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.options.reduced_resolution import corner, keeps_reservoir
from restir_gi.reference.passes.neighbors import find_neighbors
from restir_gi.reference.restir_gi import render_frames
from restir_gi.reference.scene.catalogue.answers import sphere_furnace
from restir_gi.reference.scene.named import Named, find_scene_or_file, frames_of
from restir_gi.reference.settings import UNBIASED
from restir_gi.reference.transport.world import build_world
from tests.contracts.test_tradeoff import job
from tests.properties.test_neighbors import FLAT, as_draws


def run(name, lattice, frames=4, size=16, **settings):
    """Frames, and the rays that drew new samples."""
    animation = frames_of(Named(name, False, size, size), find_scene_or_file(name))
    world = build_world(animation(0))
    about = replace(UNBIASED, lattice=lattice, **settings)
    made = render_frames(world, about, 1, 0, Schedule(), animation)
    return list(islice(made, frames)), world


@given(st.integers(1, 9), st.integers(1, 9), st.integers(1, 5))
def test_squares_have_one_corner(width, height, side):
    """Inside of the image, in the same square, and its own."""
    rows = np.arange(width * height)
    found = corner(rows, width, side)
    assert np.array_equal(corner(found, width, side), found)
    dx, dy = rows % width - found % width, rows // width - found // width
    assert ((dx >= 0) & (dx < side) & (dy >= 0) & (dy < side)).all()
    squares = -(-width // side) * -(-height // side)
    assert keeps_reservoir(rows, width, side).sum() == squares


@given(st.integers(2, 4), st.integers(0, 9))
def test_neighbours_are_those_that_have_reservoirs(side, seed):
    size = len(FLAT.depth)
    u = np.random.default_rng(seed).random((5 * 4, size))
    draws = as_draws(u.ravel(), 5)
    width = 12
    for found in find_neighbors(
        np.arange(size),
        FLAT,
        width,
        UNBIASED,
        draws,
        partial(corner, width=width, side=side),
    ):
        there = found[found != NONE]
        assert keeps_reservoir(there, width, side).all()


@pytest.mark.parametrize("name", ["cornell-box", "moving-camera", "moving-light"])
@pytest.mark.parametrize("side", [2, 4])
def test_others_draw_nothing_and_keep_nothing(name, side):
    frames, world = run(name, side)
    keeps = keeps_reservoir(np.arange(256), 16, side)
    for frame in frames:
        for kept in (frame.temporal, frame.spatial):
            assert not kept.M[~keeps].any()
            assert not kept.W[~keeps].any()
            assert kept.M[keeps].any()
        # But they are shaded.
        assert frame.color[~keeps].any()
    drawn = world.caster.counts["initial"]
    assert drawn <= 4 * keeps.sum()
    assert frames[-1].temporal.M.max() == 4.0


@pytest.mark.parametrize("mis", ["1/M", "1/Z", "balance", "pairwise", "defensive"])
@pytest.mark.parametrize("side", [2, 3])
def test_inside_a_sphere_all_pixels_are_exact(mis, side):
    """But those to whom nobody lends anything, which are black.

    Of 9 tries in a disk of ten pixels about one of 256 nearly none fails.
    """
    about = {"source": "cosine", "mis": mis, "max_angle": 180.0, "max_depth": 1.0}
    frames, _ = run("sphere-furnace", side, radius=0.7, **about)
    _, answer, _ = sphere_furnace(1)
    color = frames[-1].color
    lit = color.any(axis=1)
    assert lit.mean() > 0.98
    np.testing.assert_allclose(color[lit] / answer, 1.0, rtol=1e-12)


def test_a_lattice_needs_neighbours():
    settings = method_named("restir-gi-unbiased").settings
    for wrong in ("spatial=false", "reuse=fused", "reuse=double-buffered"):
        with pytest.raises(Exception, match="needs spatial=true and reuse=separate"):
            with_values(settings, ("lattice=2", wrong))
    assert with_values(settings, ("lattice=2",)).lattice == 2


def test_less_is_kept():
    """A fourth of the reservoirs; the G-buffer stays."""
    method = method_named("restir-gi-unbiased")
    sizes = []
    for lattice in (1, 2):
        settings = replace(method.settings, lattice=lattice)
        frames = method.frames(replace(job(method), settings=settings))
        sizes.append(next(frames).kept)
    assert sizes[0] - sizes[1] == pytest.approx(0.75 * 2 * 88)

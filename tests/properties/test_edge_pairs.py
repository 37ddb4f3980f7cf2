"""Edge pairs: told by albedo, normal and depth, symmetric, none out of the image."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from gradient_domain.edges import Axis, differ, edges, partners
from reference.passes.neighbors import NONE
from reference.records import take
from reference.scene.surface import SurfacePoints, VisiblePoints
from tests.properties.path_scenes import world
from tests.statistics.replicates import g_buffer

WIDTH, HEIGHT = 12, 8


def flat(width=WIDTH, height=HEIGHT):
    """A grey wall that all pixels see, 2 m away."""
    n = width * height
    up = np.tile([0.0, 0.0, 1.0], (n, 1))
    zeros = np.zeros(n, np.int32)
    surface = SurfacePoints(
        position=np.zeros((n, 3)),
        normal=up,
        smooth=None,
        wo=up,
        color=np.full((n, 3), 0.5),
        material=zeros,
        primitive=zeros,
        front=np.ones(n, bool),
    )
    return VisiblePoints(surface, np.full(n, 2.0))


def changed(visible, mask, **fields):
    """The same, other at some pixels."""
    surface, depth = visible.surface, visible.depth.copy()
    if "depth" in fields:
        depth[mask] = fields.pop("depth")
    for name, value in fields.items():
        column = getattr(surface, name).copy()
        column[mask] = value
        surface = replace(surface, **{name: column})
    return VisiblePoints(surface, depth)


def right_half():
    return np.arange(WIDTH * HEIGHT) % WIDTH >= WIDTH // 2


def turned(degrees):
    angle = np.radians(degrees)
    return [np.sin(angle), 0.0, np.cos(angle)]


CHANGES = {
    "albedo, enough": ({"color": 0.6001}, True),
    "albedo, too little": ({"color": 0.5999}, False),
    "albedo of a channel": ({"color": [0.5, 0.5, 0.39]}, True),
    "normal, enough": ({"normal": turned(26.0)}, True),
    "normal, too little": ({"normal": turned(25.6)}, False),
    "depth, enough": ({"depth": 2.23}, True),
    "depth, too little": ({"depth": 2.22}, False),
    "nothing is seen": ({"primitive": -1, "depth": 0.0}, True),
}


@pytest.mark.parametrize("name", CHANGES)
def test_what_is_an_edge(name):
    """Between the halves of the image, and nowhere else."""
    fields, expected = CHANGES[name]
    found = edges(changed(flat(), right_half(), **fields), WIDTH)
    x = found.x.reshape(HEIGHT, WIDTH)
    assert (x[:, WIDTH // 2 - 1] == expected).all()
    x[:, WIDTH // 2 - 1] = False
    assert not x.any()
    assert not found.y.any()


def test_a_grid_of_dark_and_white():
    """Squares of 4 pixels: a quarter of the pairs, and none in the last column."""
    at = np.arange(16 * 16)
    dark = ((at % 16 // 4) + (at // 16 // 4)) % 2 == 0
    found = edges(changed(flat(16, 16), dark, color=0.05), 16)
    assert found.x.sum() == found.y.sum() == 16 * 3
    assert_array_equal(np.flatnonzero(found.x[:16]), [3, 7, 11])
    assert_array_equal(np.flatnonzero(found.y[::16]), [3, 7, 11])


def test_where_nobody_sees_anything_is_no_edge():
    empty = changed(flat(), np.ones(WIDTH * HEIGHT, bool), primitive=-1, depth=0.0)
    found = edges(empty, WIDTH)
    assert not (found.x | found.y).any()


@pytest.mark.parametrize("axis", Axis)
@pytest.mark.parametrize("size", [(1, 1), (1, 5), (4, 1), (5, 3)])
def test_partners_are_the_next_pixels(axis, size):
    width, height = size
    second = partners(width, height, axis)
    step = 1 if axis == Axis.X else width
    there = second != NONE
    assert_array_equal(second[there], np.flatnonzero(there) + step)
    last = np.arange(width * height) % width == width - 1
    if axis == Axis.Y:
        last = np.arange(width * height) // width == height - 1
    assert_array_equal(~there, last)


@pytest.mark.parametrize("scene", ["paint", "checker", "many-lights"])
def test_an_edge_is_one_from_both_sides(scene):
    """Printed is a depth relative to the first pixel: the pair would have an order."""
    visible = g_buffer(world(scene))
    for axis in Axis:
        second = partners(32, 32, axis)
        rows = np.flatnonzero(second != NONE)
        a, b = take(visible, rows), take(visible, second[rows])
        assert_array_equal(differ(a, b), differ(b, a))
        assert differ(a, b).any()
        assert not differ(a, b).all()

"""Pairs of pixels: which there are, which lie across an edge, and who looks alike."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from restir_gi.gradient_domain.gradient_restir import edge_neighbors, unlike
from restir_gi.gradient_domain.pairs import (
    Axis,
    as_differences,
    draw_around,
    pair_at,
    pixel_pairs,
)
from restir_gi.gradient_domain.reconstruction import differences
from restir_gi.gradient_domain.settings import GradientSettings
from restir_gi.reference.frame import FrameContext
from restir_gi.reference.numerics.records import NONE
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.scene.surface import SurfacePoints, VisiblePoints
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


def edges(visible, width):
    """Of each axis, at the first pixels."""
    pairs = pixel_pairs(width, len(visible.depth) // width)
    across = unlike(visible, pairs.first, pairs.second)
    found = np.zeros((2, len(visible.depth)), bool)
    found[pairs.axis, pairs.first] = across
    return found


@pytest.mark.parametrize("name", CHANGES)
def test_what_is_an_edge(name):
    """Between the halves of the image, and nowhere else."""
    fields, expected = CHANGES[name]
    x, y = edges(changed(flat(), right_half(), **fields), WIDTH)
    x = x.reshape(HEIGHT, WIDTH)
    assert (x[:, WIDTH // 2 - 1] == expected).all()
    x[:, WIDTH // 2 - 1] = False
    assert not x.any()
    assert not y.any()


def test_a_grid_of_dark_and_white():
    """Squares of 4 pixels: a quarter of the pairs, and none in the last column."""
    at = np.arange(16 * 16)
    dark = ((at % 16 // 4) + (at // 16 // 4)) % 2 == 0
    x, y = edges(changed(flat(16, 16), dark, color=0.05), 16)
    assert x.sum() == y.sum() == 16 * 3
    assert_array_equal(np.flatnonzero(x[:16]), [3, 7, 11])
    assert_array_equal(np.flatnonzero(y[::16]), [3, 7, 11])


def test_where_nobody_sees_anything_is_no_edge():
    empty = changed(flat(), np.ones(WIDTH * HEIGHT, bool), primitive=-1, depth=0.0)
    assert not edges(empty, WIDTH).any()


SIZES = [(1, 1), (1, 5), (4, 1), (5, 3)]


@pytest.mark.parametrize("size", SIZES)
def test_pairs_are_those_that_do_not_lead_out(size):
    width, height = size
    pairs = pixel_pairs(width, height)
    assert len(pairs) == height * (width - 1) + (height - 1) * width
    step = np.where(pairs.axis == Axis.X, 1, width)
    assert_array_equal(pairs.second, pairs.first + step)
    same_line = pairs.first // width == pairs.second // width
    assert_array_equal(same_line, pairs.axis == Axis.X)
    assert_array_equal(pairs.dx + width * pairs.dy, step)


@pytest.mark.parametrize("size", SIZES)
def test_a_pair_is_found_by_its_first_pixel(size):
    """And none at pixels that have no neighbour, or are not there."""
    width, height = size
    pairs = pixel_pairs(width, height)
    y, x = np.divmod(pairs.first, width)
    rows = pair_at(pairs.axis, x, y, width, height)
    assert_array_equal(rows, np.arange(len(pairs)))
    y, x = (v.ravel() - 2 for v in np.mgrid[: height + 4, : width + 4])
    for axis in Axis:
        found = pair_at(np.full(len(x), axis), x, y, width, height)
        assert (found != NONE).sum() == (pairs.axis == axis).sum()


@pytest.mark.parametrize("size", SIZES)
def test_differences_are_minus_those_of_pairs(size):
    """The paper's is pixel less neighbour; an image is made from the other one."""
    image = np.random.default_rng(3).random((size[0] * size[1], 3))
    pairs = pixel_pairs(*size)
    delta = image[pairs.first] - image[pairs.second]
    found, expected = (
        as_differences(pairs, delta, len(image)),
        differences(image, size[0]),
    )
    assert_array_equal(found.x, expected.x)
    assert_array_equal(found.y, expected.y)


SCENES = ["paint", "checker", "many-lights"]


@pytest.mark.parametrize("scene", SCENES)
def test_an_edge_is_one_from_both_sides(scene):
    """Printed is a depth relative to the first pixel: the pair would have an order."""
    seen, pairs = g_buffer(world(scene)), pixel_pairs(32, 32)
    across = unlike(seen, pairs.first, pairs.second)
    assert_array_equal(across, unlike(seen, pairs.second, pairs.first))
    assert across.any()
    assert not across.all()


# ------------------------------------------------------------ pairs around

RADIUS = 4


def frame(scene, radius=RADIUS, tries=256, size=32, visible=None):
    """Of a scene, where pairs look for others so many pixels around."""
    w = world(scene, size)
    settings = GradientSettings(radius=0.0, min_radius=radius, tries=tries)
    return FrameContext(0, w, visible or g_buffer(w), settings, 1, 7, Schedule(500, 2))


def test_pairs_around_are_drawn_evenly_from_a_square():
    """Of the same axis; the pair itself, and pixels outside, are nobody."""
    pairs, side = pixel_pairs(32, 32), 2 * RADIUS + 1
    middle = pair_at(np.array([Axis.Y]), np.array([16]), np.array([16]), 32, 32)
    u = (np.arange(side**2) + 0.5) / side**2
    found = draw_around(frame("paint"), pairs, np.repeat(middle, side**2), u)
    assert (found == NONE).sum() == 1
    first = pairs.first[found[found != NONE]]
    assert len(set(first)) == side**2 - 1
    assert (np.abs(first % 32 - 16) <= RADIUS).all()
    assert (np.abs(first // 32 - 16) <= RADIUS).all()
    corner = pair_at(np.array([Axis.Y]), np.array([0]), np.array([0]), 32, 32)
    found = draw_around(frame("paint"), pairs, np.repeat(corner, side**2), u)
    assert (found != NONE).sum() == (RADIUS + 1) ** 2 - 1


@pytest.mark.parametrize("scene", SCENES)
def test_those_found_are_edges_that_look_alike(scene):
    pairs = pixel_pairs(32, 32)
    few, many = (edge_neighbors(frame(scene, tries=n), pairs) for n in (6, 256))
    seen = frame(scene).visible
    across = unlike(seen, pairs.first, pairs.second)
    at = np.flatnonzero(many != NONE)
    found = many[at]
    assert across[at].all()
    assert len(at) > across.sum() / 3
    assert across[found].all()
    assert (found != at).all()
    for pixel in (pairs.first, pairs.second):
        assert not unlike(seen, pixel[at], pixel[found]).any()
    assert (pairs.axis[found] == pairs.axis[at]).all()
    # Who has found somebody looks no further.
    early = few != NONE
    assert_array_equal(few[early], many[early])
    assert early.sum() < len(at)
    # The edge lies the same way round: first pixels are alike, and second ones.
    step = pairs.first[found] - pairs.first[at]
    assert (np.abs((step + 16) % 32 - 16) <= RADIUS).all()


def test_an_edge_of_the_other_order_is_not_alike():
    """Dark to white, and white to dark."""
    at = np.arange(16 * 16)
    striped = changed(flat(16, 16), at % 16 // 4 % 2 == 0, color=0.05)
    pairs = pixel_pairs(16, 16)
    found = edge_neighbors(frame("paint", 8, size=16, visible=striped), pairs)
    rows = np.flatnonzero(unlike(striped, pairs.first, pairs.second))
    assert (found[rows] != NONE).all()
    column = pairs.first % 16
    assert_array_equal(column[found[rows]] // 4 % 2, column[rows] // 4 % 2)

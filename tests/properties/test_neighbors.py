"""The search for neighbours: who is found, and how far away."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

from restir_gi.reference.numerics.arrays import dot
from restir_gi.reference.numerics.records import NONE
from restir_gi.reference.passes.neighbors import find_neighbors
from restir_gi.reference.scene.surface import SurfacePoints, VisiblePoints
from restir_gi.reference.settings import Settings
from restir_gi.reference.strategies import uniforms, unit_vectors

WIDTH, HEIGHT = 9, 7
N = WIDTH * HEIGHT


def frame(normals, depth):
    """A G-buffer of which only normals and depths matter."""
    nothing, zero = np.zeros((N, 3)), np.zeros(N, np.int32)
    surface = SurfacePoints(
        nothing, normals, None, nothing, nothing, zero, zero, np.ones(N, bool)
    )
    return VisiblePoints(surface, depth)


FLAT = frame(np.tile([0.0, 0.0, 1.0], (N, 1)), np.ones(N))


@st.composite
def frames(draw):
    """Two orientations and three depths over the image, and some holes."""
    n = draw(unit_vectors(2))
    which = np.array(draw(st.lists(st.integers(0, 1), min_size=N, max_size=N)))
    depth = np.array(
        draw(st.lists(st.sampled_from([0.0, 1.0, 1.04, 2.0]), min_size=N, max_size=N))
    )
    return frame(n[which], depth)


def search(visible, draws, rows=None, width=WIDTH, **settings):
    rows = np.arange(N) if rows is None else rows
    return find_neighbors(rows, visible, width, Settings(**settings), draws)


def as_draws(u, tries):
    """Four lanes a try."""
    return [tuple(lane) for lane in u.reshape(tries, 4, -1)]


@given(frames(), uniforms(3 * 4 * N), st.sampled_from([0.1, 0.3, 2.0]))
def test_neighbours_are_others_that_look_alike(visible, u, radius):
    """Inside of the image, not the pixel itself, within the limits of section 4.2."""
    normal, depth = visible.surface.normal, visible.depth
    rows = np.arange(N)
    for found in search(visible, as_draws(u, 3), radius=radius):
        there = found != NONE
        a, b = rows[there], found[there]
        assert ((b >= 0) & (b < N)).all()
        assert (a != b).all()
        cosine = dot(normal[a], normal[b])
        assert (cosine >= np.cos(np.radians(25))).all()
        near, far = np.minimum(depth[a], depth[b]), np.maximum(depth[a], depth[b])
        assert (near > 0).all()
        assert (far - near <= 0.05 * far).all()
        # Half a pixel for rounding to centres, in each coordinate.
        reach = max(radius * WIDTH, 3.0) + np.sqrt(0.5)
        distance = np.hypot(a % WIDTH - b % WIDTH, a // WIDTH - b // WIDTH)
        assert (distance <= reach).all()


@given(uniforms(4 * N))
def test_the_point_of_the_disk_is_that_of_its_numbers(u):
    """Radius √u1 and angle 2π u2: in a plain image, wherever that is inside."""
    (found,) = search(FLAT, as_draws(u, 1), radius=0.5)
    lanes = as_draws(u, 1)[0]
    r, phi = 4.5 * np.sqrt(lanes[0]), 2 * np.pi * lanes[1]
    rows = np.arange(N)
    x = rows % WIDTH + np.rint(r * np.cos(phi)).astype(int)
    y = rows // WIDTH + np.rint(r * np.sin(phi)).astype(int)
    inside = (x >= 0) & (x < WIDTH) & (y >= 0) & (y < HEIGHT)
    expected = np.where(inside & (y * WIDTH + x != rows), y * WIDTH + x, NONE)
    assert_array_equal(found, expected)


def far_to_the_right(tries):
    """Numbers that point to the rim of the disk, along the row."""
    u = np.zeros((tries, 4, 1))
    u[:, 0] = 1 - 2.0**-24
    return [tuple(lanes) for lanes in u]


@pytest.mark.parametrize("alike_from", [0, 13, 30])
def test_failures_halve_the_radius_down_to_three_pixels(alike_from):
    """A row of 100 pixels: 50, 25, 12.5, 6.25, 3.125, 3, 3, ... to the right.

    Pixels from ``alike_from`` on turn away; the first that does not is found, and then
    the radius stays.
    """
    width = 100
    normal = np.tile([0.0, 0.0, 1.0], (width, 1))
    if alike_from:
        normal[alike_from:] = [1.0, 0.0, 0.0]
    zero = np.zeros(width, np.int32)
    nothing = np.zeros((width, 3))
    surface = SurfacePoints(
        nothing, normal, None, nothing, nothing, zero, zero, np.ones(width, bool)
    )
    visible = VisiblePoints(surface, np.ones(width))
    draws = far_to_the_right(7)
    found = search(visible, draws, np.zeros(1, int), width, radius=0.5)
    steps = {0: [50] * 7, 13: [NONE] * 2 + [12] * 5, 30: [NONE] + [25] * 6}
    assert [int(f[0]) for f in found] == steps[alike_from]


def test_the_radius_is_never_below_its_least():
    """Nobody is alike: the search goes on at three pixels, and finds nobody."""
    lonely = np.tile([1.0, 0.0, 0.0], (N, 1))
    lonely[0] = [0.0, 0.0, 1.0]
    found = search(frame(lonely, np.ones(N)), far_to_the_right(5), np.zeros(1, int))
    assert [int(f[0]) for f in found] == [NONE] * 5
    # 10 % of nine pixels is less than three.
    (first,) = search(FLAT, far_to_the_right(1), np.zeros(1, int))
    assert first[0] == 3


def test_where_nothing_is_seen_nobody_is_a_neighbour():
    depth = np.ones(N)
    depth[:WIDTH] = 0.0
    visible = frame(FLAT.surface.normal, depth)
    (found,) = search(visible, far_to_the_right(1), np.arange(WIDTH - 3))
    assert_array_equal(found, NONE)

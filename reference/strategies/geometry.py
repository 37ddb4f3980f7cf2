"""Directions, points and the geometry of reuse."""

from dataclasses import dataclass

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from restir_gi.reference.numerics.arrays import Scalars, Vec3s, normalize
from restir_gi.reference.numerics.frames import normal_frames
from restir_gi.reference.resampling.reservoir import Samples
from restir_gi.reference.strategies.numbers import ROWS, scalars, uniforms


@st.composite
def unit_vectors(draw: st.DrawFn, rows: int = ROWS) -> Vec3s:
    """Unit vectors: points of a cube's faces, pushed onto the sphere.

    Axes, diagonals and the edges between octants are simple examples, so that shrinking
    leads there.

    Returns strategy of (rows, 3) float64; to rounding.
    """
    face = draw(arrays(np.int64, rows, elements=st.integers(0, 5)))
    sides = draw(arrays(np.float64, (rows, 2), elements=st.floats(-1, 1)))
    axis, sign = face % 3, np.where(face < 3, 1.0, -1.0)
    cube = np.column_stack([sign, sides])
    columns = (np.arange(3) - axis[:, None]) % 3
    return normalize(np.take_along_axis(cube, columns, axis=1))


def points(reach: float = 10.0, rows: int = ROWS) -> st.SearchStrategy[Vec3s]:
    """Points of a cube about the origin, strategy of (rows, 3) float64; any.

    Parameters
    ----------
    reach : float, m; half its side
    """
    return arrays(np.float64, (rows, 3), elements=st.floats(-reach, reach))


def colors(
    low: float = 0.0, high: float = 1.0, rows: int = ROWS
) -> st.SearchStrategy[Vec3s]:
    """Linear colours, strategy of (rows, 3) float64; each channel on its own."""
    return arrays(np.float64, (rows, 3), elements=st.floats(low, high))


@st.composite
def directions_above(draw: st.DrawFn, normals: Vec3s, least: float = 0.0) -> Vec3s:
    """Unit vectors in the hemispheres of given unit normals.

    Parameters
    ----------
    normals : (N, 3) float64; unit vectors
    least : float; smallest cosine with them

    Returns
    -------
    strategy of (N, 3) float64; cosine at least ``least``, to rounding
    """
    rows = len(normals)
    cosine: Scalars = draw(scalars(least, 1.0, rows))
    phi = 2 * np.pi * draw(uniforms(rows))
    sine = np.sqrt(1 - cosine * cosine)
    tangent, bitangent = normal_frames(normals)
    found: Vec3s = (
        (sine * np.cos(phi))[:, None] * tangent
        + (sine * np.sin(phi))[:, None] * bitangent
        + cosine[:, None] * normals
    )
    return found


@dataclass(frozen=True, slots=True)
class Views:
    """A patch at a sample point, and points that look at its lit side.

    Attributes
    ----------
    position, normal : (N, 3) float64; of the patch; unit normal
    eyes : tuple of (N, 3) float64; points on the side of the normal
    """

    position: Vec3s
    normal: Vec3s
    eyes: tuple[Vec3s, ...]


@st.composite
def views_of_a_patch(
    draw: st.DrawFn,
    eyes: int = 3,
    near: float = 0.01,
    far: float = 100.0,
    least: float = 0.01,
    rows: int = ROWS,
) -> Views:
    """Points that see one patch under cosines and from distances of any kind.

    Parameters
    ----------
    eyes : int; how many points look at the patch
    near, far : float, m; smallest and largest distance
    least : float; smallest cosine at the patch

    Returns
    -------
    strategy of Views; constructed from patch, cosine, azimuth and distance
    """
    position, normal = draw(points(rows=rows)), draw(unit_vectors(rows))
    places = []
    for _ in range(eyes):
        direction = draw(directions_above(normal, least))
        distance = draw(scalars(near, far, rows))
        places.append(position + distance[:, None] * direction)
    return Views(position, normal, tuple(places))


@st.composite
def samples(draw: st.DrawFn, rows: int = ROWS, brightest: float = 100.0) -> Samples:
    """Sample points with unit normals, some of them black, which are nulls.

    Parameters
    ----------
    brightest : float, W/(m² sr); largest channel
    """
    radiance = draw(colors(0, brightest, rows))
    return Samples(draw(points(rows=rows)), draw(unit_vectors(rows)), radiance)

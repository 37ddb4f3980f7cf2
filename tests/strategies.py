"""Hypothesis strategies that construct valid input, for the tests here and for yours.

Each takes the number of rows (a *batch*) and makes whole arrays; nothing is filtered
away, so no example is thrown out.  Values span what a scene may hold, their ends
included; what lies beyond belongs to ``tests/extremes``.

>>> from hypothesis import given
>>> @given(views_of_a_patch(rows=2))
... def test(views):
...     assert views.eyes[0].shape == views.position.shape == (2, 3)
>>> test()
"""

from dataclasses import dataclass

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from reference.arrays import Vec3s, dot, normalize
from reference.frames import normal_frames
from reference.resampling.reservoir import Candidates, Reservoirs, Samples
from reference.rng import TabledUniforms
from reference.scene.materials.kinds import (
    Coated,
    Conductor,
    Dielectric,
    Lambertian,
    mirror,
)
from reference.scene.materials.parameters import Kind, MaterialTable, tabulate
from reference.scene.surface import SurfacePoints

ROWS = 5
"""Rows of a batch where a test does not say otherwise."""


def scalars(low, high, rows=ROWS, dtype=np.float64):
    """Numbers between two bounds, both included.

    Parameters
    ----------
    low, high : float
        Bounds, which ``dtype`` can represent.
    rows : int
        Size of the batch.
    dtype : type
        float16, float32 or float64.

    Returns
    -------
    strategy of (rows,) dtype
        Finite.
    """
    width = 8 * np.dtype(dtype).itemsize
    return arrays(dtype, rows, elements=st.floats(low, high, width=width))


def uniforms(rows=ROWS):
    """Multiples of 2⁻²⁴ in [0, 1): the numbers that :mod:`reference.rng` makes.

    Parameters
    ----------
    rows : int
        Size of the batch.

    Returns
    -------
    strategy of (rows,) float64
        Exact in float32.
    """
    words = arrays(np.uint32, rows, elements=st.integers(0, 2**24 - 1))
    return words.map(lambda w: w * 2.0**-24)


def draws(rows=ROWS):
    """Four uniforms a row, as :class:`reference.rng.Uniforms` hands them out."""
    return st.tuples(*[uniforms(rows)] * 4)


def tabled_uniforms(dimensions, rows=ROWS):
    """Tables of uniforms for a whole pass.

    Parameters
    ----------
    dimensions : int
        Dimensions that the pass draws.
    rows : int
        Size of the batch.

    Returns
    -------
    strategy of TabledUniforms
        (dimensions, 4, rows) float64.
    """
    return uniforms(dimensions * 4 * rows).map(
        lambda u: TabledUniforms(u.reshape(dimensions, 4, rows))
    )


@st.composite
def unit_vectors(draw, rows=ROWS):
    """Unit vectors: points of a cube's faces, pushed onto the sphere.

    Axes, diagonals and the edges between octants are simple examples, so that shrinking
    leads there.
    """
    face = draw(arrays(np.int64, rows, elements=st.integers(0, 5)))
    sides = draw(arrays(np.float64, (rows, 2), elements=st.floats(-1, 1)))
    axis, sign = face % 3, np.where(face < 3, 1.0, -1.0)
    cube = np.column_stack([sign, sides])
    columns = (np.arange(3) - axis[:, None]) % 3
    return normalize(np.take_along_axis(cube, columns, axis=1))


def points(reach=10.0, rows=ROWS):
    """Points of a cube about the origin.

    Parameters
    ----------
    reach : float, m
        Half its side.
    rows : int
        Size of the batch.

    Returns
    -------
    strategy of (rows, 3) float64
        Any.
    """
    return arrays(np.float64, (rows, 3), elements=st.floats(-reach, reach))


def colors(low=0.0, high=1.0, rows=ROWS):
    """Linear colours.

    Parameters
    ----------
    low, high : float
        Bounds of each channel.
    rows : int
        Size of the batch.

    Returns
    -------
    strategy of (rows, 3) float64
        Each channel on its own.
    """
    return arrays(np.float64, (rows, 3), elements=st.floats(low, high))


@st.composite
def directions_above(draw, normals, least=0.0):
    """Unit vectors in the hemispheres of given unit normals.

    Parameters
    ----------
    draw : callable
        Supplied by Hypothesis.
    normals : (N, 3) float64
        Unit vectors.
    least : float
        Smallest cosine with them.

    Returns
    -------
    strategy of (N, 3) float64
        Cosine at least ``least``, to rounding.
    """
    rows = len(normals)
    cosine = draw(scalars(least, 1.0, rows))
    phi = 2 * np.pi * draw(uniforms(rows))
    sine = np.sqrt(1 - cosine * cosine)
    tangent, bitangent = normal_frames(normals)
    return (
        (sine * np.cos(phi))[:, None] * tangent
        + (sine * np.sin(phi))[:, None] * bitangent
        + cosine[:, None] * normals
    )


# ---------------------------------------------------------------- geometry of reuse


@dataclass(frozen=True, slots=True)
class Views:
    """A patch at a sample point, and points that look at its lit side.

    Attributes
    ----------
    position, normal : (N, 3) float64
        Of the patch; unit normal.
    eyes : tuple of (N, 3) float64
        Points on the side of the normal.
    """

    position: Vec3s
    normal: Vec3s
    eyes: tuple[Vec3s, ...]


@st.composite
def views_of_a_patch(draw, eyes=3, near=0.01, far=100.0, least=0.01, rows=ROWS):
    """Points that see one patch under cosines and from distances of any kind.

    Parameters
    ----------
    draw : callable
        Supplied by Hypothesis.
    eyes : int
        How many points look at the patch.
    near, far : float, m
        Smallest and largest distance.
    least : float
        Smallest cosine at the patch.
    rows : int
        Size of the batch.

    Returns
    -------
    strategy of Views
        Constructed from patch, cosine, azimuth and distance.
    """
    position, normal = draw(points(rows=rows)), draw(unit_vectors(rows))
    places = []
    for _ in range(eyes):
        direction = draw(directions_above(normal, least))
        distance = draw(scalars(near, far, rows))
        places.append(position + distance[:, None] * direction)
    return Views(position, normal, tuple(places))


@st.composite
def samples(draw, rows=ROWS, brightest=100.0):
    """Sample points, some of them black, which are nulls."""
    radiance = draw(colors(0, brightest, rows))
    return Samples(draw(points(rows=rows)), draw(unit_vectors(rows)), radiance)


# ---------------------------------------------------------------- reservoirs


@st.composite
def candidates(draw, rows=ROWS, first=0, y=None):
    """Open reservoirs; every so often a null, w = 0 with M counted, or an empty row.

    Parameters
    ----------
    draw : callable
        Supplied by Hypothesis.
    rows : int
        Size of the batch.
    first : int
        The samples are numbered from here: row i holds ``first + i``.
    y : strategy or None
        Of samples to hold in place of numbers.

    Returns
    -------
    strategy of Candidates
        p_hat and w are 0 together or not at all, M is 0 only where they are.
    """
    alive = draw(arrays(bool, rows))
    p_hat = np.where(alive, draw(scalars(2.0**-10, 2.0**10, rows)), 0.0)
    w = np.where(alive, draw(scalars(2.0**-20, 2.0**20, rows)), 0.0)
    least = np.where(alive, 1, 0)
    M = np.maximum(draw(arrays(np.int64, rows, elements=st.integers(0, 500))), least)
    held = np.arange(first, first + rows) if y is None else draw(y)
    return Candidates(held, p_hat, w, M.astype(np.float64))


@st.composite
def reservoirs(draw, rows=ROWS, first=0, y=None):
    """Closed reservoirs; every so often with W = 0.

    Parameters
    ----------
    draw : callable
        Supplied by Hypothesis.
    rows : int
        Size of the batch.
    first : int
        The samples are numbered from here: row i holds ``first + i``.
    y : strategy or None
        Of samples to hold in place of numbers.

    Returns
    -------
    strategy of Reservoirs
        M from 1 to 500.
    """
    alive = draw(arrays(bool, rows))
    W = np.where(alive, draw(scalars(2.0**-20, 2.0**20, rows)), 0.0)
    M = draw(arrays(np.int64, rows, elements=st.integers(1, 500)))
    held = np.arange(first, first + rows) if y is None else draw(y)
    return Reservoirs(held, W, M.astype(np.float64))


# ---------------------------------------------------------------- surfaces

COLOR = (0.8, 0.5, 0.2)

EXAMPLES = {
    Kind.LAMBERTIAN: [Lambertian(COLOR), Lambertian(COLOR, two_sided=False)],
    Kind.ROUGH_CONDUCTOR: [
        Conductor(COLOR, 0.3),
        Conductor((1.0, 1.0, 1.0), 0.6, eta=(0.2, 0.9, 1.1), k=(3.9, 2.4, 2.2)),
        Conductor(COLOR, 1.0, schlick=True),
        Conductor(COLOR, 0.15, two_sided=False),
    ],
    Kind.SMOOTH_CONDUCTOR: [
        mirror(COLOR),
        Conductor((1.0, 1.0, 1.0), 0.0, eta=(0.2, 0.9, 1.1), k=(3.9, 2.4, 2.2)),
    ],
    Kind.ROUGH_COATED: [
        Coated(COLOR, 0.3),
        Coated(COLOR, 0.5, ior=1.8, nonlinear=True),
        Coated((0.0, 0.0, 0.0), 0.3, two_sided=False),
    ],
    Kind.SMOOTH_COATED: [
        Coated(COLOR, 0.0),
        Coated(COLOR, 0.0, ior=1.8, nonlinear=True, two_sided=False),
    ],
    Kind.DIELECTRIC: [Dielectric(1.5), Dielectric(1.0 / 1.5)],
}
"""Materials of each kind, one for each branch of its code."""


def materials(*kinds):
    """Materials of given kinds, of all kinds where none is named.

    Parameters
    ----------
    *kinds : Kind
        Which.

    Returns
    -------
    strategy of Material
        One of ``EXAMPLES``: the tables of a coat are not cheap.
    """
    chosen = kinds or tuple(Kind)
    return st.sampled_from([m for kind in chosen for m in EXAMPLES[kind]])


@dataclass(frozen=True, slots=True)
class Surfaces:
    """Points on surfaces, with the table of their materials."""

    table: MaterialTable
    points: SurfacePoints


@st.composite
def surfaces(draw, *kinds, rows=ROWS, smooth=None, least=0.01):
    """Points seen from above, on materials of given kinds.

    Parameters
    ----------
    draw : callable
        Supplied by Hypothesis.
    *kinds : Kind
        Kinds of material, all where none is named.
    rows : int
        Size of the batch.
    smooth : bool or None
        Whether the points have shading normals of their own; ``None``: either.
    least : float
        Smallest cosine of the viewer with the shading normal.

    Returns
    -------
    strategy of Surfaces
        Fronts and backs; the viewer is above geometric and shading normal.
    """
    table = tabulate(draw(st.lists(materials(*kinds), min_size=1, max_size=3)))
    index = st.integers(0, len(table.kind) - 1)
    material = draw(arrays(np.int32, rows, elements=index))
    wo = draw(unit_vectors(rows))
    normal = draw(directions_above(wo, least))
    shading = None
    if draw(st.booleans()) if smooth is None else smooth:
        other = draw(directions_above(wo, least))
        # In the hemisphere of the geometric normal, as interpolation leaves it.
        shading = np.where((dot(other, normal) > 0)[:, None], other, normal)
    found = SurfacePoints(
        position=draw(points(rows=rows)),
        normal=normal,
        smooth=shading,
        wo=wo,
        color=np.take(table.color, material, axis=0),
        material=material,
        primitive=np.arange(rows, dtype=np.int32),
        front=draw(arrays(bool, rows)),
    )
    return Surfaces(table, found)


# ---------------------------------------------------------------- cutting rows


@st.composite
def cuts(draw, rows=ROWS):
    """Ways to cut rows into pieces and shuffle them.

    Parameters
    ----------
    draw : callable
        Supplied by Hypothesis.
    rows : int
        Size of the batch.

    Returns
    -------
    strategy of list of (K,) int
        Together a permutation of all rows; pieces may be empty.
    """
    order = np.array(draw(st.permutations(range(rows))), dtype=np.int64)
    at = sorted(draw(st.lists(st.integers(0, rows), max_size=3)))
    return np.split(order, at)

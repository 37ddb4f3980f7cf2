"""Textured lights, cut into cells that are chosen in proportion to what they emit.

A point of a light is the image of a place (s, t) of the unit square, under a map that
keeps areas in proportion.  The square of a textured triangle is cut into n × n cells.
A cell is a light of its own: the table of all lights chooses it, and the point on it is
uniform.  Half of its weight is the mean luminance of some points in it, half that of
all texels that reach into the rectangle around it.  Every colour in the cell is a
weighted mean of these texels: where anything is emitted, the weight is positive, which
makes the estimate unbiased.
"""

from dataclasses import dataclass

import numpy as np

from restir_gi.reference.images.image import luminance
from restir_gi.reference.numerics.arrays import Indices, Scalars, Vec3s, normalize
from restir_gi.reference.numerics.records import take
from restir_gi.reference.numerics.sampling import invert_triangle, sample_triangle
from restir_gi.reference.scene.geometry import (
    Geometry,
    barycentric,
    texture_coordinates,
)
from restir_gi.reference.scene.texel_sums import TexelSums, texels
from restir_gi.reference.scene.textures import read

CELLS_A_TEXEL = 2.0
"""Cells along a side of a texel: most of them then show one texel alone."""

MOST_ON_A_SIDE = 64
"""Cells along a side of the square of a triangle."""

MOST_CELLS = 1 << 17
"""Cells of all triangles of a scene, as long as each has one."""


def radiance_at(geometry: Geometry, primitive: Indices, x: Vec3s) -> Vec3s:
    """Radiance that points of primitives emit from the sides that emit.

    Parameters
    ----------
    primitive : (N,) int; triangles and spheres
    x : (N, 3) float64, m; points on them, to rounding

    Returns
    -------
    (N, 3) float64, W/(m² sr); read from their textures, where they have one
    """
    radiance = take(geometry.emission, primitive)
    if geometry.emission_texture is None:
        return radiance
    index = geometry.emission_texture[primitive]
    for k, texture in enumerate(geometry.emission_textures):
        rows = np.flatnonzero(index == k)
        if len(rows):
            some, at = primitive[rows], x[rows]
            u, v, outward = _coordinates(geometry, some, at)
            uv = texture_coordinates(geometry, some, u, v, outward)
            radiance[rows] = read(texture, uv)
    return radiance


def _coordinates(
    geometry: Geometry, primitive: Indices, x: Vec3s
) -> tuple[Scalars, Scalars, Vec3s]:
    """Barycentric coordinates on triangles, and directions from centres of spheres."""
    u, v, outward = np.zeros(len(x)), np.zeros(len(x)), np.zeros((len(x), 3))
    on_sphere = primitive >= geometry.triangles
    triangle, sphere = np.flatnonzero(~on_sphere), np.flatnonzero(on_sphere)
    if len(triangle):
        u[triangle], v[triangle] = barycentric(
            geometry, primitive[triangle], x[triangle]
        )
    if len(sphere):
        center = geometry.center[primitive[sphere] - geometry.triangles]
        outward[sphere] = normalize(x[sphere] - center)
    return u, v, outward


@dataclass(frozen=True, slots=True, eq=False)
class LightCells:
    """Into how many cells lights are cut.

    Attributes
    ----------
    side : (T + S,) int64
        n of each primitive, which has n × n cells; 1 for one that is not cut.
    """

    side: Indices

    def place_in(
        self, primitive: Indices, cell: Indices, s: Scalars, t: Scalars
    ) -> tuple[Scalars, Scalars]:
        """Place on a primitive of a place in one of its cells.

        Parameters
        ----------
        primitive, cell : (N,) int; primitives, and which of their cells
        s, t : (N,) float64; in [0, 1)

        Returns
        -------
        (N,), (N,) float64; in [0, 1)
        """
        side = self.side[primitive]
        row, column = np.divmod(cell, side)
        return (row + s) / side, (column + t) / side

    def cell_of(self, geometry: Geometry, primitive: Indices, x: Vec3s) -> Indices:
        """Cells in which points of primitives lie.

        Parameters
        ----------
        primitive : (N,) int; triangles and spheres
        x : (N, 3) float64, m; points on them, to rounding

        Returns
        -------
        (N,) int64; 0 where the primitive is not cut
        """
        cell = np.zeros(len(x), np.int64)
        rows = np.flatnonzero(self.side[primitive] > 1)
        if len(rows):
            some = primitive[rows]
            side = self.side[some]
            s, t = invert_triangle(*barycentric(geometry, some, x[rows]))
            row = np.minimum((s * side).astype(np.int64), side - 1)
            column = np.minimum((t * side).astype(np.int64), side - 1)
            cell[rows] = row * side + column
        return cell


def cut_lights(
    geometry: Geometry, primitive: Indices
) -> tuple[LightCells, Indices, Scalars]:
    """Cut textured lights into cells.

    Parameters
    ----------
    geometry : Geometry; the scene, in which something has a textured emission
    primitive : (A,) int; primitives that may emit, in ascending order

    Returns
    -------
    LightCells; of all primitives
    (C,) int
        Primitive of each cell, in the order of primitives and of their cells; those
        whose texture is black all over have none.
    (C, 3) float64, W/(m² sr)
        A grey of about the mean luminance of each cell, or the colour of a primitive
        that has one.
    """
    texture = np.full(len(geometry.emission), -1)
    if geometry.emission_texture is not None:
        texture = geometry.emission_texture
    sums = [TexelSums.of(t) for t in geometry.emission_textures]
    # Leave out what lies in the dark of its texture, then cut the rest.
    one = np.ones(len(primitive), np.int64)
    whole = _cells(geometry, primitive, one)
    shines = _weights(geometry, sums, texture, whole) > 0
    primitive = primitive[shines | (texture[primitive] < 0)]
    side = np.ones(len(geometry.emission), np.int64)
    side[primitive] = _sides(geometry, texture, primitive)
    cells = _cells(geometry, primitive, side[primitive])
    color: Vec3s = geometry.emission[cells.primitive]
    textured = texture[cells.primitive] >= 0
    weight = _weights(geometry, sums, texture, cells)
    color[textured] = weight[textured, None]
    return LightCells(side), cells.primitive, color


@dataclass(frozen=True, slots=True, eq=False)
class _Cells:
    """Primitives of cells, rectangles around them in (u, v), and points in them."""

    primitive: Indices
    low: Scalars
    high: Scalars
    inside: list[Scalars]


def _cells(geometry: Geometry, primitive: Indices, side: Indices) -> _Cells:
    count = side * side
    of = np.repeat(primitive, count)
    side = np.repeat(side, count)
    cell = np.arange(len(of)) - np.repeat(np.cumsum(count) - count, count)
    row, column = np.divmod(cell, side)
    on_sphere = of >= geometry.triangles
    triangle, nowhere = np.where(on_sphere, 0, of), np.zeros((len(of), 3))

    def grid_points(steps: tuple[float, ...]) -> list[Scalars]:
        places = [((row + s) / side, (column + t) / side) for s in steps for t in steps]
        return [
            texture_coordinates(geometry, triangle, *sample_triangle(*place), nowhere)
            for place in places
        ]

    corners = grid_points((0.0, 1.0))
    low, high = np.min(corners, axis=0), np.max(corners, axis=0)
    # Of a sphere the whole texture counts.
    low[on_sphere], high[on_sphere] = 0.0, 1.0
    return _Cells(of, low, high, grid_points((1 / 6, 3 / 6, 5 / 6)))


def _sides(geometry: Geometry, texture: Indices, primitive: Indices) -> Indices:
    """Along each side ``CELLS_A_TEXEL``, within the limits."""
    cells = _cells(geometry, primitive, np.ones(len(primitive), np.int64))
    across = np.zeros(len(primitive))
    for k, one in enumerate(geometry.emission_textures):
        rows = np.flatnonzero(texture[primitive] == k)
        extent = (cells.high[rows] - cells.low[rows]) * one.scale
        across[rows] = np.max(np.abs(extent) * texels(one).shape[1::-1], axis=1)
    across[primitive >= geometry.triangles] = 0.0
    side = np.ceil(np.clip(across * CELLS_A_TEXEL, 1.0, MOST_ON_A_SIDE))
    excess = np.sum(side * side) / MOST_CELLS
    if excess > 1:
        side = np.maximum(np.floor(side / np.sqrt(excess)), 1.0)
    sides: Indices = side.astype(np.int64)
    return sides


def _weights(
    geometry: Geometry, sums: list[TexelSums], texture: Indices, cells: _Cells
) -> Scalars:
    """Half from the texels around, which hides nothing, half from points inside."""
    weight = np.zeros(len(cells.primitive))
    for k, one in enumerate(geometry.emission_textures):
        rows = np.flatnonzero(texture[cells.primitive] == k)
        around = sums[k].around(cells.low[rows], cells.high[rows])
        shown = [luminance(read(one, uv[rows])) for uv in cells.inside]
        on_sphere = cells.primitive[rows] >= geometry.triangles
        within = np.where(on_sphere, around, np.mean(shown, axis=0))
        weight[rows] = (around + within) / 2
    return weight

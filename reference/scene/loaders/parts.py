"""Triangles of one material, as an OBJ or PLY file has them."""

from dataclasses import dataclass

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Scalars, Vec3s
from restir_gi.reference.scene.loaders.ledger import Ledger
from restir_gi.reference.scene.loaders.pictures import decode_srgb


@dataclass(frozen=True, slots=True, eq=False)
class MeshPart:
    """Triangles of one material, as a file has them.

    Attributes
    ----------
    material : str or None; name of the material, if it has one
    vertices : (V, 3) float64; positions
    faces : (F, 3) int64; triangles
    normals : (V, 3) float64 or None; vertex normals, where the file has them
    uv : (V, 2) float64 or None; texture coordinates, where the file has them
    colors : (V, 3) float64 or None; linear vertex colours, where the file has them
    """

    material: str | None
    vertices: Vec3s
    faces: Indices
    normals: Vec3s | None = None
    uv: Scalars | None = None
    colors: Vec3s | None = None


def linear_colors(stored: Vec3s, where: str, ledger: Ledger) -> Vec3s:
    """Linear vertex colours of what mesh files hold in sRGB, (V, 3) float64; in [0, 1].

    Parameters
    ----------
    stored : (V, 3) float64; of the file, 1 for the brightest

    Raises
    ------
    UsageError
        A value is not in [0, 1].
    """
    if not ((stored >= 0) & (stored <= 1)).all():
        ledger.stop(f"{where}vertex colours lie between 0 and 1; some do not")
    return decode_srgb(stored)


def fans(sizes: Indices) -> tuple[Indices, Indices]:
    """Triangles of polygons, as fans about their first corners.

    Parameters
    ----------
    sizes : (F,) int; corners of each polygon, which lie one after the other; at least 3

    Returns
    -------
    (T, 3) int64, (T,) int64; numbers of the three corners; the polygon of each triangle
    """
    triangles = sizes - 2
    polygon = np.repeat(np.arange(len(sizes)), triangles)
    first = (np.cumsum(sizes) - sizes)[polygon]
    within = np.arange(len(polygon)) - (np.cumsum(triangles) - triangles)[polygon]
    return np.stack([first, first + within + 1, first + within + 2], axis=-1), polygon

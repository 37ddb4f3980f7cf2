"""Triangles in the world, as files hold them."""

from dataclasses import dataclass

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Scalars, Vec3s, normalize
from restir_gi.reference.scene.loaders.triangles import place, turn_over
from restir_gi.reference.scene.shapes import Mesh


@dataclass(frozen=True, slots=True, eq=False)
class WorldTriangles:
    """A mesh whose pose is in its vertices.

    Attributes
    ----------
    vertices : (V, 3) float32, m; in the world
    faces : (F, 3) uint32; counter-clockwise seen from the front
    normals : (V, 3) float32 or None; unit vertex normals; ``None`` for flat faces
    uv : (V, 2) float32 or None; texture coordinates, v upwards
    """

    vertices: Vec3s
    faces: Indices
    normals: Vec3s | None
    uv: Scalars | None


def world_triangles(mesh: Mesh) -> WorldTriangles:
    """Triangles of a mesh where they stand, rounded once.

    Both forms hold float32 and no pose, so that corners which meet in the scene meet in
    the file.
    """
    vertices = place(mesh.vertices, mesh.pose)
    mirrored = bool(np.linalg.det(mesh.pose[:3, :3]) < 0)
    normals = None
    if mesh.normals is not None:
        turned = normalize(mesh.normals @ np.linalg.inv(mesh.pose[:3, :3]))
        normals = turned.astype(np.float32)
    return WorldTriangles(
        vertices=vertices.astype(np.float32),
        faces=turn_over(mesh.faces, mirrored).astype(np.uint32),
        normals=normals,
        uv=None if mesh.uv is None else mesh.uv.astype(np.float32),
    )

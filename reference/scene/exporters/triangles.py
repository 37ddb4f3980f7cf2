"""Triangles in the world, as files hold them."""

from dataclasses import replace

import numpy as np

from restir_gi.reference.numerics.arrays import normalize
from restir_gi.reference.scene.loaders.triangles import place, turn_faces_to_normals
from restir_gi.reference.scene.shapes import Mesh


def in_world(mesh: Mesh) -> Mesh:
    """The mesh with its pose in its vertices.

    Both forms hold corners in float32.  Of corners in the world those that meet in the
    scene meet in the file.
    """
    normals = mesh.normals
    if normals is not None:
        normals = normalize(normals @ np.linalg.inv(mesh.pose[:3, :3]))
    vertices = place(mesh.vertices, mesh.pose)
    return replace(mesh, vertices=vertices, normals=normals, pose=np.eye(4))


def faces_against_normals(mesh: Mesh) -> bool:
    """Whether a front is not where its vertex normals point, which readers decide by.

    Parameters
    ----------
    mesh : Mesh; in the world
    """
    return turn_faces_to_normals(mesh) is not mesh

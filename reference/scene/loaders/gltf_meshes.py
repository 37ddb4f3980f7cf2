"""glTF primitives as meshes in the world."""

from typing import Any

import numpy as np

from reference.arrays import Indices, Scalars, Vec3s, normalize
from reference.scene.loaders.gltf_buffers import Document, read_accessor
from reference.scene.loaders.gltf_materials import Finish
from reference.scene.loaders.triangles import (
    check_indices,
    drop_texture_without_uv,
    place,
    turn_faces_to_normals,
    turn_over,
)
from reference.scene.shapes import Mesh

TRIANGLES, STRIP, FAN = 4, 5, 6


def read_primitive(
    document: Document,
    primitive: dict[str, Any],
    name: str,
    finish: Finish,
    matrix: Scalars,
) -> Mesh | None:
    """Triangles of one material, in the world.

    Parameters
    ----------
    document : Document
        The file.
    primitive : dict
        As in the file.
    name : str
        Of the node or mesh.
    finish : Finish
        What it wears.
    matrix : (4, 4) float64
        Of its node, to the world.

    Returns
    -------
    Mesh or None
        ``None`` for points and lines, which is noted.
    """
    ledger = document.ledger
    attributes = primitive["attributes"]
    mode = primitive.get("mode", TRIANGLES)
    if mode not in (TRIANGLES, STRIP, FAN):
        ledger.note(f'mesh "{name}": its points or lines are left out')
        return None
    if "targets" in primitive:
        ledger.note(f'mesh "{name}": its morph targets are ignored')
    if "COLOR_0" in attributes:
        ledger.note(f'mesh "{name}": its vertex colours are ignored')
    vertices = read_accessor(document, attributes["POSITION"]).astype(np.float64)
    indices: Indices = np.arange(len(vertices))
    if "indices" in primitive:
        indices = read_accessor(document, primitive["indices"])[:, 0]
    normals = None
    if "NORMAL" in attributes:
        normals = _turn(read_accessor(document, attributes["NORMAL"]), matrix)
    uv = None
    if f"TEXCOORD_{finish.uv_set}" in attributes:
        stored = read_accessor(document, attributes[f"TEXCOORD_{finish.uv_set}"])
        u, v, _ = finish.uv_matrix @ np.c_[stored, np.ones(len(stored))].T
        # glTF counts v from the top of the picture, we from its bottom.
        uv = np.stack([u, 1 - v], axis=-1)
    faces = _faces(indices, mode)
    mesh = Mesh(
        name=name,
        vertices=place(vertices, matrix),
        # A mirrored front would be the back.
        faces=turn_over(faces) if np.linalg.det(matrix[:3, :3]) < 0 else faces,
        material=finish.material,
        emission=finish.emission,
        normals=normals,
        uv=uv,
    )
    check_indices(mesh, ledger)
    return drop_texture_without_uv(turn_faces_to_normals(mesh), ledger)


def _turn(normals: Vec3s, matrix: Scalars) -> Vec3s | None:
    """Normals turn with the inverse transpose; a flattened mesh keeps none."""
    linear = matrix[:3, :3]
    if np.linalg.det(linear) == 0 or not np.isfinite(linear).all():
        return None
    return normalize(normals @ np.linalg.inv(linear))


def _faces(indices: Indices, mode: int) -> Indices:
    if mode == TRIANGLES:
        return indices[: len(indices) // 3 * 3].reshape(-1, 3)
    if mode == FAN:
        first = np.full(max(len(indices) - 2, 0), indices[0] if len(indices) else 0)
        return np.stack([first, indices[1:-1], indices[2:]], axis=-1)
    faces = np.stack([indices[:-2], indices[1:-1], indices[2:]], axis=-1)
    # Every other triangle of a strip is wound the other way round.
    return turn_over(faces, np.arange(len(faces)) % 2 == 1)

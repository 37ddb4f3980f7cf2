"""glTF primitives as meshes in the world."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Scalars, Vec3s, normalize
from restir_gi.reference.scene.loaders.gltf_buffers import Document, read_accessor
from restir_gi.reference.scene.loaders.gltf_check import replace_word
from restir_gi.reference.scene.loaders.gltf_materials import Finish
from restir_gi.reference.scene.loaders.triangles import (
    check_indices,
    drop_texture_without_uv,
    place,
    turn_faces_to_normals,
    turn_over,
)
from restir_gi.reference.scene.materials.kinds import Dielectric
from restir_gi.reference.scene.shapes import Mesh

TRIANGLES, STRIP, FAN = 4, 5, 6
SURFACES = (TRIANGLES, STRIP, FAN)


@dataclass(frozen=True, slots=True, eq=False)
class PlacedPrimitive:
    """A primitive that stands in the scene, before its accessors are read.

    Attributes
    ----------
    name : str; of its node or mesh
    finish : Finish; what it wears
    matrices : list of (4, 4) float64; to the world, one an instance
    """

    name: str
    primitive: dict[str, Any]
    finish: Finish
    matrices: list[Scalars]


def read_primitive(document: Document, placed: PlacedPrimitive) -> Mesh | None:
    """Triangles of one material, in the world.

    All instances; ``None`` if there are none, or no vertices.
    """
    primitive, finish = placed.primitive, placed.finish
    attributes = primitive["attributes"]
    where = f'mesh "{placed.name}"'
    if "POSITION" not in attributes or not placed.matrices:
        document.ledger.note(f"{where} has no positions and is left out")
        return None

    def read(name: str, *types: str) -> Scalars:
        return read_accessor(document, attributes[name], types, f"{where}, {name}")

    vertices = read("POSITION", "VEC3").astype(np.float64)
    indices: Indices = np.arange(len(vertices))
    if "indices" in primitive:
        given = primitive["indices"]
        indices = read_accessor(document, given, ("SCALAR",), f"{where}, indices")
        indices = _whole(document, indices[:, 0], where)
    normals = read("NORMAL", "VEC3") if "NORMAL" in attributes else None
    coordinates = f"TEXCOORD_{finish.uv_set}"
    uv = None
    if coordinates in attributes:
        uv = _uv(read(coordinates, "VEC2"), finish)
    colors = None
    if "COLOR_0" in attributes:
        colors = _colors(document, read("COLOR_0", "VEC3", "VEC4"), finish, where)
    mesh = Mesh(
        name=placed.name,
        vertices=vertices,
        faces=_faces(indices, primitive.get("mode", TRIANGLES)),
        material=finish.material,
        emission=finish.emission,
        two_sided_emission=finish.two_sided_emission,
        colors=colors,
        opacity=finish.opacity,
        opacity_cutoff=finish.opacity_cutoff,
        normals=normals,
        uv=uv,
    )
    check_indices(mesh, document.ledger)
    # For each vertex its place, normal, colour and coordinates, twice; for each face
    # its indices, corners and what it takes to compare their normals.
    numbers = 2 * 11 * len(vertices) + 40 * len(mesh.faces)
    copies = len(placed.matrices)
    document.claim(8 * numbers * copies, f"{where} stands in {copies} places")
    mesh = _in_world(mesh, placed.matrices)
    return drop_texture_without_uv(turn_faces_to_normals(mesh), document.ledger)


def _whole(document: Document, indices: Scalars, where: str) -> Indices:
    if indices.dtype.kind == "f":
        document.ledger.stop(f"{where}: its indices must be unsigned integers")
    return indices


def _uv(stored: Scalars, finish: Finish) -> Scalars:
    # Like a non-finite vertex, a product beyond float64 is the validation's to report.
    with np.errstate(invalid="ignore", over="ignore"):
        u, v, _ = finish.uv_matrix @ np.c_[stored, np.ones(len(stored))].T
    # glTF counts v from the top of the picture, we from its bottom.
    return np.stack([u, 1 - v], axis=-1)


def _colors(
    document: Document, stored: Scalars, finish: Finish, where: str
) -> Vec3s | None:
    """Factors on the reflectance; ``None`` where all are 1."""

    def replaced(name: str, problem: str) -> None:
        replace_word(document.ledger, "attribute", name, where, problem)

    rgb = stored[:, :3].astype(np.float64)
    if finish.masked and (stored[:, 3:] != 1).any():
        problem = "the alpha of its vertex colours is not modelled"
        replaced("COLOR_0 with alpha", problem)
    if (rgb < 0).any() or (rgb > 1).any():
        problem = f"its vertex colours are {rgb.min():.3g} to {rgb.max():.3g}"
        replaced("COLOR_0 outside of 0 to 1", f"{problem}, not 0 to 1")
        rgb = np.clip(rgb, 0, 1)
    if (rgb == 1).all():
        return None
    if isinstance(finish.material, Dielectric):
        replaced("COLOR_0 on glass", "vertex colours on glass are not modelled")
        return None
    return rgb


def _faces(indices: Indices, mode: int) -> Indices:
    if mode == TRIANGLES:
        return indices[: len(indices) // 3 * 3].reshape(-1, 3)
    if mode == FAN:
        first = np.full(max(len(indices) - 2, 0), indices[0] if len(indices) else 0)
        return np.stack([first, indices[1:-1], indices[2:]], axis=-1)
    faces = np.stack([indices[:-2], indices[1:-1], indices[2:]], axis=-1)
    # Every other triangle of a strip is wound the other way round.
    return turn_over(faces, np.arange(len(faces)) % 2 == 1)


def _in_world(mesh: Mesh, matrices: list[Scalars]) -> Mesh:
    """All instances side by side."""
    count = len(mesh.vertices)
    normals = None
    if mesh.normals is not None:
        turned = [_turn(mesh.normals, matrix) for matrix in matrices]
        kept = [each for each in turned if each is not None]
        normals = np.concatenate(kept) if len(kept) == len(turned) else None
    # A mirrored front would be the back.
    mirrored = [np.linalg.det(matrix[:3, :3]) < 0 for matrix in matrices]
    faces = [
        (turn_over(mesh.faces) if turn else mesh.faces) + i * count
        for i, turn in enumerate(mirrored)
    ]
    return replace(
        mesh,
        vertices=np.concatenate([place(mesh.vertices, each) for each in matrices]),
        faces=np.concatenate(faces),
        normals=normals,
        colors=_repeated(mesh.colors, len(matrices)),
        uv=_repeated(mesh.uv, len(matrices)),
    )


def _repeated(table: Scalars | None, times: int) -> Scalars | None:
    return None if table is None else np.tile(table, (times, 1))


def _turn(normals: Vec3s, matrix: Scalars) -> Vec3s | None:
    """Normals turn with the inverse transpose; a flattened mesh keeps none."""
    linear = matrix[:3, :3]
    if np.linalg.det(linear) == 0:
        return None
    # A matrix may be so flat that its inverse leaves the range of float64.
    with np.errstate(invalid="ignore", over="ignore"):
        inverse = np.linalg.inv(linear)
        return normalize(normals @ inverse) if np.isfinite(inverse).all() else None

"""OBJ and PLY through trimesh: triangles, and what they look like."""

import re
from dataclasses import dataclass, replace
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from reference.arrays import Indices, Scalars, Vec3s
from reference.files import read_file
from reference.scene.loaders.framing import camera_or_framing, default_environment
from reference.scene.loaders.ledger import Ledger
from reference.scene.loaders.mtl import PLAIN, Look, read_looks
from reference.scene.loaders.triangles import (
    check_indices,
    drop_texture_without_uv,
    turn_faces_to_normals,
)
from reference.scene.scene import Scene
from reference.scene.shapes import Mesh


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """Triangles of one material, as a file has them.

    Attributes
    ----------
    name : str
        Of the material, else of the file.
    vertices : (V, 3) float64
        Positions.
    faces : (F, 3) int
        Triangles.
    normals : (V, 3) float64 or None
        Vertex normals, where the file has them.
    uv : (V, 2) float64 or None
        Texture coordinates, where the file has them.
    """

    name: str
    vertices: Vec3s
    faces: Indices
    normals: Vec3s | None
    uv: Scalars | None


def load(ledger: Ledger) -> Scene:
    """Scene of an OBJ or PLY file.

    Parameters
    ----------
    ledger : Ledger
        Of the file: .obj, with its .mtl files, or .ply.

    Returns
    -------
    Scene
        Seen by a default camera, and lit by a constant environment if nothing emits.

    Raises
    ------
    UsageError
        Not such a file, truncated, without triangles, or (unless lenient) with a
        material file or a texture missing.
    """
    path = ledger.path
    is_obj = path.suffix.lower() == ".obj"
    looks = read_looks(path, ledger) if is_obj else {}
    meshes = tuple(
        _mesh(part, looks.get(part.name), ledger) for part in read_parts(path, ledger)
    )
    scene = Scene(
        name=path.stem,
        camera=camera_or_framing(None, meshes, (), ledger),
        meshes=meshes,
    )
    environment = default_environment(scene, ledger)
    ledger.settle()
    return replace(scene, environment=environment, notes=tuple(ledger.notes))


def _mesh(part: Part, look: Look | None, ledger: Ledger) -> Mesh:
    name = part.name
    if look is None:
        # trimesh names what has no name.
        name, look = ledger.path.stem, PLAIN
        ledger.note(f'"{name}" has no material: it is matt with reflectance 0.8')
    mesh = Mesh(
        name=name,
        vertices=part.vertices,
        faces=part.faces,
        material=look.material,
        emission=look.emission,
        normals=part.normals,
        uv=part.uv,
    )
    check_indices(mesh, ledger)
    return drop_texture_without_uv(turn_faces_to_normals(mesh), ledger)


def read_parts(path: Path, ledger: Ledger) -> list[Part]:
    """All triangles of an OBJ or PLY file; nothing is merged or dropped.

    Parameters
    ----------
    path : Path
        .obj or .ply.
    ledger : Ledger
        Of the scene file, which may be another.

    Returns
    -------
    list of Part
        One a material, in the order of their names.

    Raises
    ------
    UsageError
        Not such a file, truncated, or without triangles.
    """
    own = Ledger(path, ledger.lenient, refusals=ledger.refusals)
    kind = "OBJ" if path.suffix.lower() == ".obj" else "PLY"
    contents = read_file(path)
    vertices, faces = _declared(contents, kind, own)
    with own.reading(f"{kind} file"):
        decoded = _decode(contents, kind, path)
        parts = [_part(entry, path) for entry in decoded if "faces" in entry]
    found = sum(len(part.faces) for part in parts)
    if faces == 0:
        own.stop(f"it has no triangles; name a {kind} file with faces")
    # trimesh returns what it got of a file that ends too early.
    if found < faces or sum(len(part.vertices) for part in parts) < vertices:
        own.stop(
            f"it yields {found} triangles from {faces} faces and {vertices} vertices;"
            " it is truncated or corrupt"
        )
    if any(entry.get("vertex_colors") is not None for entry in decoded):
        ledger.note(f"{path.name}: its vertex colours are ignored")
    return sorted(parts, key=lambda part: part.name)


def _decode(contents: bytes, kind: str, path: Path) -> list[dict[str, Any]]:
    """Arguments for a mesh: unlike its mesh, they hold only what the file does."""
    from trimesh.exchange.obj import load_obj
    from trimesh.exchange.ply import load_ply
    from trimesh.resolvers import FilePathResolver

    if kind == "PLY":
        # With fix_texture=True vertices are reordered, but not their normals.
        return [load_ply(BytesIO(contents), fix_texture=False, skip_materials=True)]
    # The materials tell us only their names.
    loaded = load_obj(BytesIO(contents), resolver=FilePathResolver(str(path)))
    return list(loaded.get("geometry", {}).values())


def _part(entry: dict[str, Any], path: Path) -> Part:
    from trimesh import Trimesh

    # Splits polygons into triangles.
    mesh = Trimesh(entry["vertices"], entry["faces"], process=False)
    normals = entry.get("vertex_normals")
    uv = getattr(entry.get("visual"), "uv", None)
    material = getattr(entry.get("visual"), "material", None)
    return Part(
        name=getattr(material, "name", None) or path.stem,
        vertices=np.array(mesh.vertices, np.float64),
        faces=np.array(mesh.faces, np.int64),
        normals=None if normals is None else np.array(normals, np.float64),
        uv=None if uv is None else np.array(uv, np.float64)[:, :2],
    )


def _declared(contents: bytes, kind: str, ledger: Ledger) -> tuple[int, int]:
    """Vertices and faces that the text of the file promises, at least."""
    if kind == "PLY":
        header, end, _ = contents.partition(b"end_header")
        if b"texcoord" in header:
            ledger.stop("faces hold texture coordinates; vertices should hold them")
        counts = dict(re.findall(rb"element\s+(\w+)\s+(\d+)", header))
        if not header.startswith(b"ply") or not end or b"vertex" not in counts:
            ledger.stop("not a valid PLY file (its header is incomplete)")
        return int(counts[b"vertex"]), int(counts.get(b"face", 0))
    if backward := re.search(rb"^[ \t]*f\s[^\n]*-\d", contents, re.MULTILINE):
        line = contents.count(b"\n", 0, backward.end()) + 1
        ledger.stop(
            f"line {line}: a face counts its vertices backwards; write absolute indices"
        )
    return 0, len(re.findall(rb"^[ \t]*f\s", contents, re.MULTILINE))

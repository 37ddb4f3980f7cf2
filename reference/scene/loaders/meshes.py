"""OBJ and PLY: triangles, and what they look like."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from restir_gi.reference.scene.loaders.framing import (
    camera_or_framing,
    default_environment,
)
from restir_gi.reference.scene.loaders.ledger import Ledger
from restir_gi.reference.scene.loaders.mtl import PLAIN, MtlAppearance, read_looks
from restir_gi.reference.scene.loaders.obj import (
    ObjText,
    read_obj_faces,
    read_obj_words,
)
from restir_gi.reference.scene.loaders.parts import MeshPart
from restir_gi.reference.scene.loaders.ply import read_ply
from restir_gi.reference.scene.loaders.triangles import (
    check_indices,
    drop_texture_without_uv,
    turn_faces_to_normals,
)
from restir_gi.reference.scene.materials.kinds import Lambertian
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.shapes import Mesh

WHITE = MtlAppearance(Lambertian((1.0, 1.0, 1.0)))


def load(ledger: Ledger) -> Scene:
    """Scene of an OBJ or PLY file.

    Seen by a default camera, and lit by a constant environment if nothing emits.

    Raises UsageError: not such a file, truncated, without triangles, or (unless
    lenient) with something missing or not modelled.

    Parameters
    ----------
    ledger : Ledger; of the file: .obj, with its .mtl files, or .ply
    """
    contents, looks = ledger.contents(), dict[str, MtlAppearance]()
    if ledger.path.suffix.lower() == ".obj":
        text = read_obj_words(contents, "", ledger)
        looks, complete = read_looks(text.libraries, ledger)
        if complete:
            _refuse_missing(text, looks, ledger)
        ledger.settle()  # before any number is read
        parts = read_obj_faces(text, ledger)
    else:
        parts = [read_ply(contents, "", ledger)]
    meshes = tuple(_mesh(part, looks, ledger) for part in parts)
    scene = Scene(
        name=ledger.path.stem,
        camera=camera_or_framing(None, meshes, (), ledger),
        meshes=meshes,
    )
    environment = default_environment(scene, ledger)
    ledger.settle()
    return replace(scene, environment=environment, notes=tuple(ledger.notes))


def _refuse_missing(
    text: ObjText, looks: Mapping[str, MtlAppearance], ledger: Ledger
) -> None:
    for name, line in {n: line for line, n in reversed(text.materials)}.items():
        if name not in looks:
            ledger.replace(
                f'{text.where(line)}: no material file (mtllib) has "{name}"',
                "taken as matt with reflectance 0.8",
            )


def _mesh(part: MeshPart, looks: Mapping[str, MtlAppearance], ledger: Ledger) -> Mesh:
    name = part.material or ledger.path.stem
    look = looks.get(part.material or "", PLAIN)
    if part.material is None:
        told = "reflectance 0.8"
        if part.colors is not None:
            look, told = WHITE, "the colours of its vertices"
        ledger.note(f'"{name}" has no material: it is matt with {told}')
    uv = part.uv
    if uv is not None:
        with np.errstate(over="ignore", invalid="ignore"):  # for the validation to tell
            uv = uv * look.scale + look.offset
    mesh = Mesh(
        name=name,
        vertices=part.vertices,
        faces=part.faces,
        material=look.material,
        emission=look.emission,
        colors=part.colors,
        opacity=look.opacity,
        normals=part.normals,
        uv=uv,
    )
    check_indices(mesh, ledger)
    return drop_texture_without_uv(turn_faces_to_normals(mesh), ledger)


def read_parts(name: str, ledger: Ledger) -> list[MeshPart]:
    """All triangles of an OBJ or PLY file beside a scene, without its materials.

    Returns
    -------
    list of MeshPart; of one material each, in the order of their names

    Raises
    ------
    UsageError
        Not such a file, truncated, or without triangles.
    """
    contents = ledger.read(name)
    if name.lower().endswith(".ply"):
        return [read_ply(contents, f"{name}: ", ledger)]
    return read_obj_faces(read_obj_words(contents, f"{name}: ", ledger), ledger)

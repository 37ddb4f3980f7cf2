"""Mitsuba's shapes as meshes and spheres."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from reference.arrays import Vec3s
from reference.errors import UsageError
from reference.scene.loaders.framing import color
from reference.scene.loaders.ledger import Ledger
from reference.scene.loaders.mitsuba_materials import Materials
from reference.scene.loaders.mitsuba_nodes import Node
from reference.scene.loaders.mitsuba_textures import read_color
from reference.scene.loaders.triangles import (
    check_indices,
    drop_texture_without_uv,
    place,
    turn_faces_to_normals,
    turn_over,
)
from reference.scene.materials.kinds import Dielectric, Lambertian, Material
from reference.scene.shapes import Mesh, Sphere
from reference.scene.textures import Bitmap, Checker, Color, mean_color

FILES = ("obj", "ply", "serialized")
KNOWN = (*FILES, "rectangle", "cube", "disk", "sphere")
DISK_SIDES = 128


def read_shape(mi: Any, node: Node, materials: Materials) -> Mesh | Sphere | None:
    """Shape of a file.

    Parameters
    ----------
    mi : module
        ``mitsuba``.
    node : Node
        The shape.
    materials : Materials
        Of the file.

    Returns
    -------
    Mesh or Sphere or None
        In the world; ``None`` if it was left out, which is noted.
    """
    ledger = materials.ledger
    if node.kind not in KNOWN:
        ledger.replace(
            f"{node.name} is not modelled (of shapes, {', '.join(KNOWN)} are)",
            "left out",
        )
        return None
    path = _file(node, ledger) if node.kind in FILES else None
    if node.kind in FILES and path is None:
        return None
    emission = _emission(mi, node, ledger)
    material = _material(node, materials, any(emission))
    if material is None:
        return None
    shape: Mesh | Sphere
    if node.kind == "sphere":
        shape = _sphere(node, material, emission, ledger)
    else:
        shape = _mesh(mi, node, path, ledger)
        shape = replace(shape, material=material, emission=emission)
        shape = drop_texture_without_uv(shape, ledger)
    for medium in node.inside("Medium"):
        ledger.replace(f"{node.name} holds the medium {medium.name}", "left empty")
    node.refuse_unread(ledger, harmless="silhouette_sampling_weight")
    return shape


def _material(node: Node, materials: Materials, emits: bool) -> Material | None:
    bsdfs = node.inside("BSDF")
    if not bsdfs:
        # Mitsuba's defaults: lamps are black, other shapes half white.
        return Lambertian((0.0,) * 3 if emits else (0.5,) * 3, two_sided=False)
    return materials.of(bsdfs[0])


def _emission(mi: Any, node: Node, ledger: Ledger) -> Color:
    for emitter in node.inside("Emitter"):
        if emitter.kind != "area":
            ledger.replace(f"{emitter.name} on {node.name} is not modelled", "ignored")
            continue
        radiance = read_color(mi, emitter, "radiance", 1.0, True, ledger)
        emitter.refuse_unread(ledger, harmless="sampling_weight")
        return radiance
    return 0.0, 0.0, 0.0


def _file(node: Node, ledger: Ledger) -> Path | None:
    filename = node.get("filename")
    if filename is None:
        ledger.stop(f"{node.name} has no filename; it needs one")
    try:
        path = ledger.locate(filename)
    except UsageError as error:
        ledger.replace(f"{node.name}: {error}", "left out")
        return None
    if not path.is_file():
        ledger.replace(f'{node.name}: the file "{filename}" is missing', "left out")
        return None
    return path


def _mesh(mi: Any, node: Node, path: Path | None, ledger: Ledger) -> Mesh:
    """Triangles without their look, front sides as Mitsuba has them."""
    flip = bool(node.get("flip_normals", False))
    if node.kind == "rectangle":
        corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], float)
        return _flat(node, corners, (corners[:, :2] + 1) / 2, flip)
    if node.kind == "disk":
        ledger.note(
            f"Disks are taken as polygons of {DISK_SIDES} sides and the same area"
        )
        return _flat(node, _disk(), None, flip)
    plugin = {"type": node.kind, "to_world": mi.ScalarTransform4f(node.matrix())}
    for key in ("face_normals", "flip_tex_coords", "shape_index"):
        if key in node.values:
            plugin[key] = node.get(key)
    if path is not None:
        plugin["filename"] = str(path)
    with ledger.reading(f"file of {node.name}"):
        table = mi.traverse(mi.load_dict(plugin))
        vertices, normals, uv = (
            np.array(table[f"vertex_{name}"], np.float64)
            for name in ("positions", "normals", "texcoords")
        )
        faces = np.array(table["faces"], np.int64).reshape(-1, 3)
    mesh = Mesh(
        name=node.id,
        vertices=vertices.reshape(-1, 3),
        faces=faces,
        material=Lambertian((0.5,) * 3),
        normals=normals.reshape(-1, 3) if normals.size else None,
        uv=uv.reshape(-1, 2) if uv.size else None,
    )
    check_indices(mesh, ledger)
    mesh = turn_faces_to_normals(mesh)
    if node.kind == "cube":
        mesh = replace(mesh, normals=None)
    return _flipped(mesh) if flip else mesh


def _flat(node: Node, corners: Vec3s, uv: Vec3s | None, flip: bool) -> Mesh:
    """Fan over a convex polygon whose front looks along +z of its own frame."""
    matrix = node.matrix()
    first = np.arange(1, len(corners) - 1)
    faces = np.stack([np.zeros_like(first), first, first + 1], axis=-1)
    # Mitsuba turns the normal with the inverse transpose; the winding turns over in a
    # mirror.
    mirrored = np.linalg.det(matrix[:3, :3]) < 0
    return Mesh(
        name=node.id,
        vertices=place(corners, matrix),
        faces=turn_over(faces) if mirrored != flip else faces,
        material=Lambertian((0.5,) * 3),
        uv=uv,
    )


def _flipped(mesh: Mesh) -> Mesh:
    normals = None if mesh.normals is None else -mesh.normals
    return replace(mesh, faces=turn_over(mesh.faces), normals=normals)


def _disk() -> Vec3s:
    angle = 2 * np.pi * np.arange(DISK_SIDES) / DISK_SIDES
    radius = np.sqrt(2 * np.pi / (DISK_SIDES * np.sin(2 * np.pi / DISK_SIDES)))
    circle = [np.cos(angle), np.sin(angle), np.zeros(DISK_SIDES)]
    corners: Vec3s = radius * np.stack(circle, axis=-1)
    return corners


def _sphere(node: Node, material: Material, emission: Color, ledger: Ledger) -> Sphere:
    matrix = node.matrix()
    scales = np.linalg.norm(matrix[:3, :3], axis=0)
    if not np.allclose(scales, scales[0], rtol=1e-4):
        ledger.replace(
            f"{node.name} is stretched by its to_world, which is not modelled",
            "taken as a sphere of the mean radius",
        )
    center = np.array(node.get("center", [0.0, 0.0, 0.0]), float)
    if not isinstance(material, Dielectric):
        texture = material.reflectance
        if isinstance(texture, Bitmap | Checker):
            ledger.replace(
                f"{node.name}: a texture on a sphere lies otherwise in Mitsuba",
                "taken in the mean colour of the texture",
            )
            material = replace(material, reflectance=color(mean_color(texture)))
    # Unlike on other shapes, in Mitsuba a mirrored sphere is turned inside out.
    mirrored = bool(np.linalg.det(matrix[:3, :3]) < 0)
    return Sphere(
        name=node.id,
        center=color(place(center[None], matrix)[0]),
        radius=float(node.get("radius", 1.0) * scales.mean()),
        material=material,
        emission=emission,
        inward=mirrored != bool(node.get("flip_normals", False)),
    )

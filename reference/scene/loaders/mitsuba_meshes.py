"""Triangles of Mitsuba's shapes, front sides as Mitsuba has them."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars, Vec3s, cross, normalize
from restir_gi.reference.scene.loaders.ledger import Ledger
from restir_gi.reference.scene.loaders.mitsuba_nodes import Node, reading
from restir_gi.reference.scene.loaders.triangles import (
    check_indices,
    place,
    turn_faces_to_normals,
    turn_over,
)
from restir_gi.reference.scene.materials.kinds import Lambertian
from restir_gi.reference.scene.shapes import Mesh

FILES = ("obj", "ply", "serialized")
SIDES = 128  # of a disk or a cylinder
GREY = Lambertian((0.5,) * 3)


def read_mesh(
    mi: Any,
    node: Node,
    matrix: Scalars,
    path: Path | None,
    attribute: str,
    textured: bool,
    ledger: Ledger,
) -> Mesh:
    """Triangles of a shape, without its look, in the world.

    Parameters
    ----------
    node : Node; the shape; no sphere
    matrix : (4, 4) float64; its own frame to world
    path : Path or None; where its triangles are, if they are in a file
    attribute : str; which of its attributes are its colours; "" for none
    """
    flip = node.flag("flip_normals", False, ledger)
    if node.kind == "rectangle":
        corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], float)
        faces = np.array([[0, 1, 2], [0, 2, 3]])
        return _placed(node, matrix, corners, faces, (corners[:, :2] + 1) / 2, flip)
    if node.kind == "disk":
        ledger.note(f"Disks are taken as polygons of {SIDES} sides and the same area")
        return _placed(node, matrix, *_disk(textured), flip)
    if node.kind == "cylinder":
        ledger.note(
            f"Cylinders are taken as prisms of {SIDES} sides and the same volume"
        )
        return _cylinder(mi, node, matrix, flip, ledger)
    plugin = {"type": node.kind, "to_world": mi.ScalarTransform4f(matrix)}
    for key in ("face_normals", "flip_tex_coords"):
        if key in node.values:
            plugin[key] = node.flag(key, False, ledger)
    if "shape_index" in node.values:
        plugin["shape_index"] = int(node.number("shape_index", 0, ledger))
    if path is not None:
        plugin["filename"] = str(path)
    with reading(f"file of {node.name}", ledger):
        table = mi.traverse(mi.load_dict(plugin))
        vertices, normals, uv = (
            np.array(table[f"vertex_{name}"], np.float64)
            for name in ("positions", "normals", "texcoords")
        )
        faces = np.array(table["faces"], np.int64).reshape(-1, 3)
        colors = np.array(table[attribute]) if attribute in table else None
    ledger.take(
        8 * (vertices.size + normals.size + uv.size + faces.size),
        f"{node.name} has {len(faces)} triangles",
    )
    mesh = Mesh(
        name=node.id,
        vertices=vertices.reshape(-1, 3),
        faces=faces,
        material=GREY,
        normals=normals.reshape(-1, 3) if normals.size else None,
        uv=uv.reshape(-1, 2) if uv.size else None,
    )
    check_indices(mesh, ledger)
    if colors is not None:
        mesh = _colored(mesh, colors, attribute, ledger)
    mesh = turn_faces_to_normals(mesh)
    if node.kind == "cube":
        mesh = replace(mesh, normals=None)
    if not flip:
        return mesh
    turned = None if mesh.normals is None else -mesh.normals
    return replace(mesh, faces=turn_over(mesh.faces), normals=turned)


def _colored(mesh: Mesh, values: Scalars, attribute: str, ledger: Ledger) -> Mesh:
    """A mesh whose vertices have colours; those of faces get vertices of their own."""
    if attribute.startswith("face_"):
        corners = mesh.faces.ravel()
        mesh = replace(
            mesh,
            vertices=mesh.vertices[corners],
            faces=np.arange(len(corners)).reshape(-1, 3),
            normals=None if mesh.normals is None else mesh.normals[corners],
            uv=None if mesh.uv is None else mesh.uv[corners],
        )
        rows = values.reshape(len(mesh.faces), -1).repeat(3, axis=0)
    else:
        rows = values.reshape(len(mesh.vertices), -1)
    if rows.shape[1] not in (1, 3):
        ledger.stop(
            f'{mesh.name}: the attribute "{attribute}" has {rows.shape[1]} channels;'
            " a colour has 1 or 3"
        )
    colors = np.broadcast_to(rows, (len(rows), 3)).astype(np.float64)
    return replace(mesh, colors=np.ascontiguousarray(colors))


def _placed(
    node: Node,
    matrix: Scalars,
    corners: Vec3s,
    faces: Scalars,
    uv: Scalars | None,
    flip: bool,
) -> Mesh:
    """A flat shape whose front looks along +z of its own frame."""
    # Mitsuba turns the normal with the inverse transpose; the winding turns over in a
    # mirror.
    mirrored = np.linalg.det(matrix[:3, :3]) < 0
    return Mesh(
        name=node.id,
        vertices=place(corners, matrix),
        faces=turn_over(faces) if mirrored != flip else faces,
        material=GREY,
        uv=uv,
    )


def _circle() -> tuple[Scalars, Scalars, Scalars]:
    """Azimuth of the corners of a polygon of the area of the unit circle, and they."""
    angle = 2 * np.pi * np.arange(SIDES + 1) / SIDES
    radius = np.sqrt(2 * np.pi / (SIDES * np.sin(2 * np.pi / SIDES)))
    return angle, radius * np.cos(angle), radius * np.sin(angle)


def _disk(textured: bool) -> tuple[Vec3s, Scalars, Scalars | None]:
    """A fan from a corner, or from the centre if a texture lies on it.

    Then u is the distance from the centre and v the azimuth over 2 π.
    """
    angle, x, y = _circle()
    rim = np.stack([x, y, np.zeros(SIDES + 1)], axis=-1)
    if not textured:
        first = np.arange(1, SIDES - 1)
        faces = np.stack([np.zeros_like(first), first, first + 1], axis=-1)
        return rim[:-1], faces, None
    count = np.arange(SIDES)
    rim_uv = np.stack([np.ones(SIDES + 1), angle / (2 * np.pi)], axis=-1)
    centre_uv = np.stack([np.zeros(SIDES), (count + 0.5) / SIDES], axis=-1)
    corners = np.concatenate([np.zeros((SIDES, 3)), rim])
    faces = np.stack([count, SIDES + count, SIDES + count + 1], axis=-1)
    return corners, faces, np.concatenate([centre_uv, rim_uv])


def _cylinder(mi: Any, node: Node, matrix: Scalars, flip: bool, ledger: Ledger) -> Mesh:
    """An open tube; u is the azimuth over 2 π, v runs along it."""
    start = node.point("p0", np.zeros(3), ledger)
    axis = node.point("p1", np.array([0.0, 0.0, 1.0]), ledger) - start
    radius = node.number("radius", 1.0, ledger)
    length = float(np.linalg.norm(axis))
    if not 0 < length < np.inf:
        ledger.stop(f"{node.name}: p0 and p1 have to be two different points")
    frame = mi.Frame3f(mi.Vector3f((axis / length).tolist()))
    own = np.eye(4)
    own[:3, :3] = np.stack([frame.s, frame.t, frame.n], axis=-1)
    own[:3, :3] *= [radius, radius, length]
    own[:3, 3] = start
    matrix = matrix @ own
    angle, x, y = _circle()
    z = np.zeros(SIDES + 1)
    corners = np.concatenate(
        [np.stack([x, y, z], axis=-1), np.stack([x, y, z + 1], axis=-1)]
    )
    along = angle / (2 * np.pi)
    uv = np.concatenate([np.stack([along, z], axis=-1), np.stack([along, z + 1], -1)])
    low = np.arange(SIDES)
    high = low + SIDES + 1
    faces = np.concatenate(
        [
            np.stack([low, low + 1, high + 1], axis=-1),
            np.stack([low, high + 1, high], axis=-1),
        ]
    )
    mesh = _placed(node, matrix, corners, faces, uv, flip)
    # Away from the axis, by the inverse transpose.
    outward = np.concatenate([np.stack([x, y, z], axis=-1)] * 2)
    linear = matrix[:3, :3]
    cofactors = cross(linear.T[[1, 2, 0]], linear.T[[2, 0, 1]])
    normals = normalize(outward @ cofactors)
    mirrored = np.linalg.det(matrix[:3, :3]) < 0
    return replace(mesh, normals=-normals if mirrored != flip else normals)

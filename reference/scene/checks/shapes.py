"""Shapes: finite vertices, faces that exist, poses that keep their volume."""

from dataclasses import replace

import numpy as np

from restir_gi.reference.numerics.arrays import (
    Masks,
    Scalars,
    cross,
    divide_or_zero,
    dot,
)
from restir_gi.reference.scene.checks.materials import check_material
from restir_gi.reference.scene.checks.textures import check_texture
from restir_gi.reference.scene.checks.values import (
    BRIGHTEST,
    need_numbers,
    need_rows,
    refuse,
)
from restir_gi.reference.scene.geometry import world_corners
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.shapes import Mesh, Sphere
from restir_gi.reference.scene.textures import Bitmap

LARGEST = 1e50
"""Coordinates in metres that may still be squared and multiplied."""


def check_mesh(where: str, mesh: Mesh) -> None:
    """Require a mesh whose every number has a meaning.

    Raises UsageError, which names the vertex, the face, or the property.
    """
    need_rows(where, "vertex", np.asarray(mesh.vertices), 3)
    check_faces(where, mesh)
    check_pose(where, mesh)
    if mesh.normals is not None:
        need_rows(where, "normal", np.asarray(mesh.normals), 3)
        _need_one_a_vertex(where, "normals", len(mesh.normals), mesh)
    if mesh.uv is not None:
        uv = np.asarray(mesh.uv)
        need_rows(where, "texture coordinate", uv, 2)
        need_numbers(where, "a texture coordinate", uv, -LARGEST, LARGEST)
        _need_one_a_vertex(where, "texture coordinates", len(mesh.uv), mesh)
    check_texture(where, "emission", mesh.emission, BRIGHTEST)
    if mesh.colors is not None:
        need_rows(where, "vertex colour", np.asarray(mesh.colors), 3)
        _need_one_a_vertex(where, "vertex colours", len(mesh.colors), mesh)
        need_numbers(where, "colour of a vertex", mesh.colors, 0, 1)
    if mesh.opacity is not None:
        _check_mask(where, mesh, mesh.opacity)
    check_material(where, mesh.material)


def _check_mask(where: str, mesh: Mesh, opacity: Bitmap) -> None:
    check_texture(where, "opacity", opacity, 1.0)
    need_numbers(where, "opacity_cutoff", mesh.opacity_cutoff, 0, 1)
    if mesh.uv is None:
        right = "they say where its holes are"
        refuse(where, "it has an opacity but no texture coordinates", right)


def check_faces(where: str, mesh: Mesh) -> None:
    """Require faces of three vertices that the mesh has.

    Parameters
    ----------
    mesh : Mesh; its vertices checked

    Raises
    ------
    UsageError
        Names the face.
    """
    faces = np.asarray(mesh.faces)
    if faces.ndim != 2 or faces.shape[1] != 3 or faces.dtype.kind not in "iu":
        kind = f"{faces.dtype} of shape {faces.shape}"
        refuse(where, f"its faces are {kind}", "they must be integers, (F, 3)")
    count = len(mesh.vertices)
    bad = np.flatnonzero(((faces < 0) | (faces >= count)).any(axis=1))
    if len(bad):
        face = tuple(int(i) for i in faces[bad[0]])
        right = f"its {count} vertices are numbered from 0 to {count - 1}"
        refuse(where, f"face {bad[0]} is {face}", right)


def check_pose(where: str, mesh: Mesh) -> None:
    """Require a pose that keeps the mesh in the world and does not flatten it.

    Parameters
    ----------
    mesh : Mesh; with finite vertices

    Raises
    ------
    UsageError
        Names the pose, or the first vertex that it throws too far out.
    """
    pose = np.asarray(mesh.pose, float)
    if pose.shape != (4, 4):
        refuse(where, f"its pose has shape {pose.shape}", "it must be (4, 4)")
    need_numbers(where, "pose", pose)
    if not np.array_equal(pose[3], [0, 0, 0, 1]):
        right = "the last row of a pose is (0, 0, 0, 1)"
        refuse(where, "its pose is not affine", right)
    columns = divide_or_zero(pose[:3, :3], np.abs(pose[:3, :3]).max(axis=0))
    if abs(np.linalg.det(columns)) < 1e-12:
        refuse(where, "its pose flattens it", "a pose turns, moves and scales")
    with np.errstate(over="ignore", invalid="ignore"):
        world = mesh.vertices @ pose[:3, :3].T + pose[:3, 3]
        bad = np.flatnonzero(~(np.abs(world) <= LARGEST).all(axis=1))
    if len(bad):
        right = f"coordinates must stay within {LARGEST:g} m"
        refuse(where, f"vertex {bad[0]} is too far out", right)


def check_sphere(where: str, sphere: Sphere) -> None:
    """Require a sphere that is one.

    Raises UsageError, which names the property.
    """
    need_numbers(where, "center", sphere.center, -LARGEST, LARGEST, count=3)
    need_numbers(where, "radius", sphere.radius, high=LARGEST)
    if sphere.radius <= 0:
        refuse(where, f"radius is {sphere.radius:g}", "it must be above 0")
    check_texture(where, "emission", sphere.emission, BRIGHTEST)
    check_material(where, sphere.material)


def without_flat_faces(scene: Scene) -> Scene:
    """Drop triangles without area, with a note for each mesh that lost some.

    Meshes that lost all are gone.

    Parameters
    ----------
    scene : Scene; its numbers checked
    """
    meshes, notes = [], []
    for mesh in scene.meshes:
        keep = has_area(world_corners(mesh))
        lost = len(keep) - int(keep.sum())
        if lost:
            count = f"{lost} of {len(keep)} triangles have no area and are left out"
            notes.append(f'Mesh "{mesh.name}": {count}.')
            mesh = replace(mesh, faces=np.asarray(mesh.faces)[keep])
        if keep.any():
            meshes.append(mesh)
    if len(meshes) == len(scene.meshes) and not notes:
        return scene
    return replace(scene, meshes=tuple(meshes), notes=(*scene.notes, *notes))


def has_area(corners: Scalars) -> Masks:
    """Whether triangles have an area beyond the rounding of their corners.

    Parameters
    ----------
    corners : (T, 3, 3) float64, m; in the world

    Returns
    -------
    (T,) bool
        False where the height is below the rounding of the coordinates: such a
        triangle has no normal.
    """
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    largest = np.abs(corners).max(axis=(1, 2), initial=0.0)
    scale = np.where(largest > 0, largest, 1.0)[:, None]
    u, v = (b - a) / scale, (c - a) / scale
    normal = cross(u, v)
    longest = np.sqrt(np.maximum(dot(u, u), dot(v, v)))
    # A corner is off by half an ulp in each coordinate, 2⁻⁵³ of the largest; two
    # corners and three coordinates move the height by less than 2⁻⁵⁰.
    area: Masks = np.sqrt(dot(normal, normal)) > 2.0**-50 * longest
    return area


def _need_one_a_vertex(where: str, what: str, count: int, mesh: Mesh) -> None:
    if count != len(mesh.vertices):
        right = f"each of the {len(mesh.vertices)} vertices needs one"
        refuse(where, f"it has {count} {what}", right)

"""Triangles from files as meshes that the renderer can take at their word."""

from dataclasses import replace

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Scalars, Vec3s, cross, dot
from restir_gi.reference.scene.loaders.framing import color
from restir_gi.reference.scene.loaders.ledger import Ledger
from restir_gi.reference.scene.materials.kinds import Dielectric
from restir_gi.reference.scene.shapes import Mesh
from restir_gi.reference.scene.textures import Pattern, mean_color


def check_indices(mesh: Mesh, ledger: Ledger) -> None:
    """Refuse faces that name vertices which do not exist, and tables that do not fit.

    Raises UsageError: the first fault.
    """
    count = len(mesh.vertices)
    if len(mesh.faces) and not 0 <= mesh.faces.min() <= mesh.faces.max() < count:
        wrong = mesh.faces[(mesh.faces < 0) | (mesh.faces >= count)][0]
        ledger.stop(
            f'mesh "{mesh.name}" has a face with vertex {wrong};'
            f" its vertices are 0 to {count - 1}"
        )
    for name, table in (("normals", mesh.normals), ("texture coordinates", mesh.uv)):
        if table is not None and len(table) != count:
            ledger.stop(
                f'mesh "{mesh.name}" has {len(table)} {name} for {count} vertices;'
                " it needs one each"
            )


def turn_faces_to_normals(mesh: Mesh) -> Mesh:
    """Let each face look the way that its vertex normals point.

    Parameters
    ----------
    mesh : Mesh; in the world

    Returns
    -------
    Mesh
        Faces whose normal has a negative product with the sum of its vertex normals
        are turned over.  Renderers tell the sides apart by the shading normal, so a
        lamp that is wound the other way round still shines where they have it shine.
    """
    if mesh.normals is None:
        return mesh
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
    # Vertices that are not finite are the validation's to report.
    with np.errstate(invalid="ignore", over="ignore"):
        product = dot(cross(b - a, c - a), mesh.normals[mesh.faces].sum(axis=1))
    against = product < 0
    if not against.any():
        return mesh
    return replace(mesh, faces=turn_over(mesh.faces, against))


def turn_over(faces: Indices, which: Scalars | bool = True) -> Indices:
    """Reverse the order of the vertices, (F, 3) int; the first vertex stays the first.

    Parameters
    ----------
    faces : (F, 3) int; triangles
    which : (F,) bool or bool; those to turn over
    """
    turned: Indices = np.where(np.reshape(which, (-1, 1)), faces[:, [0, 2, 1]], faces)
    return turned


def drop_texture_without_uv(mesh: Mesh, ledger: Ledger) -> Mesh:
    """Replace textures that cannot be placed by their mean colours.

    Its material and its emission have one colour each if it has no texture coordinates,
    and no part of it is masked.
    """
    if mesh.uv is not None:
        return mesh
    material, emission = mesh.material, mesh.emission
    reflectance = getattr(material, "reflectance", None)
    if isinstance(reflectance, Pattern) and not isinstance(material, Dielectric):
        mean = color(mean_color(reflectance))
        material = replace(material, reflectance=mean)
    if isinstance(emission, Pattern):
        emission = color(mean_color(emission))
    kept = material is mesh.material and emission is mesh.emission
    if kept and mesh.opacity is None:
        return mesh
    ledger.replace(
        f'mesh "{mesh.name}" has a texture but no texture coordinates',
        "taken in the mean colour of the texture",
    )
    return replace(mesh, material=material, emission=emission, opacity=None)


def place(vertices: Vec3s, matrix: Scalars) -> Vec3s:
    """Points moved by an affine matrix, (V, 3) float64; in the world.

    Parameters
    ----------
    vertices : (V, 3) float; points
    matrix : (4, 4) float64; acts on columns
    """
    if np.array_equal(matrix, np.eye(4)):
        return vertices.astype(np.float64)  # 0 · inf would spread NaN
    # Like a non-finite vertex, a product beyond float64 is the validation's to report.
    with np.errstate(invalid="ignore", over="ignore"):
        placed: Vec3s = vertices @ matrix[:3, :3].T + matrix[:3, 3]
    return placed

"""Shapes as an author gives them: triangle meshes with a rigid pose, and spheres."""

from dataclasses import dataclass, field

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Scalars, Vec3s
from restir_gi.reference.scene.materials.kinds import Material
from restir_gi.reference.scene.textures import Bitmap, Color, Texture, shines


def _identity() -> Scalars:
    return np.eye(4)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Mesh:
    """Triangles of one material.

    Attributes
    ----------
    vertices : (V, 3) float64, m; in the mesh's own frame
    faces : (F, 3) int; counter-clockwise seen from the front, the side that emits
    material : Material
        How both sides scatter (the front alone where the material is one-sided).
    emission : Texture, W/(m² sr); radiance that leaves the front in every direction
    two_sided_emission : bool; the back emits as the front does
    colors : (V, 3) float64 or None
        Linear factors on the reflectance, interpolated over each triangle.
    opacity : Bitmap or None
        Where the mean of its channels is below ``opacity_cutoff``, there is no
        surface.
    opacity_cutoff : float; between 0 and 1
    normals : (V, 3) float64 or None; unit vertex normals; ``None`` for flat faces
    uv : (V, 2) float64 or None; texture coordinates
    pose : (4, 4) float64
        Own frame to world; rotation, translation and (when loaded) scale.
    """

    name: str
    vertices: Vec3s
    faces: Indices
    material: Material
    emission: Texture = (0.0, 0.0, 0.0)
    two_sided_emission: bool = False
    colors: Vec3s | None = None
    opacity: Bitmap | None = None
    opacity_cutoff: float = 0.5
    normals: Vec3s | None = None
    uv: Scalars | None = None
    pose: Scalars = field(default_factory=_identity)


@dataclass(frozen=True, slots=True, kw_only=True)
class Sphere:
    """An analytic sphere: exact, so that the noise-free identities hold on it.

    Attributes
    ----------
    center : (float, float, float), m; in the world
    radius : float, m; positive
    material : Material; how both sides scatter
    emission : Texture, W/(m² sr); radiance that leaves the front
    two_sided_emission : bool; the back emits as the front does
    inward : bool; the front is the inside
    """

    name: str
    center: tuple[float, float, float]
    radius: float
    material: Material
    emission: Texture = (0.0, 0.0, 0.0)
    two_sided_emission: bool = False
    inward: bool = False


def emits(shape: Mesh | Sphere) -> bool:
    """Whether any point of a shape emits.

    Its texture may still be dark wherever the shape shows it.
    """
    return shines(shape.emission)


def quad(
    name: str,
    corner: Color,
    edge_u: Color,
    edge_v: Color,
    material: Material,
    emission: Texture = (0.0, 0.0, 0.0),
) -> Mesh:
    """A parallelogram of two triangles; its front is the side of edge_u × edge_v.

    Parameters
    ----------
    corner, edge_u, edge_v : (float, float, float), m
        One corner and the two edges that leave it.
    emission : Texture, W/(m² sr); radiance that leaves the front

    Returns
    -------
    Mesh; with (u, v) from 0 to 1 along the edges
    """
    o, u, v = (np.asarray(x, float) for x in (corner, edge_u, edge_v))
    return Mesh(
        name=name,
        vertices=np.array([o, o + u, o + u + v, o + v]),
        faces=np.array([[0, 1, 2], [0, 2, 3]]),
        uv=np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]),
        material=material,
        emission=emission,
    )


def box(
    name: str, size: Color, pose: Scalars, material: Material, inward: bool = False
) -> Mesh:
    """A closed cuboid about the origin of its own frame.

    Parameters
    ----------
    size : (float, float, float), m; extents along its own axes
    pose : (4, 4) float64; own frame to world
    inward : bool; the front is the inside
    """
    signs = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)])
    corners = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4)]
    corners += [(2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    faces = np.array([t for a, b, c, d in corners for t in ((a, b, c), (a, c, d))])
    return Mesh(
        name=name,
        vertices=signs * (np.asarray(size, float) / 2),
        faces=faces[:, ::-1] if inward else faces,
        material=material,
        pose=pose,
    )

"""All shapes of a scene as one list of primitives, in the world."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from restir_gi.reference.numerics.arrays import (
    Indices,
    Masks,
    Scalars,
    Vec3s,
    cross,
    divide_or_zero,
    dot,
    length,
    normalize,
    triangle_normal,
)
from restir_gi.reference.numerics.records import take
from restir_gi.reference.scene.materials.kinds import Dielectric, Material
from restir_gi.reference.scene.materials.parameters import MaterialTable, tabulate
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.shapes import Mesh, Sphere
from restir_gi.reference.scene.textures import Bitmap, Pattern, Texture, mean_color

INSIDE = 2.0**-16
"""How far hit points stay inside their triangle, in half extents of the scene.

Eight times the step that rays take off a surface: enough for wedges of 10 degrees.
"""


@dataclass(frozen=True, slots=True, eq=False)
class AlphaMask:
    """Where a mesh has holes.

    Attributes
    ----------
    opacity : Bitmap; its channels' mean is compared
    cutoff : float; there is a surface from this opacity on
    """

    opacity: Bitmap
    cutoff: float


@dataclass(frozen=True, slots=True, eq=False)
class Geometry:
    """All primitives of a scene: T triangles, then S spheres.

    Attributes
    ----------
    triangle : (T, 4, 3) float64
        First vertex, the edges to the second and the third (m), and the unit normal of
        the front: side by side, since a hit wants all of them.
    margin : (T, 3) float64
        Least barycentric coordinates of a hit, which is kept ``INSIDE`` its triangle.
    area : (T + S,) float64, m²; area of each primitive
    smooth : (T, 3, 3) float64 or None
        Vertex normals; ``None`` where every face is flat.
    uv : (T, 3, 2) float64 or None
        Texture coordinates; ``None`` where no texture needs them.
    color : (T, 3, 3) float64 or None
        Factors on the reflectance at the vertices; ``None`` where there are none.
    mask : (T,) int32 or None
        Row of ``masks``, -1 for triangles without holes; ``None`` where none has any.
    center : (S, 3) float64, m; sphere centres
    radius : (S,) float64, m; sphere radii
    inward : (S,) bool; the front is the inside
    material : (T + S,) int32; row of ``materials``
    emission : (T + S, 3) float64, W/(m² sr)
        Radiance of the front; the mean of its texture, where it has one.
    emission_texture : (T + S,) int32 or None
        Row of ``emission_textures``, -1 for one colour; ``None`` where all have one.
    emission_textures : tuple of Bitmap or Checker; textures of radiance
    emits_behind : (T + S,) bool or None
        The back emits as the front does; ``None`` where no back does.
    shape : (T + S,) int32; mesh, or sphere after the last mesh
    materials : MaterialTable; materials of the scene
    middle : (3,) float64, m; centre of the bounding box
    extent : float, m; half of its longest side
    """

    triangle: Scalars
    margin: Vec3s
    area: Scalars
    smooth: Scalars | None
    uv: Scalars | None
    color: Scalars | None
    mask: Indices | None
    masks: tuple[AlphaMask, ...]
    center: Vec3s
    radius: Scalars
    inward: Masks
    material: Indices
    emission: Vec3s
    emission_texture: Indices | None
    emission_textures: tuple[Pattern, ...]
    emits_behind: Masks | None
    shape: Indices
    materials: MaterialTable
    middle: Vec3s
    extent: float

    @property
    def triangles(self) -> int:
        """Number of triangles."""
        return len(self.triangle)


def build_geometry(scene: Scene) -> Geometry:
    """Put all shapes of a scene into the world; primitives in the order of the scene.

    Parameters
    ----------
    scene : Scene; validated: its numbers are finite and its triangles have areas
    """
    shapes: tuple[Mesh | Sphere, ...] = (*scene.meshes, *scene.spheres)
    materials: list[Material] = []
    for shape in shapes:
        if not any(shape.material is m for m in materials):
            materials.append(shape.material)
    row = {id(m): i for i, m in enumerate(materials)}
    table = tabulate(materials)
    if any(m.colors is not None and np.min(m.colors) <= 0 for m in scene.meshes):
        table = replace(table, plain=False)

    def per_triangle(parts: list[Scalars], *shape: int) -> Scalars:
        return np.concatenate(parts) if parts else np.zeros((0, *shape))

    corners = per_triangle([world_corners(m) for m in scene.meshes], 3, 3)
    counts = [len(m.faces) for m in scene.meshes] + [1] * len(scene.spheres)
    shape_index = np.repeat(np.arange(len(shapes), dtype=np.int32), counts)
    smooth = any(m.normals is not None for m in scene.meshes)
    glow = [s.emission for s in shapes]
    glow_textures, glow_row = _textures_of(glow)
    both = np.array([s.two_sided_emission for s in shapes], bool)[shape_index]
    textured = any(isinstance(t, Pattern) for t in table.textures)
    masks, mask_row = _masks_of(scene.meshes)
    edge_u, edge_v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    front, normal = cross(edge_u, edge_v), triangle_normal(edge_u, edge_v)
    center = np.array([s.center for s in scene.spheres], float).reshape(-1, 3)
    radius = np.array([s.radius for s in scene.spheres], float)
    reach = radius[:, None]
    every = np.concatenate([corners.reshape(-1, 3), center - reach, center + reach])
    low, high = every.min(axis=0), every.max(axis=0)
    extent = float(np.max(high - low)) / 2
    return Geometry(
        triangle=np.stack([corners[:, 0], edge_u, edge_v, normal], axis=1),
        margin=_margins(edge_u, edge_v, length(front), extent),
        area=np.concatenate([0.5 * length(front), 4.0 * np.pi * radius**2]),
        smooth=per_triangle([_world_normals(m) for m in scene.meshes], 3, 3)
        if smooth
        else None,
        uv=per_triangle([_corner_uv(m) for m in scene.meshes], 3, 2)
        if textured or glow_textures or masks
        else None,
        color=per_triangle([_corner_colors(m) for m in scene.meshes], 3, 3)
        if any(m.colors is not None for m in scene.meshes)
        else None,
        mask=mask_row[shape_index[: len(corners)]] if masks else None,
        masks=masks,
        center=center,
        radius=radius,
        inward=np.array([s.inward for s in scene.spheres], bool),
        material=np.array([row[id(s.material)] for s in shapes], np.int32)[shape_index],
        emission=take(
            np.array([mean_color(t) for t in glow], float).reshape(-1, 3), shape_index
        ),
        emission_texture=glow_row[shape_index] if glow_textures else None,
        emission_textures=glow_textures,
        emits_behind=both if both.any() else None,
        shape=shape_index,
        materials=table,
        middle=(low + high) / 2,
        extent=extent,
    )


def _masks_of(meshes: Sequence[Mesh]) -> tuple[tuple[AlphaMask, ...], Indices]:
    """Masks of meshes, each once, and the row of each mesh's own."""
    masks: list[AlphaMask] = []
    row = np.full(len(meshes), -1, np.int32)
    for i, mesh in enumerate(meshes):
        if mesh.opacity is None:
            continue
        opacity, cutoff = mesh.opacity, mesh.opacity_cutoff
        same = [m.opacity is opacity and m.cutoff == cutoff for m in masks]
        if not any(same):
            masks.append(AlphaMask(opacity, cutoff))
            same.append(True)
        row[i] = same.index(True)
    return tuple(masks), row


def _textures_of(
    emissions: Sequence[Texture],
) -> tuple[tuple[Pattern, ...], Indices]:
    """Textures among emissions, each object once, and the row of each emission."""
    textures: list[Pattern] = []
    row = np.full(len(emissions), -1, np.int32)
    for i, emission in enumerate(emissions):
        if isinstance(emission, Pattern):
            if not any(emission is t for t in textures):
                textures.append(emission)
            row[i] = next(k for k, t in enumerate(textures) if t is emission)
    return tuple(textures), row


def _margins(
    edge_u: Vec3s, edge_v: Vec3s, doubled_area: Scalars, extent: float
) -> Vec3s:
    # A coordinate is the distance from the opposite edge over the height above it.
    opposite = (length(edge_v - edge_u), length(edge_v), length(edge_u))
    kept = [divide_or_zero(INSIDE * extent * e, doubled_area) for e in opposite]
    margins: Vec3s = np.minimum(np.stack(kept, axis=-1), 1 / 3)
    return margins


def inside(
    geometry: Geometry, triangle: Indices, u: Scalars, v: Scalars
) -> tuple[Scalars, Scalars]:
    """Barycentric coordinates of hit points, kept off the edges of their triangles.

    Parameters
    ----------
    triangle : (N,) int; which triangles
    u, v : (N,) float64; barycentric coordinates of the second and third vertex

    Returns
    -------
    (N,), (N,) float64
        Moved by at most about ``INSIDE`` half extents of the scene: a point in a
        concave edge then stands clear of the other wall, however sharp the edge.
    """
    least = geometry.margin.take(triangle, axis=0)
    w = np.maximum(1.0 - u - v, least[:, 0])
    u, v = np.maximum(u, least[:, 1]), np.maximum(v, least[:, 2])
    total = u + v + w
    return u / total, v / total


def on_triangles(
    geometry: Geometry, triangle: Indices, u: Scalars, v: Scalars
) -> tuple[Vec3s, Vec3s]:
    """Points of triangles and the normals of their fronts.

    Parameters
    ----------
    triangle : (N,) int; which triangles
    u, v : (N,) float64; barycentric coordinates of the second and third vertex

    Returns
    -------
    (N, 3) float64, m and (N, 3) float64; positions and unit normals
    """
    rows = geometry.triangle.take(triangle, axis=0)
    position = np.asfortranarray(rows[:, 0])
    position += rows[:, 1] * u[:, None]
    position += rows[:, 2] * v[:, None]
    return position, np.asfortranarray(rows[:, 3])


def barycentric(
    geometry: Geometry, triangle: Indices, x: Vec3s
) -> tuple[Scalars, Scalars]:
    """Barycentric coordinates of points of triangles.

    Parameters
    ----------
    triangle : (N,) int; which triangles
    x : (N, 3) float64, m; points on them, to rounding

    Returns
    -------
    (N,), (N,) float64; of the second and third vertex; both >= 0, sum at most 1
    """
    rows = geometry.triangle.take(triangle, axis=0)
    edge_u, edge_v, normal = (np.ascontiguousarray(rows[:, k]) for k in (1, 2, 3))
    offset, doubled_area = x - rows[:, 0], 2.0 * geometry.area[triangle]
    u = np.maximum(dot(normal, cross(offset, edge_v)) / doubled_area, 0.0)
    v = np.maximum(dot(normal, cross(edge_u, offset)) / doubled_area, 0.0)
    total = np.maximum(u + v, 1.0)
    return u / total, v / total


def texture_coordinates(
    geometry: Geometry, primitive: Indices, u: Scalars, v: Scalars, outward: Vec3s
) -> Scalars:
    """Texture coordinates of points of primitives.

    Parameters
    ----------
    primitive : (N,) int; triangles and spheres
    u, v : (N,) float64
        Barycentric coordinates of the second and third vertex, on triangles.
    outward : (N, 3) float64; unit vectors from the centre, on spheres

    Returns
    -------
    (N, 2) float64; 0 on triangles of meshes that have none
    """
    uv = np.zeros((len(primitive), 2))
    on_sphere = primitive >= geometry.triangles
    triangle = np.flatnonzero(~on_sphere)
    if geometry.uv is not None and len(triangle):
        corners = geometry.uv[primitive[triangle]]
        b1, b2 = u[triangle, None], v[triangle, None]
        blended = (1 - b1 - b2) * corners[:, 0] + b1 * corners[:, 1]
        uv[triangle] = blended + b2 * corners[:, 2]
    sphere = np.flatnonzero(on_sphere)
    if len(sphere):
        n = outward[sphere]
        # Longitude from +x towards +z, latitude from the south pole at -y.
        uv[sphere, 0] = (np.arctan2(n[:, 2], n[:, 0]) / (2.0 * np.pi)) % 1.0
        uv[sphere, 1] = 0.5 + np.arcsin(np.clip(n[:, 1], -1.0, 1.0)) / np.pi
    return uv


def world_corners(mesh: Mesh) -> Scalars:
    """Corners of the triangles of a mesh.

    Returns (F, 3, 3) float64, m; in the world; triangle, corner, component.
    """
    vertices = mesh.vertices @ mesh.pose[:3, :3].T + mesh.pose[:3, 3]
    corners: Scalars = vertices[mesh.faces]
    return corners


def _world_normals(mesh: Mesh) -> Scalars:
    if mesh.normals is None:
        corners = world_corners(mesh)
        a, b, c = (corners[:, k] for k in range(3))
        return np.repeat(triangle_normal(b - a, c - a)[:, None], 3, axis=1)
    # Normals turn with the inverse transpose.
    turned = normalize(mesh.normals @ np.linalg.inv(mesh.pose[:3, :3]))
    corner_normals: Scalars = turned[mesh.faces]
    return corner_normals


def _corner_uv(mesh: Mesh) -> Scalars:
    if mesh.uv is None:
        return np.zeros((len(mesh.faces), 3, 2))
    corner_uv: Scalars = np.asarray(mesh.uv, float)[mesh.faces]
    return corner_uv


def _corner_colors(mesh: Mesh) -> Scalars:
    # A dielectric has no reflectance that a colour could be a factor of.
    if mesh.colors is None or isinstance(mesh.material, Dielectric):
        return np.ones((len(mesh.faces), 3, 3))
    corner_colors: Scalars = np.asarray(mesh.colors, float)[mesh.faces]
    return corner_colors

"""Scenes whose paths need every kind of shift, small."""

from dataclasses import replace
from functools import cache

import numpy as np

from restir_gi.extensions.candidates import draw_paths
from restir_gi.extensions.pt_settings import CRITERIA
from restir_gi.extensions.shifting import Shift, Technique, advance, leave, start
from restir_gi.reference.numerics.arrays import dot
from restir_gi.reference.numerics.records import scatter, where
from restir_gi.reference.numerics.rng import KeyedUniforms, Stream
from restir_gi.reference.passes.gbuffer import visible_points
from restir_gi.reference.scene.camera import pixel_centers
from restir_gi.reference.scene.catalogue.registry import find_scene
from restir_gi.reference.scene.lights import SpotLight
from restir_gi.reference.scene.materials.kinds import (
    Coated,
    Conductor,
    Dielectric,
    mirror,
)
from restir_gi.reference.scene.materials.parameters import Kind
from restir_gi.reference.scene.origins import contact, step_before
from restir_gi.reference.scene.surface import direction_and_distance
from restir_gi.reference.scene.textures import Bitmap
from restir_gi.reference.scene.validation import validate
from restir_gi.reference.transport.world import build_world

FLOORS = {
    "paint": None,
    "rough metal": Conductor((0.9, 0.8, 0.6), alpha=0.3),
    "glossy metal": Conductor((0.9, 0.8, 0.6), alpha=0.02),
    "mirror": mirror((0.9, 0.9, 0.9)),
    "rough coat": Coated((0.5, 0.3, 0.2), alpha=0.3),
    "smooth coat": Coated((0.5, 0.3, 0.2), alpha=0.0),
    "glass": Dielectric(1.5),
    "rough glass": Dielectric(1.5, 0.3, "beckmann"),
}
"""Materials of the blocks of a Cornell box."""

SIZE = 32

UNIT = 2.0**-53
"""Relative rounding of one operation."""


def far():
    """A Cornell box of two kilometres."""
    found, larger = find_scene("cornell-box"), np.diag((1e3, 1e3, 1e3, 1.0))
    meshes = tuple(replace(mesh, pose=larger @ mesh.pose) for mesh in found.meshes)
    position, target = (
        tuple(1e3 * np.array(v)) for v in (found.camera.position, found.camera.target)
    )
    camera = replace(found.camera, position=position, target=target)
    return replace(found, camera=camera, meshes=meshes)


def near():
    """Where the short block stands on the floor: ways of millimetres."""
    found = find_scene("cornell-box")
    camera = replace(found.camera, target=(0.35, 0.0, 0.6636), fov=0.3)
    return replace(found, camera=camera)


def bright():
    """Mirrors under a ceiling that shines, which rays often hit."""
    found, ceiling = find_scene("cornell-box"), {"emission": (1.0, 1.0, 1.0)}
    reflecting = {"material": FLOORS["mirror"]}
    meshes = tuple(
        replace(
            mesh,
            **(ceiling if mesh.name == "ceiling" else {}),
            **(reflecting if "block" in mesh.name else {}),
        )
        for mesh in found.meshes
    )
    return replace(found, meshes=meshes)


def lamps():
    """A lamp of which some parts shine, on both sides, and a spot."""
    found, pixels = find_scene("cornell-box"), np.zeros((4, 4, 3))
    pixels[1, 2], pixels[2, :2] = (90.0, 60.0, 20.0), (5.0, 40.0, 40.0)
    glow = {"emission": Bitmap(pixels, "nearest"), "two_sided_emission": True}
    light = next(mesh for mesh in found.meshes if mesh.name == "light")
    uv = light.vertices[:, [0, 2]] - light.vertices[:, [0, 2]].min(axis=0)
    low = light.vertices - [0.0, 0.3, 0.0]
    shining = replace(light, uv=uv / uv.max(axis=0), vertices=low, **glow)
    meshes = tuple(shining if mesh is light else mesh for mesh in found.meshes)
    top = float(low[:, 1].min()) - 0.2
    aim = (0.6, -0.8, 0.0)
    spot = SpotLight((-0.5, top, 0.2), aim, (4.0, 2.0, 6.0), 40.0, 20.0, "smooth")
    return replace(found, meshes=meshes, spots=(spot,))


ROOMS = {"far": far, "near": near, "bright": bright, "lamps": lamps}


@cache
def world(name, size=SIZE):
    """A scene of the catalogue, or the Cornell box, other blocks or another view."""
    if name in ROOMS:
        found = ROOMS[name]()
    else:
        found = find_scene("cornell-box" if name in FLOORS else name)
    camera = replace(found.camera, width=size, height=size)
    meshes = found.meshes
    if FLOORS.get(name) is not None:
        meshes = tuple(
            replace(mesh, material=FLOORS[name]) if "block" in mesh.name else mesh
            for mesh in meshes
        )
    return build_world(validate(replace(found, camera=camera, meshes=meshes)))


def points(w):
    """What its pixels see."""
    camera = w.camera
    return visible_points(w, *pixel_centers(camera.width, camera.height)).surface


def uniforms(pixels, seed=7):
    """Random numbers of paths by their numbers."""

    def of(number):
        pixel = (number % pixels).astype(np.uint32)
        return KeyedUniforms(pixel, number // pixels, seed, Stream.PATH)

    return of


def shifted(shift, w, x, paths, rows):
    """Paths at other points, and the Jacobian, for some of the rows; 0 elsewhere."""
    at = np.flatnonzero(rows & x.hit)
    value, jacobian = shift(w, x, at, paths, at)
    size = len(paths)
    jacobian = scatter(at, jacobian, size)
    return paths.moved(scatter(at, value, size), jacobian), jacobian


def drawn(name, kind, frame=0, bounces=4, size=SIZE):
    """World, visible points, candidates and shift of one frame."""
    w = world(name, size)
    x, pixels = points(w), size * size
    number = np.arange(pixels) + frame * pixels
    of = uniforms(pixels)
    criterion = CRITERIA[kind]
    found = draw_paths(w, x, bounces, criterion, number, of(number))
    return w, x, found, Shift(criterion, of)


def neighbors(size, right, down):
    """Row of each pixel's neighbour, so many pixels off; the image is a torus."""
    grid = np.arange(size * size).reshape(size, size)
    return np.roll(grid, (-down, -right), axis=(0, 1)).ravel()


def walked(w, criterion, x, number, of, last):
    """Points x_1 to x_last of walks with these random numbers.

    Returns for each v the points, and whether they were left by a delta lobe.
    """
    step, visited = start(x), []
    for vertex in range(1, last + 1):
        leaving = leave(w, step, vertex, of(number), step.points.hit)
        visited.append((step.points, leaving.bsdf.delta))
        if vertex < last:
            step = advance(w, criterion, step, vertex, leaving)
    return visited


def joints(w, criterion, visited, paths):
    """Index of the first point at which paths can be joined; 0 where there is none.

    Judged from the points themselves: their distances, and the widths of their lobes.
    """
    found = np.zeros(len(paths), int)
    last = min(len(visited), criterion.last_joint)
    for v in range(2, last + 1):
        (x, delta_from), (met, delta_to) = visited[v - 2], visited[v - 1]
        x_to = where(paths.joint == v, paths.surface, met)
        chosen = (paths.end == v) & (paths.technique == Technique.NEXT_EVENT)
        # At a joint no numbers are replayed, nor are its ends left by delta lobes.
        single = (delta_from & (paths.joint != v)) | (
            delta_to & ~chosen & (paths.joint != v) & (paths.joint != v + 1)
        )
        distance = np.linalg.norm(contact(w.geometry, x_to) - x.position, axis=1)
        fits = distance > criterion.distance * w.geometry.extent
        for end in (x, x_to):
            fits = fits & (least_roughness(w.materials, end) >= criterion.roughness)
        exists = (paths.joint == 0) | (v <= paths.joint)
        fits = fits & ~single & exists & (v <= paths.end)
        found = np.where(fits & (found == 0), v, found)
    return found


def least_roughness(table, points):
    """Root of the GGX width; 1 for diffuse surfaces, also under smooth coats."""
    kind, width = table.kind[points.material], table.alpha[points.material]
    rough = np.isin(kind, (Kind.ROUGH_CONDUCTOR, Kind.ROUGH_COATED))
    painted = np.isin(kind, (Kind.LAMBERTIAN, Kind.SMOOTH_COATED))
    return np.where(points.hit, np.where(rough, width**0.5, painted * 2.0 - 1.0), -1.0)


def seen_from(w, x, surface, x_s):
    """Points of surfaces as other points see them, and how far away they are."""
    omega, d = direction_and_distance(x.position, x_s)
    step = step_before(w.geometry, surface.primitive, surface.normal, -omega)
    return replace(surface, wo=-omega, position=x_s + step), d


def steepness(w, points, omega, other):
    """Largest derivative of the logarithm of a density by the angle of a direction.

    A cosine's is at most 1 / cos.  That of GGX is 2 / α by the angle of the normal
    between both directions, which turns 1 / (2 cos θ_d) as fast as either of them.
    """
    table = w.materials
    kind, alpha = table.kind[points.material], table.alpha[points.material]
    rough = np.isin(kind, (Kind.ROUGH_CONDUCTOR, Kind.ROUGH_COATED))
    cosine = np.maximum(np.abs(dot(points.shading, omega)), UNIT)
    half = np.sqrt(np.maximum(0.5 + 0.5 * dot(omega, other), UNIT))
    return 1.0 / cosine + rough / (np.where(rough, alpha, 1.0) * half)


def left_from(w, x, paths, shift):
    """Points x_(c-1) at which paths that start at x_1 are joined."""
    last = int(paths.joint.max()) - 1
    visited = walked(w, shift.criterion, x, paths.number, shift.uniforms, last)
    found = visited[0][0]
    for v, (met, _) in enumerate(visited, start=1):
        found = where(paths.joint == v + 1, met, found)
    return found

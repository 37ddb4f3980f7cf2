"""Rays at the ends of the number line: no acne, no leaks, no black dots.

All of it at scene scales from 1e-3 to 1e3 and a kilometre from the origin; against
geometry where mathematics says what must be seen, and against an intersector that
tries every triangle in float64.

Embree works in float32 on the scene scaled into [-1, 1]³.  A vertex, an origin and a
direction are each off by up to 2⁻²⁴ in three coordinates, and the intersection adds a
few roundings: some 32 · 2⁻²⁴ = 2⁻¹⁹ of half the scene's size in all.  That is
``MARGIN``: how far a ray may pass on the wrong side of an edge, and no further.
"""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from restir_gi.reference.numerics.records import take
from restir_gi.reference.scene.camera import Camera
from restir_gi.reference.scene.catalogue.registry import find_scene
from restir_gi.reference.scene.checks.space import distance_to_triangles
from restir_gi.reference.scene.geometry import world_corners
from restir_gi.reference.scene.hits import surface_points
from restir_gi.reference.scene.lights import (
    ConstantEnvironment,
    DirectionalLight,
    PointLight,
)
from restir_gi.reference.scene.materials.kinds import Lambertian
from restir_gi.reference.scene.origins import STEP, contact
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.shapes import Mesh, Sphere, box, quad
from restir_gi.reference.transport.path_tracer import follow
from restir_gi.reference.transport.world import build_world
from tests.analytic.rendering import (
    frames_of,
    moved,
    path_traced,
    sized,
    what_is_seen,
    world_of,
)
from tests.extremes.intersector import cross_all, judge

MARGIN = 2.0**-19
GREY = Lambertian((0.5, 0.5, 0.5))
LIGHT = (1.0, 1.0, 1.0)
SKY = ConstantEnvironment(LIGHT)
EPS = 2.0**-52


def placed(scale, offset, turned=False):
    """A similarity: scale, then move, perhaps after a turn about no axis of ours."""
    matrix = np.eye(4)
    if turned:
        axis = np.array([1.0, -2.0, 0.5])
        matrix = trimesh.transformations.rotation_matrix(0.7, axis)
    matrix[:3] *= scale
    matrix[:3, 3] = offset, -0.7 * offset, 0.3 * offset
    return matrix


PLACES = {
    f"scale {scale:g}, offset {offset:g}": placed(scale, offset)
    for scale in (1e-3, 1.0, 1e3)
    for offset in (0.0, 1e3)
}
PLACES["turned, scale 0.001, offset 1000"] = placed(1e-3, 1e3, turned=True)
everywhere = pytest.mark.parametrize("place", PLACES.values(), ids=PLACES)


def directions(count, seed=0):
    """Unit vectors all over the sphere."""
    vectors = np.random.default_rng(seed).normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def triangles(scene):
    """Corners of all triangles in the world, (T, 3, 3)."""
    return np.concatenate([world_corners(mesh) for mesh in scene.meshes])


def half_size(scene):
    """Half of the longest side of a scene of triangles."""
    return np.ptp(triangles(scene).reshape(-1, 3), axis=0).max() / 2


def everyone(rows):
    """Mask of all rows."""
    return np.ones(len(rows), bool)


def row_dot(a, b):
    return np.einsum("...i,...i->...", a, b)


def mesh_sphere(subdivisions=3, inward=False):
    """A closed convex mesh of 20 · 4^n triangles."""
    ball = trimesh.creation.icosphere(subdivisions=subdivisions)
    faces = np.asarray(ball.faces)
    return Mesh(
        name="ball",
        vertices=np.asarray(ball.vertices, float),
        faces=faces[:, ::-1] if inward else faces,
        material=GREY,
    )


def sun_at(elevation, azimuth=20.0):
    """A sun whose light comes from so many degrees above the horizon y = 0."""
    e, a = np.radians([elevation, azimuth])
    to_sun = np.array([np.cos(e) * np.cos(a), np.sin(e), np.cos(e) * np.sin(a)])
    return DirectionalLight(tuple(-to_sun / np.linalg.norm(to_sun)), LIGHT)


def eye_at(elevation, distance=3.0):
    e = np.radians(elevation)
    position = (0.3, distance * np.sin(e), distance * np.cos(e))
    return Camera(position=position, target=(0, 0, 0), fov=30.0)


def fine_floor(parts=40):
    """A plane of 2 parts² triangles."""
    grid = np.linspace(-1, 1, parts + 1)
    x, z = (c.ravel() for c in np.meshgrid(grid, grid))
    row = np.arange(parts * (parts + 1)).reshape(parts, parts + 1)[:, :-1].ravel()
    faces = [[row, row + parts + 1, row + parts + 2], [row, row + parts + 2, row + 1]]
    return Mesh(
        name="floor",
        vertices=np.stack([x, 0 * x, z], axis=1),
        faces=np.concatenate([np.stack(f, axis=1) for f in faces]),
        material=GREY,
    )


# ---------------------------------------------------------------- no acne


ELEVATIONS = (60.0, 5.0, 0.5, 0.05)


@everywhere
@pytest.mark.parametrize("seen_from", [60.0, 2.0])
def test_a_plane_never_shadows_itself(place, seen_from):
    """Every point is lit, down to a sun 0.05 degrees high."""
    for elevation in ELEVATIONS:
        scene = Scene(
            name="plane",
            camera=eye_at(seen_from),
            meshes=(fine_floor(),),
            suns=(sun_at(elevation),),
        )
        scene = moved(scene, place)
        world = world_of(scene, 32)
        seen = what_is_seen(world)
        color = path_traced(world, "direct", points=seen)
        assert seen.hit.sum() > 30
        cosine = -seen.normal[seen.hit] @ np.array(scene.suns[0].direction)
        assert cosine.min() > 0.9 * np.sin(np.radians(elevation))
        lit = 0.5 / np.pi * cosine[:, None]
        assert np.abs(color[seen.hit] - lit).max() < 16 * EPS


CONVEX = {
    "analytic": {
        "spheres": (Sphere(name="s", center=(0, 0, 0), radius=1, material=GREY),)
    },
    "mesh": {"meshes": (mesh_sphere(),)},
    "fine mesh": {"meshes": (mesh_sphere(5),)},
    "block": {"meshes": (box("b", (1, 0.6, 0.8), np.eye(4), GREY),)},
}


@everywhere
@pytest.mark.parametrize("shape", CONVEX)
def test_a_convex_body_is_lit_where_it_faces_the_sun_and_nowhere_else(place, shape):
    """The terminator is a line: no dots on either side of it."""
    for elevation in (70.0, 3.0):
        scene = Scene(
            name="body",
            camera=Camera((1.5, 1.2, 2.8), (0, 0, 0), fov=45.0),
            suns=(sun_at(elevation),),
            **CONVEX[shape],
        )
        scene = moved(scene, place)
        world = world_of(scene, 48)
        seen = what_is_seen(world)
        color = path_traced(world, "direct", points=seen)[:, 0]
        cosine = -seen.normal @ np.array(scene.suns[0].direction)
        faces = seen.hit & (cosine > 0)
        assert faces.sum() > 100
        expected = np.where(faces, 0.5 / np.pi * np.maximum(cosine, 0.0), 0.0)
        assert np.abs(color - expected).max() < 16 * EPS


@everywhere
@pytest.mark.parametrize("shape", CONVEX)
def test_rays_that_leave_a_convex_body_meet_nothing(place, shape):
    """Also those that leave along the surface, 1e-4 above it, and below the shading."""
    camera = Camera((1.5, 1.2, 2.8), (0, 0, 0), fov=40.0)
    scene = moved(Scene(name="b", camera=camera, **CONVEX[shape]), place)
    world = world_of(scene, 64)
    seen = what_is_seen(world)
    seen = take(seen, np.flatnonzero(seen.hit))
    for lift in (1.0, 0.1, 1e-2, 1e-4):
        side = unit(np.cross(seen.normal, directions(len(seen))))
        outward = unit(side + lift * seen.normal)
        assert not follow(world, seen, outward, everyone(seen), "bounce").hit.any()


# ---------------------------------------------------------------- no leaks


CLOSED = {
    "box": box("room", (2, 2, 2), np.eye(4), GREY, inward=True),
    "flat box": box("room", (2, 0.02, 2), np.eye(4), GREY, inward=True),
    "ball": mesh_sphere(3, inward=True),
}


def rays_at_edges(mesh, origin, count=40):
    """Directions to all vertices, and to points on all edges, to the last bit and near.

    The near ones miss by 1e-7 of the scene, about a rounding of float32.
    """
    corners = mesh.vertices[mesh.faces]
    share = np.linspace(0, 1, count)[:, None, None]
    on_edges = [
        corners[:, i] + share * (corners[:, (i + 1) % 3] - corners[:, i])
        for i in range(3)
    ]
    targets = np.concatenate([mesh.vertices, *(e.reshape(-1, 3) for e in on_edges)])
    shaken = targets + 1e-7 * np.random.default_rng(1).normal(size=targets.shape)
    return unit(np.concatenate([targets, shaken]) - origin)


@everywhere
@pytest.mark.parametrize("shape", ["box", "flat box", "ball"])
@pytest.mark.few(3)
def test_no_ray_finds_a_way_out_of_a_closed_body(place, shape):
    """Aimed at edges and corners, and anywhere."""
    mesh = CLOSED[shape]
    eye = np.array([0.123, 0.003, -0.21])
    scene = Scene(name="r", camera=Camera(tuple(eye), (1, 0, 0)), meshes=(mesh,))
    world = world_of(moved(scene, place), 4)
    aimed = np.concatenate([rays_at_edges(mesh, eye), directions(5000)])
    turn = place[:3, :3] / np.linalg.norm(place[:3, 0])
    aimed = aimed @ turn.T
    start = np.tile(world.camera.position, (len(aimed), 1))
    hits = world.caster.from_camera(start, aimed)
    assert (hits.primitive >= 0).all()
    # And on from there, four times, wherever they have come to: edges included.
    points = surface_points(world.geometry, hits, start, aimed)
    for bounce in range(4):
        assert points.front.all()
        onward = directions(len(points), bounce)
        sign = np.where(row_dot(onward, points.normal) > 0, 1.0, -1.0)
        points = follow(
            world, points, onward * sign[:, None], everyone(points), "bounce"
        )
        assert points.hit.all()


@everywhere
@pytest.mark.parametrize("shape", CLOSED)
def test_a_closed_body_in_bright_light_is_black_inside(place, shape):
    """Exactly: sky and sun outside, a lamp just behind the wall."""
    scene = Scene(
        name="room",
        camera=Camera((0.3, 0.002, 0.4), (1, 0, -1), fov=110.0),
        meshes=(CLOSED[shape],),
        suns=(sun_at(40.0), sun_at(0.0, 45.0)),
        points=(PointLight((1.01, 1.01, 1.01), LIGHT),),
        environment=SKY,
    )
    world = world_of(moved(scene, place), 48)
    assert not path_traced(world, "full", bounces=6, samples=6).any()
    assert not frames_of(world, 2, bounces=2)[-1].color.any()


def test_control_a_hole_is_found():
    """One of 1,280 triangles is missing: light gets in."""
    mesh = CLOSED["ball"]
    holed = replace(mesh, faces=mesh.faces[1:])
    camera = Camera((0.3, 0.002, 0.4), (1, 0, -1), fov=110.0)
    scene = Scene(name="r", camera=camera, meshes=(holed,), environment=SKY)
    assert path_traced(world_of(scene, 48), "full", bounces=6, samples=6).any()


TOUCHING = {
    "side by side": ((2, 0, 0), 0.0),
    "on top": ((0, 2, 0), 0.0),
    "on top, turned": ((0, 2, 0), 33.0),
    "edge to edge": ((2, 2, 0), 0.0),
    "interlocking": ((1, 0, 0), 0.0),
    "the same place": ((0, 0, 0), 0.0),
}


@everywhere
@pytest.mark.parametrize("how", TOUCHING)
def test_light_stays_in_a_box_that_touches_another(place, how):
    """A lamp in the one, faces shared or coplanar with the other: dark outside."""
    where, turn = TOUCHING[how]
    other = trimesh.transformations.rotation_matrix(np.radians(turn), [0, 1, 0])
    other[:3, 3] = where
    lamp = quad("lamp", (-0.1, -0.5, -0.1), (0, 0, 0.2), (0.2, 0, 0), GREY, LIGHT)
    scene = Scene(
        name="boxes",
        camera=Camera((4.0, 5.0, 6.0), (0.5, 0.5, 0), fov=45.0),
        meshes=(
            box("lit", (2, 2, 2), np.eye(4), GREY),
            box("dark", (2, 2, 2), other, GREY),
            lamp,
        ),
    )
    world = world_of(moved(scene, place), 40)
    assert what_is_seen(world).hit.mean() > 0.1
    assert not path_traced(world, "full", bounces=4, samples=8).any()


# ---------------------------------------------------------------- no black dots


def edge_view(size=33):
    """A camera whose pixel centres 4 and 28 lie on the edges of a cube's back wall.

    The wall is 2 m away and 2 m wide: slope 1/2, which is 24/33 of the half width.
    """
    half_width = 0.5 * 33 / 24
    fov = float(np.degrees(2 * np.arctan(half_width)))
    camera = Camera((0, 0, 1), (0, 0, -1), fov=fov, width=size, height=size)
    room = box("room", (2, 2, 2.5), np.eye(4), GREY, inward=True)
    matrix = np.eye(4)
    matrix[2, 3] = 0.25
    return Scene(name="room", camera=camera, meshes=(replace(room, pose=matrix),))


def on_edges(size=33):
    """Rows whose pixel centres lie on an edge."""
    x, y = np.arange(size * size) % size, np.arange(size * size) // size
    inner = (np.minimum(x, y) >= 4) & (np.maximum(x, y) <= 28)
    frame = inner & ((x == 4) | (x == 28) | (y == 4) | (y == 28))
    # The edges that come towards the camera are the diagonals.
    outer = (x == y) | (x + y == size - 1)
    return np.flatnonzero(frame | (outer & ~inner))


def test_the_view_really_meets_the_edges():
    world = build_world(edge_view())
    seen = take(what_is_seen(world), on_edges())
    x = contact(world.geometry, seen)
    # Within some steps of a wall: a point may be moved by so much, not more.
    near = 32 * STEP
    walls = (np.abs(np.abs(x) - [1, 1, 1]) < near) | (np.abs(x - [0, 0, -1]) < near)
    assert len(x) > 100
    assert (walls.sum(axis=1) >= 2).mean() > 0.9


@everywhere
def test_points_on_concave_edges_stand_before_both_walls(place):
    """From exact edges and corners of a cube: all rays stay in, all walls are seen."""
    world = build_world(moved(edge_view(), place))
    seen = what_is_seen(world)
    points = take(seen, np.repeat(on_edges(), 64))
    onward = directions(len(points), 5)
    sign = np.where(row_dot(onward, points.normal) > 0, 1.0, -1.0)
    met = follow(world, points, onward * sign[:, None], everyone(points), "bounce")
    assert met.hit.all()
    # The front is the inside: a point behind a wall would see backs.
    assert met.front.all()


@everywhere
def test_concave_edges_are_as_bright_as_what_is_beside_them(place):
    """Walls that glow: light at x is e (1 + ρ + ρ²), on edges as anywhere.

    The reflected part of a sample lies between 0 and B = 2 ρ e (1 + ρ) = 1.5, since
    either strategy of MIS brings at most ρ e a vertex.  By Hoeffding's inequality the
    mean of n = 112 · 96 samples is off by more than B √(ln(2 / 1e-9) / 2n) = 0.05 with
    probability 1e-9.  A pixel behind the wall lacks 0.75 of 1.75.
    """
    scene = edge_view()
    glowing = tuple(replace(m, emission=LIGHT) for m in scene.meshes)
    world = build_world(moved(replace(scene, meshes=glowing), place))
    points = take(what_is_seen(world), on_edges())
    color = path_traced(world, "full", bounces=1, samples=96, points=points)[:, 0]
    assert abs(color.mean() - 1.75) < 0.06
    # And no pixel alone is dark: 0.55, for its 96 samples and the rate over 112.
    assert len(color) == 112
    assert color.min() > 1.75 - 0.56


def wedge(angle):
    """Two planes that meet at an angle, seen so that a row of pixels is on the edge."""
    a = np.radians(angle / 2)
    z = np.array([0.0, 0.0, 2.0])
    upper, lower = (2 * np.array([np.cos(a), s * np.sin(a), 0]) for s in (1, -1))
    return Scene(
        name="wedge",
        camera=Camera((1.5, 0, 0), (0, 0, 0), fov=40.0),
        meshes=(
            quad("upper", tuple(-z / 2), tuple(z), tuple(upper), GREY),
            quad("lower", tuple(-z / 2), tuple(lower), tuple(z), GREY),
        ),
        environment=SKY,
    )


@pytest.mark.parametrize(
    "angle",
    [170, 135, 90, 60, 40, 20, 10],
)
def test_the_edge_of_a_wedge_is_seen_from_inside(angle):
    """Where rays start is before both planes."""
    world = world_of(wedge(angle), 33)
    seen = what_is_seen(world)
    on_edge = np.arange(33 * 16 + 2, 33 * 16 + 31)
    x = contact(world.geometry, take(seen, on_edge))
    assert np.abs(x[:, :2]).max() < 32 * STEP
    points = take(seen, np.repeat(on_edge, 64))
    # Towards the opening all is free; the walls hide everything else.
    a = np.radians(angle / 2)
    height = np.array([np.sin(a), np.cos(a), 0.0]), np.array([np.sin(a), -np.cos(a), 0])
    for n in height:
        assert (points.position @ n > 0).all()


# ---------------------------------------------------------------- far and huge


@pytest.mark.parametrize("far", [1e2, 1e4, 1e6])
def test_a_camera_very_far_away_sees_the_same(far):
    """From 1e6 m the block is as sharp as from near: judged by the float64 intersector.

    The camera's own rounding, 2⁻⁵³ · 1e6 = 1e-10, is far below the margin.
    """
    scene = Scene(
        name="far",
        camera=Camera(
            position=(0.6 * far, 0.5 * far, 0.7 * far),
            target=(0, 0, 0),
            fov=float(np.degrees(2 * np.arctan(1.2 / far))),
        ),
        meshes=(box("b", (1, 0.6, 0.8), np.eye(4), GREY), fine_floor(10)),
        suns=(sun_at(30.0),),
    )
    world = world_of(scene, 40)
    seen = what_is_seen(world)
    start = np.tile(scene.camera.position, (len(seen), 1))
    judged = judge(cross_all(start, -seen.wo, triangles(scene)), seen.primitive, MARGIN)
    assert judged.legal.all()
    assert judged.forced.mean() > 0.9
    assert seen.hit.mean() > 0.25
    color = path_traced(world, "direct", points=seen)
    top = seen.hit & (seen.normal[:, 1] > 0.9) & (seen.position[:, 1] > 0.2)
    assert np.abs(color[top] - 0.5 / np.pi * np.sin(np.radians(30))).max() < 16 * EPS


@pytest.mark.parametrize("far", [1e2, 1e3, 1e4])
def test_a_huge_triangle_far_away_opens_no_leak(far):
    """A room of 2 m, closed, in a scene of 1e4 m: rounding is 1e-3 m, no leaks."""
    outlier = Mesh(
        name="outlier",
        vertices=far * np.array([[1.0, 0, 0], [1, 1, 0], [1, 0, 1]]),
        faces=np.array([[0, 1, 2]]),
        material=GREY,
    )
    scene = Scene(
        name="room",
        camera=Camera((0.1, 0.2, 0.3), (1, 0, -1), fov=110.0),
        meshes=(CLOSED["box"], outlier),
        environment=SKY,
    )
    world = world_of(scene, 48)
    seen = what_is_seen(world)
    assert seen.hit.all()
    assert seen.front.all()
    assert not path_traced(world, "full", bounces=3, samples=4).any()


# ---------------------------------------------------------------- against brute force


def random_triangles(count, size, seed):
    rng = np.random.default_rng(seed)
    center = rng.uniform(-1, 1, (count, 1, 3))
    return center + size * rng.normal(size=(count, 3, 3))


def slivers(count, seed, thinnest=-6):
    """Triangles of length 1 and height 10^thinnest to 1e-2."""
    rng = np.random.default_rng(seed)
    a, along, across = (rng.uniform(-1, 1, (count, 3)) for _ in range(3))
    height = 10.0 ** rng.uniform(thinnest, -2, (count, 1))
    return np.stack([a, a + along, a + 0.4 * along + height * across], axis=1)


SOUPS = {
    "one": random_triangles(1, 1.0, 1),
    "small": random_triangles(30, 0.5, 2),
    "thousand": random_triangles(1200, 0.1, 3),
    "slivers": slivers(300, 4),
    # Not so thin that float32 turns their normals by more than a degree.
    "long": slivers(300, 4, thinnest=-4),
    "outlier": np.concatenate([random_triangles(60, 0.4, 5), [1e3 * np.eye(3)]]),
    "coplanar": np.tile(random_triangles(20, 0.5, 6), (3, 1, 1)),
    "sheets": np.concatenate(
        [random_triangles(40, 0.5, 7) * [1, 1, 0] + [0, 0, 1e-4 * i] for i in range(10)]
    ),
}


def soup_scene(corners):
    vertices = corners.reshape(-1, 3)
    faces = np.arange(len(vertices)).reshape(-1, 3)
    mesh = Mesh(name="soup", vertices=vertices, faces=faces, material=GREY)
    return Scene(name="soup", camera=Camera((0, 0, 4), (0, 0, 0)), meshes=(mesh,))


@everywhere
@pytest.mark.parametrize("soup", SOUPS)
def test_closest_hits_are_those_of_every_triangle_tried(place, soup):
    scene = moved(soup_scene(SOUPS[soup]), place)
    world = build_world(scene)
    rng = np.random.default_rng(8)
    count = 400 if len(SOUPS[soup]) > 1000 else 1000
    local = rng.uniform(-1, 1, (count, 3)), rng.uniform(-1, 1, (count, 3))
    start, target = (x @ place[:3, :3].T + place[:3, 3] for x in local)
    along = unit(target - start)
    hits = world.caster.from_camera(start, along)
    crossings = cross_all(start, along, triangles(scene))
    margin = MARGIN * half_size(scene)
    judged = judge(crossings, hits.primitive, margin)
    assert judged.legal.all()
    # Triangles in one plane tie, and with an outlier the margin is a metre wide.
    if soup not in ("coplanar", "sheets", "outlier"):
        assert judged.forced.mean() > 0.8
    # At the distance that was told, the ray is at the triangle.
    for i in np.flatnonzero(hits.primitive >= 0)[:300]:
        there = start[i] + hits.distance[i] * along[i]
        corners = triangles(scene)[hits.primitive[i]]
        assert distance_to_triangles(there, corners[None])[0] <= 2 * margin


def test_control_a_wrong_triangle_is_not_legal():
    scene = soup_scene(SOUPS["thousand"])
    world = build_world(scene)
    start, along = np.zeros((400, 3)), directions(400)
    hits = world.caster.from_camera(start, along)
    crossings = cross_all(start, along, triangles(scene))
    judged = judge(crossings, np.roll(hits.primitive, 1), MARGIN)
    assert judged.legal.mean() < 0.2
    nothing = np.full(400, -1)
    assert judge(crossings, nothing, MARGIN).legal.mean() < 0.9


@everywhere
def test_hit_points_lie_on_their_triangles(place):
    """Made of barycentrics in float64: off the plane by rounding of the coordinates.

    Eight roundings of the largest coordinate, whatever Embree rounded before.
    """
    scene = moved(soup_scene(SOUPS["small"]), place)
    world = build_world(scene)
    g = world.geometry
    start = np.tile(place[:3, 3], (2000, 1))
    along = directions(2000)
    points = surface_points(g, world.caster.from_camera(start, along), start, along)
    points = take(points, np.flatnonzero(points.hit))
    assert len(points) > 300
    x = contact(g, points)
    corners = triangles(scene)[points.primitive]
    edges = corners[:, 1:] - corners[:, :1]
    normal = unit(np.cross(edges[:, 0], edges[:, 1]))
    height = np.abs(row_dot(x - corners[:, 0], normal))
    largest = np.abs(triangles(scene)).max()
    assert height.max() <= 8 * EPS * largest
    # Before the surface by a step, on the side that is seen.
    lift = row_dot(points.position - x, points.normal)
    step = STEP * half_size(scene)
    assert (lift >= 0.99 * step).all()
    assert (lift <= 2.01 * step).all()


@everywhere
@pytest.mark.parametrize("soup", ["small", "thousand", "long"])
def test_visibility_is_that_of_every_triangle_tried_and_symmetric(place, soup):
    """Between points of surfaces; forced where nothing comes within the margin."""
    scene = moved(soup_scene(SOUPS[soup]), place)
    world, size = build_world(scene), half_size(scene)
    g = world.geometry
    count = 500
    start = np.tile(place[:3, 3], (4000, 1))
    along = directions(4000, 3)
    points = surface_points(g, world.caster.from_camera(start, along), start, along)
    rows = np.flatnonzero(points.hit)
    rng = np.random.default_rng(9)
    a, b = rng.choice(rows, count), rng.choice(rows, count)
    x = contact(g, points)
    # Each on the side of its surface that faces the other.
    toward = x[b] - x[a]
    faces = row_dot(toward, points.normal[a]) > 0.05 * size
    faces &= row_dot(toward, points.normal[b]) < -0.05 * size
    a, b = a[faces], b[faces]
    assert len(a) > 20
    from_a, from_b = take(points, a), take(points, b)
    forth = world.caster.visible(from_a, x[b], from_b.normal, everyone(a), "reuse")
    back = world.caster.visible(from_b, x[a], from_a.normal, everyone(a), "reuse")
    distance = np.linalg.norm(x[b] - x[a], axis=1)
    crossings = cross_all(x[a], unit(x[b] - x[a]), triangles(scene))
    # What lies within 16 margins of either end, or of an edge, may count or not.
    margin = 16 * MARGIN * size
    blur = margin / np.maximum(crossings.slope, 1e-300)
    between = (crossings.distance > blur) & (
        crossings.distance < distance[:, None] - blur
    )
    surely = (between & (crossings.inside > margin)).any(axis=1)
    reach = (crossings.distance > -blur) & (
        crossings.distance < distance[:, None] + blur
    )
    own = np.zeros_like(reach)
    own[np.arange(len(a)), points.primitive[a]] = True
    own[np.arange(len(a)), points.primitive[b]] = True
    possibly = (reach & ~own & (crossings.inside > -margin)).any(axis=1)
    for free in (forth, back):
        assert not free[surely].any()
        assert free[~possibly].all()
    forced = surely | ~possibly
    assert forced.mean() > 0.9
    assert forth.mean() > 0.02
    assert np.array_equal(forth[forced], back[forced])


# ---------------------------------------------------------------- odds and ends


@everywhere
def test_rays_may_start_at_vertices(place):
    """Seen exactly at the eight corners of a block, all rays outward are free."""
    block = box("b", (1, 1, 1), np.eye(4), GREY)
    scene = Scene(name="b", camera=Camera((0, 0, 4), (0, 0, 0)), meshes=(block,))
    world = build_world(moved(scene, place))
    vertices = block.vertices @ place[:3, :3].T + place[:3, 3]
    # Each corner is looked at from outside, along its own diagonal.
    away = unit(vertices - place[:3, 3])
    start = vertices + 2 * np.linalg.norm(place[:3, 0]) * away
    hits = world.caster.from_camera(start, -away)
    points = surface_points(world.geometry, hits, start, -away)
    found = np.flatnonzero(points.hit)
    # A convex corner is a silhouette from nowhere here: all eight are hit.
    assert len(found) == 8
    points = take(points, np.repeat(found, 200))
    outward = directions(len(points), 2)
    # Within the cone that no face of the block is in: towards the corner's octant.
    local = np.repeat(np.sign(block.vertices), 200, axis=0)
    turn = place[:3, :3] / np.linalg.norm(place[:3, 0])
    outward = (np.abs(outward) * local) @ turn.T
    assert not follow(world, points, outward, everyone(points), "bounce").hit.any()


def test_rays_are_counted_by_kind():
    """Each ray once: primary, bounce, shadow, and those of ReSTIR GI."""
    scene = sized(find_scene("cornell-box"), 16)
    world = build_world(scene)
    caster = world.caster
    assert caster.counts == Counter()
    seen = what_is_seen(world)
    assert caster.counts == Counter(primary=256)
    hit = int(seen.hit.sum())
    some = np.arange(256) < 10
    caster.visible(seen, seen.position, seen.normal, some, "reuse")
    caster.escapes(seen, seen.normal, some, "shadow")
    caster.from_surface(seen, seen.normal, everyone(seen), "bounce")
    assert caster.counts == Counter(primary=256, reuse=10, shadow=10, bounce=256)
    caster.counts.clear()
    path_traced(world, "direct", points=seen)
    # One shadow ray and one BSDF ray a vertex at most, and only from what scatters.
    assert 0 < caster.counts["shadow"] <= hit
    assert 0 < caster.counts["bounce"] <= hit
    caster.counts.clear()
    frames_of(world, 2)
    assert caster.counts["primary"] == 256
    assert 0 < caster.counts["initial"] <= 2 * 256
    assert caster.counts["reuse"] > 0


def test_no_rays_no_answers():
    """Empty arrays in, empty arrays out, for triangles and spheres alike."""
    for name in ("cornell-box", "sphere-furnace"):
        world = world_of(find_scene(name), 4)
        none = np.zeros((0, 3))
        hits = world.caster.from_camera(none, none)
        points = surface_points(world.geometry, hits, none, none)
        assert len(points) == 0
        nobody = np.zeros(0, bool)
        assert len(world.caster.visible(points, none, none, nobody, "reuse")) == 0
        assert len(world.caster.escapes(points, none, nobody, "shadow")) == 0
        assert len(follow(world, points, none, everyone(points), "bounce")) == 0

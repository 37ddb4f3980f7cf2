"""Alpha masks: a hole is no surface, for rays of all kinds, however many lie in a row.

Closed forms without tolerance: a mesh that is all holes is not there and one without
holes is whole, to the last bit of the picture.  A soup of pierced triangles is held
against every triangle tried by itself, in float64.
"""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from restir_gi.reference.scene.catalogue.rooms import cornell_box
from restir_gi.reference.scene.emitters import build_emitters
from restir_gi.reference.scene.geometry import build_geometry
from restir_gi.reference.scene.light_sampling import sample_light
from restir_gi.reference.scene.materials.kinds import Lambertian
from restir_gi.reference.scene.shapes import Mesh, quad
from restir_gi.reference.scene.surface import Viewpoints
from restir_gi.reference.scene.textures import Bitmap
from restir_gi.reference.scene.validation import validate
from restir_gi.reference.transport.world import build_world
from tests.analytic.rendering import frames_of, path_traced, world_of

GREY = Lambertian((0.5, 0.5, 0.5))
SIZE = 20


def bitmap(rows):
    """Opacities in rows from the top, read without interpolation."""
    return Bitmap(np.repeat(np.array(rows, float)[..., None], 3, axis=2), "nearest")


ABSENT, WHOLE = bitmap([[0.0]]), bitmap([[1.0]])
LEFT = bitmap([[1.0, 0.0]])


def veil(opacity, height=0.9):
    """A slanted sheet in the middle of the Cornell box, which it nearly fills."""
    sheet = quad("veil", (-0.6, height, -0.6), (1.2, 0.0, 0.0), (0.0, 0.3, 1.2), GREY)
    return replace(sheet, opacity=opacity)


def box_with(*meshes):
    box = cornell_box()
    return world_of(validate(replace(box, meshes=(*box.meshes, *meshes))), SIZE)


def pictures(world):
    """Path-traced light of all kinds, and three frames of ReSTIR GI."""
    frames = frames_of(world, 3)
    return [path_traced(world, "full", 3), *(frame.color for frame in frames)]


@pytest.mark.parametrize("layers", [1, 40])
def test_sheets_that_are_all_holes_are_not_there(layers):
    sheets = [veil(ABSENT, 0.5 + 0.01 * k) for k in range(layers)]
    pierced, bare = box_with(*sheets), box_with()
    for found, wanted in zip(pictures(pierced), pictures(bare), strict=True):
        assert_array_equal(found, wanted)
    behind = pierced.caster.counts.pop("behind masks")
    # The same rays, and one more for each hole that one of them passes.
    assert pierced.caster.counts == bare.caster.counts
    assert behind >= 100 * layers


def test_a_sheet_without_holes_is_whole():
    masked, whole = box_with(veil(WHOLE)), box_with(veil(None))
    for found, wanted in zip(pictures(masked), pictures(whole), strict=True):
        assert_array_equal(found, wanted)
    assert masked.caster.counts == whole.caster.counts


def test_control_a_sheet_is_seen():
    assert (path_traced(box_with(veil(None))) != path_traced(box_with())).any()


def sheets(*opacities, gap=0.01):
    """Unit squares facing up, one above another from z = 0, and a floor below."""
    floor = quad("floor", (-1, -1, -1), (2, 0, 0), (0, 2, 0), GREY)
    stack = [
        replace(quad(f"sheet {k}", (0, 0, gap * k), (1, 0, 0), (0, 1, 0), GREY),
                opacity=opacity)
        for k, opacity in enumerate(opacities)
    ]  # fmt: skip
    lamp = quad("lamp", (-1, -1, 1), (0, 2, 0), (2, 0, 0), GREY, (1.0, 1.0, 1.0))
    return replace(cornell_box(), meshes=(floor, *stack, lamp), spheres=())


def looking_down(world, x):
    """What rays from z = 0.99 straight down meet, at points of the x axis."""
    origin = np.stack([x, np.full_like(x, 0.4), np.full_like(x, 0.99)], axis=1)
    down = np.tile([[0.0, 0.0, -1.0]], (len(x), 1))
    return world.caster.from_camera(origin, down)


def mesh_of(world, hits):
    return world.geometry.shape[hits.primitive]


X = (np.arange(8) + 0.5) / 8


def test_rays_go_on_until_there_is_a_surface():
    """Sheet 5 is solid on the left; above and below are forty that are not there."""
    stack = [ABSENT] * 5 + [LEFT] + [ABSENT] * 40
    world = build_world(sheets(*stack))
    hits = looking_down(world, X)
    assert_array_equal(mesh_of(world, hits), np.where(X < 0.5, 6, 0))
    # Float32 at a distance of 1.
    due = np.where(X < 0.5, 0.99 - 0.05, 1.99)
    assert (abs(hits.distance - due) <= 8 * np.finfo(np.float32).eps).all()
    passed = np.where(X < 0.5, 40, 46).sum()
    assert world.caster.counts == {"primary": 8, "behind masks": passed}


@pytest.mark.parametrize("pierced_first", [True, False])
def test_an_opaque_face_in_the_plane_of_a_hole_is_met(pierced_first):
    opacities = [ABSENT, None] if pierced_first else [None, ABSENT]
    world = build_world(sheets(*opacities, gap=0.0))
    solid = 1 + opacities.index(None)
    assert_array_equal(mesh_of(world, looking_down(world, X)), solid)


def test_light_passes_holes_and_nothing_else():
    """From the floor up to z = 0.9, past one sheet that is solid on the left."""
    world = build_world(sheets(LEFT))
    below = np.stack([X, np.full(8, 0.4), np.full(8, -0.9)], axis=1)
    above = below + np.array([0.0, 0.0, 1.8])
    points = Viewpoints(below, np.zeros(8, np.int32))
    ask, free = np.ones(8, bool), np.zeros((8, 3))
    seen = world.caster.visible(points, above, free, ask, "shadow")
    assert_array_equal(seen, X > 0.5)
    # Up to the sheet all see, and those who do not ask see nothing.
    near = below + np.array([0.0, 0.0, 0.8])
    assert world.caster.visible(points, near, free, ask, "shadow").all()
    assert not world.caster.visible(points, above, free, ~ask, "shadow").any()
    up = np.tile([[0.0, 0.0, 1.0]], (8, 1))
    assert not world.caster.escapes(points, up, ask, "shadow").any()


def test_the_cutoff_is_where_the_surface_begins():
    """Opacities of 0.2, 0.4, 0.6 and 0.8 from left to right, cut at 0.6."""
    scene = sheets(bitmap([[0.2, 0.4, 0.6, 0.8]]))
    floor, sheet, lamp = scene.meshes
    scene = replace(scene, meshes=(floor, replace(sheet, opacity_cutoff=0.6), lamp))
    world = build_world(scene)
    assert_array_equal(mesh_of(world, looking_down(world, X)), np.where(X > 0.5, 1, 0))


# ---------------------------------------------------------------- lamps with holes


def test_holes_of_a_lamp_send_no_light():
    """Each point that is drawn has its weight in the whole lamp, or none in a hole.

    So half of the lamp is drawn from as if it were the whole lamp behind a cover, and
    the mean of both is the light of what is left.
    """
    floor = quad("floor", (-1, -1, 0), (2, 0, 0), (0, 2, 0), GREY)
    lamp = quad("lamp", (0, 0, 1), (0, 1, 0), (1, 0, 0), GREY, (1.0, 2.0, 3.0))
    # Its u runs along y: solid where y < 1/2.
    pierced = replace(lamp, opacity=LEFT)
    found = {}
    for name, shape in (("whole", lamp), ("pierced", pierced)):
        scene = replace(cornell_box(), meshes=(floor, shape), spheres=())
        geometry = build_geometry(scene)
        emitters = build_emitters(scene, geometry)
        grid = (np.arange(24) + 0.5) / 24
        u = [g.ravel() for g in np.meshgrid(grid, grid, grid)]
        x = np.zeros((len(u[0]), 3))
        found[name] = sample_light(emitters, geometry, x, (*u, u[0]))
    whole, pierced = found["whole"], found["pierced"]
    assert_array_equal(pierced.x_to, whole.x_to)
    assert_array_equal(pierced.pdf, whole.pdf)
    solid = whole.x_to[:, 1] < 0.5
    assert 0.4 < solid.mean() < 0.6
    assert_array_equal(pierced.weight, np.where(solid[:, None], whole.weight, 0.0))


# ---------------------------------------------------------------- a soup of triangles


def soup(rng, count):
    """Triangles all over a cube, each with its own corner of a random mask."""
    middle = rng.uniform(-1, 1, (count, 1, 3))
    corners = middle + rng.normal(scale=0.5, size=(count, 3, 3))
    return Mesh(
        name="soup",
        vertices=corners.reshape(-1, 3),
        faces=np.arange(3 * count).reshape(-1, 3),
        material=GREY,
        uv=rng.uniform(0, 1, (3 * count, 2)),
        opacity=bitmap(rng.random((16, 16))),
        opacity_cutoff=0.7,
    )


def one_by_one(mesh, origin, direction):
    """First solid triangle along each ray, and whether rounding may choose another."""
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
    edge_u, edge_v = b - a, c - a
    normal = np.cross(edge_u, edge_v)
    size = len(origin), len(a)
    height = direction @ normal.T
    t = ((a * normal).sum(1) - origin @ normal.T) / height
    place = origin[:, None] + t[..., None] * direction[:, None] - a
    doubled = (normal**2).sum(1)
    u = (np.cross(place, edge_v) * normal).sum(-1) / doubled
    v = (np.cross(edge_u, place) * normal).sum(-1) / doubled
    uv = mesh.uv[mesh.faces]
    w = (1 - u - v)[..., None]
    where = w * uv[:, 0] + u[..., None] * uv[:, 1] + v[..., None] * uv[:, 2]
    texel = 16 * where
    row, column = 15 - np.floor(texel[..., 1]), np.floor(texel[..., 0])
    row, column = (np.clip(k, 0, 15).astype(int) for k in (row, column))
    inside = (np.minimum(np.minimum(u, v), 1 - u - v) > 0) & (t > 0)
    solid = inside & (mesh.opacity.pixels[row, column, 0] >= mesh.opacity_cutoff)
    depth = np.where(solid, t, np.inf)
    first = np.argmin(depth, axis=1)
    met = np.isfinite(depth[np.arange(size[0]), first])
    # Near an edge, a texel's border, edge-on, or close behind another surface.
    edge = np.minimum(np.minimum(abs(u), abs(v)), abs(1 - u - v)) < 1e-3
    border = (abs(texel - np.round(texel)) < 1e-2).any(-1)
    thin = abs(height) / np.linalg.norm(normal, axis=1) < 1e-2
    near = np.sort(np.where(inside, t, np.inf), axis=1)
    with np.errstate(invalid="ignore"):
        touching = (np.diff(near, axis=1) < 1e-4).any(1)
    doubtful = ((edge | border | thin) & (t > -1e-3)).any(1) | touching
    return np.where(met, first, -1), doubtful


@pytest.mark.parametrize("seed", range(3))
def test_a_soup_of_pierced_triangles_is_met_where_each_is_by_itself(seed):
    """Rays in doubt within 1e-3, 4000 times the rounding of float32, are left out."""
    rng = np.random.default_rng(seed)
    mesh = soup(rng, 25)
    world = build_world(replace(cornell_box(), meshes=(mesh,), spheres=()))
    origin = rng.uniform(-1, 1, (4000, 3))
    direction = rng.normal(size=(4000, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    wanted, doubtful = one_by_one(mesh, origin, direction)
    found = world.caster.from_camera(origin, direction).primitive
    sure = ~doubtful
    assert sure.sum() > 300
    assert_array_equal(found[sure], wanted[sure])
    points = Viewpoints(origin, np.full(4000, -1, np.int32))
    free = world.caster.escapes(points, direction, np.ones(4000, bool), "shadow")
    assert_array_equal(free[sure], wanted[sure] < 0)
    # Control: without holes other triangles are met.
    bare = build_world(
        replace(cornell_box(), meshes=(replace(mesh, opacity=None),), spheres=())
    )
    other = bare.caster.from_camera(origin, direction).primitive
    assert (other[sure] != wanted[sure]).mean() > 0.1

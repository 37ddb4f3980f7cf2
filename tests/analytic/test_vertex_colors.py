"""Colours of vertices: factors on the reflectance, linear over each triangle."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from restir_gi.reference.scene.catalogue.rooms import cornell_box
from restir_gi.reference.scene.hits import surface_points
from restir_gi.reference.scene.materials.kinds import Dielectric, Lambertian
from restir_gi.reference.scene.shapes import quad
from restir_gi.reference.scene.textures import Bitmap
from restir_gi.reference.scene.validation import validate
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.transport.world import build_world
from tests.analytic.rendering import path_traced, world_of

SQUARE = quad("square", (0, 0, 0), (1, 0, 0), (0, 1, 0), Lambertian((0.8, 0.5, 0.2)))
RAMP = np.array([[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)
"""Red is x and green is y, at the corners of the square."""


def seen_from_above(mesh, rows=500):
    scene = replace(cornell_box(), meshes=(mesh,), spheres=())
    world = build_world(scene)
    xy = np.random.default_rng(0).uniform(0.01, 0.99, (rows, 2))
    origin = np.column_stack([xy, np.ones(rows)])
    down = np.tile([[0.0, 0.0, -1.0]], (rows, 1))
    hits = world.caster.from_camera(origin, down)
    return xy, surface_points(world.geometry, hits, origin, down)


@pytest.mark.parametrize("textured", [False, True])
def test_colours_are_linear_over_triangles(textured):
    """Barycentric coordinates are Embree's, in float32: some ten of its roundings."""
    reflectance = np.array([0.8, 0.5, 0.2])
    material = Lambertian(tuple(reflectance))
    if textured:
        material = Lambertian(Bitmap(reflectance.reshape(1, 1, 3)))
    mesh = replace(SQUARE, material=material, colors=RAMP)
    xy, points = seen_from_above(mesh)
    due = np.column_stack([xy, np.ones(len(xy))]) * reflectance
    assert (abs(points.color - due) <= 10 * np.finfo(np.float32).eps).all()
    # Control: the other diagonal.
    _, other = seen_from_above(replace(mesh, colors=RAMP[[0, 3, 2, 1]]))
    assert (abs(other.color - due) > 0.01).any()


def test_white_vertices_change_nothing():
    white = replace(SQUARE, colors=np.ones((4, 3)))
    for mesh in (white, SQUARE):
        _, points = seen_from_above(mesh)
        assert_array_equal(points.color, np.tile([[0.8, 0.5, 0.2]], (500, 1)))


def test_one_colour_at_all_vertices_is_another_reflectance():
    """In the whole picture; products are those of 1/2 and so exact."""
    box = cornell_box()

    def halved(mesh, by_vertex):
        if by_vertex:
            return replace(mesh, colors=np.full((len(mesh.vertices), 3), 0.5))
        dim = tuple(0.5 * c for c in mesh.material.reflectance)
        return replace(mesh, material=Lambertian(dim))

    def picture(by_vertex):
        meshes = tuple(halved(m, by_vertex) for m in box.meshes)
        return path_traced(world_of(replace(box, meshes=meshes), 16), "full", 2)

    # The sum of three equal terms of barycentric weights is 1 but for rounding.
    found, wanted = picture(True), picture(False)
    assert (abs(found - wanted) <= 64 * np.finfo(float).eps * wanted).all()
    assert (wanted > 0).any()


def test_black_vertices_are_no_plain_scene():
    """Where a colour is 0 in one channel alone, sources are not told by geometry."""
    for colors, plain in ((RAMP, False), (RAMP + 0.1, True)):
        scene = replace(
            cornell_box(), meshes=(replace(SQUARE, colors=colors / 1.1),), spheres=()
        )
        assert build_world(scene).materials.plain is plain


def test_glass_has_no_reflectance_to_colour():
    _, points = seen_from_above(replace(SQUARE, material=Dielectric(1.5), colors=RAMP))
    assert_array_equal(points.color, 1.0)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"colors": RAMP[:3]}, "vertex colours"),
        ({"colors": 2 * RAMP}, "colour of a vertex is 2 somewhere; it must be 0 to 1"),
        ({"opacity": Bitmap(np.full((1, 1, 3), 2.0))}, "opacity in the bitmap"),
        (
            {"opacity": Bitmap(np.ones((1, 1, 3))), "opacity_cutoff": 2.0},
            "opacity_cutoff is 2",
        ),
        ({"opacity": Bitmap(np.ones((1, 1, 3))), "uv": None}, "no texture coordinates"),
    ],
)
def test_colours_and_masks_that_mean_nothing_are_refused(changes, message):
    box = cornell_box()
    scene = replace(box, meshes=(*box.meshes, replace(SQUARE, **changes)))
    with pytest.raises(UsageError, match=message):
        validate(scene)

"""Light through rough glass: lights on the other side are seen, from either side.

Point lights and suns are found by choice alone, so that one shadow ray gives all of
their light and nothing is left to chance: the value is the BSDF's times the light's.
"""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from restir_gi.reference.scene.camera import Camera, pixel_centers
from restir_gi.reference.scene.catalogue.rooms import cornell_box
from restir_gi.reference.scene.lights import DirectionalLight, PointLight
from restir_gi.reference.scene.materials.kinds import Dielectric, Lambertian
from restir_gi.reference.scene.materials.table import scattering
from restir_gi.reference.scene.shapes import Sphere, quad
from restir_gi.reference.scene.validation import validate
from restir_gi.reference.transport.direct_light import choose_light
from restir_gi.reference.transport.path_tracer import first_hits
from restir_gi.reference.transport.world import build_world

GLASS = Dielectric(1.5, 0.4)
PANE = quad("pane", (-1, -1, 0), (2, 0, 0), (0, 2, 0), GLASS)
BALL = Sphere(name="ball", center=(0.0, 0.0, 0.0), radius=1.0, material=GLASS)
# Where nothing is in the way: it gives the scene its size.
FAR = quad("far", (-3, -2, -2), (0, 4, 0), (0, 0, 4), Lambertian((0.0,) * 3))


def seen(shape, light, eye_z):
    """What a camera on the z axis sees of a shape, and the light it has chosen."""
    spheres = (shape,) if isinstance(shape, Sphere) else ()
    meshes = (FAR,) if spheres else (shape, FAR)
    camera = Camera(
        position=(0.0, 0.05, eye_z), target=(0.0, 0.0, 0.0), fov=20.0, width=8, height=8
    )
    of = {"points": (), "suns": ()}
    of["points" if isinstance(light, PointLight) else "suns"] = (light,)
    scene = replace(cornell_box(), camera=camera, meshes=meshes, spheres=spheres, **of)
    world = build_world(validate(scene))
    points = first_hits(world, *pixel_centers(8, 8))
    u = (np.full(64, 0.5),) * 4
    return world, points, choose_light(world, points, u)


BELOW = PointLight((0.1, 0.2, -0.5), (1.0, 1.0, 1.0))
ABOVE = PointLight((0.1, 0.2, 0.5), (1.0, 1.0, 1.0))


@pytest.mark.parametrize("light", [BELOW, ABOVE])
@pytest.mark.parametrize("eye_z", [2.0, -2.0])
def test_point_lights_on_both_sides_of_a_pane(light, eye_z):
    world, points, chosen = seen(PANE, light, eye_z)
    offset = np.array(light.position) - points.position
    square = (offset**2).sum(axis=1)
    wi = offset / np.sqrt(square)[:, None]
    due = scattering(world.materials, points, wi) / square[:, None]
    # No microfacet refracts by more than the index lets it.
    shines = due.any(axis=1)
    assert shines.sum() > 16
    assert_array_equal(chosen.seen, shines)
    assert_allclose(chosen.value, due, rtol=1e-12)


@pytest.mark.parametrize("eye_z", [2.0, -2.0])
def test_suns_on_the_other_side_of_a_pane(eye_z):
    toward_the_eye = (0.0, 0.6, float(np.copysign(0.8, eye_z)))
    sun = DirectionalLight(toward_the_eye, (2.0, 2.0, 2.0))
    world, points, chosen = seen(PANE, sun, eye_z)
    wi = -np.tile([toward_the_eye], (64, 1))
    assert chosen.seen.all()
    assert_allclose(
        chosen.value, 2.0 * scattering(world.materials, points, wi), rtol=1e-12
    )
    assert chosen.value.all()


def test_a_lamp_in_a_ball_of_rough_glass():
    """Rays leave the sphere inwards, exactly, and meet its other side no sooner."""
    world, points, chosen = seen(BALL, PointLight((0.1, 0.2, -0.1), (1.0,) * 3), 3.0)
    assert_array_equal(points.primitive, world.geometry.triangles)
    assert chosen.seen.all()
    assert (chosen.value > 0).all()
    # Control: behind the ball its far side is in the way.
    _, _, hidden = seen(BALL, PointLight((0.1, 0.2, -2.0), (1.0,) * 3), 3.0)
    assert not hidden.seen.any()


def test_control_paint_sees_no_light_behind_itself():
    paint = replace(PANE, material=Lambertian((0.5,) * 3))
    _, _, chosen = seen(paint, BELOW, 2.0)
    assert not chosen.seen.any()

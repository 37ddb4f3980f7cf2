"""Inside a sphere: the two scenes in which ReSTIR GI has no noise at all."""

from restir_gi.reference.scene.camera import Camera
from restir_gi.reference.scene.lights import PointLight
from restir_gi.reference.scene.materials.kinds import Lambertian
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.shapes import Sphere
from restir_gi.reference.scene.textures import Checker

ALBEDO = 0.5
EMISSION = 2.0
INTENSITY = 3.0

_CAMERA = Camera(
    position=(0.3, 0.2, 0.1), target=(0.4, 0.9, -0.2), up=(0, 0, 1), fov=80.0
)


def sphere_furnace() -> Scene:
    """A grey sphere that glows evenly, seen from inside.

    Light after i reflections is albedo^i · emission at every point.
    """
    grey = Lambertian((ALBEDO, ALBEDO, ALBEDO))
    glow = (EMISSION, EMISSION, EMISSION)
    sphere = Sphere(
        name="sphere",
        center=(0.0, 0.0, 0.0),
        radius=1.0,
        material=grey,
        emission=glow,
        inward=True,
    )
    return Scene(name="sphere-furnace", camera=_CAMERA, spheres=(sphere,))


def half_lit_sphere() -> Scene:
    """A sphere, half grey and half black, around a point light in its centre.

    Every sample point reflects one known radiance or none; half of the area each.  The
    camera sees grey alone.
    """
    # 0.4 repetitions along the longitude stay in the first half of the checker, so that
    # the latitude alone decides: black in the south, grey in the north.
    halves = Checker((0.0,) * 3, (ALBEDO,) * 3, (0.4, 1.0))
    sphere = Sphere(
        name="sphere",
        center=(0.0, 0.0, 0.0),
        radius=1.0,
        material=Lambertian(halves),
        inward=True,
    )
    light = PointLight((0.0, 0.0, 0.0), (INTENSITY,) * 3)
    return Scene(
        name="half-lit-sphere", camera=_CAMERA, spheres=(sphere,), points=(light,)
    )

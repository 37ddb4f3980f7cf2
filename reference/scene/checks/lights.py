"""Lights: nothing negative, and one that shines where a scene must be lit."""

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.scene.checks.shapes import LARGEST
from restir_gi.reference.scene.checks.values import (
    BRIGHTEST,
    need_numbers,
    refuse,
    told,
)
from restir_gi.reference.scene.lights import (
    ConstantEnvironment,
    Environment,
    LatLongEnvironment,
    SpotLight,
)
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.shapes import emits

UNIT = 1e-6
"""How far from 1 a unit vector may be: it may have been stored in float32."""

NARROWEST = 0.01
"""Least cutoff of a spot light, in degrees: its cosine still tells it from its axis."""


def check_lights(scene: Scene) -> None:
    """Require lights whose every number has a meaning; none need shine.

    Raises UsageError, which names the light and the property.

    Parameters
    ----------
    scene : Scene; its shapes checked
    """
    for i, point in enumerate(scene.points):
        where = f"{scene.name}: point light {i}"
        need_numbers(where, "position", point.position, -LARGEST, LARGEST, count=3)
        need_numbers(where, "intensity", point.intensity, 0, BRIGHTEST, count=3)
    for i, spot in enumerate(scene.spots):
        _check_spot(f"{scene.name}: spot light {i}", spot)
    for i, sun in enumerate(scene.suns):
        where = f"{scene.name}: sun {i}"
        need_numbers(where, "direction", sun.direction, count=3)
        _need_unit(where, np.asarray(sun.direction, float))
        need_numbers(where, "irradiance", sun.irradiance, 0, BRIGHTEST, count=3)
    if scene.environment is not None:
        check_environment(f"{scene.name}: environment", scene.environment)


def check_lit(scene: Scene) -> None:
    """Require a light that shines.

    Raises UsageError: nothing emits.

    Parameters
    ----------
    scene : Scene; its numbers checked
    """
    if not is_lit(scene):
        right = "give a mesh or a sphere an emission, or add a lamp, a sun or a sky"
        refuse(scene.name, "nothing in the scene emits light", right)


def check_environment(where: str, environment: Environment) -> None:
    """Require a sky of non-negative radiance.

    Raises UsageError, which names the property.
    """
    if isinstance(environment, ConstantEnvironment):
        need_numbers(where, "radiance", environment.radiance, 0, BRIGHTEST, count=3)
        return
    pixels = environment.pixels
    if pixels.ndim != 3 or pixels.shape[2] != 3 or pixels.size == 0:
        size = "x".join(map(str, pixels.shape))
        refuse(where, f"its map is {size}", "it must be (h, w, 3), not empty")
    need_numbers(where, "radiance in the map", pixels, 0, BRIGHTEST)
    turn = np.asarray(environment.to_world, float)
    need_numbers(where, "rotation", turn, count=9)
    if np.abs(turn @ turn.T - np.eye(3)).max() > UNIT:
        right = "its rows must be orthogonal unit vectors"
        refuse(where, "to_world is not a rotation", right)


def is_lit(scene: Scene) -> bool:
    """Whether any shape, lamp, sun or sky has an emission above 0.

    Parameters
    ----------
    scene : Scene; its numbers checked
    """
    if any(map(emits, scene.meshes)) or any(map(emits, scene.spheres)):
        return True
    colors = [lamp.intensity for lamp in scene.lamps]
    colors += [sun.irradiance for sun in scene.suns]
    if isinstance(scene.environment, ConstantEnvironment):
        colors.append(scene.environment.radiance)
    if isinstance(scene.environment, LatLongEnvironment):
        colors.append(tuple(scene.environment.pixels.max(axis=(0, 1))))
    return bool(np.any(np.array(colors) > 0))


def _check_spot(where: str, spot: SpotLight) -> None:
    need_numbers(where, "position", spot.position, -LARGEST, LARGEST, count=3)
    need_numbers(where, "direction", spot.direction, count=3)
    _need_unit(where, np.asarray(spot.direction, float))
    need_numbers(where, "intensity", spot.intensity, 0, BRIGHTEST, count=3)
    need_numbers(where, "cutoff", spot.cutoff, NARROWEST, 180, count=1)
    need_numbers(where, "beam", spot.beam, 0, 180, count=1)
    if spot.beam > spot.cutoff:
        wrong = f"beam is {spot.beam:g} degrees"
        refuse(where, wrong, f"it must be at most cutoff, {spot.cutoff:g}")
    if spot.falloff not in ("linear", "smooth"):
        refuse(where, f"falloff is {spot.falloff!r}", "it must be linear or smooth")


def _need_unit(where: str, direction: Scalars) -> None:
    size = float(np.linalg.norm(direction))
    if abs(size - 1.0) > UNIT:
        right = "a direction has length 1"
        refuse(where, f"direction is {told(direction)}, {size:g} long", right)

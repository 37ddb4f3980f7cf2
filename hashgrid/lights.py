"""Points on lights as samples: any surface point can take one over as it is.

A sample is a light and a place on it, and its measure is that of the unit square of
places, light by light.  Neither knows who looks: the shift from one surface point to
another is the identity, and its Jacobian 1, where lights move, too.
"""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from extensions.connection import roughness
from reference.arrays import Indices, Masks, Scalars, Vec3s, zero_vectors
from reference.direct_light import sees_light
from reference.light_shares import share_of_choice
from reference.records import take
from reference.rng import Draw
from reference.scene.emitters import Emitters
from reference.scene.light_sampling import LightSamples, points_on_lights
from reference.scene.materials.table import scattering
from reference.scene.surface import SurfacePoints
from reference.tables import index_in_table
from reference.world import World

GONE = -1
"""In place of a light that the scene has no more."""

Chance = Literal["delta-lobes", "balance"]


@dataclass(frozen=True, slots=True)
class LightPoints:
    """N points on lights.

    Attributes
    ----------
    light : (N,) int64; row of the list of lights, or ``GONE``
    s, t : (N,) float64; place on the light, in the unit square
    cell : (N,) int64
        Mark of the cell in which the sample was taken over last, 0 if it never was.
    value : (N, 3) float64, W/(m² sr)
        f L_e cos θ over the density of the place: what a surface point reflects of it,
        shadows left out.
    """

    light: Indices
    s: Scalars
    t: Scalars
    cell: Indices
    value: Vec3s

    def __len__(self) -> int:
        """Number of rows."""
        return len(self.light)

    def moved(self, value: Vec3s, jacobian: Scalars) -> "LightPoints":
        """The same points, as other surface points reflect them.

        Parameters
        ----------
        value : (N, 3) float64; there
        jacobian : (N,) float64, sr/sr; of the shift: 1
        """
        return replace(self, value=value)


def draw_lights(emitters: Emitters | None, u: Draw) -> tuple[LightPoints, Scalars]:
    """Draw points on lights by power.

    Parameters
    ----------
    u : four (N,) float64; lane 0 chooses the light, 1 and 2 the place on it

    Returns
    -------
    LightPoints; N rows, of value 0
    (N,) float64; density; 1 where there is no light at all, and the points are ``GONE``
    """
    size = len(u[0])
    light, density = np.full(size, GONE), np.ones(size)
    if emitters is not None:
        light = index_in_table(emitters.cumulative, emitters.guide, u[0])
        density = emitters.probability[light]
    nowhere = np.zeros(size, np.int64)
    return LightPoints(light, u[1], u[2], nowhere, zero_vectors(size)), density


def reflected(
    world: World, points: SurfacePoints, lights: LightPoints, chance: Chance
) -> Vec3s:
    """What surface points reflect of points on lights, shadows left out.

    Parameters
    ----------
    lights : LightPoints; N points on lights
    chance : 'delta-lobes' or 'balance'
        Which part of the light is left to rays that meet lights by chance: what delta
        lobes reflect, or the share of the balance heuristic against drawing by power.

    Returns
    -------
    (N, 3) float64, W/(m² sr)
        f L_e cos θ over the density of the place on the light, that of choosing the
        light not among it; 0 for lights that are gone.
    """
    able = (lights.light != GONE) & points.hit
    if able.all() and len(able):
        return _reflected(world, points, lights, chance)
    value, rows = zero_vectors(len(points)), np.flatnonzero(able)
    if len(rows):
        some, here = take(points, rows), take(lights, rows)
        value[rows] = _reflected(world, some, here, chance)
    return value


def _reflected(
    world: World, points: SurfacePoints, lights: LightPoints, chance: Chance
) -> Vec3s:
    assert world.emitters is not None
    light = _seen_from(world, points, lights)
    value = scattering(world.materials, points, light.wi) * light.weight
    if chance == "balance":
        value *= share_of_choice(world, points, light.wi, light.pdf)[:, None]
    scaled: Vec3s = value * world.emitters.probability[lights.light][:, None]
    return scaled


def _seen_from(
    world: World, points: SurfacePoints, lights: LightPoints
) -> LightSamples:
    assert world.emitters is not None
    u = lights.s, lights.s, lights.t, lights.t
    x = points.position
    return points_on_lights(world.emitters, world.geometry, x, lights.light, u)


def in_sight(
    world: World, points: SurfacePoints, lights: LightPoints, active: Masks
) -> Masks:
    """Whether surface points see points on lights.

    Parameters
    ----------
    lights : LightPoints; N points on lights
    active : (N,) bool; who asks; nobody for a light that is gone

    Returns
    -------
    (N,) bool; one ray each; false for those who do not ask
    """
    seen = np.zeros(len(points), bool)
    rows = np.flatnonzero(active)
    if len(rows):
        some = take(points, rows)
        light = _seen_from(world, some, take(lights, rows))
        seen[rows] = sees_light(world, some, light, np.ones(len(rows), bool))
    return seen


def same_lights(before: Emitters | None, now: Emitters | None) -> Indices:
    """Where the lights of one frame stand in the list of another.

    Parameters
    ----------
    before, now : Emitters or None; lights of two frames of one animation

    Returns
    -------
    (E,) int64
        For each light of ``before`` its row in ``now``, or ``GONE``.  No two are the
        same.
    """
    if before is None:
        return np.zeros(0, np.int64)
    size = len(before.probability)
    if now is None:
        return np.full(size, GONE)
    if now is before:
        return np.arange(size)
    # A shape keeps its number while the scene moves, and lights of it come and go.
    shapes: Indices = now.entry[before.primitive].astype(np.int64)
    if before.cells is not None or now.cells is not None:
        cell = np.arange(len(shapes)) - before.entry[before.primitive]
        alike = before.sides(before.primitive) == now.sides(before.primitive)
        shapes = np.where(alike & (shapes != GONE), shapes + cell, GONE)
    others = (_others(before), _others(now))
    if others[0] != others[1]:
        return np.concatenate([shapes, np.full(size - len(shapes), GONE)])
    return np.concatenate([shapes, len(now.primitive) + np.arange(sum(others[0]))])


def _others(emitters: Emitters) -> tuple[int, int, int]:
    sky = emitters.environment is not None
    return len(emitters.position), len(emitters.direction), int(sky)


def lends(world: World, points: SurfacePoints) -> Masks:
    """Whether a vertex can receive light from chosen points that others may take.

    Returns
    -------
    (K,) bool
        False for misses, for what scatters into single directions alone, and for rough
        dielectrics, whose light is not reused.
    """
    able: Masks = roughness(world.materials, points) >= 0
    return able

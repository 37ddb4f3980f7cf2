"""Points on lights as samples: any surface point can take one over as it is.

A sample is a light and a place on it, and its measure is that of the unit square of
places, light by light.  Neither depends on the viewer: the shift from one surface point
to another is the identity, and its Jacobian 1, where lights move, too.
"""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from restir_gi.reference.numerics.arrays import (
    Indices,
    Masks,
    Scalars,
    Vec3s,
    zero_vectors,
)
from restir_gi.reference.numerics.records import keep
from restir_gi.reference.numerics.rng import Draw
from restir_gi.reference.numerics.tables import index_in_table
from restir_gi.reference.scene.emitters import Emitters
from restir_gi.reference.scene.hits import Hits
from restir_gi.reference.scene.light_sampling import LightSamples, points_on_lights
from restir_gi.reference.scene.materials.bsdf_sampling import BsdfSamples
from restir_gi.reference.scene.materials.parameters import MaterialTable
from restir_gi.reference.scene.materials.table import scattering
from restir_gi.reference.scene.surface import SurfacePoints
from restir_gi.reference.transport.direct_light import (
    bsdf_sampling_weight,
    emitter_hits,
    light_sampling_weight,
)
from restir_gi.reference.transport.world import World

GONE = -1
"""In place of a light that the scene has no more."""

Chance = Literal["delta-lobes", "balance"]
"""What rays that hit lights contribute: delta lobes alone, or the balance heuristic."""


@dataclass(frozen=True, slots=True)
class LightPoints:
    """N points on lights.

    Attributes
    ----------
    light : (N,) int64; row of the list of lights, or ``GONE``
    s, t : (N,) float64; place on the light, in the unit square
    cell : (N,) int64
        Slot of the cell in which the sample was taken over last, plus 1; 0 if never.
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

    Returns
    -------
    (N, 3) float64, W/(m² sr)
        f L_e cos θ over the density of the place on the light, that of choosing the
        light not among it; 0 for lights that are gone.
    """
    value, able = zero_vectors(len(points)), (lights.light != GONE) & points.hit
    if world.emitters is None or not able.any():
        return value
    x, some = keep(points, able), keep(lights, able)
    light = light_samples(world, x, some)
    found = from_light(world.materials, x, light)
    if chance == "balance":
        found *= light_sampling_weight(world, x, light.wi, light.pdf)[:, None]
    value[able] = found * world.emitters.probability[some.light][:, None]
    return value


def from_light(
    materials: MaterialTable, points: SurfacePoints, light: LightSamples
) -> Vec3s:
    """What surface points reflect of points on lights, over all of their density.

    Returns (N, 3) float64, W/(m² sr).
    """
    found: Vec3s = scattering(materials, points, light.wi) * light.weight
    return found


def light_samples(
    world: World, points: SurfacePoints, lights: LightPoints
) -> LightSamples:
    """Points on lights, none of them gone, as surface points see them."""
    assert world.emitters is not None
    u = lights.s, lights.s, lights.t, lights.t
    x = points.position
    return points_on_lights(world.emitters, world.geometry, x, lights.light, u)


def reflected_hits(
    world: World, points: SurfacePoints, bsdf: BsdfSamples, hits: Hits, chance: Chance
) -> Vec3s:
    """What surface points reflect of the lights that their rays hit.

    Parameters
    ----------
    chance : 'delta-lobes' or 'balance'
        What of it counts: the rest of what `reflected` holds.

    Returns
    -------
    (N, 3) float64, W/(m² sr); 0 for rays that hit no light
    """
    rows, radiance, pdf_light = emitter_hits(world, points, bsdf, hits)
    weight = bsdf.delta[rows].astype(float)
    if chance == "balance":
        weight = bsdf_sampling_weight(bsdf.pdf[rows], bsdf.delta[rows], pdf_light)
    found = zero_vectors(len(points))
    found[rows] = bsdf.weight[rows] * (radiance * weight[:, None])
    return found


def hits_count(world: World, bsdf: BsdfSamples, chance: Chance) -> Masks:
    """Whose `reflected_hits` may be above 0, (N,); none where no light can be hit."""
    able = world.emitters is not None and world.emitters.can_be_hit
    return (bsdf.delta | (chance == "balance")) & able


def renumbered(
    lights: LightPoints, before: Emitters | None, now: Emitters | None
) -> LightPoints:
    """Points on lights by the list of another frame; `GONE` where it has none such."""
    if now is before:
        return lights
    # One entry more than there are lights: a light that is gone stays gone.
    row = np.append(same_lights(before, now), GONE)[lights.light]
    return replace(lights, light=row)


def same_lights(before: Emitters | None, now: Emitters | None) -> Indices:
    """Where the lights of one frame are in the list of another of its animation.

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

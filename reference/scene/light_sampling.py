"""Points drawn on lights, for next-event estimation."""

from dataclasses import dataclass

import numpy as np

from restir_gi.reference.numerics.arrays import (
    Indices,
    Masks,
    Scalars,
    Vec3s,
    divide_or_zero,
    dot,
    zero_vectors,
)
from restir_gi.reference.numerics.records import take
from restir_gi.reference.numerics.rng import Draw
from restir_gi.reference.numerics.sampling import sample_triangle, sample_uniform_sphere
from restir_gi.reference.numerics.tables import index_in_table
from restir_gi.reference.scene.cones import falloff
from restir_gi.reference.scene.emitters import Emitters
from restir_gi.reference.scene.environment import (
    environment_radiance,
    sample_environment,
)
from restir_gi.reference.scene.geometry import Geometry, on_triangles
from restir_gi.reference.scene.light_cells import radiance_at
from restir_gi.reference.scene.masks import is_solid_at
from restir_gi.reference.scene.surface import direction_and_distance


@dataclass(frozen=True, slots=True)
class LightSamples:
    """Points drawn on lights, N rows.

    Attributes
    ----------
    wi : (N, 3) float64; unit directions to the light
    weight : (N, 3) float64
        Radiance over density; irradiance over probability for point and spot lights
        and suns.
    pdf : (N,) float64, 1/sr
        Density in solid angle; 0 where only this strategy finds the light.
    x_to, n_to : (N, 3) float64
        Point and normal on the light, on the side that emits towards the surface point
        where one does; 0 where the light is infinitely far.
    distant : (N,) bool; infinitely far
    """

    wi: Vec3s
    weight: Vec3s
    pdf: Scalars
    x_to: Vec3s
    n_to: Vec3s
    distant: Masks


def sample_light(
    emitters: Emitters, geometry: Geometry, x: Vec3s, u: Draw
) -> LightSamples:
    """Draw a point on a light for each surface point.

    Parameters
    ----------
    x : (N, 3) float64, m; surface points
    u : four (N,) float64; lane 0 chooses the light, 1 and 2 the point on it

    Returns
    -------
    LightSamples; weight 0 where a back that does not emit faces the point, and in holes
    """
    light = index_in_table(emitters.cumulative, emitters.guide, u[0])
    return points_on_lights(emitters, geometry, x, light, u)


def points_on_lights(
    emitters: Emitters, geometry: Geometry, x: Vec3s, light: Indices, u: Draw
) -> LightSamples:
    """Points on given lights, as surface points see them.

    Parameters
    ----------
    x : (N, 3) float64, m; surface points
    light : (N,) int; rows of the list of lights
    u : four (N,) float64; lanes 1 and 2 are the place on the light, in the unit square

    Returns
    -------
    LightSamples
        As :func:`sample_light` draws them: the probability of the light is in their
        densities.
    """
    areas, out = len(emitters.primitive), _empty_samples(len(x))
    far, every = _first_far(emitters), len(emitters.probability)
    sky = far + len(emitters.direction)
    bounds = (0, areas, far, sky, every)
    samplers = (_sample_area, _sample_point, _sample_sun, _sample_sky)
    for first, last, sampler in zip(bounds, bounds[1:], samplers, strict=False):
        if first == 0 and last == every:
            return sampler(emitters, geometry, x, light, u)
        rows = np.flatnonzero((light >= first) & (light < last))
        if len(rows) == 0:
            continue
        lanes = (u[0][rows], u[1][rows], u[2][rows], u[3][rows])
        some = sampler(emitters, geometry, take(x, rows), light[rows] - first, lanes)
        for name in LightSamples.__slots__:
            getattr(out, name)[rows] = getattr(some, name)
    return out


def _first_far(emitters: Emitters) -> int:
    return len(emitters.primitive) + len(emitters.position)


def _empty_samples(size: int) -> LightSamples:
    wi, weight, x_to, n_to = (zero_vectors(size) for _ in range(4))
    return LightSamples(wi, weight, np.zeros(size), x_to, n_to, np.zeros(size, bool))


def _sample_area(
    emitters: Emitters, geometry: Geometry, x: Vec3s, light: Indices, u: Draw
) -> LightSamples:
    primitive = emitters.primitive[light]
    area, place = geometry.area[primitive], (u[1], u[2])
    if emitters.cells is not None:
        cell = light - emitters.entry[primitive]
        place = emitters.cells.place_in(primitive, cell, *place)
        area = area / emitters.cells.side[primitive] ** 2
    x_to, n_to = _point_on(geometry, primitive, *place)
    if geometry.emits_behind is not None:
        wi, _ = direction_and_distance(x, x_to)
        behind = geometry.emits_behind[primitive] & (dot(n_to, wi) > 0)
        n_to = np.where(behind[:, None], -n_to, n_to)
    radiance = radiance_at(geometry, primitive, x_to)
    if geometry.mask is not None:
        solid = is_solid_at(geometry, primitive, x_to)
        radiance = np.where(solid[:, None], radiance, 0.0)
    return seen_on_area(x, x_to, n_to, radiance, emitters.probability[light] / area)


def seen_on_area(
    x: Vec3s, x_to: Vec3s, n_to: Vec3s, radiance: Vec3s, density: Scalars
) -> LightSamples:
    """Points on lights that have an area, as surface points see them.

    Parameters
    ----------
    x, x_to : (N, 3) float64, m; surface points, and points on lights
    n_to : (N, 3) float64; unit normals of the lights, on the side that emits
    radiance : (N, 3) float64, W/(m² sr)
    density : (N,) float64, 1/m²; of the points on the lights
    """
    wi, distance = direction_and_distance(x, x_to)
    cos_light = np.maximum(-dot(n_to, wi), 0.0)
    pdf = divide_or_zero(density * distance * distance, cos_light)
    weight = divide_or_zero(radiance, pdf[:, None])
    return LightSamples(wi, weight, pdf, x_to, n_to, np.zeros(len(x), bool))


def _point_on(
    geometry: Geometry, primitive: Indices, u1: Scalars, u2: Scalars
) -> tuple[Vec3s, Vec3s]:
    b1, b2 = sample_triangle(u1, u2)
    on_sphere = primitive >= geometry.triangles
    if not on_sphere.all():
        row = np.where(on_sphere, 0, primitive)
        x, n = on_triangles(geometry, row, b1, b2)
        if not on_sphere.any():
            return x, n
    else:
        x = n = zero_vectors(len(primitive))
    sphere = np.where(on_sphere, primitive - geometry.triangles, 0)
    outward = sample_uniform_sphere(u1, u2)
    on = geometry.center[sphere] + geometry.radius[sphere][:, None] * outward
    front = np.where(geometry.inward[sphere][:, None], -outward, outward)
    choose = on_sphere[:, None]
    return np.where(choose, on, x), np.where(choose, front, n)


def _sample_point(
    emitters: Emitters, geometry: Geometry, x: Vec3s, light: Indices, u: Draw
) -> LightSamples:
    x_to = emitters.position[light]
    wi, distance = direction_and_distance(x, x_to)
    probability = emitters.probability[len(emitters.primitive) + light]
    certain = divide_or_zero(np.ones(len(x)), probability)
    per_distance = divide_or_zero(certain, distance * distance)
    intensity = emitters.intensity[light]
    if emitters.cones is not None:
        intensity = intensity * falloff(emitters.cones, light, -wi)[:, None]
    weight = intensity * per_distance[:, None]
    size = len(x)
    free_space = zero_vectors(size)
    return LightSamples(
        wi, weight, np.zeros(size), x_to, free_space, np.zeros(size, bool)
    )


def _sample_sun(
    emitters: Emitters, geometry: Geometry, x: Vec3s, light: Indices, u: Draw
) -> LightSamples:
    size = len(x)
    probability = emitters.probability[_first_far(emitters) + light]
    weight = divide_or_zero(emitters.irradiance[light], probability[:, None])
    nowhere = zero_vectors(size)
    return LightSamples(
        -emitters.direction[light],
        weight,
        np.zeros(size),
        nowhere,
        nowhere,
        np.ones(size, bool),
    )


def _sample_sky(
    emitters: Emitters, geometry: Geometry, x: Vec3s, light: Indices, u: Draw
) -> LightSamples:
    assert emitters.environment is not None
    wi, density = sample_environment(emitters.environment, u[1], u[2])
    pdf = density * emitters.probability[-1]
    radiance = environment_radiance(emitters.environment, wi)
    nowhere = np.zeros_like(wi)
    weight = divide_or_zero(radiance, pdf[:, None])
    return LightSamples(wi, weight, pdf, nowhere, nowhere, np.ones(len(wi), bool))

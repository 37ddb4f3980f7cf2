"""All lights of a scene as one list to choose from."""

from dataclasses import dataclass

import numpy as np

from reference.arrays import Indices, Masks, Scalars, Vec3s, divide_or_zero, dot, take
from reference.images import luminance_weights
from reference.rng import Draw
from reference.sampling import (
    cumulate,
    sample_table,
    sample_triangle,
    sample_uniform_sphere,
)
from reference.scene.environment import (
    EnvironmentMap,
    build_environment,
    environment_radiance,
    pdf_environment,
    sample_environment,
)
from reference.scene.geometry import Geometry, contact
from reference.scene.scene import Scene
from reference.scene.surface import SurfacePoints, direction_and_distance


@dataclass(frozen=True, slots=True, eq=False)
class Emitters:
    """All lights: A primitives, then points, suns, and last the environment.

    Attributes
    ----------
    probability, cumulative : (E,) float64
        Of choosing each light, in proportion to its power; running sum.
    primitive : (A,) int32
        Primitives that emit.
    entry : (P,) int32
        Light of each primitive of the scene, -1 for none.
    position, intensity : (L, 3) float64
        Point lights.
    direction, irradiance : (D, 3) float64
        Suns.
    environment : EnvironmentMap or None
        What surrounds the scene.
    """

    probability: Scalars
    cumulative: Scalars
    primitive: Indices
    entry: Indices
    position: Vec3s
    intensity: Vec3s
    direction: Vec3s
    irradiance: Vec3s
    environment: EnvironmentMap | None

    @property
    def can_be_hit(self) -> bool:
        """Whether a ray can find a light by chance."""
        return len(self.primitive) > 0 or self.environment is not None


@dataclass(frozen=True, slots=True)
class LightSamples:
    """Points drawn on lights, N rows.

    Attributes
    ----------
    wi : (N, 3) float64
        Unit directions to the light.
    weight : (N, 3) float64
        Radiance over density; irradiance over probability for point lights and suns.
    pdf : (N,) float64, 1/sr
        Density in solid angle; 0 where only this strategy finds the light.
    x_to, n_to : (N, 3) float64
        Point and normal on the light; 0 where it is infinitely far.
    distant : (N,) bool
        Infinitely far.
    """

    wi: Vec3s
    weight: Vec3s
    pdf: Scalars
    x_to: Vec3s
    n_to: Vec3s
    distant: Masks


def build_emitters(scene: Scene, geometry: Geometry) -> Emitters | None:
    """List the lights of a scene.

    Parameters
    ----------
    scene : Scene
        Validated.
    geometry : Geometry
        Of the scene.

    Returns
    -------
    Emitters or None
        ``None`` where nothing emits.
    """
    weights = np.array(luminance_weights())
    primitive = np.flatnonzero(geometry.emission.any(axis=1)).astype(np.int32)
    entry = np.full(len(geometry.emission), -1, np.int32)
    entry[primitive] = np.arange(len(primitive))
    intensity = np.array([p.intensity for p in scene.points], float).reshape(-1, 3)
    irradiance = np.array([s.irradiance for s in scene.suns], float).reshape(-1, 3)
    environment = build_environment(scene.environment) if scene.environment else None
    # Power: π A L of an area, 4π I of a point; light from afar falls on a disk.
    disk = np.pi * 3.0 * geometry.extent**2
    area_power = np.pi * geometry.area[primitive, None] * geometry.emission[primitive]
    powers = [area_power, 4.0 * np.pi * intensity, disk * irradiance]
    if environment is not None:
        nodes = sample_uniform_sphere(*_sphere_nodes())
        mean = environment_radiance(environment, nodes).mean(axis=0)
        powers.append(4.0 * np.pi * disk * mean[None])
    power = np.concatenate(powers) @ weights
    if not (power > 0).any():
        return None
    return Emitters(
        probability=power / power.sum(),
        cumulative=cumulate(power),
        primitive=primitive,
        entry=entry,
        position=np.array([p.position for p in scene.points], float).reshape(-1, 3),
        intensity=intensity,
        direction=np.array([s.direction for s in scene.suns], float).reshape(-1, 3),
        irradiance=irradiance,
        environment=environment,
    )


def _sphere_nodes() -> tuple[Scalars, Scalars]:
    # Only a choice probability hangs on this mean, not the result.
    grid = (np.arange(128) + 0.5) / 128
    u1, u2 = np.meshgrid(grid, grid)
    return u1.ravel(), u2.ravel()


def sample_light(
    emitters: Emitters, geometry: Geometry, x: Vec3s, u: Draw
) -> LightSamples:
    """Draw a point on a light for each surface point.

    Parameters
    ----------
    emitters : Emitters
        The lights.
    geometry : Geometry
        The scene.
    x : (N, 3) float64, m
        Surface points.
    u : four (N,) float64
        Lane 0 chooses the light, 1 and 2 the point on it.

    Returns
    -------
    LightSamples
        Weight 0 where the light's back faces the point.
    """
    light, _ = sample_table(emitters.cumulative, u[0])
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
        some = sampler(emitters, geometry, x[rows], light[rows] - first, lanes)
        for name in LightSamples.__slots__:
            getattr(out, name)[rows] = getattr(some, name)
    return out


def _first_far(emitters: Emitters) -> int:
    return len(emitters.primitive) + len(emitters.position)


def _empty_samples(size: int) -> LightSamples:
    wi, weight, x_to, n_to = (np.zeros((size, 3)) for _ in range(4))
    return LightSamples(wi, weight, np.zeros(size), x_to, n_to, np.zeros(size, bool))


def _sample_area(
    emitters: Emitters, geometry: Geometry, x: Vec3s, light: Indices, u: Draw
) -> LightSamples:
    primitive = emitters.primitive[light]
    x_to, n_to = _point_on(geometry, primitive, u)
    wi, distance = direction_and_distance(x, x_to)
    cos_light = np.maximum(-dot(n_to, wi), 0.0)
    density = emitters.probability[light] / geometry.area[primitive]
    pdf = divide_or_zero(density * distance * distance, cos_light)
    weight = divide_or_zero(geometry.emission[primitive], pdf[:, None])
    return LightSamples(wi, weight, pdf, x_to, n_to, np.zeros(len(x), bool))


def _point_on(
    geometry: Geometry, primitive: Indices, u: Draw
) -> tuple[Vec3s, Vec3s]:
    b1, b2 = sample_triangle(u[1], u[2])
    on_sphere = primitive >= geometry.triangles
    if not on_sphere.all():
        row = np.where(on_sphere, 0, primitive)
        x = geometry.corner[row] + b1[:, None] * geometry.edge_u[row]
        x = x + b2[:, None] * geometry.edge_v[row]
        n = geometry.face_normal[row]
        if not on_sphere.any():
            return x, n
    else:
        x = n = np.zeros((len(primitive), 3))
    sphere = np.where(on_sphere, primitive - geometry.triangles, 0)
    outward = sample_uniform_sphere(u[1], u[2])
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
    per_distance = divide_or_zero(1.0 / probability, distance * distance)
    weight = emitters.intensity[light] * per_distance[:, None]
    size = len(x)
    free_space = np.zeros((size, 3))
    return LightSamples(
        wi, weight, np.zeros(size), x_to, free_space, np.zeros(size, bool)
    )


def _sample_sun(
    emitters: Emitters, geometry: Geometry, x: Vec3s, light: Indices, u: Draw
) -> LightSamples:
    size = len(x)
    probability = emitters.probability[_first_far(emitters) + light]
    weight = emitters.irradiance[light] / probability[:, None]
    nowhere = np.zeros((size, 3))
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
    weight = radiance / pdf[:, None]
    return LightSamples(wi, weight, pdf, nowhere, nowhere, np.ones(len(wi), bool))


def emitted(
    emitters: Emitters | None, geometry: Geometry, points: SurfacePoints
) -> Vec3s:
    """Radiance that reaches a ray from what it met: a light's front, or the sky.

    Parameters
    ----------
    emitters : Emitters or None
        The lights.
    geometry : Geometry
        The scene.
    points : SurfacePoints
        Where the rays ended; misses see the environment.

    Returns
    -------
    (N, 3) float64, W/(m² sr)
        0 from backs and from surfaces that do not emit.
    """
    radiance = np.zeros((len(points), 3))
    if emitters is None:
        return radiance
    if len(emitters.primitive):
        shines = points.front & (emitters.entry[points.primitive] >= 0)
        rows = np.flatnonzero(shines & points.hit)
        radiance[rows] = geometry.emission[points.primitive[rows]]
    if emitters.environment is not None:
        rows = np.flatnonzero(~points.hit)
        radiance[rows] = environment_radiance(emitters.environment, -points.wo[rows])
    return radiance


def pdf_light(
    emitters: Emitters, geometry: Geometry, x: Vec3s, points: SurfacePoints
) -> Scalars:
    """Density with which :func:`sample_light` draws what a ray from x has met.

    Parameters
    ----------
    emitters : Emitters
        The lights.
    geometry : Geometry
        The scene.
    x : (N, 3) float64, m
        Where the rays began.
    points : SurfacePoints
        Where they ended.

    Returns
    -------
    (N,) float64, 1/sr
        0 for what does not emit.
    """
    pdf = np.zeros(len(points))
    if len(emitters.primitive):
        light = np.where(points.hit, emitters.entry[points.primitive], -1)
        rows = np.flatnonzero(points.front & (light >= 0))
        primitive = points.primitive[rows]
        light_points = take(points, rows)
        offset = contact(geometry, light_points) - x[rows]
        cosine = dot(light_points.normal, light_points.wo)
        density = emitters.probability[light[rows]] / geometry.area[primitive]
        pdf[rows] = divide_or_zero(density * dot(offset, offset), cosine)
    if emitters.environment is not None:
        rows = np.flatnonzero(~points.hit)
        sky = pdf_environment(emitters.environment, -points.wo[rows])
        pdf[rows] = sky * emitters.probability[-1]
    return pdf

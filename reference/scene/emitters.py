"""All lights of a scene as one list to choose from."""

from dataclasses import dataclass

import numpy as np

from restir_gi.reference.images.image import luminance_weights
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
from restir_gi.reference.numerics.sampling import sample_uniform_sphere
from restir_gi.reference.numerics.tables import cumulate, guide_of
from restir_gi.reference.scene.cones import Cones, build_cones, solid_angles
from restir_gi.reference.scene.environment import (
    EnvironmentMap,
    build_environment,
    environment_radiance,
    pdf_environment,
)
from restir_gi.reference.scene.geometry import Geometry
from restir_gi.reference.scene.light_cells import LightCells, cut_lights, radiance_at
from restir_gi.reference.scene.origins import contact
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.surface import SurfacePoints


@dataclass(frozen=True, slots=True, eq=False)
class Emitters:
    """All lights: A areas, then points and spots, suns, and last the environment.

    An area is a primitive that emits, or a cell of one that has a textured emission.

    Attributes
    ----------
    probability, cumulative : (E,) float64
        Of choosing each light, in proportion to its power; running sum.
    guide : (G,) int64; where searches in the running sum begin
    primitive : (A,) int32; primitive of each area, in ascending order
    entry : (P + 1,) int32
        First light of each primitive of the scene, -1 for none, and -1 for a miss.
    cells : LightCells or None
        How textured primitives are cut into areas; ``None`` where each is one.
    position, intensity : (L, 3) float64
        Point lights, then spot lights with their intensity on the axis.
    cones : Cones or None
        Of the L lights; ``None`` where all shine alike in all directions.
    direction, irradiance : (D, 3) float64; suns
    environment : EnvironmentMap or None; what surrounds the scene
    """

    probability: Scalars
    cumulative: Scalars
    guide: Indices
    primitive: Indices
    entry: Indices
    cells: LightCells | None
    position: Vec3s
    intensity: Vec3s
    cones: Cones | None
    direction: Vec3s
    irradiance: Vec3s
    environment: EnvironmentMap | None

    @property
    def can_be_hit(self) -> bool:
        """Whether a ray can hit an emitter."""
        return len(self.primitive) > 0 or self.environment is not None

    def sides(self, primitive: Indices) -> Indices:
        """Cells along a side of primitives, each of which has its square of them.

        Parameters
        ----------
        primitive : (N,) int; primitives

        Returns
        -------
        (N,) int64; 1 where the primitive is one area
        """
        if self.cells is None:
            return np.ones(len(primitive), np.int64)
        sides: Indices = self.cells.side[primitive]
        return sides


def build_emitters(scene: Scene, geometry: Geometry) -> Emitters | None:
    """List the lights of a scene; ``None`` where nothing emits.

    Parameters
    ----------
    scene : Scene; validated
    """
    weights = np.array(luminance_weights())
    primitive: Indices = np.flatnonzero(geometry.emission.any(axis=1)).astype(np.int32)
    cells, area = None, geometry.area[primitive, None]
    radiance = geometry.emission[primitive]
    if geometry.emission_texture is not None:
        cells, primitive, radiance = cut_lights(geometry, primitive)
        area = (geometry.area / cells.side**2)[primitive, None]
    # One row more than there are primitives: -1, a miss, finds no light either.
    entry = np.full(len(geometry.emission) + 1, -1, np.int32)
    areas = np.arange(len(primitive))
    entry[primitive[::-1]] = areas[::-1]
    intensity = np.array([p.intensity for p in scene.lamps], float).reshape(-1, 3)
    cones = build_cones(scene.lamps) if scene.spots else None
    irradiance = np.array([s.irradiance for s in scene.suns], float).reshape(-1, 3)
    environment = build_environment(scene.environment) if scene.environment else None
    # Power: π A L of each side of an area, 4π I of a point; distant light falls on a
    # disk.
    disk = np.pi * 3.0 * geometry.extent**2
    area_power = np.pi * area * radiance
    if geometry.emits_behind is not None:
        area_power[geometry.emits_behind[primitive]] *= 2.0
    lamp_power = 4.0 * np.pi * intensity
    if cones is not None:
        lamp_power = solid_angles(cones)[:, None] * intensity
    powers = [area_power, lamp_power, disk * irradiance]
    if environment is not None:
        nodes = sample_uniform_sphere(*_sphere_nodes())
        mean = environment_radiance(environment, nodes).mean(axis=0)
        powers.append(4.0 * np.pi * disk * mean[None])
    power = np.concatenate(powers) @ weights
    if not (power > 0).any():
        return None
    cumulative = cumulate(power)
    return Emitters(
        probability=power / power.sum(),
        cumulative=cumulative,
        guide=guide_of(cumulative),
        primitive=primitive,
        entry=entry,
        cells=cells,
        position=np.array([p.position for p in scene.lamps], float).reshape(-1, 3),
        intensity=intensity,
        cones=cones,
        direction=np.array([s.direction for s in scene.suns], float).reshape(-1, 3),
        irradiance=irradiance,
        environment=environment,
    )


def _sphere_nodes() -> tuple[Scalars, Scalars]:
    # Only a choice probability hangs on this mean, not the result.
    grid = (np.arange(128) + 0.5) / 128
    u1, u2 = np.meshgrid(grid, grid)
    return u1.ravel(), u2.ravel()


def may_emit(emitters: Emitters, primitive: Indices) -> Masks:
    """Whether what a ray met can be a light.

    Parameters
    ----------
    primitive : (N,) int32; what was met, -1 for a miss

    Returns
    -------
    (N,) bool; True for backs that do not emit, and for dark parts of a texture, too
    """
    is_light: Masks = emitters.entry[primitive] >= 0
    return is_light if emitters.environment is None else is_light | (primitive < 0)


def emitted(
    emitters: Emitters | None, geometry: Geometry, points: SurfacePoints
) -> Vec3s:
    """Radiance that reaches a ray from what it met: a light, or the sky.

    Parameters
    ----------
    points : SurfacePoints; where the rays ended; misses see the environment

    Returns
    -------
    (N, 3) float64, W/(m² sr)
        0 from backs, unless they emit as well, and from surfaces that do not emit.
    """
    radiance = zero_vectors(len(points))
    if emitters is None:
        return radiance
    if len(emitters.primitive):
        rows = _lights_seen(emitters, geometry, points)
        primitive = points.primitive[rows]
        if geometry.emission_texture is None:
            radiance[rows] = geometry.emission[primitive]
        else:
            x = contact(geometry, take(points, rows))
            radiance[rows] = radiance_at(geometry, primitive, x)
    if emitters.environment is not None:
        rows = np.flatnonzero(~points.hit)
        radiance[rows] = environment_radiance(emitters.environment, -points.wo[rows])
    return radiance


def _lights_seen(
    emitters: Emitters, geometry: Geometry, points: SurfacePoints
) -> Indices:
    """Rows that met a side of a light that emits."""
    shown = points.front
    if geometry.emits_behind is not None:
        shown = shown | geometry.emits_behind[points.primitive]
    return np.flatnonzero(shown & (emitters.entry[points.primitive] >= 0))


def pdf_light(
    emitters: Emitters, geometry: Geometry, x: Vec3s, points: SurfacePoints
) -> Scalars:
    """Density with which :func:`sample_light` draws what a ray from x has met.

    Parameters
    ----------
    x : (N, 3) float64, m; where the rays began

    Returns
    -------
    (N,) float64, 1/sr
        0 for what does not emit; over a textured light it is that of the cell.
    """
    pdf = np.zeros(len(points))
    if len(emitters.primitive):
        rows = _lights_seen(emitters, geometry, points)
        lights = take(points, rows)
        x_to = contact(geometry, lights)
        offset = x_to - x[rows]
        cosine = dot(lights.normal, lights.wo)
        light, area = emitters.entry[lights.primitive], geometry.area[lights.primitive]
        if emitters.cells is not None:
            light = light + emitters.cells.cell_of(geometry, lights.primitive, x_to)
            area = area / emitters.cells.side[lights.primitive] ** 2
        density = emitters.probability[light] / area
        pdf[rows] = divide_or_zero(density * dot(offset, offset), cosine)
    if emitters.environment is not None:
        rows = np.flatnonzero(~points.hit)
        sky = pdf_environment(emitters.environment, -points.wo[rows])
        pdf[rows] = sky * emitters.probability[-1]
    return pdf

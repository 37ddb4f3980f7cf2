"""Where paths may be joined: both ends rough, and far enough apart."""

from dataclasses import dataclass, replace
from math import inf
from typing import Literal

import numpy as np

from reference.arrays import Masks, Scalars, Vec3s, dot
from reference.scene.geometry import Geometry
from reference.scene.materials.parameters import Kind, MaterialTable
from reference.scene.origins import contact, step_before
from reference.scene.surface import SurfacePoints, direction_and_distance

ShiftKind = Literal["reconnection", "replay", "hybrid"]


@dataclass(frozen=True, slots=True)
class Criterion:
    """When two neighbouring points of a path may be joined.

    Attributes
    ----------
    roughness : float
        Least perceptual roughness of both, the root of the GGX width; ``inf`` for
        never.
    distance : float
        Least distance of both, in half extents of the scene.
    last_joint : int
        Largest index of a reconnection vertex.
    replays : bool
        Whether what cannot be joined at x_2 is replayed; else it is not shifted.
    """

    roughness: float = 0.2
    distance: float = 0.01
    last_joint: int = 127
    replays: bool = True


CRITERIA: dict[ShiftKind, Criterion] = {
    "reconnection": Criterion(0.0, 0.0, last_joint=2, replays=False),
    "replay": Criterion(roughness=inf),
    "hybrid": Criterion(),
}


def roughness(table: MaterialTable, points: SurfacePoints) -> Scalars:
    """Perceptual roughness of all lobes that are no delta lobes.

    Parameters
    ----------
    table : MaterialTable
        Materials.
    points : SurfacePoints
        N points.

    Returns
    -------
    (N,) float64
        1 for paint and for the base under a smooth coat, √alpha for GGX, −1 for what
        scatters into single directions alone and for misses.

    Notes
    -----
    The thresholds of the literature are in this unit; alpha is its square.
    """
    kind, alpha = table.kind[points.material], table.alpha[points.material]
    painted = (kind == Kind.LAMBERTIAN) | (kind == Kind.SMOOTH_COATED)
    single = (kind == Kind.SMOOTH_CONDUCTOR) | (kind == Kind.DIELECTRIC)
    found = np.where(painted, 1.0, np.sqrt(alpha))
    return np.where(single | ~points.hit, -1.0, found)


def seen_from(
    geometry: Geometry, x_from: SurfacePoints, x_to: SurfacePoints, x_s: Vec3s
) -> SurfacePoints:
    """The same points of surfaces, as they are seen from elsewhere.

    Parameters
    ----------
    geometry : Geometry
        The scene.
    x_from : SurfacePoints
        N points that look.
    x_to : SurfacePoints
        N points looked at.
    x_s : (N, 3) float64, m
        Where these touch their surfaces.

    Returns
    -------
    SurfacePoints
        ``wo`` looks back to ``x_from``.  The direction is that from point to point: a
        ray's differs by the rounding of its hit.
    """
    omega, _ = direction_and_distance(x_from.position, x_s)
    offset = step_before(geometry, x_to.primitive, x_to.normal, -omega)
    return replace(x_to, wo=-omega, position=x_s + offset)


@dataclass(frozen=True, slots=True)
class Segment:
    """From one point of a path to the next, N rows.

    Attributes
    ----------
    distance : (N,) float64, m
        Between them.
    spread : (N,) float64, 1/m²
        cos φ / d² at the second: solid angle that its area fills.
    joinable : (N,) bool
        The criterion holds, if both leave by lobes that are no delta lobes.
    """

    distance: Scalars
    spread: Scalars
    joinable: Masks


def segment(
    criterion: Criterion,
    geometry: Geometry,
    x_from: SurfacePoints,
    x_to: SurfacePoints,
) -> Segment:
    """Measure a segment; the same for whoever measures it, base path or offset path.

    Parameters
    ----------
    criterion : Criterion
        When points may be joined.
    geometry : Geometry
        The scene.
    x_from, x_to : SurfacePoints
        N points; ``x_to.wo`` looks back to ``x_from``.

    Returns
    -------
    Segment
        N rows; not joinable where a point is a miss.
    """
    _, distance = direction_and_distance(x_from.position, contact(geometry, x_to))
    cosine = np.abs(dot(x_to.normal, x_to.wo))
    apart = distance > 0
    spread = np.divide(cosine, distance**2, out=np.zeros(len(cosine)), where=apart)
    table = geometry.materials
    rough = np.minimum(roughness(table, x_from), roughness(table, x_to))
    far = distance > criterion.distance * geometry.extent
    joinable = apart & far & (rough >= max(criterion.roughness, 0.0))
    return Segment(distance, spread, joinable)

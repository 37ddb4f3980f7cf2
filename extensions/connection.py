"""Where paths may be joined: both ends rough, and far enough apart."""

from dataclasses import dataclass, replace
from math import inf
from typing import Literal

import numpy as np

from reference.arrays import Masks, Scalars, divide_or_zero, dot
from reference.scene.geometry import Geometry
from reference.scene.materials.parameters import Kind, MaterialTable
from reference.scene.origins import contact, step_before
from reference.scene.surface import SurfacePoints, direction_and_distance

NEVER_JOINED = (Kind.SMOOTH_CONDUCTOR, Kind.DIELECTRIC, Kind.ROUGH_DIELECTRIC)
"""Kinds that scatter into single directions alone, and those that see both sides."""

ShiftKind = Literal["reconnection", "replay", "hybrid"]


@dataclass(frozen=True, slots=True)
class Criterion:
    """When two neighbouring points of a path may be joined.

    Attributes
    ----------
    roughness : float
        Least perceptual roughness of both, the root of the GGX width; ``inf`` for
        never.
    distance : float; least distance of both, in half extents of the scene
    last_joint : int; largest index of a reconnection vertex
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

    The thresholds of the literature are in this unit; alpha is its square.

    Returns
    -------
    (N,) float64
        1 for paint and for the base under a smooth coat, √alpha for microfacets, −1 for
        what scatters into single directions alone, for rough dielectrics, which see
        both sides, and for misses.
    """
    kind = table.kind
    painted = (kind == Kind.LAMBERTIAN) | (kind == Kind.SMOOTH_COATED)
    single = np.isin(kind, NEVER_JOINED)
    rough = np.where(painted, 1.0, np.where(single, -1.0, np.sqrt(table.alpha)))
    return np.where(points.hit, rough[points.material], -1.0)


@dataclass(frozen=True, slots=True)
class Segment:
    """From one point of a path to the next, N rows.

    Attributes
    ----------
    distance : (N,) float64, m; between them
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
) -> tuple[SurfacePoints, Segment]:
    """Look from one point to another, and measure the way.

    Returns
    -------
    SurfacePoints
        The second, as the first sees it: ``wo`` looks back.  The direction is that from
        point to point; a ray's differs by the rounding of its hit.
    Segment
        The same for whoever measures it, base path or offset path; not joinable where
        a point is a miss.
    """
    x_s = contact(geometry, x_to)
    omega, distance = direction_and_distance(x_from.position, x_s)
    offset = step_before(geometry, x_to.primitive, x_to.normal, -omega)
    seen = replace(x_to, wo=-omega, position=x_s + offset)
    cosine = np.abs(dot(x_to.normal, omega))
    spread = divide_or_zero(cosine, distance**2)
    table = geometry.materials
    rough = np.minimum(roughness(table, x_from), roughness(table, x_to))
    far = distance > criterion.distance * geometry.extent
    joinable = (distance > 0) & far & (rough >= max(criterion.roughness, 0.0))
    return seen, Segment(distance, spread, joinable)

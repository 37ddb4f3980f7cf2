"""Paths in the cells of a grid, and what a frame writes into them."""

from dataclasses import dataclass

from extensions.connection import roughness
from hashgrid.cache import Cache
from reference.arrays import Indices, Masks
from reference.resampling.reservoir import Reservoirs
from reference.scene.surface import SurfacePoints
from reference.world import World


@dataclass(frozen=True, slots=True, eq=False)
class PathCache:
    """Paths in the cells of a grid.

    Attributes
    ----------
    cache : Cache
        Of V vertices, with reservoirs of `extensions.paths.Paths` from them on.
    reach : (V,) int8; largest index of a last surface point that each could have drawn
    """

    cache: Cache
    reach: Indices


@dataclass(frozen=True, slots=True)
class Written:
    """What K paths leave at x_v, and behind it.

    Attributes
    ----------
    reservoirs : Reservoirs
        Of the paths from there on; without a sample where it cannot be joined.
    rest : Written or None; at the next vertex that writes
    """

    points: SurfacePoints
    reservoirs: Reservoirs
    rest: "Written | None"


def joins(world: World, points: SurfacePoints, least: float) -> Masks:
    """Whether paths can be joined to what follows a vertex, as far as it decides.

    Returns (K,) bool; rough enough: no sample is looked at.
    """
    rough: Masks = roughness(world.materials, points) >= max(least, 0.0)
    return rough

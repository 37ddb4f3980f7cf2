"""Vertices of the last frame that lend points on lights."""

from dataclasses import dataclass, replace

import numpy as np

from hashgrid.cache import Cache, homes
from hashgrid.lights import GONE, Chance, LightPoints, reflected, same_lights
from reference.arrays import Indices
from reference.records import take
from reference.resampling.generalized import Shifted
from reference.resampling.reservoir import Reservoirs
from reference.scene.emitters import Emitters
from reference.scene.surface import SurfacePoints
from reference.world import World


@dataclass(frozen=True, slots=True, eq=False)
class LightDonor:
    """Donors of points on lights, and K receivers.

    Attributes
    ----------
    world, points : World, SurfacePoints; of the K receivers
    world_from, points_from : World, SurfacePoints; of the N donors
    reservoirs : Reservoirs; N rows of `LightPoints`, in the receivers' list of lights
    rows : (K,) int; row that is offered to each receiver, or ``NONE``
    lights_from : (E,) int64
        For each light of the receivers its row in the donors' list.
    chance : 'delta-lobes' or 'balance'; as of `hashgrid.lights.reflected`
    same_domain : bool; donor and receiver are one point
    """

    world: World
    points: SurfacePoints
    world_from: World
    points_from: SurfacePoints
    reservoirs: Reservoirs
    rows: Indices
    lights_from: Indices
    chance: Chance
    same_domain: bool = False

    def shifted(self, at: Indices) -> Shifted:
        """Values of the donors' points at the receivers.

        Parameters
        ----------
        at : (A,) int; receivers, none without a donor

        Returns
        -------
        (A, 3), (A,) float64; value, and Jacobian 1
        """
        lights = take(self.reservoirs.y, self.rows[at])
        value = reflected(self.world, take(self.points, at), lights, self.chance)
        return value, np.ones(len(at))

    def inverse(self, samples: LightPoints, at: Indices) -> Shifted:
        """Values of the receivers' points at their donors.

        Parameters
        ----------
        samples : LightPoints; K rows, at the receivers
        at : (A,) int; which of them, none without a donor

        Returns
        -------
        (A, 3), (A,) float64; value in the donors' scene, and Jacobian 1
        """
        points = take(self.points_from, self.rows[at])
        lights = renumbered(take(samples, at), self.lights_from)
        value = reflected(self.world_from, points, lights, self.chance)
        return value, np.ones(len(at))


def renumbered(lights: LightPoints, rows: Indices) -> LightPoints:
    """Points on lights by the list of another frame, N rows.

    Parameters
    ----------
    lights : LightPoints; N rows
    rows : (E,) int64; row of each light in the other list, or ``GONE``
    """
    # One entry more than there are lights: a light that is gone stays gone.
    row = np.append(rows, GONE)[lights.light]
    return replace(lights, light=row)


def carried(cache: Cache, emitters: Emitters | None) -> Reservoirs:
    """Reservoirs of a cache, for the frame that looks into it.

    Parameters
    ----------
    cache : Cache; of the frame before

    Returns
    -------
    Reservoirs
        V rows of `LightPoints` by the list of this frame, which know their cells.
    """
    r, rows = cache.reservoirs, same_lights(cache.world.emitters, emitters)
    lights = replace(renumbered(r.y, rows), cell=homes(cache.grid, len(cache.points)))
    return replace(r, y=lights)


@dataclass(frozen=True, slots=True, eq=False)
class Lent:
    """What the last frame lends to all vertices of this one.

    Attributes
    ----------
    cache : Cache; of the last frame
    reservoirs : Reservoirs; of the cache, in this frame's list of lights
    lights_from : (E,) int64
        For each light of this frame its row in the last frame's list.
    """

    cache: Cache
    reservoirs: Reservoirs
    lights_from: Indices


def lent(cache: Cache, world: World) -> Lent:
    """Make what a cache has ready for a frame.

    Parameters
    ----------
    cache : Cache; of the frame before
    """
    lights_from = same_lights(world.emitters, cache.world.emitters)
    return Lent(cache, carried(cache, world.emitters), lights_from)

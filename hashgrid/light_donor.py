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
    world, points : World, SurfacePoints
        Of the K receivers.
    world_from, points_from : World, SurfacePoints
        Of the N donors.
    reservoirs : Reservoirs
        N rows of `LightPoints`, in the receivers' list of lights.
    rows : (K,) int
        Row that is offered to each receiver, or ``NONE``.
    lights_from : (E,) int64
        For each light of the receivers its row in the donors' list.
    chance : 'delta-lobes' or 'balance'
        As of `hashgrid.lights.reflected`.
    same_domain : bool
        Donor and receiver are one point.
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
        at : (A,) int
            Receivers, none without a donor.

        Returns
        -------
        (A, 3), (A,) float64
            Value, and Jacobian 1.
        """
        lights = take(self.reservoirs.y, self.rows[at])
        value = reflected(self.world, take(self.points, at), lights, self.chance)
        return value, np.ones(len(at))

    def inverse(self, samples: LightPoints, at: Indices) -> Shifted:
        """Values of the receivers' points at their donors.

        Parameters
        ----------
        samples : LightPoints
            K rows, at the receivers.
        at : (A,) int
            Which of them, none without a donor.

        Returns
        -------
        (A, 3), (A,) float64
            Value in the donors' scene, and Jacobian 1.
        """
        points = take(self.points_from, self.rows[at])
        lights = renumbered(take(samples, at), self.lights_from)
        value = reflected(self.world_from, points, lights, self.chance)
        return value, np.ones(len(at))


def renumbered(lights: LightPoints, rows: Indices) -> LightPoints:
    """Points on lights by the list of another frame.

    Parameters
    ----------
    lights : LightPoints
        N rows.
    rows : (E,) int64
        Row of each light in the other list, or ``GONE``.

    Returns
    -------
    LightPoints
        N rows.
    """
    # One entry more than there are lights: a light that is gone stays gone.
    row = np.append(rows, GONE)[lights.light]
    return replace(lights, light=row)


def carried(cache: Cache, emitters: Emitters | None) -> Reservoirs:
    """Reservoirs of a cache, for the frame that looks into it.

    Parameters
    ----------
    cache : Cache
        Of the frame before.
    emitters : Emitters or None
        Lights of this frame.

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
    cache : Cache
        Of the last frame.
    reservoirs : Reservoirs
        Of the cache, in this frame's list of lights.
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
    cache : Cache
        Of the frame before.
    world : World
        The scene.

    Returns
    -------
    Lent
        Once for all vertices.
    """
    lights_from = same_lights(world.emitters, cache.world.emitters)
    return Lent(cache, carried(cache, world.emitters), lights_from)

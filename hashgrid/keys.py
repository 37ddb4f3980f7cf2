"""Which cell of space a point lies in: cells grow with the distance to the eye."""

from dataclasses import dataclass

import numpy as np

from hashgrid.hashes import UInts, nested, pcg, xxhash
from reference.arrays import Indices, Scalars, Vec3s, length
from reference.frames import normal_frames
from reference.rng import Draw
from reference.scene.camera import Camera

LEAST = 1e-3
"""Edge of the smallest cells, m."""

PIXELS = 16.0
"""Edge of a cell in the image, about."""

FARTHEST = 2.0**62
"""Cells beyond are all taken for this one."""


@dataclass(frozen=True, slots=True)
class Lattice:
    """How fine space is divided, seen from an eye.

    Attributes
    ----------
    eye : (float, float, float), m
        Of the frame whose grid is built, or read: never that of another.
    base : float
        Edge of a cell over its distance, before it is rounded down to a power of two.
    facings : int
        Parts of each component of the normal that cells tell apart, 1 to 16; 1 for
        none.
    """

    eye: tuple[float, float, float]
    base: float
    facings: int = 1


def lattice_of(camera: Camera, facings: int = 1) -> Lattice:
    """Lattice whose cells are some 16 pixels wide.

    Its base is tan(fov_y · 16 · max(1 / h, h / w²)): [Boisse21], with the numbers of
    the author's later renderer.

    Parameters
    ----------
    facings : int; parts of each component of the normal
    """
    w, h = camera.width, camera.height
    fov_y = 2 * np.arctan(camera.half_width * h / w)
    base = np.tan(min(fov_y * PIXELS * max(1 / h, h / w**2), np.pi / 4))
    return Lattice(camera.position, float(base), facings)


@dataclass(frozen=True, slots=True)
class Keys:
    """Cells that N points lie in.

    Attributes
    ----------
    level : (N,) int16; edge 1e-3 · 2^level m
    x, y, z : (N,) int64; position in units of the edge, rounded down
    facing : (N,) int16
        Part of the normal's sphere; 0 where the lattice does not look at it.
    """

    level: Indices
    x: Indices
    y: Indices
    z: Indices
    facing: Indices

    def __len__(self) -> int:
        """Number of rows."""
        return len(self.level)

    @property
    def words(self) -> list[UInts]:
        """Lower 32 bits of each field, (N,) uint32, as two's complement."""
        fields = (self.level, self.x, self.y, self.z, self.facing)
        return [(f.astype(np.int64) & 0xFFFFFFFF).astype(np.uint32) for f in fields]

    @property
    def place(self) -> UInts:
        """(N,) uint32: hash whose remainder is the bucket."""
        return nested(pcg, self.words)

    @property
    def checksum(self) -> UInts:
        """(N,) uint32: another hash, at least 1; 0 marks a free place."""
        return np.maximum(nested(xxhash, self.words), np.uint32(1))


def levels(lattice: Lattice, position: Vec3s) -> Indices:
    """Level of detail at points.

    Parameters
    ----------
    position : (N, 3) float64, m; the points

    Returns
    -------
    (N,) int64; floor(log2(1000 · distance · base)), at least 0
    """
    offset = np.clip(position - np.asarray(lattice.eye), -FARTHEST, FARTHEST)
    distance = length(offset)
    wanted = np.maximum(distance * lattice.base / LEAST, 1.0)
    # The exponent of a float is exact, where a rounded logarithm is not.
    level: Indices = np.frexp(wanted)[1].astype(np.int64) - 1
    return level


def edges(level: Indices) -> Scalars:
    """Edges of cells, (N,) float64, m; 1e-3 · 2^level.

    Parameters
    ----------
    level : (N,) int64; from 0
    """
    size: Scalars = np.ldexp(LEAST, level.astype(np.int32))
    return size


def keys_of(lattice: Lattice, position: Vec3s, normal: Vec3s) -> Keys:
    """Cells of points.

    Parameters
    ----------
    position : (N, 3) float64, m; the points
    normal : (N, 3) float64; unit normals
    """
    level = levels(lattice, position)
    scaled = np.floor(position / edges(level)[:, None])
    x, y, z = np.clip(scaled, -FARTHEST, FARTHEST).astype(np.int64).T
    facing = _facings(lattice.facings, normal)
    return Keys(level.astype(np.int16), x, y, z, facing)


def _facings(parts: int, normal: Vec3s) -> Indices:
    place = np.floor((normal + 1.0) * (parts / 2))
    a, b, c = np.clip(place, 0, parts - 1).astype(np.int64).T
    facing: Indices = (a + parts * (b + parts * c)).astype(np.int16)
    return facing


def jittered(lattice: Lattice, position: Vec3s, normal: Vec3s, u: Draw) -> Vec3s:
    """Points moved at random in their tangent plane, by up to √2 edges each way.

    Parameters
    ----------
    position, normal : (N, 3) float64, m and 1; the points, and unit normals
    u : four (N,) float64; lanes 0 and 1

    Returns
    -------
    (N, 3) float64, m; what hides the borders of the cells, at insertion and look-up
    """
    across, along = normal_frames(normal)
    reach = np.sqrt(2.0) * edges(levels(lattice, position))
    a, b = ((2.0 * lane - 1.0) * reach for lane in u[:2])
    moved: Vec3s = position + a[:, None] * across + b[:, None] * along
    return moved

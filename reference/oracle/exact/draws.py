"""What a kernel is given: ordinary numbers, but for those that an extreme drives."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars, Vec3s
from restir_gi.reference.oracle.exact.extremes import PLAIN, Extreme, Generator


@dataclass(slots=True, eq=False)
class Draws:
    """Rows of one cell of the matrix.

    Attributes
    ----------
    rng : Generator; source of all numbers
    extreme : Extreme; what is driven to its end
    read : set of str; names of the values that were asked for
    """

    rng: Generator
    rows: int
    info: Any
    extreme: Extreme
    read: set[str] = field(default_factory=set)

    def __call__(self, name: str) -> Scalars:
        """Fresh values of a name.

        Returns (rows,) float64; of the extreme where it drives that name.
        """
        self.read.add(name)
        sampler = self.extreme.drives.get(name, PLAIN[name])
        return sampler(self.rng, self.rows, self.info)

    def color(self, name: str) -> Vec3s:
        """Three values of a name, (rows, 3) float64; each on its own."""
        return np.stack([self(name) for _ in range(3)], axis=1)

    def unit(self) -> Vec3s:
        """Directions of all kinds.

        Returns (rows, 3) float64; unit vectors, every third along an axis.
        """
        v = self.rng.normal(size=(self.rows, 3))
        v[::3] = np.eye(3)[self.rng.integers(0, 3, len(v[::3]))]
        unit: Vec3s = v / np.linalg.norm(v, axis=1)[:, None]
        return unit

    def place(self) -> Vec3s:
        """Points about as far from the origin in each axis.

        Returns
        -------
        (rows, 3) float64, m; the origin itself where no extreme drives the offset
        """
        place: Vec3s = self("offset")[:, None] * self.rng.uniform(
            0.5, 1.0, (self.rows, 3)
        )
        return place

    def seen_from(self, place: Vec3s, normal: Vec3s) -> Vec3s:
        """Points that see patches at some angle, (rows, 3) float64, m; on either side.

        Parameters
        ----------
        place, normal : (rows, 3) float64, m and 1; patches
        """
        reach = self("scale") * self("distance")
        eye: Vec3s = place + reach[:, None] * self.leaning(normal)
        return eye

    def leaning(self, normal: Vec3s) -> Vec3s:
        """Unit vectors at some angle to normals, (rows, 3) float64; on either side.

        Parameters
        ----------
        normal : (rows, 3) float64; unit normals
        """
        across = np.cross(normal, self.rng.normal(size=normal.shape))
        across /= np.linalg.norm(across, axis=1)[:, None]
        cosine = self("cosine")[:, None]
        flat = np.sqrt(1 - np.minimum(cosine**2, 1))
        leaning: Vec3s = cosine * normal + flat * across
        return leaning

    def about_z(self) -> Vec3s:
        """Unit vectors at some angle to the z axis.

        Returns (rows, 3) float64; whose third component is the cosine.
        """
        return self.leaning(np.tile([0.0, 0.0, 1.0], (self.rows, 1)))

    def in_type(self, values: Scalars) -> Scalars:
        """Numbers rounded to the type.

        Parameters
        ----------
        values : array of float64

        Returns
        -------
        array; at most the largest number of the type
        """
        most = float(self.info.max)
        return np.clip(values, -most, most).astype(self.info.dtype)


def weights(*names: str) -> Callable[[Draws], dict[str, Scalars]]:
    """From draws to inputs that are weights, (rows,) float64 of each name."""
    return lambda draws: {name: draws("weight") for name in names}

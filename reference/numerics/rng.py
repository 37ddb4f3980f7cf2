"""Numbered random streams: any number can be made again from its key.

The contract, for whoever writes a backend: stream s, dimension d of pixel p in frame t
under seed k is the four lanes of ``pcg4d(p, t, k, 64 s + d)``, each turned into a
number in [0, 1) by ``(lane >> 8) * 2**-24``.  Known answers are in
``tests/golden/pcg4d.csv``.
"""

from dataclasses import dataclass
from enum import IntEnum
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Indices, Scalars

DIMENSIONS = 64
"""Dimensions of a stream: the step between the keys of two streams."""

UInts = NDArray[np.uint32]
Draw = tuple[Scalars, Scalars, Scalars, Scalars]


class Stream(IntEnum):
    """Who draws: one stream a purpose, so that passes never share a number."""

    PIXEL = 0
    INITIAL = 1
    TEMPORAL = 2
    SPATIAL = 3
    DIRECT = 4
    SPECULAR = 5
    PATH = 6
    ROULETTE = 7
    LIGHTS = 8
    CELLS = 9
    PAIRS = 10
    PAIRS_AROUND = 11
    SEARCH = 12


def pcg4d(x: UInts, y: UInts, z: UInts, w: UInts) -> tuple[UInts, UInts, UInts, UInts]:
    """Hash four 32-bit words into four: the PCG4D permutation.

    [Jarzynski20, Listing 5]: one linear congruential step of each word, two rounds of
    multiply-add between the words, an xor-shift between the rounds.

    Parameters
    ----------
    x, y, z, w : (N,) uint32; the key; broadcast against each other

    Returns
    -------
    four (N,) uint32; arithmetic is modulo 2^32
    """
    step, increment = np.uint32(1664525), np.uint32(1013904223)
    # Arrays of one word, unlike scalars, wrap around without a warning.
    x, y, z, w = (np.atleast_1d(v) * step + increment for v in (x, y, z, w))
    for last_round in (False, True):
        x = x + y * w
        y = y + z * x
        z = z + x * y
        w = w + y * z
        if not last_round:
            x, y, z, w = (v ^ (v >> np.uint32(16)) for v in (x, y, z, w))
    return x, y, z, w


def to_unit_interval(bits: UInts) -> Scalars:
    """Number in [0, 1) from 32 bits: (x >> 8) · 2⁻²⁴.

    Parameters
    ----------
    bits : (N,) uint32; random words

    Returns
    -------
    (N,) float64
        Multiples of 2⁻²⁴, at most 1 - 2⁻²⁴.  Exact in float32, so that a backend has
        the same number; x · 2⁻³² would round to 1 there once in 2²⁵ draws.
    """
    return (bits >> np.uint32(8)) * 2.0**-24


class Uniforms(Protocol):
    """Random numbers as data: four uniforms a row for each dimension."""

    def draw(self, dimension: int) -> Draw:
        """Four ``(N,)`` arrays of numbers in [0, 1)."""
        ...

    def rows(self, rows: Indices) -> "Uniforms":
        """The same numbers for some of the rows."""
        ...


@dataclass(frozen=True, slots=True)
class KeyedUniforms:
    """Uniforms made on demand from the key (pixel, frame, seed, stream).

    Attributes
    ----------
    pixel : (N,) uint32; y · width + x
    frame : int or (N,) int
        Of all rows, or of each.  Non-negative, below 2^27: PCG4D mixes its words by
        products, whose high bits never reach the low ones, so that frames which differ
        in the highest bits alone have dependent streams.
    seed : int; the same holds of it
    """

    pixel: UInts
    frame: int | Indices
    seed: int
    stream: Stream

    def draw(self, dimension: int) -> Draw:
        """Four uniforms a row, four (N,) float64; in [0, 1).

        Parameters
        ----------
        dimension : int; 0 to 63; each decision has its own

        Raises
        ------
        IndexError
            A dimension that belongs to the next stream.
        """
        if not 0 <= dimension < DIMENSIONS:
            raise IndexError(f"dimension {dimension} is outside 0..{DIMENSIONS - 1}")
        words = (self.frame, self.seed, self.stream * DIMENSIONS + dimension)
        frame, seed, key = (np.atleast_1d(word).astype(np.uint32) for word in words)
        x, y, z, w = pcg4d(self.pixel, frame, seed, key)
        return (
            to_unit_interval(x),
            to_unit_interval(y),
            to_unit_interval(z),
            to_unit_interval(w),
        )

    def rows(self, rows: Indices) -> "KeyedUniforms":
        """The same numbers for some of the rows.

        Parameters
        ----------
        rows : (K,) int; which rows
        """
        frame = self.frame if isinstance(self.frame, int) else self.frame[rows]
        return KeyedUniforms(self.pixel[rows], frame, self.seed, self.stream)


@dataclass(frozen=True, slots=True)
class TabledUniforms:
    """Uniforms read from a table: replays, lattices and proofs bring their own.

    Attributes
    ----------
    table : (D, 4, N) float; dimension, lane, row; any dtype
    """

    table: Scalars

    def draw(self, dimension: int) -> Draw:
        """Four uniforms a row, four (N,); as they stand in the table.

        Parameters
        ----------
        dimension : int; 0 to D - 1
        """
        x, y, z, w = self.table[dimension]
        return x, y, z, w

    def rows(self, rows: Indices) -> "TabledUniforms":
        """The same numbers for some of the rows.

        Parameters
        ----------
        rows : (K,) int; which rows
        """
        return TabledUniforms(self.table[:, :, rows])

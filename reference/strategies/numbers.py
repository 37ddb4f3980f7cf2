"""Numbers: bounded, uniform, and at the ends of their type."""

from typing import Any

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import DTypeLike, NDArray

from restir_gi.reference.numerics.arrays import Indices, Scalars
from restir_gi.reference.numerics.rng import Draw, TabledUniforms

ROWS = 5
"""Rows of a batch where a test does not say otherwise."""


def scalars(
    low: float, high: float, rows: int = ROWS, dtype: DTypeLike = np.float64
) -> st.SearchStrategy[Scalars]:
    """Numbers between two bounds, both included, strategy of (rows,) dtype; finite.

    Parameters
    ----------
    low, high : float; bounds, which ``dtype`` can represent
    dtype : type; float16, float32 or float64
    """
    kind = np.dtype(dtype)
    width: Any = 8 * kind.itemsize
    return arrays(kind, rows, elements=st.floats(low, high, width=width))


def uniforms(rows: int = ROWS) -> st.SearchStrategy[Scalars]:
    """Multiples of 2⁻²⁴ in [0, 1), as :mod:`restir_gi.reference.numerics.rng` makes.

    Returns strategy of (rows,) float64; exact in float32.
    """
    words = arrays(np.uint32, rows, elements=st.integers(0, 2**24 - 1))

    def divided(w: NDArray[np.uint32]) -> Scalars:
        return w * 2.0**-24

    return words.map(divided)


def draws(rows: int = ROWS) -> st.SearchStrategy[Draw]:
    """Four uniforms a row: :class:`restir_gi.reference.numerics.rng.Uniforms`.

    Returns strategy of four (rows,) float64; in [0, 1).
    """
    u = uniforms(rows)
    return st.tuples(u, u, u, u)


def tabled_uniforms(
    dimensions: int, rows: int = ROWS
) -> st.SearchStrategy[TabledUniforms]:
    """Tables of uniforms for a whole pass.

    (dimensions, 4, rows) float64.
    """
    return uniforms(dimensions * 4 * rows).map(
        lambda u: TabledUniforms(u.reshape(dimensions, 4, rows))
    )


@st.composite
def cuts(draw: st.DrawFn, rows: int = ROWS) -> list[Indices]:
    """Ways to cut rows into pieces and shuffle them.

    Returns
    -------
    strategy of list of (K,) int
        Together a permutation of all rows; pieces may be empty.
    """
    order = np.array(draw(st.permutations(range(rows))), dtype=np.int64)
    at = sorted(draw(st.lists(st.integers(0, rows), max_size=3)))
    return np.split(order, at)

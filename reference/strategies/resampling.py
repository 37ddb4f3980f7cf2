"""Reservoirs, open and closed."""

from typing import Any

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from restir_gi.reference.resampling.reservoir import Candidates, Reservoirs
from restir_gi.reference.strategies.numbers import ROWS, scalars


@st.composite
def candidates(
    draw: st.DrawFn,
    rows: int = ROWS,
    first: int = 0,
    y: st.SearchStrategy[Any] | None = None,
) -> Candidates:
    """Open reservoirs; every so often a null, w = 0 with M counted, or an empty row.

    Parameters
    ----------
    first : int; the samples are numbered from here: row i holds ``first + i``
    y : strategy or None; of samples to hold in place of numbers

    Returns
    -------
    strategy of Candidates
        p_hat and w are 0 together or not at all, M is 0 only where they are.
    """
    alive = draw(arrays(bool, rows))
    p_hat = np.where(alive, draw(scalars(2.0**-10, 2.0**10, rows)), 0.0)
    w = np.where(alive, draw(scalars(2.0**-20, 2.0**20, rows)), 0.0)
    least = np.where(alive, 1, 0)
    M = np.maximum(draw(arrays(np.int64, rows, elements=st.integers(0, 500))), least)
    held = np.arange(first, first + rows) if y is None else draw(y)
    return Candidates(held, p_hat, w, M.astype(np.float64))


@st.composite
def reservoirs(
    draw: st.DrawFn,
    rows: int = ROWS,
    first: int = 0,
    y: st.SearchStrategy[Any] | None = None,
) -> Reservoirs:
    """Closed reservoirs; every so often with W = 0.  M from 1 to 500.

    Parameters
    ----------
    first : int; the samples are numbered from here: row i holds ``first + i``
    y : strategy or None; of samples to hold in place of numbers
    """
    alive = draw(arrays(bool, rows))
    W = np.where(alive, draw(scalars(2.0**-20, 2.0**20, rows)), 0.0)
    M = draw(arrays(np.int64, rows, elements=st.integers(1, 500)))
    held = np.arange(first, first + rows) if y is None else draw(y)
    return Reservoirs(held, W, M.astype(np.float64))

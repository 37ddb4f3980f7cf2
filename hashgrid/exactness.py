"""The grid's kernel in the matrix of extremes."""

from typing import Any

from restir_gi.hashgrid.grid import FARTHEST, SMALLEST, Lattice, levels
from restir_gi.reference.numerics.arrays import Indices
from restir_gi.reference.oracle.exact.draws import Draws
from restir_gi.reference.oracle.exact.kernel import Inputs, Kernel, Row
from restir_gi.reference.oracle.exact.numbers import (
    EXACT,
    Exact,
    UndecidedError,
    exact,
    literal,
)
from restir_gi.reference.oracle.exact.vectors import inner

_LATTICE = Lattice((0.0, 0.0, 0.0), 0.02)


def _draw(draws: Draws) -> dict[str, Any]:
    return {"position": draws.seen_from(draws.place(), draws.unit())}


def _run(given: Inputs) -> Indices:
    return levels(_LATTICE, given["position"])


def _clipped(x: Exact) -> Exact:
    return exact(max(min(x.value, FARTHEST), -FARTHEST), x.type)


def _level(row: Row) -> Exact:
    """floor(log2(|x − eye| · base / edge)), at least 0."""
    x, y, z = (_clipped(component) for component in row["position"])
    base = exact(_LATTICE.base, x.type)
    size = inner((x, y, z), (x, y, z)).sqrt() * base / literal(SMALLEST, x.type)
    if size <= 1:
        return x * 0
    low, high = (EXACT.frexp(size.value + k * size.error)[1] for k in (-1, 1))
    if low != high:
        raise UndecidedError
    return exact(low - 1, x.type)


CELL_LEVEL = Kernel(
    "cell-level",
    "",
    _draw,
    _run,
    _level,
    {
        "points that touch": "0: no cell is smaller than a millimetre",
        "points far away": "that of 2⁶² m",
        "edge-on": "does not know the angle",
        "in a corner": "0",
        "scale of the scene": "at least 0",
        "far from the origin": "grows with the distance from the eye",
    },
)
"""Level of detail of a cell."""

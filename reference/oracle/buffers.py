"""Records of the passes as buffers of the contract."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Indices
from restir_gi.reference.numerics.records import take
from restir_gi.reference.oracle.cases import Buffers
from restir_gi.reference.oracle.contract.fields import Precision, dtype_of
from restir_gi.reference.oracle.prepared_frame import PreparedFrame
from restir_gi.reference.resampling.reservoir import Reservoirs, Samples


def given(inputs: Buffers, precision: Precision) -> dict[str, NDArray[Any]]:
    """Buffers in the types of the contract, in C order."""
    types = {"f": dtype_of("real", precision), "i": dtype_of("index", precision)}
    types["u"] = dtype_of("bits", precision)
    return {
        name: np.ascontiguousarray(array.astype(types[array.dtype.kind]))
        for name, array in inputs.items()
    }


def prefixed(prefix: str, buffers: Buffers) -> dict[str, NDArray[Any]]:
    """The same buffers under longer names.

    Parameters
    ----------
    prefix : str; put before each name, with an underscore
    """
    return {f"{prefix}_{name}": array for name, array in buffers.items()}


def receivers(
    at: PreparedFrame, rows: Indices | None = None
) -> dict[str, NDArray[Any]]:
    """Visible points as buffers.

    Parameters
    ----------
    rows : (N,) int, optional; which; by default all in order
    """
    surface = at.last.visible.surface
    if rows is not None:
        surface = take(surface, rows)
    return {
        "visible_position": surface.position,
        "visible_normal": surface.normal,
        "albedo": surface.color,
    }


def samples(y: Samples) -> dict[str, NDArray[Any]]:
    """Sample points as buffers."""
    return {"position": y.position, "normal": y.normal, "radiance": y.radiance}


def reservoirs(r: Reservoirs) -> dict[str, NDArray[Any]]:
    """Reservoirs as buffers."""
    return samples(r.y) | {"W": r.W, "M": r.M}

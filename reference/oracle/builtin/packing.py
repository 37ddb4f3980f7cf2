"""Reservoirs in bits by the production functions, in any layout."""

from typing import Any

import numpy as np
from numpy.typing import DTypeLike

from restir_gi.reference.oracle.builtin.buffers import (
    Array,
    as_real,
    reservoirs_of,
    reservoirs_out,
)
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.contract.packing import (
    PAPER,
    RESTIR_PT,
    RTXDI,
    RTXDI_PATH,
)
from restir_gi.reference.resampling.packing import (
    paper,
    restir_pt,
    rtxdi,
    rtxdi_path,
)

COUNTS = ("age", "reconnection_vertex", "path_length", "random_index")
KEPT = ("seed", "light", "light_place")
FLAGS = ("boosts", "on_light")
NUMBERS = ("partial_jacobian", "onward_pdf")

VISIBLE = {PAPER: (paper, "seed"), RESTIR_PT: (restir_pt, "age")}
"""Layouts that hold the visible point, and what stands in their last word."""


def pack(
    precision: Precision, layout: str = PAPER, **buffers: Array
) -> dict[str, Array]:
    """Words of reservoirs.

    Parameters
    ----------
    layout : str; as the contract names it
    **buffers : array; that the contract gives with it
    """
    r = reservoirs_of(buffers)
    if layout == RTXDI:
        return _words(rtxdi.pack(r, buffers["age"], buffers["misc"]))
    if layout == RTXDI_PATH:
        return _words(rtxdi_path.pack(r, _record(buffers)))
    form, last = VISIBLE[layout]
    at = (buffers["visible_position"], buffers["visible_normal"])
    return _words(form.pack(*at, r, buffers[last]))


def unpack(precision: Precision, words: Array, layout: str = PAPER) -> dict[str, Array]:
    """Reservoirs of words.

    Parameters
    ----------
    layout : str; as the contract names it
    words : (N, 8), (N, 12) or (N, 16) uint32
    """
    if layout == RTXDI:
        r, age, misc = rtxdi.unpack(_records(words, rtxdi.RESERVOIR))
        return reservoirs_out(precision, r) | _bits(age=age, misc=misc)
    if layout == RTXDI_PATH:
        r, path = rtxdi_path.unpack(_records(words, rtxdi_path.RESERVOIR))
        whole = {name: getattr(path, name) for name in (*COUNTS, *FLAGS, *KEPT)}
        reals = {name: getattr(path, name) for name in NUMBERS}
        reals["target_function"] = path.target
        held = {name: as_real(precision, array) for name, array in reals.items()}
        return reservoirs_out(precision, r) | held | _bits(**whole)
    form, last = VISIBLE[layout]
    x_v, n_v, r, word = form.unpack(_records(words, form.RESERVOIR))
    return {
        "visible_position": as_real(precision, x_v),
        "visible_normal": as_real(precision, n_v),
        **reservoirs_out(precision, r),
        last: word,
    }


def _words(codes: Array) -> dict[str, Array]:
    return {"words": codes.view("<u4").reshape(len(codes), -1)}


def _records(words: Array, dtype: DTypeLike) -> Array:
    return np.ascontiguousarray(words).view(dtype)[:, 0]


def _record(buffers: dict[str, Array]) -> rtxdi_path.PathRecord:
    taken: dict[str, Any] = {n: buffers[n] for n in (*COUNTS, *KEPT, *NUMBERS)}
    taken |= {name: buffers[name] == 1 for name in FLAGS}
    return rtxdi_path.PathRecord(**taken, target=buffers["target_function"])


def _bits(**columns: Array) -> dict[str, Array]:
    return {name: array.astype("<u4") for name, array in columns.items()}

"""Reservoirs whose layout is known, field by field.

The same fields as `restir_gi.reference.resampling.packing` has them; a manifest could
say each of them itself.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class Layout:
    """A layout of reservoirs.

    Attributes
    ----------
    title : str; whose it is
    stride : int; bytes of a reservoir
    fields : tuple of mapping; as a manifest has them
    tile : (int, int) or None; pixels of the blocks of a buffer; None: rows
    """

    title: str
    stride: int
    fields: tuple[Mapping[str, Any], ...]
    tile: tuple[int, int] | None = None


def _field(name: str, kind: str, offset: int) -> Mapping[str, Any]:
    return {"name": name, "kind": kind, "offset": offset}


_FORTY_FOUR = (
    _field("visible_position", "float32", 0),
    _field("visible_normal", "octahedral-snorm16", 12),
    _field("position", "float32", 16),
    _field("normal", "octahedral-snorm16", 28),
    _field("radiance", "float16", 32),
    _field("M", "uint16", 38),
    _field("W", "float32", 40),
)

LAYOUTS: Mapping[str, Layout] = {
    "rtxdi": Layout(
        "RTXDI's packed GI reservoir",
        32,
        (
            _field("position", "float32", 0),
            _field("M", "uint8", 12),
            _field("age", "uint8", 13),
            _field("misc", "uint16", 14),
            _field("radiance", "logluv32", 16),
            _field("W", "float32", 20),
            _field("normal", "octahedral-snorm16", 24),
        ),
        (16, 16),
    ),
    "restir_pt": Layout(
        "screen-space ReSTIR GI of ReSTIR_PT",
        48,
        (*_FORTY_FOUR, _field("age", "uint32", 44)),
    ),
    "paper": Layout(
        "the paper's 48 bytes", 48, (*_FORTY_FOUR, _field("seed", "uint32", 44))
    ),
}
"""By the names that manifests have."""

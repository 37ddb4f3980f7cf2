"""Decoded frames: the numbers of an engine's buffers, rows in the order of pixels."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class CapturedBuffers:
    """What one frame holds of one role, such as the reservoirs after temporal reuse.

    Attributes
    ----------
    columns : mapping of str to (N, ...) array
        By the contract's names; row = y · width + x from the top left.  Reals are
        float64, row numbers int64 with -1 for none, bits uint32.  All are finite, but
        for reservoirs and colours, of which a pass may have made NaN.
    storage : str
        In which layout a reservoir was stored: ``"rtxdi"``, ``"restir_pt"`` or
        ``"paper"``; ``"fields"`` where the manifest describes field by field.
    formats : mapping of str to str
        Kind of number that each column was stored in, such as ``"float16"``; what was
        derived has that of what it was derived from.
    derived : mapping of str to str
        How columns came about that no buffer holds, such as ``"pdf"``: ``"1 / W"``.
    words : mapping of str to (N, B) uint8
        Bytes of each row as they were stored, by the name of the buffer; pictures and
        arrays of plain numbers have none.
    """

    columns: Mapping[str, NDArray[Any]]
    storage: str = "fields"
    formats: Mapping[str, str] = field(default_factory=dict)
    derived: Mapping[str, str] = field(default_factory=dict)
    words: Mapping[str, NDArray[np.uint8]] = field(default_factory=dict)

    def __getitem__(self, name: str) -> NDArray[Any]:
        """Column of a name, (N, ...); KeyError where there is none."""
        return self.columns[name]

    def __contains__(self, name: object) -> bool:
        """Whether there is a column of this name."""
        return name in self.columns


@dataclass(frozen=True, slots=True)
class CapturedFrame:
    """The buffers of one frame.

    Attributes
    ----------
    number : int; as the engine counts
    roles : mapping of str to CapturedBuffers
        ``gbuffer``, ``initial``, ``temporal``, ``spatial`` and whatever else was
        dumped; see `restir_gi.reference.oracle.capture.roles`.
    """

    number: int
    roles: Mapping[str, CapturedBuffers]

    def __getitem__(self, role: str) -> CapturedBuffers:
        """Buffers of a role; KeyError where there are none."""
        return self.roles[role]

    def __contains__(self, role: object) -> bool:
        """Whether there are buffers of this role."""
        return role in self.roles

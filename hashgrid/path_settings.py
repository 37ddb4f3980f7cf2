"""Settings of path reservoirs in the cells of a grid."""

from dataclasses import dataclass
from math import inf
from typing import Literal

from restir_gi.extensions.pt_settings import PathSettings
from restir_gi.reference.methods.setting_values import refuse_beyond
from restir_gi.reference.numerics.arrays import Masks, Scalars
from restir_gi.reference.resampling.generalized import Mis

CELL_LIMITS = {
    "query": (0, 31),
    "cells": (0, 8),
    "cell_reuse": (1, 8),
    "cell_cap": (1, inf),
    "facings": (1, 16),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class CellSettings(PathSettings):
    """Settings of ReGIR GI: those of ReSTIR PT, with 1/Z, and of the cells.

    Attributes
    ----------
    query : int
        Bounce at which a path looks into a cell: 1 at the visible point, 2 at the next
        one; 0 for every bounce.
    cells : int; how many cells of the last frame it looks into; 0 for none
    cell_reuse : int; how many neighbours it takes from each
    cell_cap : float; limit of M in cells
    cell_mis : '1/M', '1/Z', 'balance', 'pairwise' or 'defensive'
        MIS weights in cells; 1/M is biased, and the article's.
    nulls : 'counted' or 'dropped'
        Vertices whose paths found no light, or cannot be joined: they are in the cells,
        too, without a sample, or not at all, which is biased, and the article's.
    writers : 'same-bounce' or 'every-bounce'
        Whose reservoirs a cell holds: vertices of the bounce that looks into it, or of
        all bounces, which is biased, and the article's.
    facings : int; parts of each component of the normal that cells tell apart
    """

    mis: Mis = "1/Z"  # where few paths find light, a share for one's own is waste
    query: int = 2
    cells: int = 1
    cell_reuse: int = 4
    cell_cap: float = 20.0
    cell_mis: Mis = "balance"
    nulls: Literal["counted", "dropped"] = "counted"
    writers: Literal["same-bounce", "every-bounce"] = "same-bounce"
    facings: int = 1

    def __post_init__(self) -> None:
        # Slots make another class of it, which the short form of super does not know.
        PathSettings.__post_init__(self)
        refuse_beyond(self, CELL_LIMITS)

    def looks_up(self, vertex: int) -> bool:
        """Whether paths at x_v look into a cell."""
        return self.cells > 0 and self.query in (0, vertex)

    def stores(self, vertex: int) -> bool:
        """Whether reservoirs of x_v are put into cells, for vertices that look up."""
        every = self.cells > 0 and self.writers == "every-bounce"
        return self.looks_up(vertex) or every

    def grids(self, vertices: tuple[int, ...]) -> list[tuple[int, ...]]:
        """Which of the vertices that store share a grid."""
        if self.writers == "every-bounce":
            return [vertices] if vertices else []
        return [(v,) for v in vertices]

    def inserts(self, W: Scalars) -> Masks:
        """Which reservoirs are put into cells, by their weights, (N,)."""
        return (W > 0) | (self.nulls == "counted")

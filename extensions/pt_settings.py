"""Settings of ReSTIR PT."""

from dataclasses import dataclass
from math import inf
from typing import Literal

from restir_gi.extensions.shifting import Criterion
from restir_gi.reference.methods.framed import Image
from restir_gi.reference.methods.setting_values import refuse_beyond
from restir_gi.reference.resampling.generalized import Mis
from restir_gi.reference.settings import Search

ShiftKind = Literal["reconnection", "replay", "hybrid"]

CRITERIA: dict[ShiftKind, Criterion] = {
    "reconnection": Criterion(0.0, 0.0, last_joint=2, replays=False),
    "replay": Criterion(roughness=inf),
    "hybrid": Criterion(),
}
"""The three shifts are one: they differ in where paths may be joined."""

LEAST_AND_MOST = {
    "temporal_cap": (1, inf),
    "spatial_cap": (1, inf),
    "neighbors": (0, 63),
    "radius": (0, 1),
    "min_radius": (0, 2**14),
    "max_angle": (0, 180),
    "max_depth": (0, inf),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class PathSettings(Search):
    """Settings of ReSTIR PT.

    Attributes
    ----------
    shift : 'reconnection', 'replay' or 'hybrid'; how paths are shifted between pixels
    mis : '1/M', '1/Z', 'balance', 'pairwise' or 'defensive'
        MIS weights; the first is biased.
    temporal, spatial : bool; which passes run
    temporal_cap, spatial_cap : float; limits of M
    neighbors : int; whose paths the spatial pass resamples
    image : 'last' or 'mean'; the last frame, as a renderer shows it, or the mean of all
    """

    shift: ShiftKind = "hybrid"
    mis: Mis = "defensive"
    temporal: bool = True
    spatial: bool = True
    temporal_cap: float = 20.0
    spatial_cap: float = 500.0
    neighbors: int = 3
    image: Image = "last"

    def __post_init__(self) -> None:
        refuse_beyond(self, LEAST_AND_MOST)

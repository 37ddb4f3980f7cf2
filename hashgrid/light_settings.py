"""Settings of light reservoirs in world space."""

from dataclasses import dataclass
from math import inf

from restir_gi.hashgrid.lights import Chance
from restir_gi.reference.methods.framed import Image
from restir_gi.reference.methods.setting_values import refuse_beyond
from restir_gi.reference.resampling.generalized import Mis

LEAST_AND_MOST = {
    "candidates": (1, 32),
    "cells": (0, 8),
    "reuse": (1, 8),
    "cap": (1, inf),
    "facings": (1, 16),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class LightSettings:
    """Settings of light reservoirs in world space.

    Attributes
    ----------
    candidates : int; points on lights that each vertex draws by power
    mis : '1/M', '1/Z', 'balance', 'pairwise' or 'defensive'
        MIS weights of the neighbours; the first is biased, and the article's.
    cells : int; how many cells of the last frame each vertex looks into; 0 for no reuse
    reuse : int; how many neighbours it takes from each
    cap : float; limit of M
    visible : bool
        Whether visible points have reservoirs, too: their own light is direct, and
        needs none, but others may reuse them.
    facings : int; parts of each component of the normal that cells tell apart
    chance : 'delta-lobes' or 'balance'
        What rays that hit lights contribute: those of delta lobes alone, or their share
        of the balance heuristic.
    image : 'last' or 'mean'; the last frame, as a renderer shows it, or the mean of all
    """

    candidates: int = 8
    mis: Mis = "balance"
    cells: int = 1
    reuse: int = 4
    cap: float = 20.0
    visible: bool = False
    facings: int = 1
    chance: Chance = "delta-lobes"
    image: Image = "last"

    def __post_init__(self) -> None:
        refuse_beyond(self, LEAST_AND_MOST)

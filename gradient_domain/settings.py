"""Settings of the methods that estimate differences of pixels."""

from dataclasses import dataclass
from typing import Literal

from restir_gi.extensions.area_settings import AreaSettings
from restir_gi.extensions.pt_settings import ShiftKind
from restir_gi.reference.methods.framed import Image
from restir_gi.reference.methods.setting_values import refuse_beyond

Reconstruction = Literal["l2", "l1"]
"""Norm of what is left of the differences: least squares, or least absolute values."""

Signs = Literal["within", "across", "without"]
"""Reservoirs of both signs that reuse their own, or each other's; or one of both."""

Around = Literal["edges", "random", "none"]
"""Neighbours: of an edge pair a similar edge pair, of every pair any other, or none."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GradientPathSettings:
    """Settings of gradient-domain path tracing.

    Attributes
    ----------
    shift : 'reconnection', 'replay' or 'hybrid'
        How paths are shifted between the pixels of a pair.
    reconstruction : 'l2' or 'l1'; norm of what is left of the differences; L1 is biased
    image : 'last' or 'mean'
        Of pixels and differences, before the image is reconstructed.
    """

    shift: ShiftKind = "hybrid"
    reconstruction: Reconstruction = "l2"
    image: Image = "mean"


@dataclass(frozen=True, slots=True, kw_only=True)
class AfterSettings(AreaSettings):
    """Settings of Area ReSTIR, whose paths differences are estimated from.

    Attributes
    ----------
    reconstruction : 'l2' or 'l1'; norm of what is left of the differences; L1 is biased
    """

    neighbors: int = 2
    reconstruction: Reconstruction = "l2"


@dataclass(frozen=True, slots=True, kw_only=True)
class GradientSettings(AfterSettings):
    """Settings of ReSTIR for pairs; those of Area ReSTIR hold of both.

    Attributes
    ----------
    signs : 'within', 'across' or 'without'
        Two reservoirs a pair, for what is positive and what is negative, that reuse
        samples of their own sign or of both; or one for the magnitude.
    around : 'edges', 'random' or 'none'
        Neighbours: of edge pairs a similar edge pair, of all pairs any, or none.
    tries : int; how many pairs are compared in search of a similar one, at most
    """

    signs: Signs = "within"
    around: Around = "edges"
    tries: int = 256

    def __post_init__(self) -> None:
        AfterSettings.__post_init__(self)
        refuse_beyond(self, {"tries": (1, 256)})

"""Settings of ReSTIR PT."""

from dataclasses import dataclass

from extensions.connection import Shift
from extensions.reuse import Mis
from reference.settings import Search


@dataclass(frozen=True, slots=True, kw_only=True)
class PathSettings(Search):
    """Settings of ReSTIR PT.

    Attributes
    ----------
    shift : 'reconnection', 'replay' or 'hybrid'
        How paths are shifted between pixels.
    mis : '1/M', '1/Z' or 'balance'
        What the sum of weights is divided by; the first is biased.
    temporal, spatial : bool
        Which passes run.
    temporal_cap, spatial_cap : float
        Limits of M.
    neighbors : int
        Whose paths the spatial pass takes over.
    """

    shift: Shift = "hybrid"
    mis: Mis = "1/Z"
    temporal: bool = True
    spatial: bool = True
    temporal_cap: float = 20.0
    spatial_cap: float = 500.0
    neighbors: int = 3

"""Settings of ReSTIR GI, with the paper's numbers as defaults."""

from dataclasses import dataclass
from typing import Literal

from reference.resampling.target import Target

Source = Literal["uniform", "cosine", "bsdf"]
Mis = Literal["1/M", "1/Z", "balance"]
Visibility = Literal["all", "chosen", "none"]
GlossySamples = Literal["path-traced", "as-lambertian"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """Settings of ReSTIR GI; the defaults are the paper's, in its unbiased form.

    Attributes
    ----------
    source : 'uniform', 'cosine' or 'bsdf'
        Density of initial directions (section 4.1).
    target : 'scattered' or 'outgoing'
        Equation 9 or 10.
    mis : '1/Z', 'balance' or '1/M'
        How reused samples are weighted; 1/M is biased.
    visibility : 'all', 'chosen' or 'none'
        Which reused samples are tested from the receiver: every one before it
        competes, the one that was kept, or none, which is biased.
    glossy_samples : 'path-traced' or 'as-lambertian'
        Sample points that are not Lambertian: their light is added as this frame's
        path found it, or reused as if it left in all directions, which is biased.
    temporal, spatial : bool
        Whether each reuse takes place.
    temporal_cap, spatial_cap : float
        Limits of M (section 5).
    iterations_few, iterations_many : int
        Neighbours tried by pixels whose spatial M is at least half of its limit, and
        by all others.
    radius : float
        Of the search, as a share of the image's width.
    min_radius : float, pixels
        To which it may shrink.
    max_angle : float, degrees
        Between the normals of pixels that share samples.
    max_depth : float
        Relative difference of their depths, |a - b| / max(a, b).
    """

    source: Source = "uniform"
    target: Target = "scattered"
    mis: Mis = "1/Z"
    visibility: Visibility = "all"
    glossy_samples: GlossySamples = "path-traced"
    temporal: bool = True
    spatial: bool = True
    temporal_cap: float = 30.0
    spatial_cap: float = 500.0
    iterations_few: int = 3
    iterations_many: int = 9
    radius: float = 0.1
    min_radius: float = 3.0
    max_angle: float = 25.0
    max_depth: float = 0.05


UNBIASED = Settings()
BIASED = Settings(mis="1/M", glossy_samples="as-lambertian")

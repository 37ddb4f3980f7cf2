"""Settings of ReSTIR GI; defaults are the paper's numbers, without its shortcuts."""

from dataclasses import dataclass
from math import inf
from typing import Literal

from restir_gi.reference.resampling.source import Source
from restir_gi.reference.resampling.target import Target
from restir_gi.reference.transport.not_reused import GlossySamples

Mis = Literal["1/M", "1/Z", "balance", "pairwise", "defensive"]
Visibility = Literal["all", "chosen", "none"]
JacobianUse = Literal["multiplied", "left-out", "divided"]
BeyondLimit = Literal["reject-mirrored", "reject", "clamp"]
MotionReuse = Literal["shifted", "as-stored"]
Reuse = Literal["separate", "double-buffered", "fused"]
Storage = Literal["float64", "float32", "half", "paper"]
FinalVisibility = Literal["in-weight", "traced", "reused"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Search:
    """Which points are similar, and where neighbours are looked for.

    Attributes
    ----------
    radius : float; of the disk, in widths of the image
    min_radius : float, pixels; least radius
    max_angle : float, degrees; between the normals of similar points
    max_depth : float; relative difference of their depths
    """

    radius: float = 0.1
    min_radius: float = 3.0
    max_angle: float = 25.0
    max_depth: float = 0.05


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings(Search):
    """Settings of ReSTIR GI; the defaults are the paper's numbers, without shortcuts.

    The paper's renderer has ``target="outgoing"``, ``roulette=0.25`` and
    ``reuse="double-buffered"`` besides; ``--preset paper`` sets them.

    Attributes
    ----------
    source : 'uniform', 'cosine' or 'bsdf'; density of initial directions (section 4.1)
    target : 'scattered' or 'outgoing'; Equation 9 or 10
    mis : '1/Z', 'balance', 'pairwise', 'defensive' or '1/M'
        How reused samples are weighted; 1/M is biased.
    visibility : 'all', 'chosen' or 'none'
        Which reused samples are tested from the receiver: every one before it
        competes, the one that was kept, or none, which is biased.
    glossy_samples : 'path-traced' or 'as-lambertian'
        Sample points that are not Lambertian: their light is added as this frame's
        path found it, or reused as if it left in all directions, which is biased.
    temporal, spatial : bool; whether each reuse takes place
    temporal_cap, spatial_cap : float; limits of M (section 5)
    iterations_few, iterations_many : int
        Neighbours tried by pixels whose spatial M is at least half of its limit, and
        by all others.
    radius : float; of the search, as a share of the image's width
    min_radius : float, pixels; to which it may shrink
    max_angle : float, degrees; between the normals of pixels that share samples
    max_depth : float; relative difference of their depths, |a - b| / max(a, b)
    motion : 'shifted' or 'as-stored'
        Reservoirs of a last frame that looked different: shifted into this one, with
        Jacobian, visibility and Z, or taken as they stand, as in the paper, which is
        biased.
    validate_every : int, frames
        Samples are traced again in every n-th frame of a scene that changes (section
        4.3), and reservoirs emptied whose sample is not what it was, which is biased;
        0 for never.
    validation_tolerance : float; relative change of luminance that a sample survives
    boost_below : float
        Pixels whose spatial M is below it reuse the spatial reservoirs of their
        neighbours, too (Figure 10); 0 for never.
    roulette : float
        Share of the tiles of 64 x 32 pixels whose paths go on beyond the first bounce
        (section 5, which has 0.25).
    storage : 'float64', 'float32', 'half' or 'paper'
        How reservoirs are kept between passes: as they are, rounded to a shorter type,
        or in the 48 bytes of section 5.
    reuse : 'separate', 'double-buffered' or 'fused'
        Spatial reuse of this frame's temporal reservoirs; of the last frame's, as two
        buffers without a barrier have them (section 5); or one pass for all.
    jacobian : 'multiplied', 'left-out' or 'divided'
        What becomes of Equation 11; divided as in Algorithm 4.  Only the first is
        unbiased.
    jacobian_limit : float; of max(J, 1/J), at least 1; inf for none
    beyond_limit : 'reject-mirrored', 'reject' or 'clamp'
        What becomes of shifts beyond it: refused here and in the weights of others,
        refused here alone, or J clamped; the latter two are biased.
    max_age : float, frames
        Samples older than this are dropped, which is biased: how old a sample is
        depends on its value.
    boiling_filter : float
        Strength of a filter that empties temporal reservoirs which outshine their
        tile, 0 to 1; biased.
    permutation : bool; histories are read from a shuffled place nearby
    fallback_search : bool; where reprojection fails, some places nearby are tried
    final_visibility : 'in-weight', 'traced' or 'reused'
        A last ray for the sample that is shown: none, since hidden samples have no
        weight; one a frame; or only where the sample did not come from the pixel's own
        past, which is biased while things move.
    checkerboard : bool
        New samples in every other pixel, and where there is no history; biased while
        things move.
    lattice : int, pixels
        Reduced-resolution reservoirs: side of the squares of which one pixel draws
        samples and keeps a reservoir.  The other pixels are shaded from reservoirs
        nearby, which is biased: light that none of these can see is missing.  1 for a
        reservoir in every pixel.
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
    motion: MotionReuse = "shifted"
    validate_every: int = 0
    validation_tolerance: float = 0.1
    boost_below: float = 0.0
    roulette: float = 1.0
    storage: Storage = "float64"
    reuse: Reuse = "separate"
    jacobian: JacobianUse = "multiplied"
    jacobian_limit: float = inf
    beyond_limit: BeyondLimit = "reject-mirrored"
    max_age: float = inf
    boiling_filter: float = 0.0
    permutation: bool = False
    fallback_search: bool = False
    final_visibility: FinalVisibility = "in-weight"
    checkerboard: bool = False
    lattice: int = 1


UNBIASED = Settings()
BIASED = Settings(
    mis="1/M",
    glossy_samples="as-lambertian",
    motion="as-stored",
    validate_every=6,
)

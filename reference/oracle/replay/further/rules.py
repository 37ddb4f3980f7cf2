"""What the further passes are replayed with: the contract, or a known mistake."""

from collections.abc import Callable
from dataclasses import dataclass

from restir_gi.reference.numerics.arrays import Indices, Scalars
from restir_gi.reference.oracle.replay.bounded import Bounded
from restir_gi.reference.oracle.replay.further.formulas import (
    boiling_tile,
    calm,
    light,
    packed_confidence,
    parity,
    room,
    roulette_tile,
    tail_weight,
)
from restir_gi.reference.oracle.replay.further.layout_rules import (
    OCTAHEDRON,
    PATH_RULES,
    RTXDI_RULES,
    Octahedron,
    PathRules,
    RtxdiRules,
)
from restir_gi.reference.oracle.replay.geometry import luminance
from restir_gi.reference.oracle.replay.rules import Rules

HALVES = 24
"""Half words of a packed reservoir, the low one of each word first."""


@dataclass(frozen=True, slots=True)
class FurtherRules:
    """What the further passes calculate with.

    Attributes
    ----------
    pixel_place : float; where in its pixel a ray passes, from the left and from above
    upside_down, mirrored : bool; y of the image counts upwards, or x to the left
    angle_of_height : bool; the angle of view is the vertical one
    up_as_it_is : bool; the vector up is not made orthogonal to the view, nor unit
    depth_is_distance : bool; from the pinhole, not along the axis
    behind_counts : bool
        What is behind the pinhole is seen; reprojection takes |z| for its depth.
    normal_turns : bool; to the side that is seen
    back_faces : bool; triangles are met from both sides
    place_shift : float, pixels
        Added to both coordinates of the place before, ahead of the floor.
    border : 'cut', 'truncated', 'clamped' or 'wide'
        Places outside have no row; those less than a pixel left of the image or above
        it, or all of them, are moved to its border; or one more column is inside.
    own_normal_asked, own_depth_asked : bool
        Compared is what the pixel itself saw before, not what its place saw.
    compares_normals, compares_anything : bool; with what the last frame saw
    misses_go_on : bool; pixels that see nothing have a row too
    luminance : callable; of the radiance, in validation and in the boiling filter
    room : callable; of validation, as the function of `formulas`
    by_channels : bool; each channel has to be what it was
    nulls : 'stay', 'asked' or 'cleared'; in validation: always, as any sample, or never
    ray_asked : bool; whether validation heeds that the sample is met
    keeps_confidence : bool; of reservoirs that are emptied
    light, calm, boiling_tile : callable
        Of the boiling filter, as the functions of `formulas`.
    dark_counts : bool; pixels without light are in the mean
    parity : callable; of the checkerboard, as the function of `formulas`
    history_asked : bool; who has no history draws in every frame
    roulette_tile, tail_weight : callable
        Of the roulette, as the functions of `formulas`.
    octahedron : Octahedron; how normals are written and read
    halves : tuple of int
        Of layouts of 48 bytes, as all that follows but the last two: at which half word
        each half word of the layout stands.
    half_toward_zero, half_overflows : bool
        Channels are rounded toward 0; those too large become infinity.
    small_halves_kept : bool; halves below 2⁻¹⁴ do not become 0
    packed_confidence : callable; as the function of `formulas`
    confidence_signed : bool; M is read as a number with a sign
    rtxdi, rtxdi_path : RtxdiRules and PathRules; of these layouts
    """

    pixel_place: float = 0.5
    upside_down: bool = False
    mirrored: bool = False
    angle_of_height: bool = False
    up_as_it_is: bool = False
    depth_is_distance: bool = False
    behind_counts: bool = False
    normal_turns: bool = True
    back_faces: bool = True
    place_shift: float = 0.0
    border: str = "cut"
    own_normal_asked: bool = False
    own_depth_asked: bool = False
    compares_normals: bool = True
    compares_anything: bool = True
    misses_go_on: bool = False
    luminance: Callable[[Bounded], Bounded] = luminance
    room: Callable[[Bounded, Bounded, Bounded], Bounded] = room
    by_channels: bool = False
    nulls: str = "stay"
    ray_asked: bool = True
    keeps_confidence: bool = False
    light: Callable[[Bounded, Bounded], Bounded] = light
    calm: Callable[[Bounded, Bounded, Bounded], Bounded] = calm
    boiling_tile: Callable[[Indices, Indices, int], Indices] = boiling_tile
    dark_counts: bool = False
    parity: Callable[[Indices, Indices, int, int], Indices] = parity
    history_asked: bool = True
    roulette_tile: Callable[[Indices, Indices, int], Indices] = roulette_tile
    tail_weight: Callable[[Bounded], Bounded] = tail_weight
    octahedron: Octahedron = OCTAHEDRON
    halves: tuple[int, ...] = tuple(range(HALVES))
    half_toward_zero: bool = False
    half_overflows: bool = False
    small_halves_kept: bool = True
    packed_confidence: Callable[[Scalars], Scalars] = packed_confidence
    confidence_signed: bool = False
    rtxdi: RtxdiRules = RTXDI_RULES
    rtxdi_path: PathRules = PATH_RULES


def further(rules: Rules) -> FurtherRules:
    """What the further passes of a replay calculate with."""
    return rules.part or FurtherRules()

"""Known mistakes with reservoirs in bits."""

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.oracle.diagnosis.hypothesis import mistake
from restir_gi.reference.oracle.replay.further.formulas import MOST_M, packed_confidence
from restir_gi.reference.oracle.replay.further.layout_rules import Octahedron
from restir_gi.reference.oracle.replay.further.rules import HALVES, FurtherRules

PACK, UNPACK = ("pack",), ("unpack",)
BITS = (*PACK, *UNPACK)

FOLD_RIGHT = "(u, v) = ((1 − |v|) sign u, (1 − |u|) sign v) where z < 0"
HALF_RIGHT = "rounded to nearest; what is too large becomes 65504"
M_RIGHT = "M from 0 to 65535, at least 1 where it is positive"
NORMAL_RIGHT = "u in bits 15:0, v in bits 31:16"


def _exchanged(*pairs: tuple[int, int]) -> FurtherRules:
    halves = list(range(HALVES))
    for one, other in pairs:
        halves[one], halves[other] = other, one
    return FurtherRules(halves=tuple(halves))


POSITIONS_FIRST = FurtherRules(
    halves=(*range(6), 12, 13, *range(6, 12), *range(14, HALVES))
)


def _wrapped(M: Scalars) -> Scalars:
    held: Scalars = np.where(M > MOST_M, np.rint(M) % 65536, packed_confidence(M))
    return held


def _to_0(M: Scalars) -> Scalars:
    held: Scalars = np.clip(M, 0.0, MOST_M)
    return held


LAYOUTS = (
    mistake(
        "v-before-u",
        "the two coordinates of normals change places",
        "v in bits 15:0, u in bits 31:16",
        NORMAL_RIGHT,
        BITS,
        part=FurtherRules(octahedron=Octahedron(v_first=True)),
    ),
    mistake(
        "normals-exchanged",
        "the two normals change places",
        "word 3: normal; word 7: visible_normal",
        "word 3: visible_normal; word 7: normal",
        BITS,
        part=_exchanged((6, 14), (7, 15)),
    ),
    mistake(
        "m-before-blue",
        "M stands before blue",
        "word 9: M in bits 15:0, blue in bits 31:16",
        "word 9: blue in bits 15:0, M in bits 31:16",
        BITS,
        part=_exchanged((18, 19)),
    ),
    mistake(
        "blue-first",
        "the channels stand in the other order",
        "blue, green, red",
        "red, green, blue",
        BITS,
        part=_exchanged((16, 18)),
    ),
    mistake(
        "halves-from-above",
        "the first of two halves stands in the upper bits",
        "word 8: red in bits 31:16; word 9: blue in bits 31:16",
        "word 8: red in bits 15:0; word 9: blue in bits 15:0",
        BITS,
        part=_exchanged((16, 17), (18, 19)),
    ),
    mistake(
        "seed-before-w",
        "the last two words change places",
        "word 10: seed; word 11: W",
        "word 10: W; word 11: seed",
        BITS,
        part=_exchanged((20, 22), (21, 23)),
    ),
    mistake(
        "positions-before-normals",
        "both positions stand before both normals",
        "words 3 to 5: position; 6: visible_normal",
        "word 3: visible_normal; words 4 to 6: position",
        BITS,
        part=POSITIONS_FIRST,
    ),
)

NUMBERS = (
    mistake(
        "octahedron-not-folded",
        "the lower half of normals is not folded",
        "(u, v) as it is where z < 0",
        FOLD_RIGHT,
        BITS,
        part=FurtherRules(octahedron=Octahedron(folds=False)),
    ),
    mistake(
        "octahedron-not-divided",
        "normals are taken for points of the octahedron, since they are unit vectors",
        "(u, v) = (x, y)",
        "(u, v) = (x, y) / (|x| + |y| + |z|)",
        PACK,
        part=FurtherRules(octahedron=Octahedron(divided=False)),
    ),
    mistake(
        "sign-of-0-is-0",
        "the fold multiplies by a sign of 0, so that normals on it collapse",
        "sign 0 = 0",
        "sign 0 = +1",
        PACK,
        part=FurtherRules(octahedron=Octahedron(sign_of_zero=0)),
    ),
    mistake(
        "octahedron-by-32768",
        "the coordinate 1 has the code 32768, which there is not",
        "32768 u, cut at 32767",
        "32767 u",
        BITS,
        part=FurtherRules(octahedron=Octahedron(steps=32768)),
    ),
    mistake(
        "small-halves-are-0",
        "halves below 2⁻¹⁴ become 0",
        "0 where a channel is below 2⁻¹⁴",
        "subnormal halves stand for their numbers",
        BITS,
        part=FurtherRules(small_halves_kept=False),
    ),
    mistake(
        "pack-halves-overflow",
        "radiance that is too large for a half becomes infinity",
        "infinity from 65520 upwards",
        HALF_RIGHT,
        PACK,
        "ReSTIR_PT",
        "kajiya 6820c29",
        part=FurtherRules(half_overflows=True),
    ),
    mistake(
        "pack-halves-toward-0",
        "channels are rounded toward 0: all light becomes darker",
        "bits are cut off",
        HALF_RIGHT,
        PACK,
        "bevy 054ce1eab6",
        part=FurtherRules(half_toward_zero=True),
    ),
    mistake(
        "pack-normals-toward-0",
        "coordinates of normals are rounded toward 0",
        "int(32767 u)",
        "32767 u, rounded to nearest",
        PACK,
        part=FurtherRules(octahedron=Octahedron(toward_zero=True)),
    ),
    mistake(
        "pack-sign-runs-over",
        "the sign of a negative u fills the bits of v",
        "u | v << 16",
        "(u & 0xFFFF) | v << 16",
        PACK,
        "RTXDI 077b6fa",
        part=FurtherRules(octahedron=Octahedron(runs_over=True)),
    ),
    mistake(
        "pack-m-wraps",
        "an M that is too large starts over at 0",
        "M mod 65536",
        M_RIGHT,
        PACK,
        part=FurtherRules(packed_confidence=_wrapped),
    ),
    mistake(
        "pack-m-becomes-0",
        "an M below 1/2 becomes 0, and the sample is lost",
        "M rounded to nearest",
        M_RIGHT,
        PACK,
        part=FurtherRules(packed_confidence=_to_0),
    ),
    mistake(
        "unpack-without-sign",
        "the coordinates of normals are read without a sign",
        "(u, v) from two uint16",
        "(u, v) from two int16",
        UNPACK,
        part=FurtherRules(octahedron=Octahedron(signed=False)),
    ),
    mistake(
        "unpack-not-normalized",
        "normals that were read are not made unit vectors",
        "n = (u, v, z)",
        "n = (u, v, z) / |(u, v, z)|",
        UNPACK,
        part=FurtherRules(octahedron=Octahedron(normalized=False)),
    ),
    mistake(
        "unpack-m-with-sign",
        "M is read as a number with a sign",
        "M from an int16",
        "M from a uint16",
        UNPACK,
        part=FurtherRules(confidence_signed=True),
    ),
)

PACKING = (*LAYOUTS, *NUMBERS)

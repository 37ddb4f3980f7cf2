"""Known mistakes with who draws, and who goes on."""

from restir_gi.reference.numerics.arrays import Indices
from restir_gi.reference.oracle.diagnosis.hypothesis import mistake
from restir_gi.reference.oracle.replay.bounded import Bounded, constant
from restir_gi.reference.oracle.replay.further.rules import FurtherRules

CHECKERBOARD, ROULETTE = ("checkerboard",), ("roulette",)

TURN_RIGHT = "x + y + frame is even, or has_history is 0"
KEY_RIGHT = "key = (tile, frame, seed, 7 · 64)"
TILE_RIGHT = "tile = ⌊y / 32⌋ · ⌈width / 64⌉ + ⌊x / 64⌋"


def _still(x: Indices, y: Indices, width: int, frame: int) -> Indices:
    return x + y


def _columns(x: Indices, y: Indices, width: int, frame: int) -> Indices:
    return x + frame


def _numbers(x: Indices, y: Indices, width: int, frame: int) -> Indices:
    return y * width + x + frame


def _other_half(x: Indices, y: Indices, width: int, frame: int) -> Indices:
    return x + y + frame + 1


def _pixels(x: Indices, y: Indices, width: int) -> Indices:
    return y * width + x


def _roulette_down(x: Indices, y: Indices, width: int) -> Indices:
    return y // 32 * (width // 64) + x // 64


def _one(probability: Bounded) -> Bounded:
    return constant(1.0, probability)


TURNS = (
    mistake(
        "checkerboard-stands-still",
        "the same half of the pixels draws in every frame",
        "x + y is even, or has_history is 0",
        TURN_RIGHT,
        CHECKERBOARD,
        part=FurtherRules(parity=_still),
    ),
    mistake(
        "checkerboard-of-columns",
        "columns take turns, not the colours of a board",
        "x + frame is even, or has_history is 0",
        TURN_RIGHT,
        CHECKERBOARD,
        part=FurtherRules(parity=_columns),
    ),
    mistake(
        "checkerboard-of-pixel-numbers",
        "the number of the pixel decides: columns, where the width is even",
        "pixel + frame is even, or has_history is 0",
        TURN_RIGHT,
        CHECKERBOARD,
        part=FurtherRules(parity=_numbers),
    ),
    mistake(
        "checkerboard-without-history",
        "pixels without history wait for their turn",
        "x + y + frame is even",
        TURN_RIGHT,
        CHECKERBOARD,
        part=FurtherRules(history_asked=False),
    ),
    mistake(
        "checkerboard-other-half",
        "the other half of the pixels begins",
        "x + y + frame is odd, or has_history is 0",
        TURN_RIGHT,
        CHECKERBOARD,
        part=FurtherRules(parity=_other_half),
    ),
    mistake(
        "roulette-not-divided",
        "the tail is not divided by the probability that it is there",
        "weight = 1 where u < probability",
        "weight = 1 / probability where u < probability",
        ROULETTE,
        part=FurtherRules(tail_weight=_one),
    ),
    mistake(
        "roulette-by-pixels",
        "each pixel decides on its own",
        "key = (pixel, frame, seed, 7 · 64)",
        KEY_RIGHT,
        ROULETTE,
        part=FurtherRules(roulette_tile=_pixels),
    ),
    mistake(
        "roulette-tiles-rounded-down",
        "tiles that are cut off at the right share the number of others",
        "tile = ⌊y / 32⌋ · ⌊width / 64⌋ + ⌊x / 64⌋",
        TILE_RIGHT,
        ROULETTE,
        part=FurtherRules(roulette_tile=_roulette_down),
    ),
    mistake(
        "roulette-stands-still",
        "the frame is not in the key: the same tiles go on in every frame",
        "key = (tile, seed, 7 · 64)",
        KEY_RIGHT,
        ROULETTE,
        "HIPRT 7c534c1d",
        ignored_words=(1,),
    ),
)

"""Known mistakes with the passes that empty reservoirs."""

import numpy as np

from restir_gi.reference.numerics.arrays import Indices
from restir_gi.reference.oracle.diagnosis.hypothesis import mistake
from restir_gi.reference.oracle.diagnosis.luminances import (
    largest_channel,
    mean_of_channels,
    rec_601,
)
from restir_gi.reference.oracle.replay.bounded import Bounded, constant
from restir_gi.reference.oracle.replay.further.numbers import larger
from restir_gi.reference.oracle.replay.further.rules import FurtherRules

VALIDATION, BOILING = ("validation",), ("boiling",)

ROOM_RIGHT = "|a − b| ≤ tolerance · max(a, b)"
NULLS_RIGHT = "W and M stay where null is 1, and where met is 1"
MEAN_RIGHT = "mean over the pixels of the tile whose light is above 0"
TILE_RIGHT = "tile = ⌊y / 16⌋ · ⌈width / 16⌉ + ⌊x / 16⌋"
LIGHT_RIGHT = "light = Y(radiance) · W"
GONE_RIGHT = "W = 0 and M = 0"

LUMINANCE_RIGHT = "Y = 0.2126 R + 0.7152 G + 0.0722 B"


def _absolute(tolerance: Bounded, then: Bounded, now: Bounded) -> Bounded:
    return tolerance - abs(then - now)


def _of_then(tolerance: Bounded, then: Bounded, now: Bounded) -> Bounded:
    return tolerance * then - abs(then - now)


def _of_now(tolerance: Bounded, then: Bounded, now: Bounded) -> Bounded:
    return tolerance * now - abs(then - now)


def _darker(tolerance: Bounded, then: Bounded, now: Bounded) -> Bounded:
    return tolerance * larger(then, now) - (then - now)


def _brighter(tolerance: Bounded, then: Bounded, now: Bounded) -> Bounded:
    return tolerance * larger(then, now) - (now - then)


def _W_alone(brightness: Bounded, W: Bounded) -> Bounded:
    return W


def _without_W(brightness: Bounded, W: Bounded) -> Bounded:
    return brightness


def _not_divided(light: Bounded, mean: Bounded, strength: Bounded) -> Bounded:
    reach = constant(10.0, strength) - constant(9.0, strength) * strength
    return mean * reach - light


def _image(x: Indices, y: Indices, width: int) -> Indices:
    return np.zeros_like(x)


def _boiling_down(x: Indices, y: Indices, width: int) -> Indices:
    return y // 16 * (width // 16) + x // 16


def _tiles_of_8(x: Indices, y: Indices, width: int) -> Indices:
    return y // 8 * width + x // 8


FILTERS = (
    mistake(
        "validation-absolute",
        "the tolerance is not relative",
        "|a − b| ≤ tolerance",
        ROOM_RIGHT,
        VALIDATION,
        part=FurtherRules(room=_absolute),
    ),
    mistake(
        "validation-relative-to-then",
        "the tolerance is relative to the stored luminance alone",
        "|a − b| ≤ tolerance · a",
        ROOM_RIGHT,
        VALIDATION,
        part=FurtherRules(room=_of_then),
    ),
    mistake(
        "validation-relative-to-now",
        "the tolerance is relative to the luminance of now alone",
        "|a − b| ≤ tolerance · b",
        ROOM_RIGHT,
        VALIDATION,
        part=FurtherRules(room=_of_now),
    ),
    mistake(
        "validation-of-darker-alone",
        "only samples that became darker are cleared",
        "a − b ≤ tolerance · max(a, b)",
        ROOM_RIGHT,
        VALIDATION,
        "strolle #12",
        part=FurtherRules(room=_darker),
    ),
    mistake(
        "validation-of-brighter-alone",
        "only samples that became brighter are cleared",
        "b − a ≤ tolerance · max(a, b)",
        ROOM_RIGHT,
        VALIDATION,
        part=FurtherRules(room=_brighter),
    ),
    mistake(
        "validation-by-channels",
        "each channel is held against the tolerance, not the luminance",
        "|a − b| ≤ tolerance · max(a, b) of red, of green and of blue",
        ROOM_RIGHT,
        VALIDATION,
        part=FurtherRules(by_channels=True),
    ),
    mistake(
        "validation-clears-nulls",
        "reservoirs of nulls are cleared, since their rays meet nothing",
        "W and M stay where null is 0 and met is 1",
        NULLS_RIGHT,
        VALIDATION,
        part=FurtherRules(nulls="cleared"),
    ),
    mistake(
        "validation-asks-nulls",
        "nulls are held against what was found again, as any sample",
        "W and M stay where met is 1",
        NULLS_RIGHT,
        VALIDATION,
        part=FurtherRules(nulls="asked"),
    ),
    mistake(
        "validation-without-ray",
        "no ray looks whether the sample is still met",
        f"W and M stay where {ROOM_RIGHT}",
        f"W and M stay where met is 1 and {ROOM_RIGHT}",
        VALIDATION,
        part=FurtherRules(ray_asked=False),
    ),
    mistake(
        "validation-keeps-m",
        "M outlives the sample that is no longer valid",
        "W = 0",
        GONE_RIGHT,
        VALIDATION,
        part=FurtherRules(keeps_confidence=True),
    ),
    mistake(
        "filters-by-rec-601",
        "the luminance is that of Rec. 601",
        "Y = 0.299 R + 0.587 G + 0.114 B",
        LUMINANCE_RIGHT,
        (*VALIDATION, *BOILING),
        departure="filter",
        part=FurtherRules(luminance=rec_601),
    ),
    mistake(
        "filters-by-the-mean-of-channels",
        "the mean of the channels stands for luminance",
        "Y = (R + G + B) / 3",
        LUMINANCE_RIGHT,
        (*VALIDATION, *BOILING),
        departure="filter",
        part=FurtherRules(luminance=mean_of_channels),
    ),
    mistake(
        "filters-by-the-largest-channel",
        "the largest channel stands for luminance",
        "Y = max(R, G, B)",
        LUMINANCE_RIGHT,
        (*VALIDATION, *BOILING),
        departure="filter",
        part=FurtherRules(luminance=largest_channel),
    ),
    mistake(
        "boiling-mean-over-all",
        "pixels without light are in the mean",
        "mean over all pixels of the tile",
        MEAN_RIGHT,
        BOILING,
        part=FurtherRules(dark_counts=True),
    ),
    mistake(
        "boiling-by-w-alone",
        "W is compared with the mean of W",
        "light = W",
        LIGHT_RIGHT,
        BOILING,
        part=FurtherRules(light=_W_alone),
    ),
    mistake(
        "boiling-without-w",
        "the radiance is compared, without its weight",
        "light = Y(radiance)",
        LIGHT_RIGHT,
        BOILING,
        part=FurtherRules(light=_without_W),
    ),
    mistake(
        "boiling-keeps-m",
        "M outlives the sample that outshone its tile",
        "W = 0",
        GONE_RIGHT,
        BOILING,
        part=FurtherRules(keeps_confidence=True),
    ),
    mistake(
        "boiling-mean-of-the-image",
        "there are no tiles",
        "mean over the pixels of the image whose light is above 0",
        MEAN_RIGHT,
        BOILING,
        part=FurtherRules(boiling_tile=_image),
    ),
    mistake(
        "boiling-limit-not-divided",
        "the limit is not divided by the strength",
        "light ≤ mean · (10 − 9 strength)",
        "light · strength ≤ mean · (10 − 9 strength)",
        BOILING,
        part=FurtherRules(calm=_not_divided),
    ),
    mistake(
        "boiling-tiles-rounded-down",
        "tiles that are cut off at the right share the number of others",
        "tile = ⌊y / 16⌋ · ⌊width / 16⌋ + ⌊x / 16⌋",
        TILE_RIGHT,
        BOILING,
        part=FurtherRules(boiling_tile=_boiling_down),
    ),
    mistake(
        "boiling-tiles-of-8",
        "tiles have 8 × 8 pixels",
        "tile = ⌊y / 8⌋ · ⌈width / 8⌉ + ⌊x / 8⌋",
        TILE_RIGHT,
        BOILING,
        part=FurtherRules(boiling_tile=_tiles_of_8),
    ),
)

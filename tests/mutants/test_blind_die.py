"""A port of the page of the contract is right, and mistakes in it are found."""

import math
from functools import cache

import pytest

from tests.mutants import blind
from tests.mutants.blind_port import Port

QUICK = (
    blind.DensityOfTheOtherSource,
    blind.DividedByTheCappedM,
    blind.NeighbourSeenByTheBitBefore,
    blind.NullsAreEmptied,
    blind.FoldUsesWhatItHasChanged,
)

SHARE = 0.97
"""Of mistakes that were planted without sight of the known ones, to be killed.

Two of the forty give another M and bring no bias: it is enough that they are told.
"""


NAMED_RIGHTLY = 0.6
"""Share of all, of which every sentence has to be true; of none it may be wrong."""

TRUE = {
    "WordsDividedByTheirRange": ("u is its word times 2^-32",),
    "DensityOfTheOtherSource": ("uniform-density-for-cosine",),
    "HalfOfTheAzimuth": ("half-of-the-azimuths",),
    "GrazingLightIsCut": ("is 0 where cos θ < 0.05",),
    "BackOfTheSampleShines": ("back-of-sample",),
    "DistancesAreNotSquared": ("jacobian-unsquared",),
    "JacobianIsLimited": ("jacobian-at-most-10",),
    "WeightAgainstTheFirstAlone": ("accepts-by-the-old-sum",),
    "DarkTargetsAreNothing": ("W is 0 where p_hat < 0.001",),
    "DegreesTakenForRadians": ("max_angle were 180/π times as large",),
    "SmallDensitiesAreRaised": ("W is cut off at 20", "pdf of the new sample is at"),
    "CapOneFrameLate": ("cap-off-by-one",),
    "DividedByTheCappedM": ("capped-before-weight",),
    "ClosedByTheOutgoingTarget": ("W is right times p_hat / Y(L_o)",),
    "PastSeenFromThePast": ("if column 0 of visible were column 1",),
    "DomainWithTheNormalOfNow": ("if past_visible_normal were visible_normal",),
    "HiddenPastDoesNotCount": ("hidden-not-counted",),
    "MovedIsAlwaysDividedByM": ("one-over-m",),
    "OffsetsAreCutOff": ("if offsets were rounded toward 0",),
    "NeighboursAroundTheEdge": ("if lines went on into the next",),
    "RadiusFallsBelowItsLeast": ("if the radius fell below its least",),
    "MissingNeighbourIsTheLastRow": ("if −1 in neighbors were the last row",),
    "NeighbourSeenByTheBitBefore": ("each bit of column 0 of visible were the one",),
    "BitsInTheOrderOfTheStream": ("after the first were the one above it",),
    "NormalOfTheOwnSample": ("times J with the normal of the pixel's own sample / J",),
    "OwnAndFirstNeighbourShareANumber": ("if u_own were column 0 of u_neighbors",),
    "SpatialIgnoresItsCap": ("never-capped",),
    "ShadedBelowTheHorizon": ("color is light of whatever side",),
    "AngleOfViewIsVertical": ("angle-of-the-height",),
    "NormalIsNotTurned": ("normal-not-turned",),
    "NearestPixelCorner": ("if places were rounded to the nearest, not down",),
    "ReprojectionIgnoresDepth": ("if max_depth were without limit",),
    "NullsAreEmptied": ("validation-asks-nulls",),
    "MeanOverDarkPixelsToo": ("boiling-mean-over-all",),
    "ParityOfTheRowNumber": ("checkerboard-of-pixel-numbers",),
    "TilesThatAreWholeAlone": ("roulette-tiles-rounded-down",),
    "EveryTileHasWeightOne": ("roulette-not-divided",),
    "BrightRadianceIsInfinite": ("pack-halves-overflow",),
    "DimHalvesAreNothing": ("small-halves-are-0",),
}
"""What is true of each in words of the diagnosis; of one there is no name."""

IN_PART = {"BackOfTheSampleShines": "back-left-to-the-jacobian"}
"""A target alone that leaves the back to the Jacobian is no mistake."""


@cache
def verdict_of(mistake):
    return blind.verdict_on(mistake)


def named(mistake):
    """How each of the sentences about a mistake is: right, none, or WRONG."""
    name, found = mistake.__name__, set()
    for line in blind.said(verdict_of(mistake)):
        if any(words in line for words in TRUE.get(name, ())):
            found.add("right")
        elif IN_PART.get(name, "the first wrong term is") in line:
            found.add("none")
        else:
            found.add("WRONG")
    return found


def test_a_port_of_the_page_alone_is_right():
    verdict = blind.verdict_on(Port)
    assert verdict.status == "PASS"
    assert blind.said(verdict) == []
    assert verdict.at_extremes == []


def test_there_are_forty_mistakes_and_each_says_what_is_wrong():
    sentences = {blind.truth(mistake) for mistake in blind.MISTAKES}
    assert len(sentences) == len(blind.MISTAKES) == 40


@pytest.mark.parametrize("mistake", QUICK)
@pytest.mark.few(1)
def test_a_mistake_is_killed(mistake):
    assert verdict_of(mistake).status == "FAIL"


@pytest.mark.slow
def test_nearly_all_mistakes_are_killed():
    alive = [m for m in blind.MISTAKES if not blind.killed(verdict_of(m))]
    allowed = math.floor((1 - SHARE) * len(blind.MISTAKES))
    assert len(alive) <= allowed, [m.__name__ for m in alive]


@pytest.mark.slow
def test_most_mistakes_are_named_rightly_and_none_wrongly():
    found = {m.__name__: named(m) for m in blind.MISTAKES}
    assert [name for name, how in found.items() if "WRONG" in how] == []
    right = [name for name, how in found.items() if how == {"right"}]
    assert len(right) >= NAMED_RIGHTLY * len(blind.MISTAKES)


@pytest.mark.parametrize("mistake", blind.MISTAKES)
def test_a_mistake_takes_the_place_of_one_step(mistake):
    steps = {name for name in vars(mistake) if not name.startswith("__")}
    assert steps <= set(vars(Port))

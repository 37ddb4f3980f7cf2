"""A verdict on a renderer of which nothing is known but its pictures."""

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from math import floor, log10
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.moments import Moments
from restir_gi.reference.oracle.blackbox.convention import Convention
from restir_gi.reference.oracle.blackbox.evidence import (
    ALPHA,
    DARK,
    FIRST_LOOK,
    MISSED,
    PictureDifferences,
    Tolerance,
    differences,
    look_after,
    p_values,
    pictures_to_decide,
    share_of,
    within,
)
from restir_gi.reference.oracle.blackbox.likeness import (
    Likeness,
    conventions,
    likenesses,
)
from restir_gi.reference.oracle.blackbox.tiles import (
    PLACES,
    columns,
    name_of,
    tile_means,
)
from restir_gi.reference.oracle.blackbox.truth import Truth
from restir_gi.reference.oracle.cases import Failure, UnaskedError
from restir_gi.reference.oracle.statistics.betting import (
    Bets,
    e_value,
    interval_bets,
    place,
)
from restir_gi.reference.oracle.statistics.families import average_e, bonferroni
from restir_gi.reference.oracle.statistics.intervals import (
    student_deviations,
    truth_interval,
)
from restir_gi.reference.scene.loaders.pictures import decode_srgb

DEVIATIONS = 6.0
"""Standard errors about the truth that count as it: one of 17 truths lies outside with
probability 3e-8, if the means of many paths are normal."""

UNBOUNDED = 8.0
"""Pictures are cut at so many times the truth, where no bound was declared; a cut mean
is no larger, so that too much light is still a fault, and too little is not."""

REACH = 0.99
"""Of the largest bet, which loses everything with a black picture."""

FIRST_SEED = 100
MOST_DECIMALS = 12

Evidence = Literal["proven", "statistical", "broken"]
Status = Literal["PASS", "FAIL", "UNDECIDED"]
Picture = NDArray[np.float32]
Truths = Callable[[Convention], Truth]


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """What was known after some pictures.

    Attributes
    ----------
    differences : PictureDifferences; of their means from the truth
    p : float; of a right renderer, so large a difference of any mean
    e : float; evidence of the bets, a mean over the means; 1 where they are not used
    """

    differences: PictureDifferences
    p: float
    e: float


@dataclass(frozen=True, slots=True, eq=False)
class PicturesVerdict:
    """What is said of a renderer.

    Attributes
    ----------
    status : 'PASS', 'FAIL' or 'UNDECIDED'
        Within the tolerance; other than the truth, or broken; neither is shown.
    evidence : 'proven', 'statistical', 'broken' or ''; what accuses
    sentence : str; why, with the mean minus the truth and its error
    looks : tuple of Look; after ever more pictures; empty where there were too few
    likenesses : tuple of Likeness; conventions with which wrong pictures agree
    wanted : int or None; pictures that would decide, where it is undecided
    negative : bool; whether a pixel was, so that nothing is proven of its light
    pixels : Moments or None; of all pictures, pixel by pixel
    bound : float or None; the user's word that was used, as in `judge_pictures`
    """

    status: Status
    evidence: Evidence | Literal[""]
    sentence: str
    convention: Convention
    tolerance: Tolerance
    truth: Truth
    looks: tuple[Look, ...] = ()
    likenesses: tuple[Likeness, ...] = ()
    wanted: int | None = None
    negative: bool = False
    pixels: Moments | None = None
    alpha: float = ALPHA
    bound: float | None = None


Outcome = tuple[Status, Evidence | Literal[""], str]


class _PicturesSeen:
    """Pictures so far, and what was known at each look."""

    def __init__(self, truth: Truth, tolerance: Tolerance, bound: float | None) -> None:
        self.truth, self.margins = truth, tolerance.margins(truth)
        self.bound, self.bets = bound, _open_bets(truth, bound)
        self.linear: list[NDArray[np.float64]] = []
        self.decoded: list[NDArray[np.float64]] = []
        self.looks: list[Look] = []
        self.negative = self.repeated = False
        self._mean = self._squares = np.zeros((1, 1, 3))
        self._known: set[bytes] = set()

    def add(self, picture: Picture) -> None:
        color = picture.astype(np.float64)
        means = tile_means(color)
        # Nothing comes by chance where there is no light, or a point lamp's alone.
        by_chance = bool(color.any()) and self.truth.deviation[0] > 0
        self.repeated |= by_chance and means.tobytes() in self._known
        self._known.add(means.tobytes())
        self.linear.append(means)
        self.decoded.append(tile_means(decode_srgb(np.clip(color, 0.0, 1.0))))
        self.negative |= bool((color < 0).any())
        if not self.negative:
            self.bets = place(self.bets, means.mean(axis=1))
        step = color - self._mean
        self._mean = self._mean + step / len(self.linear)
        self._squares = self._squares + step * (color - self._mean)

    @property
    def count(self) -> int:
        return len(self.linear)

    @property
    def e(self) -> float:
        return 1.0 if self.negative else average_e(e_value(self.bets))

    def look(self) -> Look:
        found = differences(columns(np.array(self.linear)), self.truth, self.negative)
        look = Look(found, bonferroni(p_values(found)), self.e)
        self.looks.append(look)
        return look

    def pixels(self) -> Moments | None:
        if not self.count:
            return None
        mean, squares = (a.reshape(-1, 3) for a in (self._mean, self._squares))
        return Moments(self.count, mean, squares)

    def likely(self, truths: Truths, asked: Convention) -> list[Likeness]:
        others = []
        with suppress(UnaskedError):  # those for which there is time
            for words, one in conventions(asked).items():
                others.append((words, truths(one)))
        about = np.array(self.linear), np.array(self.decoded), self.truth
        return likenesses(*about, others)


def judge_pictures(
    pictures: Iterator[Picture | Failure],
    truths: Truths,
    convention: Convention,
    tolerance: Tolerance,
    bound: float | None = None,
    alpha: float = ALPHA,
    tell: Callable[[int], None] = lambda count: None,
) -> PicturesVerdict:
    """Judge pictures until it is decided, or there are no more.

    Raises UnaskedError: there was no time to trace the truth.

    Parameters
    ----------
    pictures : iterator; of different seeds; ends when the time is over
    truths : callable; traces the truth of a convention, or has it
    bound : float or None
        The user's word that no mean of a tile of one picture exceeds so many times its
        truth; ``None`` where there is none.
    alpha : float; probability that a right renderer is accused
    tell : callable; told how many pictures there are
    """
    seen = _PicturesSeen(truths(convention), tolerance, bound)
    due = look_after(0)
    outcome: Outcome | None = None
    while outcome is None:
        picture = _next(pictures)
        if isinstance(picture, Failure):
            outcome = "FAIL", "broken", picture.reason
            if seen.count >= 2:
                seen.look()
        elif picture is not None:
            seen.add(picture)
            tell(seen.count)
        if outcome is None and (picture is None or _is_due(seen, due, alpha)):
            outcome = _outcome(seen, alpha, is_last=picture is None)
            due = look_after(seen.count)
    status, evidence, sentence = outcome
    wrong = status == "FAIL" and evidence != "broken"
    wanted = None
    if status == "UNDECIDED" and seen.looks and seen.truth.mean[0] > 0:
        last = seen.looks[-1].differences
        wanted = pictures_to_decide(last, seen.margins, len(seen.looks))
        sentence += _what_would_decide(wanted)
    return PicturesVerdict(
        status=status,
        evidence=evidence,
        sentence=sentence,
        convention=convention,
        tolerance=tolerance,
        truth=seen.truth,
        looks=tuple(seen.looks),
        likenesses=tuple(seen.likely(truths, convention)) if wrong else (),
        wanted=wanted,
        negative=seen.negative,
        pixels=seen.pixels(),
        alpha=alpha,
        bound=bound,
    )


def _open_bets(truth: Truth, bound: float | None) -> Bets:
    deviations = student_deviations(DEVIATIONS, truth.samples)
    mean, error = truth.mean[:PLACES], truth.standard_error[:PLACES]
    low, high = truth_interval(mean, error, deviations)
    # Light that the path tracer never met may be there all the same.
    high = np.where(mean < DARK * mean[0], np.maximum(high, DARK * mean[0]), high)
    most = np.maximum((bound or UNBOUNDED) * mean, high)
    return interval_bets(low, high, most, proven=bound is not None, reach=REACH)


def _next(pictures: Iterator[Picture | Failure]) -> Picture | Failure | None:
    with suppress(UnaskedError):
        return next(pictures, None)
    return None


def _is_due(seen: _PicturesSeen, due: int, alpha: float) -> bool:
    is_proven = seen.count >= FIRST_LOOK and seen.e >= 2 / alpha
    return seen.count >= due or is_proven or seen.repeated


def _outcome(seen: _PicturesSeen, alpha: float, is_last: bool) -> Outcome | None:
    """What a look decides; of the last one always something."""
    if seen.count < 2:
        few = "there was time for less than two pictures"
        return ("UNDECIDED", "", few) if is_last else None
    look = seen.look()
    if not seen.truth.mean[0] > 0:
        return "UNDECIDED", "", _BLACK
    if seen.repeated:
        return "FAIL", "broken", _REPEATED
    found, size = look.differences, _size_in_words(look.differences)
    share = share_of(len(seen.looks))
    # Half of α is for either kind of evidence.
    if look.e >= 2 / alpha:
        size = _size_in_words(found, int(np.argmax(e_value(seen.bets))))
        proof = "light is never negative, and that proves it"
        if seen.bound is not None:
            proof = f"light is never negative nor beyond {seen.bound:g} times its truth"
        return "FAIL", "proven", f"{size}: {proof}"
    if look.p <= alpha / 2 * share:
        size = _size_in_words(found, accused_first(found, alpha / 2 * share))
        odds = f"a right renderer is accused with probability {alpha:.1g}"
        return "FAIL", "statistical", f"{size}; {odds}"
    if within(found, seen.margins, MISSED * share).all():
        return "PASS", "", f"{size}: within the tolerance, and so is each tile"
    neither = "neither within the tolerance nor beyond chance"
    return ("UNDECIDED", "", f"{size}: {neither}") if is_last else None


def accused_first(found: PictureDifferences, p_accuses: float) -> int:
    """Column that is told: the picture if it is wrong, else a tile, else a channel."""
    p = p_values(found)
    is_wrong = p * len(p) <= p_accuses
    if is_wrong[0]:
        return 0
    return int(np.argmin(p[:PLACES] if is_wrong[:PLACES].any() else p))


_BLACK = (
    "the path tracer met no such light in this scene, so that there is nothing to be"
    " held against pictures: ask for other --light or more --bounces"
)

_REPEATED = (
    "pictures of two seeds are the same: either {seed} does nothing, or there is no"
    " noise in them that could be measured"
)


def _size_in_words(found: PictureDifferences, column: int = 0) -> str:
    """A mean minus its truth, with its standard error."""
    truth = found.truth[column]
    if truth > 0:
        error = float(found.error[column] / truth)
        told = with_error(float(found.relative[column]), error, 100) + " % of its truth"
    else:
        told = f"{found.difference[column]:.3g}, where no light should be"
    where = name_of(column)
    return f"the mean of {where} in {found.count} pictures is off by {told}"


def with_error(value: float, error: float | None, factor: float = 1.0) -> str:
    """A signed number with its standard error, which has two digits.

    Parameters
    ----------
    error : float or None; where none is known
    factor : float; on both: 100 for per cent
    """
    scaled = factor * value
    if not error:
        return f"{scaled:+.3g}"
    decimals = min(max(1 - floor(log10(factor * error)), 0), MOST_DECIMALS)
    return f"{scaled:+.{decimals}f} ± {factor * error:.{decimals}f}"


def _what_would_decide(wanted: int | None) -> str:
    if wanted is None:
        return "; more pictures alone would not decide: the truth is not exact enough"
    return f"; about {wanted:,} pictures would decide"

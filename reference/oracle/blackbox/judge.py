"""A verdict on a renderer of which nothing is known but its pictures."""

from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from itertools import count
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.oracle.blackbox.renderer import Renderer
from restir_gi.reference.oracle.blackbox.truth import TILES, Truth, statistics
from restir_gi.reference.oracle.cases import NO_TIME, Failure, UnaskedError
from restir_gi.reference.oracle.levels.probe import Finding
from restir_gi.reference.oracle.statistics.betting import (
    Bets,
    e_value,
    interval_bets,
    place,
)
from restir_gi.reference.oracle.statistics.families import average_e
from restir_gi.reference.oracle.statistics.intervals import (
    outside_probability,
    student_deviations,
    truth_interval,
)
from restir_gi.reference.oracle.steps import Level, LevelStep

ALPHA = 5e-7
DEVIATIONS = 6.0
"""Standard errors about the truth that count as it: one of 17 truths lies outside with
probability 3e-8, if the means of many paths are normal."""

UNBOUNDED = 8.0
"""Pictures are cut at so many times the truth, where no bound was declared; a cut mean
is no larger, so that too much light is still a fault, and too little is not."""


FIRST_SEED = 100

Pictures = Callable[[Iterator[int]], Iterator[NDArray[Any] | Failure]]


def renderer_levels(
    renderer: Renderer,
    truth: Callable[[], Truth],
    bound: float | None,
    remaining: Callable[[], float],
    pictures: Pictures | None = None,
) -> Iterator[Level]:
    """Levels for pictures.

    Parameters
    ----------
    truth : callable; traces it; asked for when it is wanted
    bound : float or None
        The user's word that no mean of a tile of one picture exceeds so many times its
        truth; ``None`` where there is none.
    remaining : callable; seconds that are left
    pictures : callable, optional
        From seeds to the renderer's pictures, in order; by default one after the
        other is rendered here.

    Yields
    ------
    level, title : str; of the next step
    callable; takes it
    """
    yield "L2", "seeds", lambda: LevelStep("L2", "seeds", findings=[_seeds(renderer)])
    rendered = (pictures or partial(map, renderer.render))(count(FIRST_SEED))
    yield "L4", "mean", lambda: _mean(rendered, truth(), bound, remaining)


def _seeds(renderer: Renderer) -> Finding:
    """The same seed gives the same picture, and another one another."""
    pictures = []
    for seed in (1, 1, 2):
        picture = renderer.render(seed)
        if isinstance(picture, Failure):
            return Finding(False, picture.reason)
        pictures.append(picture)
    again, other = (np.array_equal(pictures[0], p) for p in pictures[1:])
    if not again:
        return Finding(False, "two pictures of one seed differ")
    if other:
        return Finding(False, "pictures of two seeds are the same: runs repeat")
    return Finding(True)


def _mean(
    pictures: Iterator[NDArray[Any] | Failure],
    truth: Truth,
    bound: float | None,
    remaining: Callable[[], float],
) -> LevelStep:
    deviations = student_deviations(DEVIATIONS, truth.samples)
    low, high = truth_interval(truth.mean, truth.standard_error, deviations)
    most = np.maximum((bound or UNBOUNDED) * truth.mean, high)
    bets = interval_bets(low, high, most, proven=bound is not None)
    runs = 0
    for picture in _until_the_time_is_over(pictures, remaining):
        if isinstance(picture, Failure):
            found: Finding | None = Finding(False, picture.reason)
        else:
            bets, runs = place(bets, statistics(picture)), runs + 1
            found = _accused(bets, truth.mean, runs)
        if found is not None:
            return LevelStep("L4", f"mean of {runs} pictures", findings=[found])
    if runs < 2:
        raise UnaskedError(NO_TIME.reason)
    more, title = _more(bets, bound, runs), f"mean of {runs} pictures"
    return LevelStep("L4", title, findings=[Finding(True)], more=more)


def _until_the_time_is_over(
    pictures: Iterator[NDArray[Any] | Failure], remaining: Callable[[], float]
) -> Iterator[NDArray[Any] | Failure]:
    with suppress(UnaskedError):
        for picture in pictures:
            yield picture
            if remaining() <= 0:
                return


def _accused(bets: Bets, truth: Scalars, runs: int) -> Finding | None:
    e = e_value(bets)
    if average_e(e) < 1 / ALPHA:
        return None
    column = int(np.argmax(e))
    where = "the picture" if column == 0 else f"tile {_tile(column - 1)}"
    mean = float(bets.mean[column] * bets.bound[column])
    off = mean / truth[column] - 1 if truth[column] > 0 else np.inf
    chance = ALPHA + outside_probability(DEVIATIONS, len(truth))
    return Finding(
        False,
        f"{where} is {off:+.3g} relative to the truth after {runs} pictures; a right"
        f" renderer is accused with probability {chance:.1g}",
    )


def _tile(number: int) -> str:
    return f"({number % TILES}, {number // TILES})"


def _more(bets: Bets, bound: float | None, runs: int) -> str:
    deviation = np.sqrt(bets.squares[0] / max(runs - 1, 1)) / max(bets.mean[0], 1e-9)
    room = f"{3 * float(deviation) / runs**0.5:.2g}"
    if bound is None:
        return (
            f"{runs} pictures are not too bright, to about {room}; whether they are too"
            " dark is asked with --bound"
        )
    return f"{runs} pictures are right to about {room}; four times as many halve that"

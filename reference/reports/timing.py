"""Seconds by turns: whatever else the machine does slows all of them alike."""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Generic, NamedTuple, TypeVar

from restir_gi.reference.numerics.intervals import Interval, median_interval

Result = TypeVar("Result")
Name = TypeVar("Name")

TURNS = 9


class Lap(NamedTuple, Generic[Result]):
    """One call.

    Attributes
    ----------
    result : any; what it returned
    seconds : float; how long it took
    """

    result: Result
    seconds: float


def timed(call: Callable[[], Result]) -> Lap[Result]:
    """Call, and look at the clock before and after.  Result and seconds.

    Parameters
    ----------
    call : callable; without arguments, as ``frames.__next__`` of a run
    """
    start = time.perf_counter()
    result = call()
    return Lap(result, time.perf_counter() - start)


def in_turns(
    calls: Mapping[Name, Callable[[], Result]], turns: int = TURNS
) -> Iterator[dict[Name, Lap[Result]]]:
    """Call one after the other, turn by turn, of one turn, by name.

    Parameters
    ----------
    calls : mapping of any to callable; by name, in the order of a turn
    """
    for _ in range(turns):
        yield {name: timed(call) for name, call in calls.items()}


def seconds_in_turns(
    calls: Mapping[Name, Callable[[], object]], turns: int = TURNS
) -> dict[Name, list[float]]:
    """Seconds of calls whose results do not matter; a number a turn."""
    laps = list(in_turns(calls, turns))
    return {name: [turn[name].seconds for turn in laps] for name in calls}


def time_ratio(above: Sequence[float], below: Sequence[float]) -> Interval:
    """How much longer one call takes than another.  Median of the ratios of the turns.

    Parameters
    ----------
    above, below : sequence of float; seconds of the same turns
    """
    return median_interval([a / b for a, b in zip(above, below, strict=True)])

"""Functions timed in turns: what else the machine does slows all of them alike."""

import statistics
import time
from collections.abc import Callable, Sequence

from scipy.stats import quantile_test

TURNS = 9


def timed(function: Callable[[], object]) -> float:
    """Seconds of one call."""
    start = time.perf_counter()
    function()
    return time.perf_counter() - start


def in_turns(*functions: Callable[[], object], turns: int = TURNS) -> list[list[float]]:
    """Seconds of each function, in each turn."""
    rounds = [[timed(f) for f in functions] for _ in range(turns)]
    return [list(column) for column in zip(*rounds, strict=True)]


def ratio(above: Sequence[float], below: Sequence[float]) -> str:
    """Median of the ratios of the turns, with its 95 % interval.

    The interval is that of the sign test: between two of the sorted ratios, whatever
    their law.  Of 9 turns it reaches from the second to the eighth, at 96 %.
    """
    ratios = [a / b for a, b in zip(above, below, strict=True)]
    test = quantile_test(ratios, p=0.5)
    low, high = test.confidence_interval(0.95)
    return f"{statistics.median(ratios):.2f} [{low:.2f}, {high:.2f}]"

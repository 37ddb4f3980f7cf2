"""Functions timed in turns: what else the machine does slows all of them alike."""

import time
from collections.abc import Callable, Sequence

from reference.medians import median_interval

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
    """Median of the ratios of the turns, with its 95 % interval."""
    ratios = [a / b for a, b in zip(above, below, strict=True)]
    return "{:.2f} [{:.2f}, {:.2f}]".format(*median_interval(ratios))

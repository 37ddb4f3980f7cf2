"""The smallest bias of a choice that captured frames reveal.

From the root of the checkout, some minutes::

    python -m tests.benchmarks.choices

In each row of a frame of 256 × 256 pixels a candidate is kept with probability p, but
by mistake with (1 + b) p.  Printed is the b from which half of the captures are accused
at a false-alarm rate of 1e-6 shared among all passes, candidates and strata; and beside
it that which a normal quantile would allow for one sum alone.
"""

import numpy as np
from scipy.stats import norm

from restir_gi.reference.oracle.capture.choices import (
    EVERYWHERE,
    FALSE_ALARM,
    evidence_needed,
)
from restir_gi.reference.oracle.statistics.choices import Chances, wins

ROWS, CANDIDATES, TRIALS = 256 * 256, 4, 41


def accused(rng, p, bias, frames):
    """Share of captures that are accused."""
    limit = evidence_needed(CANDIDATES, EVERYWHERE)
    chance = np.full(ROWS, p)
    found = 0
    for _ in range(TRIALS):
        captured = [
            Chances(rng.random(ROWS) < p * (1 + bias), chance, chance)
            for _ in range(frames)
        ]
        found += wins(captured, frames).log_e >= limit
    return found / TRIALS


def smallest(rng, p, frames):
    """Bias at which half of the captures are accused."""
    low, high = 0.0, 20 * np.sqrt((1 - p) / (p * ROWS * frames))
    for _ in range(7):
        middle = (low + high) / 2
        if accused(rng, p, middle, frames) < 0.5:
            low = middle
        else:
            high = middle
    return (low + high) / 2


def main():
    """Print the table."""
    rng = np.random.default_rng(5)
    print("probability  frames  smallest bias  what its variance allows")
    for frames in (1, 16):
        for p in (0.5, 0.2, 0.05, 0.01):
            allows = norm.isf(FALSE_ALARM / 2) * np.sqrt((1 - p) / (p * ROWS * frames))
            found = smallest(rng, p, frames)
            print(f"{p:11g}  {frames:6}  {100 * found:11.2f} %  {100 * allows:.2f} %")


if __name__ == "__main__":
    main()

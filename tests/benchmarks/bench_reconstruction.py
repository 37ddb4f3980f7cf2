"""How the time of least squares grows with the image.

python -m tests.benchmarks.bench_reconstruction
"""

from functools import partial

import numpy as np

from restir_gi.gradient_domain.reconstruction import differences, least_squares
from restir_gi.reference.reports.timing import seconds_in_turns

SIZES = ((480, 270), (960, 540), (1920, 1080), (3840, 2160))
REPEATS = 5


def main() -> None:
    """Measure by turns, and print medians."""
    calls = {}
    for width, height in SIZES:
        image = np.random.default_rng(0).random((width * height, 3))
        calls[width, height] = partial(
            least_squares, image, differences(image, width), width
        )
    for (width, height), spent in seconds_in_turns(calls, REPEATS).items():
        median = float(np.median(spent))
        each = 1e9 * median / (width * height)
        print(f"{width} x {height}: {median:.3f} s, {each:.0f} ns a pixel")


if __name__ == "__main__":
    main()

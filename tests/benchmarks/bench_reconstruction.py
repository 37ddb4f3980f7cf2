"""How the time of least squares grows with the image.

python -m tests.benchmarks.bench_reconstruction
"""

import time

import numpy as np

from gradient_domain.differences import differences
from gradient_domain.reconstruction import least_squares

SIZES = ((480, 270), (960, 540), (1920, 1080), (3840, 2160))
REPEATS = 5


def main() -> None:
    """Measure by turns, and print medians."""
    times: dict[tuple[int, int], list[float]] = {size: [] for size in SIZES}
    given = {}
    for width, height in SIZES:
        image = np.random.default_rng(0).random((width * height, 3))
        given[width, height] = image, differences(image, width)
    for _ in range(REPEATS):
        for width, height in SIZES:
            primal, d = given[width, height]
            start = time.perf_counter()
            least_squares(primal, d, width)
            times[width, height].append(time.perf_counter() - start)
    for (width, height), spent in times.items():
        median = float(np.median(spent))
        each = 1e9 * median / (width * height)
        print(f"{width} x {height}: {median:.3f} s, {each:.0f} ns a pixel")


if __name__ == "__main__":
    main()

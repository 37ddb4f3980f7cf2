"""Lesson 8: a line of pixels from differences. Something is wrong with it."""

import numpy as np


def reconstructed(primal, d, alpha):
    """Least squares of α (I − P) and D I − d, with (D I)_i = I_{i+1} − I_i."""
    count = len(primal)
    D = np.zeros((count - 1, count))
    rows = np.arange(count - 1)
    D[rows, rows], D[rows, rows + 1] = 1.0, -1.0
    left = alpha**2 * np.eye(count) + D.T @ D
    return np.linalg.solve(left, alpha**2 * primal + D.T @ d)


def check():
    """Differences of a slope give the slope back, about the mean of the pixels."""
    slope = np.linspace(0.0, 1.0, 9)
    found = reconstructed(np.full(9, 0.5), np.diff(slope), 1e-3)
    off = abs(found - slope).max()
    assert off < 1e-3, f"wrong by up to {off:.3f}"


if __name__ == "__main__":
    check()
    print("right")

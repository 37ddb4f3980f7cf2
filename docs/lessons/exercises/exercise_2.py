"""Lesson 2: the weight of a kept sample. Something is wrong with it."""

import numpy as np

XS, Q = np.array([0, 1, 2]), np.array([0.5, 0.25, 0.25])
P_HAT, F = np.array([1.0, 2.0, 3.0]), np.array([2.0, 1.0, 5.0])


def contribution_weight(candidates, kept):
    """W of the candidate number ``kept`` among candidates 0, 1 or 2."""
    w = [P_HAT[x] / Q[x] for x in candidates]
    return sum(w) / len(w) / P_HAT[candidates[0]]


def check():
    """All nine pairs and both choices: E[f W] is the sum of f, exactly."""
    expectation = 0.0
    for a in XS:
        for b in XS:
            w = np.array([P_HAT[a] / Q[a], P_HAT[b] / Q[b]])
            for kept, y in enumerate((a, b)):
                chance = Q[a] * Q[b] * w[kept] / w.sum()
                expectation += chance * F[y] * contribution_weight((a, b), kept)
    assert abs(expectation - F.sum()) < 1e-12, (
        f"expectation {expectation:.4f} instead of {F.sum()}"
    )


if __name__ == "__main__":
    check()
    print("right")

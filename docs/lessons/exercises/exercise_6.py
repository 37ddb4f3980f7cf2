"""Lesson 6: the divisor Z. Something is wrong with it."""

from itertools import product

# Two pixels and two points; the second pixel does not see point 1.
TARGET = ((1.0, 3.0), (2.0, 5.0))
SEES = ((True, True), (True, False))


def divisor(kept, M):
    """Z of the sample ``kept``, for reservoirs of confidences M at both pixels."""
    return sum(M[k] for k in (0, 1) if TARGET[k][kept] > 0)


def check():
    """All that can happen, exactly: the expectation of W at either point is 1.

    Each pixel draws one point, uniformly among those that it sees.
    """
    expectation = [0.0, 0.0]
    for own, near in product((0, 1), repeat=2):
        chance = (0.5 if SEES[0][own] else 0.0) * (1.0 if SEES[1][near] and near == 0
                                                   else 0.0)  # fmt: skip
        w = TARGET[0][own] * 2.0, TARGET[0][near] * 1.0
        for share, kept in ((w[0], own), (w[1], near)):
            W = sum(w) / (TARGET[0][kept] * divisor(kept, (1, 1)))
            expectation[kept] += chance * share / sum(w) * W
    assert max(abs(e - 1) for e in expectation) < 1e-12, (
        f"expectations of W: {expectation[0]:.3f} and {expectation[1]:.3f} instead of 1"
    )


if __name__ == "__main__":
    check()
    print("right")

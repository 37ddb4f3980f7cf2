"""Lesson 3: two closed reservoirs become one. Something is wrong with it."""

import numpy as np


def combined(p_hat_a, W_a, M_a, p_hat_b, W_b, M_b):
    """Probability of the second sample, and W of each sample if it is the one kept."""
    w_a, w_b = p_hat_a * W_a, p_hat_b * W_b
    M = M_a + M_b
    share = w_b / (w_a + w_b)
    return share, (w_a + w_b) / (M * p_hat_a), (w_a + w_b) / (M * p_hat_b)


def check():
    """E[f W] over both outcomes is the mean over all candidates, however many each saw.

    Each reservoir estimates the integral by f W alone; together they estimate it by the
    mean of the two, weighted by how many candidates stand behind each.
    """
    rng = np.random.default_rng(1)
    for M_a, M_b in ((1, 1), (4, 4), (1, 7), (30, 2)):
        p_a, p_b, W_a, W_b = rng.uniform(0.5, 2.0, 4)
        share, if_a, if_b = combined(p_a, W_a, M_a, p_b, W_b, M_b)
        expectation = (1 - share) * p_a * if_a + share * p_b * if_b
        wanted = (M_a * p_a * W_a + M_b * p_b * W_b) / (M_a + M_b)
        assert abs(expectation - wanted) < 1e-12, (
            f"M = {M_a} and {M_b}: {expectation:.4f} instead of {wanted:.4f}"
        )


if __name__ == "__main__":
    check()
    print("right")

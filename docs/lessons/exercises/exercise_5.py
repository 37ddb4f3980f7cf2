"""Lesson 5: a reservoir over many frames. Something is wrong with it."""

import numpy as np

CAP = 8


def next_reservoir(w, p_hat, M, new_p_hat, pdf, u):
    """One more sample: the sum of weights, the target of the sample kept, M, and W."""
    M = min(M, CAP)
    new_w = new_p_hat / pdf
    w = w + new_w
    if u * w < new_w:
        p_hat = new_p_hat
    M = M + 1
    W = w / (M * p_hat) if p_hat > 0 else 0.0
    return w, p_hat, M, W


def check():
    """A target that is the same for all samples: p̂ W is 1 / pdf in every frame."""
    w, p_hat, M = 0.0, 0.0, 0
    u = np.random.default_rng(0).random(40)
    for frame in range(40):
        w, p_hat, M, W = next_reservoir(w, p_hat, M, 0.5, 0.25, u[frame])
        assert abs(0.5 * W - 2.0) < 1e-9, (
            f"frame {frame}: p̂ W = {0.5 * W:.3f} instead of 2"
        )


if __name__ == "__main__":
    check()
    print("right")

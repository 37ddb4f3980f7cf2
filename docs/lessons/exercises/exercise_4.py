"""Lesson 4: the Jacobian of reconnection. Something is wrong with it."""

import numpy as np


def jacobian(x_from, x_to, x_sample, n_sample):
    """Ratio of the solid angle of a patch as seen by x_to, to that seen by x_from."""
    v_from, v_to = x_from - x_sample, x_to - x_sample
    d_from, d_to = np.linalg.norm(v_from), np.linalg.norm(v_to)
    cos_from = abs(n_sample @ v_from) / d_from
    cos_to = abs(n_sample @ v_to) / d_to
    return (cos_to / cos_from) * (d_to**2 / d_from**2)


def check():
    """All of the light of a small lamp arrives, whoever drew the direction.

    A lamp of area A: the mean of J over directions that x_from draws uniformly within
    its solid angle, times that angle, is the angle that x_to sees.
    """
    x_from, x_to = np.array([0.0, 0.0, 2.0]), np.array([1.0, 0.0, 1.0])
    up, area = np.array([0.0, 0.0, 1.0]), 1e-4

    def seen(x):
        return area * abs(up @ x) / np.linalg.norm(x) ** 3

    found = jacobian(x_from, x_to, np.zeros(3), up) * seen(x_from)
    assert abs(found / seen(x_to) - 1) < 1e-12, (
        f"solid angle {found:.3e} instead of {seen(x_to):.3e}"
    )


if __name__ == "__main__":
    check()
    print("right")

"""Lesson 7: the key of a cell. Something is wrong with it."""

from math import floor, log2

LEAST, BASE = 1e-3, 0.02


def key_of(point, eye):
    """Integers that tell cells apart: cells grow with the distance to the eye."""
    distance = sum((p - e) ** 2 for p, e in zip(point, eye, strict=True)) ** 0.5
    level = max(floor(log2(max(distance * BASE / LEAST, 1.0))), 0)
    edge = LEAST * 2**level
    return tuple(floor(p / edge) for p in point)


def check():
    """Two points share a key only where they lie in one cube of one size."""
    eye = (0.0, 0.0, 0.0)
    near, far = (0.05, 0.3, 0.05), (0.1, 0.6, 0.1)
    apart = sum((a - b) ** 2 for a, b in zip(near, far, strict=True)) ** 0.5
    assert key_of(near, eye) != key_of(far, eye), (
        f"points {apart:.2f} m apart share the key {key_of(near, eye)}"
    )


if __name__ == "__main__":
    check()
    print("right")

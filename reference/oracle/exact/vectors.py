"""Vectors of exact numbers."""

from restir_gi.reference.oracle.exact.numbers import Exact

Vector = tuple[Exact, Exact, Exact]


def inner(a: Vector, b: Vector) -> Exact:
    """Inner product, summed from the first component on."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def minus(a: Vector, b: Vector) -> Vector:
    """Difference of vectors."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]

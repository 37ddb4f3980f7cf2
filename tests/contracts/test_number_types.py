"""Kernels run on any number type, and hand back the type that they were given.

That is how the code which renders is also the code which is proved: by enumeration in
fractions, and against mpmath.
"""

from dataclasses import fields
from fractions import Fraction

import mpmath
import numpy as np
import pytest

from restir_gi.reference.numerics.arrays import (
    cross,
    divide_or_zero,
    dot,
    length,
    normalize,
    sqrt,
)
from restir_gi.reference.numerics.frames import turn
from restir_gi.reference.resampling.jacobian_limits import clamp_jacobian
from restir_gi.reference.resampling.pairwise import (
    pairwise_canonical,
    pairwise_neighbor,
)
from restir_gi.reference.resampling.reservoir import (
    Candidates,
    Reservoirs,
    balance_heuristic,
    cap_confidence,
    choose_second,
    finalize,
    initial_candidates,
    merge,
    one_over_m,
    one_over_z,
    reused_candidates,
)
from restir_gi.reference.resampling.shift import reconnection_jacobian

FLOATS = [np.float16, np.float32, np.float64, np.longdouble]
OBJECTS = [Fraction, mpmath.mpf]

# Values that all types hold exactly; a row whose weights are 0 among them.
P_HAT, PDF = [2, 0, 0.5], [0.25, 1, 0]
W, M = [4, 0, 0.125], [3, 1, 16]
U = [0.25, 0.5, 0.75]

# Distances 9 to 7 and 13 to 13, and a point that touches the patch.
EYE = [[0, 0, 0], [8, 0, 0], [6, 6, 3]]
OTHER = [[8, 0, 0], [0, 0, 0], [8, 0, 0]]
PATCH = [[6, 6, 3], [4, 12, 3], [6, 6, 3]]
NORMAL = [[0, -1, 0], [0, -0.5, 0.25], [0, -1, 0]]


def numbers(kind):
    """Convert lists to arrays of a kind of number."""

    def convert(values):
        if kind in FLOATS:
            return np.array(values, kind)
        flat = [kind(x) for x in np.ravel(np.array(values, float)).tolist()]
        return np.array(flat, object).reshape(np.shape(values))

    return convert


def numbers_of(result):
    """All arrays of numbers that a kernel returned, but no masks."""
    if isinstance(result, Candidates | Reservoirs):
        result = [getattr(result, f.name) for f in fields(result) if f.name != "y"]
    return result if isinstance(result, list | tuple) else [result]


def samples(a):
    return np.arange(len(a(M)))


def opened(a):
    return initial_candidates(samples(a), a(P_HAT), a(PDF))


def reopened(a):
    r = Reservoirs(samples(a), a(W), a(M))
    return reused_candidates(r, a(P_HAT), a(PDF))


def merged(a):
    return merge(opened(a), reopened(a), a(U))


HOLDS = [np.array([True, False, True]), np.array([True, False, False])]

KERNELS = {
    "dot": lambda a: dot(a(EYE), a(OTHER)),
    "cross": lambda a: cross(a(EYE), a(OTHER)),
    "turn": lambda a: turn(a(EYE), a(OTHER)),
    "length": lambda a: length(a(EYE)),
    "sqrt": lambda a: sqrt(a([4, 0.25, 0])),
    "normalize": lambda a: normalize(a(EYE)),
    "divide_or_zero": lambda a: divide_or_zero(a(P_HAT), a(PDF)),
    "initial_candidates": opened,
    "reused_candidates": reopened,
    "merge": merged,
    "finalize": lambda a: finalize(merged(a), a(M)),
    "cap_confidence": lambda a: cap_confidence(finalize(merged(a), a(M)), 2),
    "no cap": lambda a: cap_confidence(finalize(merged(a), a(M)), float("inf")),
    "one_over_m": lambda a: one_over_m([a(M), a(W)]),
    "one_over_z": lambda a: one_over_z([a(M), a(W)], HOLDS),
    "pairwise_neighbor": lambda a: pairwise_neighbor(
        a(M), a(U), a(W), a(PDF), a(M) + a(M), False
    ),
    "defensive neighbor": lambda a: pairwise_neighbor(
        a(M), a(U), a(W), a(PDF), a(M) + a(M), True
    ),
    "pairwise_canonical": lambda a: pairwise_canonical(
        [a(M), a(W)], [a(U), a(PDF)], a(M), a(P_HAT), False
    ),
    "defensive canonical": lambda a: pairwise_canonical(
        [a(M), a(W)], [a(U), a(PDF)], a(M), a(P_HAT), True
    ),
    "clamp_jacobian": lambda a: clamp_jacobian(a(P_HAT), a([2])[0]),
    "balance_heuristic": lambda a: balance_heuristic([a(M), a(W)], [a(U)] * 2, a(PDF)),
    "reconnection_jacobian": lambda a: reconnection_jacobian(
        a(EYE), a(OTHER), a(PATCH), a(NORMAL)
    ),
}  # fmt: skip

every_kernel = pytest.mark.parametrize("kernel", KERNELS.values(), ids=KERNELS)


@every_kernel
@pytest.mark.parametrize("kind", FLOATS)
def test_floats_keep_their_type(kernel, kind):
    for array in numbers_of(kernel(numbers(kind))):
        assert array.dtype == kind


@every_kernel
@pytest.mark.parametrize("kind", OBJECTS)
def test_objects_keep_their_type(kernel, kind):
    """Whole numbers may stay int: M of a new sample is a count."""
    for array in numbers_of(kernel(numbers(kind))):
        assert array.dtype == object
        assert {type(x) for x in array.ravel()} <= {kind, int}


@every_kernel
def test_all_types_agree(kernel):
    """The inputs are short binary numbers: float64 and fractions differ by rounding.

    No kernel here takes more than 32 roundings, none cancels.
    """
    exact = numbers_of(kernel(numbers(Fraction)))
    with mpmath.workdps(30):
        for kind in [*FLOATS, mpmath.mpf]:
            eps = float(np.finfo(kind).eps if kind in FLOATS else mpmath.eps)
            found = numbers_of(kernel(numbers(kind)))
            for a, b in zip(found, exact, strict=True):
                off = abs(a.astype(object) - b)
                assert (off <= 32 * max(eps, 2.0**-52) * abs(b)).all()


@pytest.mark.parametrize("kind", FLOATS + OBJECTS)
def test_a_choice_is_a_mask(kind):
    a = numbers(kind)
    taken = choose_second(a(W), a(M), a(U))
    assert taken.dtype == bool
    assert taken.tolist() == [True, True, True]


def test_control_a_constant_that_forces_a_type_is_found():
    """What the rules of promotion do to a NumPy scalar, unlike to a Python one."""
    x = np.ones(3, np.float32)
    assert (x * np.float64(0.5)).dtype == np.float64
    assert (x * 0.5).dtype == np.float32

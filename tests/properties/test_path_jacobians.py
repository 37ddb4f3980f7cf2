"""Jacobians of shifts against finite differences of the whole mapping.

From the random numbers of a base path to those with which the other pixel would draw
the shifted one: T.  Numbers that are replayed stay the same, and those that choose
lights too; the matrix of the others is of the four that choose the directions at
x_(c-1) and x_c, or of the first two where a light that is chosen follows x_c.
"""

from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from tests.mutants.plant import planted
from tests.properties.path_inverses import derivatives
from tests.properties.path_numbers import SOLVED, joined, solved

CASES = [
    ("paint", "hybrid"),
    ("rough metal", "hybrid"),
    ("glossy metal", "hybrid"),
    ("glossy metal", "reconnection"),
    ("mirror", "hybrid"),
    ("glass", "hybrid"),
    ("many-lights", "reconnection"),
    ("far", "hybrid"),
    ("near", "reconnection"),
]
each_case = pytest.mark.parametrize(("name", "kind"), CASES)

H = 1e-4
"""Half the step of the differences, and then half of that."""

INNER = 0.01
"""First numbers closer to 0 or 1 are left out: there T has no bounded derivatives."""


@cache
def differences(name, kind, frame):
    """|∂T / ∂u| of some rows, extrapolated from two steps, and what it may be off."""
    found, u, v, error = solved(name, kind, frame)
    first = np.concatenate([u[:, ::2], v[:, ::2]], axis=1)
    first[found.joints.chosen, 1::2] = 0.5
    inner = np.all((first > INNER) & (first < 1 - INNER), axis=1)
    rows = np.flatnonzero(inner & (error < SOLVED))
    joints, u, v = found.joints.of(rows), u[rows], v[rows]
    coarse, fine = (
        np.abs(np.linalg.det(derivatives(lambda a: joints.mapped(a, v)[0], u, h)))
        for h in (H, H / 2)
    )
    # The better of both is off by a third of their difference; hits by float32.
    allowed = np.abs(fine - coarse) / fine + joints.rounding(u)
    return rows, (4 * fine - coarse) / 3, allowed


def errors(name, kind, frame=0):
    """Of the stated Jacobians, relative, and what is allowed."""
    rows, determinant, allowed = differences(name, kind, frame)
    jacobian = joined(name, kind, frame).jacobian
    assert len(jacobian) == len(solved(name, kind, frame)[1])
    return np.abs(jacobian[rows] / determinant - 1), allowed


@each_case
def test_the_jacobian_is_that_of_the_whole_mapping(name, kind):
    error, allowed = errors(name, kind)
    assert len(error) > 50
    # Else these would be the paths that are easy.
    assert np.mean(solved(name, kind, 0)[-1] < SOLVED) > 0.95
    assert (error <= allowed).all()
    assert np.median(allowed) < (1e-3 if name == "near" else 1e-5)


@pytest.mark.slow
@each_case
def test_the_jacobian_is_that_of_the_whole_mapping_in_many_frames(name, kind):
    parts = [errors(name, kind, frame) for frame in range(1, 13)]
    error, allowed = (np.concatenate(part) for part in zip(*parts, strict=True))
    sizes = np.median(error), error.max(), np.median(allowed), allowed.max()
    print(name, kind, len(error), *(f"{size:.2g}" for size in sizes))  # noqa: T201
    assert (error <= allowed).all()


# ------------------------------------------------------------ controls

BASE = "step.pdf * step.came.spread * pdf"
OFFSET = "p_left * came.spread * p_onward"
SPREAD = "divide_or_zero(cosine, distance**2)"


def densities(base, offset):
    """Of both, so that such shifts would still lead home."""
    return [
        ("restir_gi.extensions.candidates", BASE, base),
        ("restir_gi.extensions.shifting", OFFSET, offset),
    ]


def spread(wrong):
    return [("restir_gi.extensions.shifting", SPREAD, wrong)]


@pytest.mark.parametrize(
    ("edits", "least"),
    [
        (densities("step.came.spread * pdf", "came.spread * p_onward"), 0.9),
        (densities("step.pdf * pdf", "p_left * p_onward"), 0.9),
        (densities("step.pdf * step.came.spread", "p_left * came.spread"), 0.1),
        (spread("divide_or_zero(np.ones_like(cosine), distance**2)"), 0.9),
        (spread("divide_or_zero(cosine, distance)"), 0.9),
        (
            [
                (
                    "restir_gi.extensions.shifting",
                    "zero(density, base)",
                    "zero(base, density)",
                )
            ],
            0.9,
        ),
    ],
    ids=[
        "without the first density",
        "without geometry",
        "without the second density",
        "without cosine",
        "distance once",
        "upside down",
    ],
)
def test_control_another_ratio_is_refuted(edits, least):
    # What is kept is found without the mistake.
    differences("rough metal", "hybrid", 0)
    with planted(SimpleNamespace(edits=edits)):
        error, allowed = errors("rough metal", "hybrid")
    assert np.mean(error > allowed) > least

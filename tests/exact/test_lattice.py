"""Floats integrated without sampling: uniforms on a lattice that divides each decision.

Weights are whole numbers, so a decision compares u with w / S for whole w and S.  On
the midpoints of D cells, D a multiple of every S that occurs, it comes out yes exactly
D w / S times, and no threshold is closer than 1 / 2D to a midpoint: no rounding excuses
a flip.  The mean over the lattice *is* the expectation, for any backend that takes its
uniforms as data.  The tolerance is the rounding of one row.
"""

import itertools
import math
from fractions import Fraction

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from restir_gi.reference.resampling import reservoir
from restir_gi.reference.resampling.reservoir import (
    Candidates,
    Reservoirs,
    finalize,
    initial_candidates,
    merge,
    one_over_z,
    reused_candidates,
)

DTYPES = [np.float16, np.float32, np.float64]

PDF = [0.25, 0.5, 2.0]
"""Source densities of three candidates: powers of two, so that p̂ / p is exact."""

WEIGHTS = (0, 1, 2)
"""p̂ / p of a candidate, each with probability 1/3; 0 is a null."""

F = [3.0, -1.25, 0.625]
"""Integrand at the three candidates."""

CELLS = (12, 60)
"""Least common multiples of the sums 1..4 and 1..6 that two merges meet."""


def midpoints(cells):
    return (np.arange(cells) + 0.5) / cells


def lattice(dtype, finer=1):
    """All weights of three candidates with all decisions: columns of equal weight."""
    grid = np.meshgrid(
        *[WEIGHTS] * 3, *(midpoints(cells * finer) for cells in CELLS), indexing="ij"
    )
    return [column.ravel().astype(dtype) for column in grid]


def stream(dtype, finer=1):
    """Three candidates resampled on the lattice: their weights, who was kept, and W."""
    *weights, u2, u3 = lattice(dtype, finer)
    candidates = [
        initial_candidates(np.full(len(w), i), w * dtype(p), np.full(len(w), p, dtype))
        for i, (w, p) in enumerate(zip(weights, PDF, strict=True))
    ]
    both = merge(candidates[0], candidates[1], u2)
    kept = merge(both, candidates[2], u3)
    return weights, finalize(kept, kept.M)


def mean_estimate(dtype, finer=1):
    """Mean of f(y) W over the lattice, each row rounded as the number type does."""
    _, r = stream(dtype, finer)
    assert r.W.dtype == dtype
    values = np.array(F, dtype)[r.y] * r.W
    return math.fsum(values.astype(float)) / len(values)


def exact_estimate():
    """1/3 Σ f_i / p_i · P(w_i > 0), and the same of |f|."""
    terms = [Fraction(f) / Fraction(p) for f, p in zip(F, PDF, strict=True)]
    share = Fraction(2, 3) / 3
    return float(sum(terms) * share), float(sum(map(abs, terms)) * share)


def tolerance(dtype):
    """Three roundings of half an eps in each row: two quotients and f W."""
    return 1.5 * float(np.finfo(dtype).eps) * exact_estimate()[1]


@pytest.mark.parametrize("dtype", DTYPES)
def test_each_candidate_is_kept_exactly_as_often_as_it_weighs(dtype):
    """Counted in whole numbers, for each combination of weights."""
    weights, r = stream(dtype)
    per_combination = math.prod(CELLS)
    kept = r.y.reshape(-1, per_combination)
    given = np.stack(weights, axis=-1).reshape(-1, per_combination, 3)[:, 0].astype(int)
    for w, y in zip(given, kept, strict=True):
        if w.sum():
            counts = np.bincount(y, minlength=3)
            assert_array_equal(counts * w.sum(), w * per_combination)


@pytest.mark.parametrize("dtype", DTYPES)
def test_the_mean_is_the_expectation(dtype):
    assert abs(mean_estimate(dtype) - exact_estimate()[0]) <= tolerance(dtype)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_a_finer_lattice_has_the_same_mean(dtype):
    """Not an accident of one lattice: any multiple of the cells divides as well."""
    assert abs(mean_estimate(dtype, finer=3) - exact_estimate()[0]) <= tolerance(dtype)


# ---------------------------------------------------------------- planted bias


def wrong_choice(w_a, w_b, u):
    """A newcomer favoured by 1 %."""
    return u * (w_a + w_b) < 1.01 * w_b


def test_control_a_weight_off_by_1_percent_is_found():
    off = 1.01 * mean_estimate(np.float32) - exact_estimate()[0]
    assert abs(off) > 1000 * tolerance(np.float32)


def test_control_a_choice_off_by_1_percent_is_found(monkeypatch):
    """Ten times as fine, a threshold that is moved by 1 % passes a midpoint."""
    monkeypatch.setattr(reservoir, "choose_second", wrong_choice)
    off = mean_estimate(np.float32, finer=10) - exact_estimate()[0]
    assert abs(off) > 1000 * tolerance(np.float32)


# ---------------------------------------------------------------- reuse

MU = np.array([[1.0, 2.0, 0.5, 0.0], [2.0, 1.0, 1.0, 0.0]])
"""Measures of three cells, and of nothing, at receiver and source: powers of two."""

SEEN = np.array([[1, 1, 1, 0], [1, 0, 1, 0]], bool)
"""The source does not see cell 1: its draws of it are nulls."""

WEIGHT = np.array([1.0, 2.0, 1.0, 0.0])
"""p̂ at the receiver is chosen so that a sample weighs this, whoever made it."""


def reuse_on_a_lattice(dtype, supports=True):
    """1/Z over two pixels that draw each of four outcomes with probability 1/4."""
    own, other, u = (
        column.ravel()
        for column in np.meshgrid(range(4), range(4), midpoints(12), indexing="ij")
    )
    u = u.astype(dtype)
    with np.errstate(divide="ignore", invalid="ignore"):
        jacobian = np.nan_to_num(MU[0] / MU[1]).astype(dtype)
        p_hat = np.nan_to_num(WEIGHT / (4 * MU[0])).astype(dtype)
    one = np.ones(len(u), dtype)

    def closed(pixel, y):
        W = np.where(SEEN[pixel][y], 4 * MU[pixel][y], 0.0).astype(dtype)
        return Reservoirs(y, W, one)

    a = reused_candidates(closed(0, own), p_hat[own])
    b = reused_candidates(closed(1, other), p_hat[other], jacobian[other])
    kept: Candidates = merge(a, b, u)
    holds = SEEN[1][kept.y] if supports else np.ones(len(u), bool)
    r = finalize(kept, one_over_z([a.M, b.M], [np.ones(len(u), bool), holds]))
    return [math.fsum(r.W[r.y == x].astype(float)) / len(u) for x in range(3)]


@pytest.mark.parametrize("dtype", DTYPES)
def test_each_cell_contributes_its_measure(dtype):
    """E[W 1{y = x}] = mu(x), to the two quotients of a row; all else is exact."""
    found = reuse_on_a_lattice(dtype)
    assert np.all(abs(found - MU[0, :3]) <= np.finfo(dtype).eps * MU[0, :3])


def test_control_1_over_m_loses_half_of_the_cell_that_the_donor_does_not_see():
    found = reuse_on_a_lattice(np.float32, supports=False)
    assert found == pytest.approx([1.0, 1.0, 0.5], rel=1e-6)


def test_the_lattices_divide_every_decision():
    """The claim on which all rests."""
    for cells, count in zip(CELLS, (2, 3), strict=True):
        sums = {sum(w) for w in itertools.product(WEIGHTS, repeat=count)} - {0}
        assert all(cells % s == 0 for s in sums)

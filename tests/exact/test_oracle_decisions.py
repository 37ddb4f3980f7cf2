"""Decisions within rounding and beyond it, and the budget of the former.

Both samples weigh about the same, so that the threshold of u is near 1/2, and u is put
beside it in units of the bound that the replay itself states.
"""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.stats import poisson

from restir_gi.reference.oracle.builtin.backend import FLOAT32
from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.levels.patches import NEAR, eye, patch_reservoirs
from restir_gi.reference.oracle.replay.bounded import Bounded, exact, rounding_of
from restir_gi.reference.oracle.replay.formulas import preference
from restir_gi.reference.oracle.replay.judgement import (
    BUDGET_ALARM,
    Decisions,
    poisson_quantile,
)
from restir_gi.reference.oracle.replay.judges import JUDGES
from restir_gi.reference.oracle.replay.rules import CONTRACT_RULES
from restir_gi.reference.oracle.replay.stream import (
    by_chance,
    choices_of,
    left_open,
    sums_of,
)

ROWS = 64
ROUNDING = rounding_of("float32")


def merge_case(u, random=False):
    """Weights 1 and 1: the second is kept where u < 1/2."""
    ones = np.ones(len(u), np.float32)
    inputs = {"w_a": ones, "M_a": ones, "w_b": ones, "M_b": ones, "u": np.float32(u)}
    return Case("merge", "merge", {}, inputs, random)


def merged(case, second):
    out = dict(FLOAT32.merge(**case.inputs))
    out["second"] = np.full(case.rows, second, np.uint32)
    return JUDGES["merge"](case, out, CONTRACT_RULES, "float32")


def bound():
    """Of w − u (w_a + w_b) at the threshold."""
    one, half = (exact(np.full(1, v), ROUNDING) for v in (1.0, 0.5))
    return float(preference(half, one, one).error[0])


def test_at_the_threshold_both_branches_are_free():
    case = merge_case(np.full(ROWS, 0.5))
    assert merged(case, 0).passed
    assert merged(case, 1).passed


@pytest.mark.parametrize("side", [-1, 1])
def test_beyond_the_bound_the_other_branch_is_refused(side):
    """The preference is 1 − 2u: it leaves the bound at half of it in u."""
    step = 2.0**-24
    just = (bound() / 2 // step + 1) * step
    case = merge_case(np.full(ROWS, 0.5 + side * just))
    right = 1 if side < 0 else 0
    assert merged(case, right).passed
    assert merged(case, 1 - right).wrong.all()


def test_the_bound_is_a_few_units():
    """Neither vacuous nor less than the two roundings of the comparison."""
    assert 2 * 2.0**-24 <= bound() <= 32 * 2.0**-24


def temporal_case(u):
    """Past and new sample weigh the same at pixel 0."""
    cells = np.zeros(len(u), np.int64)
    past, new = (patch_reservoirs(NEAR, "scattered", 0, cells + k, 1.0) for k in (0, 2))
    inputs = eye(NEAR, 0, len(u)) | {f"past_{name}": a for name, a in past.items()}
    inputs |= {f"new_{n}": new[n] for n in ("position", "normal", "radiance")}
    inputs |= {"new_pdf": 1 / new["W"], "u": u}
    single = {name: np.float32(array) for name, array in inputs.items()}
    return Case("temporal", "temporal", {"target": "scattered", "cap": 9.0}, single)


def with_other_branch(case):
    """Outputs of a backend that draws with a u on the other side."""
    other = dict(case.inputs) | {"u": np.float32(1) - case.inputs["u"]}
    return FLOAT32.temporal(**other, **case.settings)


@pytest.mark.parametrize(("away", "open_"), [(2.0**-23, True), (2.0**-10, False)])
def test_a_reservoir_is_judged_along_the_branch_that_was_taken(away, open_):
    """Weights have some 20 roundings, of four units: 2⁻²³ is inside, 2⁻¹⁰ far out."""
    case = temporal_case(np.full(ROWS, 0.5 + away))
    right = JUDGES["temporal"](
        case,
        FLOAT32.temporal(**case.inputs, **case.settings),
        CONTRACT_RULES,
        "float32",
    )
    out = with_other_branch(case)
    other = JUDGES["temporal"](case, out, CONTRACT_RULES, "float32")
    assert right.passed
    assert other.wrong.any() != open_
    assert other.decisions.illegal.all() != open_


def test_a_free_branch_still_needs_the_weight_that_belongs_to_it():
    case = temporal_case(np.full(ROWS, 0.5 + 2.0**-23))
    out = with_other_branch(case)
    out["W"] = out["W"] * np.float32(1.0001)
    judged = JUDGES["temporal"](case, out, CONTRACT_RULES, "float32")
    assert judged.wrong.all()


# ---------------------------------------------------------------- budget


def test_differing_decisions_beyond_their_budget_are_a_fault():
    """256 of 256 rows lean on rounding, where none is expected to."""
    u = np.full(256, 0.5)
    lenient, strict = merge_case(u), merge_case(u, random=True)
    assert merged(lenient, 1).passed
    judged = merged(strict, 1)
    assert judged.decisions.differing == 256
    assert judged.over_budget
    assert not judged.passed


@pytest.mark.parametrize("mean", [0.0, 1e-3, 0.1, 3.0])
def test_the_budget_is_exceeded_with_the_stated_probability(mean):
    budget = Decisions(np.zeros(1, bool), 0, mean).budget
    assert poisson.sf(budget, mean) <= BUDGET_ALARM
    assert budget == 0 or poisson.sf(budget - 1, mean) > BUDGET_ALARM


def test_the_expected_number_of_open_decisions_is_their_share_of_all_numbers():
    """Counted on the whole grid of u about the threshold, to a cell on either side."""
    cell, reach = 2.0**-24, 64
    u = 0.5 + np.arange(-reach, reach + 1) * cell
    ones = exact(np.ones(len(u)), ROUNDING)
    margin = preference(exact(u, ROUNDING), ones, ones)
    open_cells = int((np.abs(margin.value) <= margin.error).sum())
    assert 2 < open_cells < reach
    stated = merged(merge_case(np.full(1, 0.5)), 1).decisions.expected
    assert abs(stated / cell - open_cells) <= 2


# ---------------------------------------------------------------- weights that may be 0


@dataclass(frozen=True)
class Weighed:
    """A weight and the number that decides on it."""

    w: Bounded
    u: Bounded


def stream(weight, error):
    """Nothing, and then a weight that is known to an error."""
    none, half = (exact(np.full(ROWS, v), ROUNDING) for v in (0.0, 0.5))
    second = Bounded(np.full(ROWS, weight), np.full(ROWS, error), ROUNDING)
    return [Weighed(none, none), Weighed(second, half)]


@pytest.mark.parametrize(("weight", "free"), [(1e-35, True), (1.0, False)])
def test_a_first_weight_that_may_be_0_need_not_be_kept(weight, free):
    """A backend in single precision has rounded it to 0, and keeps nothing."""
    slots = stream(weight, 1e-34)
    sums = sums_of(slots, CONTRACT_RULES)
    may, exactly = choices_of(slots, sums, CONTRACT_RULES)
    assert (may[0] == free).all()
    assert may[1].all()
    assert (exactly == 1).all()
    # Neither choice is counted against a budget of which it is no part.
    assert (by_chance(slots) == (not free)).all()
    assert left_open(slots, sums) == 0


def test_the_quantile_is_that_of_the_poisson_distribution():
    for mean in (0.0, 1e-300, *np.geomspace(1e-9, 1e6, 200)):
        for probability in (0.5, 1 - 1e-6):
            expected = poisson.ppf(probability, mean)
            assert poisson_quantile(probability, mean) == expected

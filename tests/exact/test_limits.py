"""Limits on the Jacobian: mirrored they are unbiased; else their bias, in fractions."""

from fractions import Fraction

import pytest

from tests.exact import claims
from tests.exact.domain import CELLS, HOLDS, MU, PIXELS
from tests.exact.mutants import MUTANTS, is_refuted
from tests.exact.test_known_bias import TRUTH, pixel_value
from tests.mutants.plant import planted

LIMIT = Fraction(3)

BY_NAME = {mutant.name: mutant for mutant in MUTANTS}
UNMIRRORED = BY_NAME["a limit on the Jacobian that Z does not know"]
OTHER_WAY = BY_NAME["a limit on the Jacobian that Z applies the other way round"]


def is_within(J):
    return max(J, 1 / J) <= LIMIT


def test_the_limit_refuses_some_shifts_in_each_direction_and_not_all():
    J = [MU[i][x] / MU[k][x] for i in PIXELS for k in PIXELS for x in CELLS if i != k]
    assert min(J) < 1 / LIMIT < LIMIT < max(J)
    assert any(is_within(ratio) for ratio in J)


@pytest.mark.parametrize("mis", ["1/Z", "balance", "pairwise", "defensive"])
@pytest.mark.parametrize("visibility", ["all", "chosen"])
def test_mirrored_rejection_is_unbiased(mis, visibility):
    found = claims.spatial_pass(mis=mis, visibility=visibility, jacobian_limit=LIMIT)
    assert list(found) == []


def test_a_symmetric_limit_has_no_wrong_way_round():
    """Why it is symmetric: a limit on J alone, mirrored the wrong way, is biased."""
    symmetric, one_sided = (
        lambda how=how: claims.spatial_pass(**{how: LIMIT})
        for how in ("jacobian_limit", "largest")
    )
    assert not is_refuted(OTHER_WAY, symmetric)
    assert is_refuted(OTHER_WAY, one_sided)


# ---------------------------------------------------------------- the biased forms


def mean_over_makers(i, x, value):
    """Mean of what each maker k of cell x brings to pixel i, by M; 0 outside of D_i."""
    makers = [k for k in PIXELS if HOLDS[k][x]]
    if not HOLDS[i][x]:
        return Fraction(0)
    total = sum(claims.TRUST[k] * value(k) for k in makers)
    return total / Fraction(sum(claims.TRUST[k] for k in makers))


@pytest.mark.parametrize(
    ("i", "value"), [(0, Fraction(14, 3)), (1, Fraction(11, 3)), (2, Fraction(23, 3))]
)
def test_unmirrored_rejection_is_dark_by_the_share_that_was_refused(i, value):
    """C(x) = mu_i(x) times the share of Z(x) whose shift is within the limit.

    -22.2, -8.3 and -30.3 %: 14/3 for 6, 11/3 for 4, 23/3 for 11.
    """
    found = claims.spatial_contributions(i, jacobian_limit=LIMIT, beyond_limit="reject")
    with planted(UNMIRRORED):
        assert claims.spatial_contributions(i, jacobian_limit=LIMIT) == found
    for x in CELLS:

        def brought(k, x=x):
            return MU[i][x] if is_within(MU[i][x] / MU[k][x]) else Fraction(0)

        assert found[x] == mean_over_makers(i, x, brought)
    assert pixel_value(found, i) == value
    assert value < TRUTH[i]


@pytest.mark.parametrize(("i", "percent"), [(0, -16.8), (1, -7.6), (2, 238.1)])
def test_clamping_leaves_part_of_the_donors_measure(i, percent):
    """C(x) = Σ_k M_k mu_k(x) clamp(mu_i(x) / mu_k(x)) / Z(x)."""
    found = claims.spatial_contributions(i, jacobian_limit=LIMIT, beyond_limit="clamp")
    for x in CELLS:

        def brought(k, x=x):
            J = MU[i][x] / MU[k][x]
            return MU[k][x] * min(max(J, 1 / LIMIT), LIMIT)

        assert found[x] == mean_over_makers(i, x, brought)
    bias = pixel_value(found, i) / TRUTH[i] - 1
    assert round(float(100 * bias), 1) == percent

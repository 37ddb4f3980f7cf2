"""Negative controls of pairwise weights: mistakes of their own kind.

Weights that are wrong in the same way for a donor's sample and for the canonical one
may still share each sample out; what is planted here is wrong on one side alone.
"""

import pytest

from tests.exact import claims
from tests.exact.mutants import PRODUCTION, SURVIVORS, Mutant

BOTH, DEFENSIVE = ("pairwise", "defensive"), ("defensive",)

MUTANTS = [
    Mutant(
        "the canonical sample is forgotten",
        "pipeline",
        "found = [weighted(own, M_c, m)]",
        "found = [weighted(own, M_c, m * 0)]",
        BOTH,
    ),
    Mutant(
        "the canonical sample counts in full",
        "pipeline",
        "found = [weighted(own, M_c, m)]",
        "found = [weighted(own, M_c, m * 0 + 1)]",
        BOTH,
    ),
    Mutant(
        "inverse Jacobian in the target of a donor's own sample",
        "pipeline",
        "mine = M_j, p_from(j, y), M_c",
        "mine = M_j, p_from(j, y) * jacobian(code, j, i, y) ** 2, M_c",
        BOTH,
    ),
    Mutant(
        "inverse Jacobian in the target of the canonical sample",
        "pipeline",
        "p_k = [p_from(j, own.y.cell) for",
        "p_k = [p_from(j, own.y.cell) * jacobian(code, j, i, own.y.cell) ** 2 for",
        BOTH,
    ),
    Mutant(
        "M of the donor's slot for the canonical one",
        "pipeline",
        "mine = M_j, p_from(j, y), M_c",
        "mine = M_j, p_from(j, y), M_j",
        BOTH,
    ),
    Mutant(
        "target of the canonical sample for the donor's",
        "pipeline",
        "M_c, P_HAT[i][y]",
        "M_c, P_HAT[i][own.y.cell]",
        BOTH,
    ),
    Mutant(
        "all confidences, the canonical one too, in its weight",
        "pairwise",
        "S = one_over_m(M_k)",
        "S = one_over_m([*M_k, M_c])",
        BOTH,
    ),
    Mutant(
        "nulls do not count among the donors' confidences",
        "pipeline",
        "S = sum(M_k) + M_c * 0",
        "S = sum(np.where(c.w > 0, c.M, M_c * 0) for c in candidates[1:])",
        BOTH,
    ),
    Mutant(
        "the canonical share is not taken from the donors",
        "pairwise",
        "total = plus(S, M_c) if defensive else S",
        "total = S",
        DEFENSIVE,
    ),
    Mutant(
        "m and M both multiply",
        "pipeline",
        "divide_or_zero(c.w, M) * m",
        "c.w * m",
        BOTH,
    ),
    Mutant(
        "the sum of weights is divided by M after all",
        "pipeline",
        "return np.full(len(z), Fraction(1))",
        "return code.mis.one_over_m(M)",
        BOTH,
    ),
]

KILLS = [(mutant, mis) for mutant in MUTANTS for mis in mutant.killed_by]


@pytest.mark.parametrize(
    ("mutant", "mis"), KILLS, ids=[f"{mutant.name} - {mis}" for mutant, mis in KILLS]
)
def test_mutant_is_refuted(mutant, mis):
    assert next(claims.spatial_pass(mutant.plant(), mis=mis), None) is not None


@pytest.mark.parametrize("mis", BOTH)
@pytest.mark.parametrize("mutant", SURVIVORS[:2], ids=lambda mutant: mutant.name)
def test_a_jacobian_that_is_wrong_on_both_sides_costs_noise_alone(mutant, mis):
    """Any p_k that is positive where k can make the sample shares it out."""
    code = mutant.plant()
    assert list(claims.spatial_pass(code, mis=mis)) == []

    def law(code):
        return claims.resampled(code, claims.fresh_frame(code), 0, mis=mis).as_dict()

    assert law(code) != law(PRODUCTION)

"""Negative controls of pairwise weights: mistakes of their own kind.

Weights that are wrong in the same way for a source's sample and for the canonical one
may still share each sample out; what is planted here is wrong on one side alone.
"""

import pytest

from tests.exact import claims
from tests.exact.mutants import (
    DONOR,
    DONORS,
    ENGINE,
    MADE,
    OWN,
    PAIRWISE,
    SURVIVORS,
    THERE,
    ExactMutant,
)
from tests.mutants.plant import planted

BOTH, DEFENSIVE = ("pairwise", "defensive"), ("defensive",)

MUTANTS = [
    ExactMutant(
        "the canonical sample is forgotten",
        ENGINE,
        OWN,
        "weighted = [_with_weight(canonical, m * 0)]",
        BOTH,
    ),
    ExactMutant(
        "the canonical sample counts in full",
        ENGINE,
        OWN,
        "weighted = [_with_weight(canonical, m * 0 + 1)]",
        BOTH,
    ),
    ExactMutant(
        "inverse Jacobian in the target of a source's own sample",
        ENGINE,
        MADE,
        "target(made) * candidate.jacobian[at]",
        BOTH,
    ),
    ExactMutant(
        "inverse Jacobian in the target of the canonical sample",
        ENGINE,
        THERE,
        "divide_or_zero(target(value), jacobian), len(p_hat)",
        BOTH,
    ),
    ExactMutant(
        "M of the source's slot for the canonical one",
        ENGINE,
        DONOR,
        "pairwise_neighbor(M, made, M, k.weighted.p_hat, S, defensive)",
        BOTH,
    ),
    ExactMutant(
        "target of the canonical sample for the source's",
        ENGINE,
        DONOR,
        "pairwise_neighbor(M, made, c.M, c.p_hat, S, defensive)",
        BOTH,
    ),
    ExactMutant(
        "all confidences, the canonical one too, in its weight",
        PAIRWISE,
        "S = one_over_m(M_k)",
        "S = one_over_m([*M_k, M_c])",
        BOTH,
    ),
    ExactMutant(
        "nulls do not count among the sources' confidences",
        ENGINE,
        DONORS,
        "S = sum(np.where(k.weighted.w > 0, k.weighted.M, c.M * 0) for k in others)",
        BOTH,
    ),
    ExactMutant(
        "the canonical share is not taken from the sources",
        PAIRWISE,
        "total = plus(S, M_c) if defensive else S",
        "total = S",
        DEFENSIVE,
    ),
    ExactMutant(
        "m and M both multiply",
        ENGINE,
        "w=divide_or_zero(c.w, c.M) * m",
        "w=c.w * m",
        BOTH,
    ),
    ExactMutant(
        "the sum of weights is divided by M after all",
        ENGINE,
        "return np.ones_like(kept.w)",
        "return one_over_m(M_k)",
        BOTH,
    ),
]

KILLS = [(mutant, mis) for mutant in MUTANTS for mis in mutant.killed_by]


@pytest.mark.parametrize(
    ("mutant", "mis"), KILLS, ids=[f"{mutant.name} - {mis}" for mutant, mis in KILLS]
)
def test_mutant_is_refuted(mutant, mis):
    with planted(mutant):
        assert next(claims.spatial_pass(mis=mis), None) is not None


@pytest.mark.parametrize("mis", BOTH)
@pytest.mark.parametrize("mutant", SURVIVORS[:2], ids=lambda mutant: mutant.name)
def test_a_jacobian_that_is_wrong_on_both_sides_costs_noise_alone(mutant, mis):
    """Any p_k that is positive where k can make the sample shares it out."""
    frames = claims.fresh_frame()
    whole = claims.spatial_law(frames, 0, mis=mis).as_dict()
    with planted(mutant):
        assert list(claims.spatial_pass(mis=mis)) == []
        assert claims.spatial_law(frames, 0, mis=mis).as_dict() != whole

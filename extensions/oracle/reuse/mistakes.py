"""Known mistakes of generalized resampling."""

from typing import Any

from restir_gi.extensions.oracle.reuse.rules import ReuseRules
from restir_gi.reference.oracle.diagnosis.hypothesis import (
    Departure,
    Hypothesis,
    mistake,
)

PASSES = ("path_reuse",)

JACOBIAN = "w_k = m_k · target_here_k · W_k · jacobian_k"
Z = "Z = Σ M_k of those with p_k(s) > 0"
BALANCE = "Z = Σ M_k p_k(s) / p_s(s)"
PAIRWISE = "m_k = M_k / T · S p_k(k) / (S p_k(k) + M_c p_c(k))"
CANONICAL = "m_c = Σ M_k / T · M_c p_c(c) / (S p_k(c) + M_c p_c(c))"
CAP = "M = min(ΣM_k, cap)"


def _known(
    name: str,
    what: str,
    wrong: str,
    right: str,
    departure: Departure = "",
    **rules: Any,
) -> Hypothesis:
    part = ReuseRules(**rules)
    return mistake(name, what, wrong, right, PASSES, departure=departure, part=part)


REUSE_MISTAKES: tuple[Hypothesis, ...] = (
    _known(
        "reuse-jacobian-left-out",
        "the weight of a shifted sample has no Jacobian",
        "w_k = m_k · target_here_k · W_k",
        JACOBIAN,
        jacobian="none",
    ),
    _known(
        "reuse-jacobian-divides",
        "the weight of a shifted sample is divided by its Jacobian",
        "w_k = m_k · target_here_k · W_k / jacobian_k",
        JACOBIAN,
        jacobian="over",
    ),
    _known(
        "reuse-jacobian-twice",
        "the weight of a shifted sample has its Jacobian twice",
        "w_k = m_k · target_here_k · W_k · jacobian_k²",
        JACOBIAN,
        jacobian="twice",
    ),
    _known(
        "reuse-target-of-the-donor",
        "the target of a sample where it was made takes the place of that here",
        "w_k = m_k · target_base_k · W_k · jacobian_k",
        JACOBIAN,
        target_base=True,
    ),
    _known(
        "reuse-nulls-not-counted",
        "sources without a sample do not count",
        "M_k = 0 where W_k = 0",
        "M_k counts where W_k = 0 too",
        nulls_count=False,
    ),
    _known(
        "reuse-empty-slots-counted",
        "slots without a source count",
        "ΣM_k over all slots",
        "M_k = 0 where there_k = 0",
        empty_count=True,
    ),
    _known(
        "reuse-one-over-m",
        "whatever the weights, the sum is divided by ΣM",
        "Z = ΣM_k",
        Z,
        replaced=("1/Z", "balance"),
        normalization="1/M",
    ),
    _known(
        "reuse-z-for-balance",
        "1/Z in place of the balance heuristic",
        Z,
        BALANCE,
        replaced=("balance",),
        normalization="1/Z",
    ),
    _known(
        "reuse-balance-for-z",
        "the balance heuristic in place of 1/Z",
        BALANCE,
        Z,
        replaced=("1/Z",),
        normalization="balance",
    ),
    _known(
        "reuse-z-of-everybody",
        "Z counts sources that could not have made the sample",
        "Z = Σ M_k",
        Z,
        every_domain=True,
    ),
    _known(
        "reuse-maker-not-in-z",
        "who made the sample does not count in Z",
        "Z = Σ M_k of the others with p_k(s) > 0",
        Z,
        maker_counts=False,
    ),
    _known(
        "reuse-made-without-jacobian",
        "the target where a sample was made is not brought into the receiver's measure",
        "p_s(s) = target_base_s",
        "p_s(s) = target_base_s / jacobian_s",
        made="none",
    ),
    _known(
        "reuse-made-times-jacobian",
        "the target where a sample was made is multiplied by the Jacobian",
        "p_s(s) = target_base_s · jacobian_s",
        "p_s(s) = target_base_s / jacobian_s",
        made="times",
    ),
    _known(
        "reuse-made-at-the-receiver",
        "the target at the receiver stands for that where the sample was made",
        "p_s(s) = target_here_s",
        "p_s(s) = target_base_s / jacobian_s",
        made="here",
    ),
    _known(
        "reuse-balance-over-the-receiver",
        "the balance heuristic is divided by the receiver's target",
        "Z = Σ M_k p_k(s) / p_c(s)",
        BALANCE,
        maker_divides=False,
    ),
    _known(
        "reuse-pairs-canonical-in-s",
        "the confidence of the canonical sample is among those of the sources",
        "S = ΣM_k",
        "S = Σ M_k of k ≠ c",
        canonical_in_s=True,
    ),
    _known(
        "reuse-defensive-without-canonical",
        "the canonical share is not taken from the sources",
        "T = S for defensive weights",
        "T = S + M_c",
        defensive_total=False,
    ),
    _known(
        "reuse-canonical-counts-whole",
        "the canonical sample keeps its whole weight",
        "m_c = 1",
        CANONICAL,
        canonical_share="whole",
    ),
    _known(
        "reuse-canonical-forgotten",
        "the canonical sample does not compete",
        "m_c = 0",
        CANONICAL,
        canonical_share="none",
    ),
    _known(
        "reuse-pairs-exchanged",
        "source and receiver have each other's target",
        "m_k = M_k / T · S p_c(k) / (S p_c(k) + M_c p_k(k))",
        PAIRWISE,
        exchanged=True,
    ),
    _known(
        "reuse-pairs-times-confidence",
        "weights in pairs are multiplied by M_k, which they have in them",
        "w_k = M_k · m_k · target_here_k · W_k · jacobian_k",
        JACOBIAN,
        beside_confidence=True,
    ),
    _known(
        "reuse-pairs-divided-again",
        "weights in pairs are divided by ΣM as well",
        "W = Σw_k / (ΣM_k · target_here_s)",
        "W = Σw_k / target_here_s",
        divided_again=True,
    ),
    _known(
        "reuse-capped-beforehand",
        "sources are capped, and not what is kept of them",
        "M_k = min(M_k, cap), M = ΣM_k",
        CAP,
        departure="confidence",
        capped="before",
    ),
    _known(
        "reuse-capped-in-weights-alone",
        "confidences are capped in the weights, and not in Z",
        "m_k = min(M_k, cap), Z = Σ M_k",
        "the same M_k in both",
        capped="weights",
    ),
    _known(
        "reuse-w-capped-with-m",
        "W is scaled down with M",
        "W = W · min(ΣM_k, cap) / ΣM_k",
        "W is left as it is",
        capped="W",
    ),
    _known(
        "reuse-never-capped",
        "confidence grows without limit",
        "M = ΣM_k",
        CAP,
        departure="confidence",
        capped="never",
    ),
    _known(
        "reuse-u-turned",
        "the number decides the other way round",
        "slot k is kept where (1 − u_k) · (w_0 + ⋯ + w_k) < w_k",
        "slot k is kept where u_k · (w_0 + ⋯ + w_k) < w_k",
        departure="order",
        u_turned=True,
    ),
)

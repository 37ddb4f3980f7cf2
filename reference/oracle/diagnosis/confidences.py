"""Known mistakes with confidences."""

from restir_gi.reference.oracle.diagnosis.hypothesis import (
    REUSE,
    SHIFTED,
    SPATIAL,
    TEMPORAL,
    mistake,
)
from restir_gi.reference.oracle.replay.bounded import Bounded, constant
from restir_gi.reference.oracle.replay.formulas import capped
from restir_gi.reference.oracle.replay.verbs import choose

M_RIGHT = "M = Σ M over all inputs, nulls too"


def _only_if_found(w: Bounded) -> Bounded:
    return choose(w.value > 0, constant(1.0, w), constant(0.0, w))


def _two(w: Bounded) -> Bounded:
    return constant(2.0, w)


def _without_M(p_hat: Bounded, W: Bounded, M: Bounded, J: Bounded) -> Bounded:
    return p_hat * W * J


def _M_twice(p_hat: Bounded, W: Bounded, M: Bounded, J: Bounded) -> Bounded:
    return p_hat * W * M * M * J


def _M_plus_one(p_hat: Bounded, W: Bounded, M: Bounded, J: Bounded) -> Bounded:
    return p_hat * W * (M + constant(1.0, M)) * J


def _without_target(p_hat: Bounded, W: Bounded, M: Bounded, J: Bounded) -> Bounded:
    return W * M * J


def _undensified(p_hat: Bounded, pdf: Bounded) -> Bounded:
    found = (pdf.value > 0) & (p_hat.value > 0)
    return choose(found, p_hat, constant(0.0, p_hat))


def _multiplied(p_hat: Bounded, pdf: Bounded) -> Bounded:
    return p_hat * pdf


def _one_more(M: Bounded, cap: float) -> Bounded:
    return capped(M, cap + 1)


CONFIDENCES = (
    mistake(
        "nulls-not-counted",
        "new samples that found nothing do not count",
        "M = 1 only where w > 0",
        M_RIGHT,
        ("initial", *TEMPORAL),
        "a note on ReGIR GI",
        fresh_confidence=_only_if_found,
    ),
    mistake(
        "reused-nulls-not-counted",
        "reused samples that arrive with no weight do not count",
        "M is skipped with w = 0",
        M_RIGHT,
        REUSE,
        "kajiya 5a124d5",
        nulls_count=False,
    ),
    mistake(
        "hidden-not-counted",
        "samples that the receiver does not see do not count",
        "M is skipped with the hidden sample",
        M_RIGHT,
        SHIFTED,
        "RTXDI #42",
        hidden_counts="none",
    ),
    mistake(
        "confidence-off-by-one",
        "a new sample counts twice",
        "M = M_past + 2",
        M_RIGHT,
        ("initial", *TEMPORAL),
        fresh_confidence=_two,
    ),
    mistake(
        "confidence-plus-one-in-weight",
        "M is one too large in the weight of a reused reservoir",
        "w = p̂ W (M + 1) J",
        "w = p̂ W M J",
        REUSE,
        "RestirPT-WebGPU TP_CP_PLUS1",
        weight=_M_plus_one,
    ),
    mistake(
        "confidence-missing-in-weight",
        "M is missing in the weight of a reused reservoir",
        "w = p̂ W J",
        "w = p̂ W M J",
        REUSE,
        weight=_without_M,
    ),
    mistake(
        "confidence-twice",
        "M is applied twice in the weight of a reused reservoir",
        "w = p̂ W M² J",
        "w = p̂ W M J",
        REUSE,
        "ReSTIR_GI by shallairo",
        weight=_M_twice,
    ),
    mistake(
        "neighbors-counted-double",
        "M of neighbours is doubled in their weight",
        "w = p̂ W (2 M) J",
        "w = p̂ W M J",
        SPATIAL,
        neighbor_trust=2.0,
    ),
    mistake(
        "target-missing-in-weight",
        "the weight of a reused reservoir lacks the target at the receiver",
        "w = W M J",
        "w = p̂ W M J",
        REUSE,
        weight=_without_target,
    ),
    mistake(
        "never-capped",
        "M is not capped",
        "M = Σ M",
        "M = min(Σ M, cap)",
        REUSE,
        "the paper's Algorithm 3 beside its section 5",
        departure="confidence",
        cap_when="never",
    ),
    mistake(
        "capped-on-arrival",
        "the pixel's own M is capped when it arrives, not when it is stored",
        "w = p̂ W min(M, cap), M = Σ min(M, cap)",
        "M = min(Σ M, cap)",
        REUSE,
        departure="confidence",
        cap_when="never",
        cap_arriving="own",
    ),
    mistake(
        "capped-before-weight",
        "M is capped before W is calculated, and the sum of weights is not",
        "W = Σ w / (p̂ min(Σ M, cap))",
        "W = Σ w / (p̂ Σ M), then M = min(Σ M, cap)",
        REUSE,
        cap_when="first",
    ),
    mistake(
        "density-left-out",
        "a new sample is not divided by its density",
        "w = p̂",
        "w = p̂ / p",
        ("initial", *TEMPORAL),
        fresh_weight=_undensified,
    ),
    mistake(
        "density-multiplied",
        "a new sample is multiplied by its density",
        "w = p̂ p",
        "w = p̂ / p",
        ("initial", *TEMPORAL),
        fresh_weight=_multiplied,
    ),
    mistake(
        "cap-off-by-one",
        "the cap is one too large",
        "M = min(Σ M, cap + 1)",
        "M = min(Σ M, cap)",
        REUSE,
        departure="confidence",
        capped=_one_more,
    ),
    mistake(
        "hidden-lights-not-counted",
        "samples with light that the receiver does not see do not count, nulls do",
        "M is skipped where a sample with w > 0 turns out to be hidden",
        M_RIGHT,
        SHIFTED,
        "RTXDI #42",
        hidden_counts="nulls",
    ),
    mistake(
        "running-weight-kept",
        "M is capped, and the running sum of weights is kept as it was",
        "the next frame has w = Σ w, and not p̂ W min(Σ M, cap)",
        "M = min(Σ M, cap) leaves W as it is",
        REUSE,
        "the paper's Algorithm 3 beside its section 5",
        cap_when="late",
    ),
)

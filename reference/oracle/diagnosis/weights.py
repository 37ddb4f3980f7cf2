"""Known mistakes with what the sum of weights is divided by."""

from reference.oracle.diagnosis.hypothesis import REUSE, SHIFTED, mistake
from reference.oracle.replay.bounded import Bounded, exact
from reference.oracle.replay.verbs import choose

W_RIGHT = "W = Σ w / (p̂(y) Z)"
Z_RIGHT = "Z = Σ M over those that could have made the kept sample"


def _undivided(w: Bounded, p_hat: Bounded, Z: Bounded) -> Bounded:
    return w / p_hat


def _without_p_hat(w: Bounded, p_hat: Bounded, Z: Bounded) -> Bounded:
    return w / Z


def _at_most_10(w: Bounded, p_hat: Bounded, Z: Bounded) -> Bounded:
    W = w / p_hat / Z
    return choose(W.value <= 10, W, exact(W.value * 0 + 10, W.rounding))


def _at_most_4(w: Bounded, p_hat: Bounded, Z: Bounded) -> Bounded:
    W = w / p_hat / Z
    return choose(W.value <= 4, W, exact(W.value * 0 + 4, W.rounding))


WEIGHTS = (
    mistake(
        "one-over-m",
        "1/M where 1/Z is asked for",
        "W = Σ w / (p̂ Σ M)",
        Z_RIGHT,
        SHIFTED,
        "the paper's biased form",
        "Capsaicin",
        normalization="1/M",
    ),
    mistake(
        "one-over-z-where-m",
        "1/Z where 1/M is asked for",
        Z_RIGHT,
        "Z = Σ M",
        SHIFTED,
        normalization="1/Z",
    ),
    mistake(
        "not-normalized",
        "the sum of weights is not divided by the confidences",
        "W = Σ w / p̂",
        W_RIGHT,
        ("finalize", *REUSE),
        finalized=_undivided,
    ),
    mistake(
        "not-divided-by-target",
        "W is not divided by the target",
        "W = Σ w / Z",
        W_RIGHT,
        ("finalize", "initial", *REUSE),
        finalized=_without_p_hat,
    ),
    mistake(
        "weight-cut-at-10",
        "W is cut at 10",
        "W = min(W, 10)",
        W_RIGHT,
        ("finalize", *REUSE),
        "kajiya",
        "ReSTIR_PT",
        finalized=_at_most_10,
    ),
    mistake(
        "weight-cut-at-4",
        "W is cut at 4",
        "W = min(W, 4)",
        W_RIGHT,
        ("finalize", *REUSE),
        "forge3d #177",
        finalized=_at_most_4,
    ),
    mistake(
        "divided-by-the-donors-target",
        "W is divided by the target at the point that made the sample",
        "W = Σ w / (p̂_donor(y) Z)",
        W_RIGHT,
        SHIFTED,
        "HIPRT 2861d1c5",
        divides_by_donor=True,
    ),
    mistake(
        "canonical-missing-in-z",
        "the pixel's own reservoir is not counted in Z",
        "Z = Σ M of the others",
        Z_RIGHT,
        SHIFTED,
        canonical_in_z=False,
    ),
    mistake(
        "visibility-missing-in-z",
        "Z counts neighbours that do not see the kept sample",
        "holds = above the horizon and lit",
        "holds = above the horizon, lit, and visible from the neighbour",
        SHIFTED,
        "the paper's Algorithm 4 with Equation 10",
        visibility_in_z=False,
    ),
    mistake(
        "visibility-missing-in-weight",
        "samples that the receiver does not see keep their weight",
        "w = p̂ W M J",
        "w = 0 where the receiver does not see the sample",
        SHIFTED,
        visibility_in_weight=False,
    ),
)

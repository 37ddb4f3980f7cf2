"""Known mistakes with merges, with floors, and with what takes part in a stream."""

from restir_gi.reference.oracle.diagnosis.hypothesis import (
    REUSE,
    SHIFTED,
    SPATIAL,
    Hypothesis,
    mistake,
)
from restir_gi.reference.oracle.diagnosis.targets import TARGETS_IN
from restir_gi.reference.oracle.replay.bounded import Bounded, constant
from restir_gi.reference.oracle.replay.formulas import weight
from restir_gi.reference.oracle.replay.limits import at_least
from restir_gi.reference.oracle.replay.target_rules import TargetRules
from restir_gi.reference.oracle.replay.verbs import choose

MERGED = "w = w_a + w_b, M = M_a + M_b"
MERGES = ("merge", *REUSE)
FLOORS = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)


def _last(a: Bounded, b: Bounded) -> Bounded:
    return b


def _one_more(a: Bounded, b: Bounded) -> Bounded:
    return a + constant(1.0, a)


def _at_least_one(M: Bounded) -> Bounded:
    return at_least(M, 1.0)


def _no_fireflies(p_hat: Bounded, W: Bounded, M: Bounded, J: Bounded) -> Bounded:
    w = weight(p_hat, W, M, J)
    return choose(W.value < 10, w, constant(0.0, w))


def _divisor_floor(least: float) -> Hypothesis:
    return mistake(
        f"divisor-at-least-{least:g}",
        f"the target is kept above {least:g} where it divides",
        f"W = Σ w / (max(p̂(y), {least:g}) Z)",
        "W = Σ w / (p̂(y) Z)",
        ("finalize", "initial", *REUSE),
        divisor_least=least,
    )


def _target_floor(word: str, kinds: tuple[str, ...], least: float) -> Hypothesis:
    return mistake(
        f"{word}-at-least-{least:g}",
        f"the target is kept above {least:g} where there is light: right in mean",
        f"p̂ = max(p̂, {least:g}) where p̂ > 0, in {' and '.join(kinds)}",
        "p̂ is as small as it is",
        TARGETS_IN,
        departure="target",
        target=TargetRules(least=least, least_in=kinds),
    )


MERGING = (
    mistake(
        "sum-of-weights-lost",
        "the sum of weights forgets what came before",
        "w = w_b",
        MERGED,
        MERGES,
        merged_weight=_last,
    ),
    mistake(
        "confidence-lost",
        "M forgets what came before",
        "M = M_b",
        MERGED,
        MERGES,
        merged_confidence=_last,
    ),
    mistake(
        "one-for-every-merge",
        "a merge adds 1 to M, whatever the other's M is",
        "M = M_a + 1",
        MERGED,
        ("merge", *SPATIAL),
        merged_confidence=_one_more,
    ),
    mistake(
        "empty-counts",
        "a reservoir that is empty counts as a sample",
        "M = max(M, 1)",
        "M = 0 counts nothing",
        REUSE,
        reused_confidence=_at_least_one,
    ),
    mistake(
        "dropped-where-w-large",
        "samples with W of 10 and more are taken for fireflies",
        "w = 0 where W ≥ 10",
        "w = p̂ W M J",
        REUSE,
        weight=_no_fireflies,
    ),
    mistake(
        "target-of-the-first",
        "W is divided by the target of the sample that came first, whoever won",
        "W = Σ w / (p̂(y_first) Z)",
        "W = Σ w / (p̂(y) Z)",
        REUSE,
        target_of="first",
    ),
    mistake(
        "donors-target-in-both",
        "the target of reused samples is that at the point that made them",
        "w = p̂_source W M J, W = Σ w / (p̂_source Z)",
        "p̂ is that at the receiver",
        SHIFTED,
        source_target=True,
    ),
    mistake(
        "none-is-pixel-0",
        "a neighbour that there is not is pixel 0",
        "row = max(row, 0)",
        "row −1 brings nothing",
        SPATIAL,
        none_is_first=True,
    ),
    mistake(
        "sources-of-this-frame",
        "the points of the past frame are looked up in the G-buffer of this one",
        "x_source = visible_position[row]",
        "x_source = past_visible_position[row]",
        ("fused",),
        sources_now=True,
    ),
    mistake(
        "rejected-counted",
        "a neighbour that there is not still counts",
        "M of row max(row, 0) is added",
        "row −1 brings nothing",
        SPATIAL,
        rejected_counts=True,
    ),
    mistake(
        "jacobian-rejected-not-counted",
        "shifts with J outside of [1/10, 10] are refused, and their M does not count",
        "w = 0 and M = 0 where J < 1/10 or J > 10",
        "w = p̂ W M J, and M counts",
        SHIFTED,
        "RTXDI #42",
        refused=(0.1, 10.0),
        refused_counts=False,
    ),
    *map(_divisor_floor, FLOORS),
    *(_target_floor("target", ("scattered", "outgoing"), least) for least in FLOORS),
    *(_target_floor("scattered", ("scattered",), least) for least in FLOORS),
)

"""Choices of real renderers that are other than the contract's, and bring no bias.

That they do not is not only said here: `innocence` calculates it.
"""

from dataclasses import replace

from restir_gi.reference.oracle.diagnosis.hypothesis import (
    REUSE,
    SHIFTED,
    SPATIAL,
    Hypothesis,
    mistake,
)
from restir_gi.reference.oracle.diagnosis.jacobians import cut_at_the_back
from restir_gi.reference.oracle.diagnosis.targets import TARGETS_IN
from restir_gi.reference.oracle.replay.rules import CONTRACT_RULES
from restir_gi.reference.oracle.replay.slots import ORDERS as STREAM_ORDERS
from restir_gi.reference.oracle.replay.slots import StreamOrder
from restir_gi.reference.oracle.replay.target_rules import TargetRules

ORDER = "the past, then the pixel's own, then neighbours in their order"
CAP = "M = min(Σ M, cap)"
Z = "Z = Σ M over those that could have made the kept sample"
STORED = "reservoirs are kept as they are"


WORDS = {"past": "past", "own": "own", "neighbors": "neighbour 0 … K−1"}


def _ordered(name: str, order: StreamOrder) -> Hypothesis:
    turned = WORDS | {"neighbors": "neighbour K−1 … 0"} if order.turned else WORDS
    stream = ", ".join(turned[who] for who in order.first)
    numbers = "of its place" if order.in_place else "of its own"
    # Where there is no past some of them are the contract's.
    fused = order.of(3, 0) != ([0, 1, 2], [0, 1, 2])
    return mistake(
        name,
        f"the stream is {stream}, each with the number {numbers}:"
        " the same distribution, and other samples",
        f"the stream is {stream}",
        ORDER,
        SPATIAL if fused else ("spatial",),
        *SEEN.get(name, ()),
        departure="order",
        order=name,
    )


SEEN = {"own-first": ("RTXDI", "bevy"), "own-last": ("ReSTIR_PT",)}

ORDERS = tuple(
    _ordered(name, order)
    for name, order in STREAM_ORDERS.items()
    if name != "reversed"  # of all passes of reuse
)

CONFIDENCES = (
    mistake(
        "capped-everywhere-on-arrival",
        "M of neighbours, too, is capped when it arrives, not when it is stored",
        "w = p̂ W min(M, cap) J, M = Σ min(M, cap)",
        CAP,
        SPATIAL,
        departure="confidence",
        cap_when="never",
        cap_arriving="all",
    ),
    mistake(
        "capped-twice",
        "the pixel's own M is capped when it arrives, and once more when it is stored",
        "w = p̂ W min(M, cap), M = min(Σ min(M, cap), cap)",
        CAP,
        REUSE,
        "ReSTIR_PT",
        departure="confidence",
        cap_arriving="own",
    ),
    mistake(
        "capped-twice-everywhere",
        "all M are capped when they arrive, and once more when they are stored",
        "w = p̂ W min(M, cap) J, M = min(Σ min(M, cap), cap)",
        CAP,
        SPATIAL,
        departure="confidence",
        cap_arriving="all",
    ),
    mistake(
        "past-capped-on-arrival",
        "M of the past is capped when it arrives, and no other",
        "w = p̂ W min(M, cap) of the past, M = min(M_past, cap) + Σ M of the others",
        CAP,
        SPATIAL,
        "RTXDI",
        departure="confidence",
        cap_when="never",
        cap_arriving="past",
    ),
    mistake(
        "whole-confidence",
        "M is a whole number when it is stored",
        "M = ⌊min(Σ M, cap)⌋",
        CAP,
        REUSE,
        "RTXDI",
        departure="confidence",
        whole_confidence=True,
    ),
    mistake(
        "confidence-in-a-byte",
        "M is stored in eight bits",
        "M = min(⌊min(Σ M, cap)⌋, 255)",
        CAP,
        REUSE,
        "RTXDI",
        departure="confidence",
        whole_confidence=True,
        most_confidence=255.0,
    ),
)


def _weights(
    name: str,
    what: str,
    formula: str,
    *seen: str,
    passes: tuple[str, ...] = SHIFTED,
    measured: bool = True,
) -> tuple[Hypothesis, ...]:
    """Weights with densities in one measure, and with each density in its own."""

    def one(anchor: str, words: str, jacobian: bool) -> Hypothesis:
        return mistake(
            anchor,
            f"{words}: right in mean",
            formula,
            Z,
            passes,
            *seen,
            departure="mis",
            normalization=name,
            mis_jacobian=jacobian,
        )

    found = one(name.replace("1/Z", "one-over-z"), what, True)
    if not measured:
        return (found,)
    words = f"{what}, of targets without their Jacobians"
    return found, one(f"{found.name}-without-jacobian", words, False)


MIS = (
    *_weights(
        "balance",
        "the sum of weights has the weight of the balance heuristic",
        "W = Σ w / p̂ · p_s(y) / Σ M p(y), s the source of the kept sample",
        "RTXDI",
    ),
    *_weights(
        "balance-in-weights",
        "each weight has that of the balance heuristic",
        "w = m p̂ W J, m = M p(y) / Σ M p(y), W = Σ w / p̂",
        "bevy",
    ),
    *_weights(
        "pairwise",
        "the weights are those of pairs",
        "W = Σ m p̂ W J / p̂(y), m of the pairwise weights",
        "ReSTIR_PT",
    ),
    *_weights(
        "defensive",
        "the weights are those of pairs, with a share for the pixel's own",
        "W = Σ m p̂ W J / p̂(y), m of the defensive pairwise weights",
        passes=REUSE,
    ),
    *_weights(
        "pairwise-of-k",
        "the weights are those of pairs, each with 1/k of the pixel's own confidence",
        "m = 1/k · M p / (M p + M_c/k · p_c), m_c the sum of what is left",
        "a renderer in WebGPU",
        passes=REUSE,
    ),
    *_weights(
        "defensive-of-k",
        "the weights are those of pairs, and the pixel's own counts as one more",
        "m = 1/(k + 1) · M p / (M p + M_c/k · p_c), m_c the sum of what is left",
        "RTXDI",
        passes=REUSE,
    ),
    *_weights(
        "chained-balance",
        "each merge is closed by itself, with the balance heuristic of two",
        "W and M after every merge, m = M p / (M p + M_next p_next)",
        "bevy",
        passes=SPATIAL,
    ),
    *_weights(
        "chained-1/Z",
        "each merge is closed by itself, with 1/Z of two",
        "W and M after every merge, Z = M or M + M_next",
        passes=SPATIAL,
        measured=False,
    ),
    mistake(
        "history-not-merged",
        "the past takes no part, as there is no history: right in mean",
        "the stream is own, neighbours, and Z is of these",
        ORDER,
        ("spatial",),
        departure="mis",
        past_merged=False,
    ),
)


def _refused(name: str, least: float, most: float, limits: str) -> Hypothesis:
    return mistake(
        name,
        f"shifts with J outside of {limits} are refused, both ways: right in mean",
        f"w = 0 outside of {limits}, and such a source does not count in Z",
        "w = p̂ W M J, whatever J is",
        SHIFTED,
        "bevy",
        departure="domain",
        refused=(least, most),
        refused_both_ways=True,
    )


DOMAINS = (
    _refused("jacobian-refused-both-ways-at-10", 0.1, 10.0, "[1/10, 10]"),
    _refused("jacobian-refused-both-ways-at-3", 1 / 3, 3.0, "[1/3, 3]"),
    _refused("jacobian-refused-both-ways-at-2", 1 / 2, 2.0, "[1/2, 2]"),
    mistake(
        "jacobian-refused-then-clamped",
        "shifts with J outside of [1/10, 10] are refused, and J is clamped to [1/3, 3]",
        "w = 0 outside of [1/10, 10], then J = clamp(J, 1/3, 3)",
        "w = p̂ W M J, whatever J is",
        ("jacobian", *SHIFTED),
        "RTXDI sample",
        refused=(0.1, 10.0),
        clamped=(1 / 3, 3.0),
    ),
    Hypothesis(
        "back-left-to-the-jacobian",
        "the target does not ask for the sample's back, where J is 0: right in mean",
        "p̂ > 0 where n_s·ω > 0, J = 0 there, and no source holds it there",
        "p̂ = 0 where n_s·ω > 0",
        TARGETS_IN,
        replace(
            CONTRACT_RULES,
            target=TargetRules(back_asked=False),
            jacobian=cut_at_the_back,
            refused_both_ways=True,
        ),
        ("RTXDI", "bevy"),
        "target",
        needs=("jacobian", "jacobian-cut-at-the-back"),
    ),
)

NULLS = (
    mistake(
        "dark-sample-keeps-its-density",
        "a sample with light that its own pixel does not reflect has W = 1/p",
        "W = 1 / p where p̂ = 0 and L_o > 0: others reflect it, and Z leaves it out",
        "W = 0 where p̂ = 0; of a null, which has no light, any W will do",
        ("initial",),
        "bevy",
        null_weight="1/pdf",
    ),
)


def _stored(name: str, what: str, *seen: str) -> Hypothesis:
    return mistake(
        f"stored-as-{name}",
        f"{what}: right to its rounding, within its range",
        f"between passes {what}",
        STORED,
        REUSE,
        *seen,
        departure="storage",
        storage=name,
    )


def _packed(words: str) -> str:
    return f"normals are two int16 on an octahedron, {words}"


STORED_AS = (
    _stored("half", "radiance and W are float16"),
    _stored("half-radiance", "radiance is float16"),
    _stored("half-weight", "W is float16"),
    _stored("packed", _packed("and radiance is float16")),
    _stored("packed-half", _packed("radiance and W are float16")),
    _stored("rgb9e5", _packed("radiance shares an exponent, and W is float16")),
    _stored("rgb9e5-float-weight", _packed("and radiance shares an exponent")),
    _stored("rgbe", _packed("radiance has 8 bits and an exponent, W is float16")),
    _stored("rgbe-float-weight", _packed("and radiance has 8 bits and an exponent")),
    _stored("rtxdi", _packed("and radiance is LogLuv, which mixes channels"), "RTXDI"),
    _stored("octahedral", "normals are two int16 on an octahedron"),
)

ALTERNATIVES: tuple[Hypothesis, ...] = (
    *ORDERS,
    *CONFIDENCES,
    *MIS,
    *DOMAINS,
    *NULLS,
    *STORED_AS,
)

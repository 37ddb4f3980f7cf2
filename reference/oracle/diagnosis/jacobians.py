"""Known mistakes with the Jacobian of the shift."""

from dataclasses import replace
from typing import Any

from restir_gi.reference.oracle.diagnosis.hypothesis import SHIFTED, Hypothesis
from restir_gi.reference.oracle.replay.bounded import Bounded, constant
from restir_gi.reference.oracle.replay.formulas import jacobian
from restir_gi.reference.oracle.replay.geometry import cosine_at
from restir_gi.reference.oracle.replay.points import ReceiverPoint, SamplePoint
from restir_gi.reference.oracle.replay.rules import CONTRACT_RULES
from restir_gi.reference.oracle.replay.verbs import choose, inner, square_root

SHIFTS = ("jacobian", *SHIFTED)
RIGHT = "J = (|cos φ_to| / |cos φ_from|) · (d_from² / d_to²), angles at the sample"


def _squares(
    x_from: ReceiverPoint, x_to: ReceiverPoint, y: SamplePoint
) -> tuple[Bounded, Bounded]:
    v_from, v_to = x_from.position - y.position, x_to.position - y.position
    return inner(v_from, v_from), inner(v_to, v_to)


def _inverse(x_from: ReceiverPoint, x_to: ReceiverPoint, y: SamplePoint) -> Bounded:
    return jacobian(x_to, x_from, y)


def _one(x_from: ReceiverPoint, x_to: ReceiverPoint, y: SamplePoint) -> Bounded:
    return constant(1.0, y.position[:, 0])


def _not_squared(x_from: ReceiverPoint, x_to: ReceiverPoint, y: SamplePoint) -> Bounded:
    d_from, d_to = _squares(x_from, x_to, y)
    return jacobian(x_from, x_to, y) * square_root(d_to / d_from)


def _without_cosines(
    x_from: ReceiverPoint, x_to: ReceiverPoint, y: SamplePoint
) -> Bounded:
    d_from, d_to = _squares(x_from, x_to, y)
    return d_from / d_to


def _without_distances(
    x_from: ReceiverPoint, x_to: ReceiverPoint, y: SamplePoint
) -> Bounded:
    d_from, d_to = _squares(x_from, x_to, y)
    return jacobian(x_from, x_to, y) * (d_to / d_from)


def _distances_upside_down(
    x_from: ReceiverPoint, x_to: ReceiverPoint, y: SamplePoint
) -> Bounded:
    d_from, d_to = _squares(x_from, x_to, y)
    ratio = d_to / d_from
    return jacobian(x_from, x_to, y) * ratio * ratio


def _cosines_upside_down(
    x_from: ReceiverPoint, x_to: ReceiverPoint, y: SamplePoint
) -> Bounded:
    d_from, d_to = _squares(x_from, x_to, y)
    ratio = d_from / d_to
    return ratio * ratio / jacobian(x_from, x_to, y)


def _receivers_cosines(
    x_from: ReceiverPoint, x_to: ReceiverPoint, y: SamplePoint
) -> Bounded:
    d_from, d_to = _squares(x_from, x_to, y)
    return abs(cosine_at(x_to, y)) / abs(cosine_at(x_from, y)) * (d_from / d_to)


def _root(x_from: ReceiverPoint, x_to: ReceiverPoint, y: SamplePoint) -> Bounded:
    return square_root(jacobian(x_from, x_to, y))


def cut_at_the_back(
    x_from: ReceiverPoint, x_to: ReceiverPoint, y: SamplePoint
) -> Bounded:
    """Jacobian of Equation 11, and 0 where either point sees the sample's back."""
    J = jacobian(x_from, x_to, y)
    faces = [inner(y.normal, x.position - y.position).value for x in (x_from, x_to)]
    return choose((faces[0] > 0) & (faces[1] > 0), J, constant(0.0, J))


_TABLE: tuple[tuple[str, str, str, dict[str, Any], tuple[str, ...]], ...] = (
    (
        "jacobian-inverted",
        "the weight is divided by the Jacobian, or source and receiver change places",
        "w = p̂ W M / J",
        {"jacobian": _inverse},
        ("the paper's Algorithm 4, line 11", "bevy-hikari #21", "C2-Renderer fcd7c28"),
    ),
    (
        "jacobian-omitted",
        "the Jacobian is left out",
        "J = 1",
        {"jacobian": _one},
        ("global-restir", "ReSTIR-BPT 7bf47ea"),
    ),
    (
        "jacobian-unsquared",
        "the distances are not squared",
        "J = (|cos φ_to| / |cos φ_from|) · (d_from / d_to)",
        {"jacobian": _not_squared},
        ("a note on ReSTIR GI in wide use",),
    ),
    (
        "jacobian-without-cosines",
        "the cosines are left out",
        "J = d_from² / d_to²",
        {"jacobian": _without_cosines},
        ("RestirPT-WebGPU U8-4",),
    ),
    (
        "jacobian-without-distances",
        "the distances are left out",
        "J = |cos φ_to| / |cos φ_from|",
        {"jacobian": _without_distances},
        (),
    ),
    (
        "jacobian-distances-upside-down",
        "the ratio of the distances is upside down",
        "J = (|cos φ_to| / |cos φ_from|) · (d_to² / d_from²)",
        {"jacobian": _distances_upside_down},
        ("C2-Renderer fcd7c28",),
    ),
    (
        "jacobian-cosines-upside-down",
        "the ratio of the cosines is upside down",
        "J = (|cos φ_from| / |cos φ_to|) · (d_from² / d_to²)",
        {"jacobian": _cosines_upside_down},
        (),
    ),
    (
        "jacobian-receiver-cosine",
        "the cosines are those at the visible points",
        "J = (|cos θ_to| / |cos θ_from|) · (d_from² / d_to²)",
        {"jacobian": _receivers_cosines},
        (),
    ),
    (
        "jacobian-root",
        "the root of the Jacobian is used",
        "w = p̂ W M √J",
        {"jacobian": _root},
        ("kajiya, spatial pass",),
    ),
    (
        "jacobian-clamped-to-3",
        "the Jacobian is clamped to [1/3, 3]",
        "J = clamp(J, 1/3, 3)",
        {"clamped": (1 / 3, 3.0)},
        ("RTXDI sample",),
    ),
    (
        "jacobian-clamped-to-2",
        "the Jacobian is clamped to [1/2, 2]",
        "J = clamp(J, 1/2, 2)",
        {"clamped": (1 / 2, 2.0)},
        (),
    ),
    (
        "jacobian-at-most-8",
        "the Jacobian is cut at 8",
        "J = min(J, 8)",
        {"clamped": (0.0, 8.0)},
        ("kajiya",),
    ),
    (
        "jacobian-at-most-10",
        "the Jacobian is cut at 10",
        "J = min(J, 10)",
        {"clamped": (0.0, 10.0)},
        ("ReSTIR_PT",),
    ),
    (
        "jacobian-rejected-beyond-10",
        "shifts with J outside of [1/10, 10] are refused, and Z does not know",
        "w = 0 where J < 1/10 or J > 10",
        {"refused": (0.1, 10.0)},
        ("RTXDI", "bevy #20259"),
    ),
    (
        "jacobian-rejected-beyond-2",
        "shifts with J above 2 are refused, and Z does not know",
        "w = 0 where J > 2",
        {"refused": (0.0, 2.0)},
        ("bevy #20580",),
    ),
)

_MISTAKES = tuple(
    Hypothesis(
        name,
        mistake,
        wrong,
        RIGHT,
        SHIFTS,
        replace(CONTRACT_RULES, **change),
        seen,
    )
    for name, mistake, wrong, change, seen in _TABLE
)


JACOBIANS = (
    *_MISTAKES,
    Hypothesis(
        "jacobian-cut-at-the-back",
        "the Jacobian is 0 behind the sample, where the target is 0 too",
        "J = (max(cos φ_to, 0) / max(cos φ_from, 0)) · (d_from² / d_to²)",
        RIGHT,
        ("jacobian",),
        replace(CONTRACT_RULES, jacobian=cut_at_the_back),
        departure="order",
    ),
)

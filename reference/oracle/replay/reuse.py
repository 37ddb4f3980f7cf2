"""Replay of the passes that reuse samples: Algorithms 3 and 4."""

from dataclasses import replace

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Masks
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.replay.bounded import (
    Bounded,
    constant,
    exact,
    rounding_of,
)
from restir_gi.reference.oracle.replay.judgement import Judgement
from restir_gi.reference.oracle.replay.points import (
    ReceiverPoint,
    SamplePoint,
    point_of,
    receiver_of,
)
from restir_gi.reference.oracle.replay.resampling import judge_resampling
from restir_gi.reference.oracle.replay.rules import Rules
from restir_gi.reference.oracle.replay.slots import (
    Closing,
    Domain,
    Slot,
    counted_nulls,
    with_hidden,
)
from restir_gi.reference.oracle.replay.verbs import choose


def judge_temporal(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``temporal``."""
    x = receiver_of(case.inputs, rounding_of(precision))
    past = _reused(case, x, rules, precision, "past_", u="u")
    slots = [counted_nulls(past, rules), _new(case, x, rules, precision)]
    closing = _closing(case, x, mis="1/M")
    return judge_resampling(outputs, slots, closing, rules, case.random)


def judge_moved(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``moved``."""
    rounding = rounding_of(precision)
    x = receiver_of(case.inputs, rounding)
    x_past = receiver_of(case.inputs, rounding, "past_")
    visible = case.inputs["visible"]
    new, old = 0, 1  # bits of the two samples; slots are the other way round
    sees = np.stack([_bit(visible[:, 1], old), _bit(visible[:, 1], new)])
    x_from = None if rules.as_stored else x_past
    past = _reused(case, x, rules, precision, "past_", u="u", x_from=x_from)
    if not rules.as_stored:
        past = replace(past, domain=Domain(x_past, sees))
        past = with_hidden(past, _bit(visible[:, 0], old), rules)
    slots = [counted_nulls(past, rules), _new(case, x, rules, precision)]
    closing = _closing(case, x, mis=str(case.settings["mis"]))
    slots = _taking_part(slots, rules)
    return judge_resampling(outputs, slots, closing, rules, case.random)


def judge_spatial(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``spatial``."""
    x = receiver_of(case.inputs, rounding_of(precision))
    neighbors = case.inputs["neighbors"]
    count = neighbors.shape[1]
    slots = [
        _reused(case, x, rules, precision, "past_", u="u_own"),
        _reused(case, x, rules, precision, "", u="u_own"),
    ]
    for k in range(count):
        slots.append(_neighbor(case, x, rules, precision, neighbors[:, k], k))
    slots = [counted_nulls(slot, rules) for slot in slots]
    closing = _closing(case, x, mis=str(case.settings["mis"]))
    slots = _taking_part(slots, rules)
    return judge_resampling(outputs, slots, closing, rules, case.random)


OWN = 1
"""Slot of the receiver's own sample, in each of the passes."""


def _closing(case: Case, x: ReceiverPoint, mis: str) -> Closing:
    cap = float(case.settings["cap"])
    return Closing(str(case.settings["target"]), mis, cap, OWN, x)


def _taking_part(slots: list[Slot], rules: Rules) -> list[Slot]:
    """Slots as the rules would have them."""
    if not rules.canonical_merged:
        none = constant(0.0, slots[OWN].w)
        slots[OWN] = replace(slots[OWN], w=none, M=none)
    return slots


def _bit(words: "Indices", place: int) -> Masks:
    found: Masks = (words >> np.uint32(place)) & np.uint32(1) != 0
    return found


def _new(case: Case, x: ReceiverPoint, rules: Rules, precision: Precision) -> Slot:
    """The sample that the initial pass has drawn."""
    rounding = rounding_of(precision)
    y = point_of(case.inputs, rounding, "new_")
    p_hat = rules.target(case.settings["target"], x, y)
    w = rules.fresh_weight(p_hat, exact(case.inputs["new_pdf"], rounding))
    u = exact(case.inputs["u"], rounding)
    return Slot(y, p_hat, w, rules.fresh_confidence(w), u)


def _reused(
    case: Case,
    x: ReceiverPoint,
    rules: Rules,
    precision: Precision,
    prefix: str,
    u: str,
    x_from: ReceiverPoint | None = None,
) -> Slot:
    """A reservoir of the receiver itself, or of another point in its place."""
    rounding = rounding_of(precision)
    y = point_of(case.inputs, rounding, prefix)
    W, M = (exact(case.inputs[prefix + name], rounding) for name in ("W", "M"))
    M = rules.reused_confidence(M)
    if rules.cap_when == "arrival":
        M = rules.capped(M, float(case.settings["cap"]))
    at = x_from if x_from and rules.source_target else x
    p_hat = rules.reuse_target(case.settings["target"], at, y)
    J = rules.jacobian(x_from, x, y) if x_from else constant(1.0, W)
    w = _weighted(rules, p_hat, W, M, J)
    return Slot(y, p_hat, w, _trusted(rules, M, J), exact(case.inputs[u], rounding))


def _trusted(rules: Rules, M: Bounded, J: Bounded) -> Bounded:
    """M of a shift, which by the contract counts whatever became of the sample."""
    if rules.refused_counts:
        return M
    return choose(J.value > 0, M, constant(0.0, M))


def _weighted(
    rules: Rules, p_hat: Bounded, W: Bounded, M: Bounded, J: Bounded
) -> Bounded:
    """Weight of a reservoir, exactly 0 for an empty one, whatever J is."""
    none = np.zeros_like(W.value)
    full = (W.value > 0) & ((p_hat.value > 0) | (p_hat.error > 0))
    w = rules.weight(p_hat, W, M, J)
    return choose(full, w, Bounded(none, none, W.rounding))


def _neighbor(
    case: Case,
    x: ReceiverPoint,
    rules: Rules,
    precision: Precision,
    row: Indices,
    k: int,
) -> Slot:
    rounding = rounding_of(precision)
    there, row = row >= 0, np.maximum(row, 0)
    y: SamplePoint = point_of(case.inputs, rounding).rows(row)
    x_from = x.rows(row)
    W, M = (exact(case.inputs[name][row], rounding) for name in ("W", "M"))
    none = constant(0.0, M)
    there = there | rules.none_is_first
    M = rules.reused_confidence(choose(there | rules.rejected_counts, M, none))
    at = x_from if rules.source_target else x
    p_hat = rules.reuse_target(case.settings["target"], at, y)
    trusted = M * constant(rules.neighbor_trust, M) if rules.neighbor_trust != 1 else M
    J = rules.jacobian(x_from, x, y)
    w = choose(there, _weighted(rules, p_hat, W, trusted, J), none)
    M = _trusted(rules, M, J)
    u = case.inputs["u_neighbors"][:, 0 if rules.shared_decision else k]
    if rules.shared_decision == "all":
        u = case.inputs["u_own"]
    visible = case.inputs["visible"]
    count = case.inputs["neighbors"].shape[1]
    bits = [count + 1, 0, *range(1, count + 1)]  # of the slots: past, own, neighbours
    sees = np.stack([_bit(visible[:, 1 + k], bit) & there for bit in bits])
    slot = Slot(y, p_hat, w, M, exact(u, rounding), Domain(x_from, sees))
    return with_hidden(slot, _bit(visible[:, 0], 1 + k), rules)

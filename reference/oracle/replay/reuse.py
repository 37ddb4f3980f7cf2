"""Replay of the passes that reuse samples: Algorithms 3 and 4."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from math import inf

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Masks
from restir_gi.reference.oracle.cases import SOURCES, Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.replay.blocks import rows_of
from restir_gi.reference.oracle.replay.bounded import (
    Bounded,
    Rounding,
    constant,
    exact,
    rounding_of,
)
from restir_gi.reference.oracle.replay.cached import jacobian_by, kept_by, target_by
from restir_gi.reference.oracle.replay.chain import judge_chain
from restir_gi.reference.oracle.replay.judgement import Judgement
from restir_gi.reference.oracle.replay.mis import CHAINED
from restir_gi.reference.oracle.replay.points import (
    ReceiverPoint,
    SamplePoint,
    receiver_read,
    sample_read,
    with_given,
)
from restir_gi.reference.oracle.replay.resampling import judge_resampling
from restir_gi.reference.oracle.replay.rules import Rules
from restir_gi.reference.oracle.replay.slots import (
    Closing,
    Domain,
    Slot,
    counted_nulls,
    in_order,
    with_hidden,
)
from restir_gi.reference.oracle.replay.storage import stored_sample, stored_W
from restir_gi.reference.oracle.replay.verbs import choose


@kept_by(64, lambda case, *others: case.rows)
def _receiver(case: Case, precision: Precision, prefix: str = "") -> ReceiverPoint:
    return receiver_read(case, rounding_of(precision), prefix)


@kept_by(256, lambda case, *others: case.rows)
def _sample(case: Case, precision: Precision, prefix: str, storage: str) -> SamplePoint:
    y = sample_read(case, rounding_of(precision), prefix)
    return stored_sample(y, storage) if case.decoded is None else y


def _too_old(case: Case, rules: Rules) -> Masks:
    """Pasts that are not reused: where either is right, as M of the result says."""
    may, must = (case.inputs["past_age"] >= age for age in rules.max_age)
    found: Masks = must | may & (case.inputs["past_counted"] == 0)
    return found


@kept_by(256, lambda case, *others: case.rows)
def _sample_around(
    case: Case, precision: Precision, k: int, storage: str, now: bool
) -> tuple[ReceiverPoint, SamplePoint]:
    """Visible point of neighbour k, and its sample; those of row 0 for none."""
    sources = SOURCES[case.pass_name]
    row = np.maximum(case.inputs[sources.rows][:, k], 0)
    around = rows_of(case.around or case, row)
    y = _sample(around, precision, sources.prefix, storage)
    return _receiver(around, precision, "" if now else sources.prefix), y


# Candidates in the order of the contract, and how their stream ends.
Stream = tuple[list[Slot], Closing]


def _temporal(case: Case, rules: Rules, precision: Precision) -> Stream:
    x = _receiver(case, precision)
    past = _reused(case, x, rules, precision, "past_", u="u")
    slots = [counted_nulls(past, rules), _new(case, x, rules, precision)]
    return slots, _closing(case, x, mis=str(case.settings.get("mis", "1/Z")))


def _moved(case: Case, rules: Rules, precision: Precision) -> Stream:
    x, x_past = _receiver(case, precision), _receiver(case, precision, "past_")
    x_past = replace(x_past, number=1)
    visible = case.inputs["visible"]
    new, old = 0, 1  # bits of the two samples; slots are the other way round
    sees = np.stack([_bit(visible[:, 1], old), _bit(visible[:, 1], new)])
    x_from = None if rules.as_stored else x_past
    past = _reused(case, x, rules, precision, "past_", u="u", x_from=x_from)
    if not rules.as_stored:
        past = replace(past, domain=Domain(_asked_as(x_past, x, rules), sees))
        past = with_hidden(past, _bit(visible[:, 0], old), rules)
    slots = [counted_nulls(past, rules), _new(case, x, rules, precision)]
    closing = _closing(case, x, mis=str(case.settings["mis"]))
    return _taking_part(slots, rules), closing


def _spatial(case: Case, rules: Rules, precision: Precision) -> Stream:
    x = _receiver(case, precision)
    slots = [
        _reused(case, x, rules, precision, "past_", u="u_own"),
        _reused(case, x, rules, precision, "", u="u_own"),
        *_neighbors(case, x, rules, precision),
    ]
    slots = [counted_nulls(slot, rules) for slot in slots]
    closing = _closing(case, x, mis=str(case.settings["mis"]))
    return _taking_part(slots, rules), closing


def _fused(case: Case, rules: Rules, precision: Precision) -> Stream:
    """As pass ``spatial``, from the past frame, and with no other past."""
    x = _receiver(case, precision)
    own = _reused(case, x, rules, precision, "", u="")
    slots = [own, *_neighbors(case, x, rules, precision)]
    if not rules.canonical_merged:
        none = constant(0.0, own.w)
        slots[0] = replace(own, w=none, M=none)
    closing = _closing(case, x, mis=str(case.settings["mis"]))
    slots = [counted_nulls(slot, rules) for slot in slots]
    return slots, replace(closing, canonical=0)


def _neighbors(
    case: Case, x: ReceiverPoint, rules: Rules, precision: Precision
) -> list[Slot]:
    """Reservoirs of other points, in their order."""
    rows = case.inputs[SOURCES[case.pass_name].rows]
    return [
        _neighbor(case, x, rules, precision, rows[:, k], k)
        for k in range(rows.shape[1])
    ]


STREAMS: Mapping[str, Callable[[Case, Rules, Precision], Stream]] = {
    "temporal": _temporal,
    "moved": _moved,
    "spatial": _spatial,
    "fused": _fused,
}
"""What each pass that reuses samples resamples from."""


def stream_of(case: Case, rules: Rules, precision: Precision) -> Stream:
    """Candidates of a pass in the order of the rules, and how their stream ends."""
    slots, closing = STREAMS[case.pass_name](case, rules, precision)
    return in_order(slots, closing, rules.order)


def judge_reuse(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge a pass that reuses samples."""
    slots, closing = stream_of(case, rules, precision)
    if rules.normalization in CHAINED:
        return judge_chain(outputs, slots, closing, rules, case.random)
    return judge_resampling(outputs, slots, closing, rules, case.random)


PAST, OWN = 0, 1
"""Slots of the past and of the receiver's own sample, in passes with a past."""


def _closing(case: Case, x: ReceiverPoint, mis: str) -> Closing:
    cap = float(case.settings["cap"])
    return Closing(str(case.settings["target"]), mis, cap, OWN, x)


def _taking_part(slots: list[Slot], rules: Rules) -> list[Slot]:
    """Slots as the rules would have them."""
    for at, merged in ((PAST, rules.past_merged), (OWN, rules.canonical_merged)):
        if not merged:
            none = constant(0.0, slots[at].w)
            slots[at] = replace(slots[at], w=none, M=none)
    return slots


def _bit(words: "Indices", place: int) -> Masks:
    found: Masks = (words >> np.uint32(place)) & np.uint32(1) != 0
    return found


def _new(case: Case, x: ReceiverPoint, rules: Rules, precision: Precision) -> Slot:
    """The sample that the initial pass has drawn."""
    rounding = rounding_of(precision)
    y = with_given(_sample(case, precision, "new_", rules.storage), case, 0)
    p_hat = target_by(rules.target, case.settings["target"], x, y)
    w = rules.fresh_weight(p_hat, exact(case.inputs["new_pdf"], rounding))
    u = decides(case, "u", rounding)
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
    y = _sample(case, precision, prefix, rules.storage)
    y = with_given(y, case, -1 if prefix else 0)
    W, M = (exact(case.inputs[prefix + name], rounding) for name in ("W", "M"))
    W = stored_W(W, rules.storage) if case.decoded is None else W
    M = rules.reused_confidence(M)
    if "past_age" in case.inputs and prefix == "past_" and rules.max_age[1] < inf:
        old, none = _too_old(case, rules), constant(0.0, M)
        W, M = choose(old, none, W), choose(old, none, M)
    if rules.cap_arriving in ("own", "all") or (rules.cap_arriving and prefix):
        M = rules.capped(M, float(case.settings["cap"]))
    at = _reused_at(x, x_from, rules) if x_from else x
    p_hat = target_by(rules.target_of_reused, case.settings["target"], at, y)
    J = constant(1.0, W)
    if x_from:
        J = rules.limited(jacobian_by(rules.jacobian, x_from, x, y))
    w = _weighted(rules, p_hat, W, M, J)
    return Slot(y, p_hat, w, _trusted(rules, M, J), decides(case, u, rounding))


def decides(
    case: Case, name: str, rounding: Rounding, column: int | None = None
) -> Bounded:
    """Random numbers that decide, (N,); anywhere in [0, 1) where nobody gave them.

    A backend with a generator of its own is judged so: each choice that has a chance
    is one that it may make.

    Parameters
    ----------
    name : str; of the buffer; empty for whoever comes first, on whom nothing decides
    column : int, optional; of a buffer with a column for each neighbour
    """
    if not name:
        first = np.zeros(case.rows)
        return Bounded(first, first, rounding)
    if name not in case.inputs:
        half = np.full(case.rows, 0.5)
        return Bounded(half, half, rounding)
    u = case.inputs[name]
    return exact(u if column is None else u[:, column], rounding)


def _reused_at(x: ReceiverPoint, x_from: ReceiverPoint, rules: Rules) -> ReceiverPoint:
    """Where the target of a reused sample is evaluated."""
    if rules.source_target:
        return x_from
    return x.viewed_as(x_from) if rules.views == "source" else x


def _asked_as(x_from: ReceiverPoint, x: ReceiverPoint, rules: Rules) -> ReceiverPoint:
    """A source, as the domain test asks it."""
    return x_from.viewed_as(x) if rules.views == "receiver" else x_from


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
    w = rules.weight(p_hat, W, M, J)
    # A mistake may give light to what has no target, but not by a J that is none.
    lit = (p_hat.value > 0) | (p_hat.error > 0) | np.isfinite(w.value)
    full = (W.value > 0) & lit
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
    sources = SOURCES[case.pass_name]
    x_from, y = _sample_around(case, precision, k, rules.storage, rules.sources_now)
    x_from, y = replace(x_from, number=1 + k), with_given(y, case, 1 + k)
    around = (case.around or case).inputs
    W, M = (exact(around[sources.prefix + name][row], rounding) for name in ("W", "M"))
    W = stored_W(W, rules.storage) if case.decoded is None else W
    none = constant(0.0, M)
    there = there | rules.none_is_first
    M = rules.reused_confidence(choose(there | rules.rejected_counts, M, none))
    if rules.cap_arriving == "all" or (rules.cap_arriving and sources.prefix):
        M = rules.capped(M, float(case.settings["cap"]))
    at = _reused_at(x, x_from, rules)
    p_hat = target_by(rules.target_of_reused, case.settings["target"], at, y)
    trusted = M * constant(rules.neighbor_trust, M) if rules.neighbor_trust != 1 else M
    J = rules.limited(jacobian_by(rules.jacobian, x_from, x, y))
    w = choose(there, _weighted(rules, p_hat, W, trusted, J), none)
    M = _trusted(rules, M, J)
    u = decides(case, sources.u, rounding, 0 if rules.shared_decision else k)
    if rules.shared_decision == "all":
        u = decides(case, "u_own", rounding)
    visible = case.inputs["visible"]
    count = case.inputs[sources.rows].shape[1]
    bits = [0, *range(1, count + 1)]  # of the slots: own, neighbours
    if case.pass_name == "spatial":
        bits = [count + 1, *bits]  # and the past before them
    sees = np.stack([_bit(visible[:, 1 + k], bit) & there for bit in bits])
    domain = Domain(_asked_as(x_from, x, rules), sees)
    slot = Slot(y, p_hat, w, M, u, domain)
    return with_hidden(slot, _bit(visible[:, 0], 1 + k), rules)

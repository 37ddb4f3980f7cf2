"""Replay of resampling: who may have been kept, and the weight it then has."""

from collections.abc import Callable

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Masks
from restir_gi.reference.oracle.cases import Buffers
from restir_gi.reference.oracle.replay.bounded import Bounded, exact
from restir_gi.reference.oracle.replay.cached import target_by
from restir_gi.reference.oracle.replay.formulas import target
from restir_gi.reference.oracle.replay.judgement import (
    Compared,
    Decisions,
    Judgement,
    beside,
    of_light,
)
from restir_gi.reference.oracle.replay.mis import (
    BALANCED,
    IN_WEIGHTS,
    OWN,
    balanced_divisor,
    in_domain,
    weights_asked,
    with_mis_weights,
)
from restir_gi.reference.oracle.replay.points import SamplePoint
from restir_gi.reference.oracle.replay.rules import Rules
from restir_gi.reference.oracle.replay.slots import Closing, Slot, nothing
from restir_gi.reference.oracle.replay.storage import (
    held_as_stored,
    in_format,
    stored_W,
)
from restir_gi.reference.oracle.replay.stream import (
    by_chance,
    choices_of,
    left_open,
    sums_of,
)
from restir_gi.reference.oracle.replay.verbs import choose

COPIED = ("position", "normal", "radiance")


def judge_resampling(
    outputs: Buffers, slots: list[Slot], closing: Closing, rules: Rules, counted: bool
) -> Judgement:
    """Judge the reservoirs that a stream of slots left.

    Parameters
    ----------
    outputs : mapping of str to array; reservoirs of N rows, by the backend
    slots : list of Slot; in the order of the stream
    counted : bool; the numbers that decide are random

    Returns
    -------
    Judgement
        Where the backend's choice is one that rounding allows, its weight is asked
        for; so nothing hangs on a choice that could as well have gone the other way.
    """
    if rules.normalization == OWN:
        return _judge_own_weights(outputs, slots, closing, rules)
    slots = with_mis_weights(slots, closing, rules)
    sums = sums_of(slots, rules)
    total, empty = sums[-1], sums[-1].value == 0
    allowed, surely = choices_of(slots, sums, rules)
    held = held_by(outputs, slots, rules)
    possible = held & allowed
    kept = np.where(possible.any(axis=0), possible.argmax(axis=0), held.argmax(axis=0))

    def fits(kept: Indices) -> Masks:
        W = closed(slots, kept, total, closing, rules)[0]["W"]
        right: Masks = weights_beside(outputs, W, rules).excess <= 1
        return right

    kept = that_fits(kept, possible, fits)
    # By numbers that nobody told any choice is the exact one that may be.
    told = not any(slot.u.error.any() for slot in slots[1:])
    surely = surely if told else kept
    illegal = ~possible.any(axis=0) & ~empty
    weights, M = closed(slots, kept, total, closing, rules)
    W = choose(empty, nothing(total), weights["W"])
    drawn = by_chance(slots)
    differs = (kept != surely) & ~illegal & ~empty & ~held[surely, _row(kept)]
    open_by_chance = left_open(slots, sums)
    decisions = Decisions(illegal, int((differs & drawn).sum()), open_by_chance)
    terms = {f"w of slot {k}": slot.w.value for k, slot in enumerate(slots)}
    terms |= {name: value.value for name, value in weights.items() if name != "W"}
    terms["kept slot"] = kept
    if told:
        terms |= {f"u of slot {k}": slot.u.value for k, slot in enumerate(slots) if k}
        terms["slot in exact arithmetic"] = surely
    compared = compared_with(outputs, slots, surely, illegal, W, M, rules)
    return Judgement(compared, terms, decisions, counted)


def _judge_own_weights(
    outputs: Buffers, slots: list[Slot], closing: Closing, rules: Rules
) -> Judgement:
    """Judge reservoirs whose MIS weights nobody knows but the backend.

    What is kept has to be one of the candidates that could weigh anything, and M is
    known; what W is, the mean has to show.
    """
    held = held_by(outputs, slots, rules)
    could = np.stack([(s.w.value > 0) | (s.w.error > 0) for s in slots])
    possible = held & could
    empty = ~could.any(axis=0)
    kept = np.where(possible.any(axis=0), possible.argmax(axis=0), held.argmax(axis=0))
    illegal = np.asarray(~possible.any(axis=0) & ~empty)
    M = closed(slots, kept, slots[0].w, closing, rules)[1]
    found = outputs["W"].astype(np.float64)
    room = np.where(empty | (found < 0), 0.0, np.inf)
    W = Bounded(np.zeros_like(found), room, M.rounding)
    compared = compared_with(outputs, slots, kept, illegal, W, M, rules)
    return Judgement(compared, {"kept slot": kept}, Decisions(illegal, 0, 0.0))


def that_fits(
    kept: Indices, possible: Masks, fits: Callable[[Indices], Masks]
) -> Indices:
    """Of the slots that may have been kept one whose W is that of the outputs.

    Two slots may hold one sample, as where a patch is met twice.  A choice between
    them that rounding leaves open shows in W alone, as far as that hangs on who made
    the sample: any of them is right, and none is known to be the one.

    Parameters
    ----------
    kept : (N,) int; the slot that is taken where no other fits better
    possible : (S, N) bool; slots that may have been kept, to rounding
    fits : callable; whether W of each row is right, (N,) bool, if these are kept

    Returns
    -------
    (N,) int; a slot of each row
    """
    rows = _row(kept)
    left = possible.copy()
    left[kept, rows] = False
    if not left.any():
        return kept
    right = fits(kept)
    while (again := left.any(axis=0) & ~right).any():
        other = np.where(again, left.argmax(axis=0), kept)
        left[other, rows] = False
        found = again & fits(other)
        kept, right = np.where(found, other, kept), right | found
    return kept


def weights_beside(outputs: Buffers, W: Bounded, rules: Rules) -> Compared:
    """W of the outputs beside what it should be, to rounding and storage.

    Parameters
    ----------
    W : Bounded; (N,)
    """
    found = beside("W", outputs["W"], stored_W(W, rules.storage))
    return of_light(found, outputs["radiance"])


def held_by(outputs: Buffers, slots: list[Slot], rules: Rules) -> Masks:
    """Whether the outputs hold the sample of each slot, (S, N)."""
    return np.stack([held_as_stored(outputs, slot.y, rules.storage) for slot in slots])


def compared_with(
    outputs: Buffers,
    slots: list[Slot],
    surely: Indices,
    illegal: Masks,
    W: Bounded,
    M: Bounded,
    rules: Rules,
) -> tuple[Compared, ...]:
    """Outputs beside what they should be, and beside what their storage can hold.

    Parameters
    ----------
    surely : (N,) int; slots that exact arithmetic keeps
    illegal : (N,) bool; rows that keep what they may not
    W, M : Bounded; (N,)
    """
    copied = [_copied(outputs, slots, surely, illegal, name) for name in COPIED]
    stored = in_format(outputs, rules.storage)
    weights = weights_beside(outputs, W, rules)
    return (*copied, weights, beside("M", outputs["M"], M), *stored)


def _row(kept: Indices) -> Indices:
    return np.arange(len(kept))


def _copied(
    outputs: Buffers, slots: list[Slot], surely: Indices, illegal: Masks, name: str
) -> Compared:
    """Buffers of the kept sample, which are wrong only where the choice is."""
    stack = np.stack([getattr(slot.y, name).value for slot in slots])
    expected = stack[surely, _row(surely)]
    found = outputs[name].astype(np.float64)
    room = np.where(illegal[:, None], 0.0, np.inf)
    return Compared(name, found, expected, np.broadcast_to(room, found.shape))


def closed(
    slots: list[Slot], kept: Indices, total: Bounded, closing: Closing, rules: Rules
) -> tuple[dict[str, Bounded], Bounded]:
    """W with its parts, and M, of rows that kept the given slots.

    Parameters
    ----------
    kept : (N,) int
    total : Bounded; (N,), sum of all weights
    """
    y, p_hat = of_kept(slots, kept)
    if rules.target_of == "first":
        p_hat = slots[0].p_hat
    M = slots[0].M
    for slot in slots[1:]:
        M = rules.merged_confidence(M, slot.M)
    Z = _normalization(slots, kept, y, p_hat, M, closing, rules)
    if rules.cap_when == "first":
        Z = rules.capped(Z, closing.cap)
    divisor = (
        _source_target(slots, kept, y, p_hat, closing)
        if rules.divides_by_source_target
        else p_hat
    )
    W = rules.closed(total, divisor, Z)
    if rules.cap_when == "late":
        W = W * (M / rules.capped(M, closing.cap))
    M = closed_confidence(M, closing, rules)
    return {"W": W, "p_hat": divisor, "Z": Z, "sum of w": total}, M


def closed_confidence(M: Bounded, closing: Closing, rules: Rules) -> Bounded:
    """M of a reservoir that is closed, (N,)."""
    if rules.cap_when != "never":
        M = rules.capped(M, closing.cap)
    return rules.stored_confidence(M)


def of_kept(slots: list[Slot], kept: Indices) -> tuple[SamplePoint, Bounded]:
    """Sample and target of the slots that were kept.

    Parameters
    ----------
    kept : (N,) int
    """
    y, p_hat = slots[0].y, slots[0].p_hat
    for k, slot in enumerate(slots[1:], start=1):
        here = kept == k
        position, normal, radiance = (
            choose(here, getattr(slot.y, n), getattr(y, n)) for n in COPIED
        )
        given = y.given
        if given is not None and slot.y.given is not None:
            given = choose(here, slot.y.given, given)
        y = SamplePoint(position, normal, radiance, given)
        p_hat = choose(here, slot.p_hat, p_hat)
    return y, p_hat


def _normalization(
    slots: list[Slot],
    kept: Indices,
    y: SamplePoint,
    p_hat: Bounded,
    M: Bounded,
    closing: Closing,
    rules: Rules,
) -> Bounded:
    asked = weights_asked(closing, rules)
    if asked in BALANCED:
        return balanced_divisor(slots, kept, y, p_hat, closing, rules)
    if asked == "1" or asked in IN_WEIGHTS:
        return exact(np.ones_like(M.value), M.rounding)
    if asked == "1/M" or not any(slot.domain for slot in slots):
        return _all_counted(slots, M, rules)
    Z = nothing(M)
    for k, slot in enumerate(slots):
        counted = _counted(slots, k, M, rules)
        if slot.domain is None:
            if k != closing.canonical or rules.canonical_in_z:
                Z = Z + counted
            continue
        x = closing.receiver if rules.receivers_domain else slot.domain.x
        p = target_by(rules.target_at_source, closing.kind, x, y)
        p = in_domain(p, slot, y, closing, rules)
        seen = slot.domain.sees[kept, _row(kept)] | (not rules.visibility_in_z)
        if not rules.maker_in_z:
            seen = seen & (kept != k)
        term = if_in_domain(p, seen, counted)
        if rules.domain_target is None:
            # By another target its maker would never have kept the given sample:
            # whether it is asked is open then.
            odd = (kept == k) & seen & (p.value <= 0)
            room = np.where(odd, counted.value, 0.0)
            term = Bounded(term.value, term.error + room, term.rounding)
        Z = Z + term
    return Z


EACH = ("last", "one", "full")
"""What Z may add for each of those that could have made the sample, other than M."""


def _all_counted(slots: list[Slot], M: Bounded, rules: Rules) -> Bounded:
    """The divisor of 1/M."""
    if rules.counted_as == "rest":
        return M - slots[0].M
    if rules.counted_as in EACH and not any(slot.domain for slot in slots):
        # Where nothing moves all could have made the sample, and Z counts them so.
        each = [_counted(slots, k, M, rules) for k in range(len(slots))]
        return sum(each[1:], each[0])
    if rules.counted_as != "merged":
        return M
    total = nothing(M)
    for slot in slots:
        total = total + (slot.M if slot.domain else M)
    return total


def _counted(slots: list[Slot], k: int, M: Bounded, rules: Rules) -> Bounded:
    """What Z adds for a slot that could have made the sample."""
    if rules.counted_as == "last":
        return slots[-1].M
    if rules.counted_as == "one":
        return exact(np.ones_like(M.value), M.rounding)
    if rules.counted_as == "full":
        return exact((slots[k].M.value > 0).astype(float), M.rounding)
    if rules.counted_as == "merged" and slots[k].domain is None:
        return M
    return slots[k].M


def if_in_domain(p: Bounded, seen: Masks, M: Bounded) -> Bounded:
    """M where the target is positive and the sample is seen; either, if uncertain.

    Parameters
    ----------
    p, M : Bounded; (N,)
    seen : (N,) bool
    """
    sure = p.surely_positive | p.surely_not_positive | ((p.value == 0) & (p.error == 0))
    value = np.where(seen & (p.value > 0), M.value, 0.0)
    error = np.where(seen & ~sure, M.value, 0.0) + M.error
    return Bounded(value, error, M.rounding)


def _source_target(
    slots: list[Slot], kept: Indices, y: SamplePoint, p_hat: Bounded, closing: Closing
) -> Bounded:
    for k, slot in enumerate(slots):
        if slot.domain is not None:
            there = target_by(target, closing.kind, slot.domain.x, y)
            p_hat = choose(kept == k, there, p_hat)
    return p_hat

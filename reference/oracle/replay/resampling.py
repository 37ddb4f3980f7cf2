"""Replay of resampling: who may have been kept, and the weight it then has."""

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Masks
from restir_gi.reference.oracle.cases import Buffers
from restir_gi.reference.oracle.replay.bounded import Bounded, exact
from restir_gi.reference.oracle.replay.judgement import (
    Compared,
    Decisions,
    Judgement,
    beside,
)
from restir_gi.reference.oracle.replay.points import SamplePoint, same_points
from restir_gi.reference.oracle.replay.rules import Rules
from restir_gi.reference.oracle.replay.slots import Closing, Slot, backwards, nothing
from restir_gi.reference.oracle.replay.stream import choices_of, left_open, sums_of
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
    if rules.backwards:
        slots, closing = backwards(slots, closing)
    sums = sums_of(slots, rules)
    total, empty = sums[-1], sums[-1].value == 0
    allowed, surely = choices_of(slots, sums, rules)
    held = np.stack([same_points(outputs, slot.y) for slot in slots])
    possible = held & allowed
    kept = np.where(possible.any(axis=0), possible.argmax(axis=0), held.argmax(axis=0))
    illegal = ~possible.any(axis=0) & ~empty
    weights, M = _closed(slots, kept, total, closing, rules)
    none = nothing(total)
    W = choose(empty, none, weights["W"])
    decisions = Decisions(
        illegal,
        int(((kept != surely) & ~illegal & ~empty & ~held[surely, _row(kept)]).sum()),
        left_open(slots, sums),
    )
    copied = [_copied(outputs, slots, surely, illegal, name) for name in COPIED]
    terms = {f"w of slot {k}": slot.w.value for k, slot in enumerate(slots)}
    terms |= {f"u of slot {k}": slot.u.value for k, slot in enumerate(slots) if k}
    terms |= {name: value.value for name, value in weights.items() if name != "W"}
    terms |= {"kept slot": kept, "slot in exact arithmetic": surely}
    compared = (*copied, beside("W", outputs["W"], W), beside("M", outputs["M"], M))
    return Judgement(compared, terms, decisions, counted)


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


def _closed(
    slots: list[Slot], kept: Indices, total: Bounded, closing: Closing, rules: Rules
) -> tuple[dict[str, Bounded], Bounded]:
    """W with its parts, and M, of rows that kept the given slots."""
    y, p_hat = _of_kept(slots, kept)
    if rules.target_of == "first":
        p_hat = slots[0].p_hat
    M = slots[0].M
    for slot in slots[1:]:
        M = rules.merged_confidence(M, slot.M)
    Z = _normalization(slots, kept, y, M, closing, rules)
    if rules.cap_when == "first":
        Z = rules.capped(Z, closing.cap)
    divisor = (
        _source_target(slots, kept, y, p_hat, closing)
        if rules.divides_by_source_target
        else p_hat
    )
    W = rules.finalized(total, divisor, Z)
    if rules.cap_when == "late":
        W = W * (M / rules.capped(M, closing.cap))
    if rules.cap_when not in ("never", "arrival"):
        M = rules.capped(M, closing.cap)
    return {"W": W, "p_hat": divisor, "Z": Z, "sum of w": total}, M


def _of_kept(slots: list[Slot], kept: Indices) -> tuple[SamplePoint, Bounded]:
    y, p_hat = slots[0].y, slots[0].p_hat
    for k, slot in enumerate(slots[1:], start=1):
        here = kept == k
        y = SamplePoint(
            *(choose(here, getattr(slot.y, name), getattr(y, name)) for name in COPIED)
        )
        p_hat = choose(here, slot.p_hat, p_hat)
    return y, p_hat


def _normalization(
    slots: list[Slot],
    kept: Indices,
    y: SamplePoint,
    M: Bounded,
    closing: Closing,
    rules: Rules,
) -> Bounded:
    asked = closing.mis if rules.normalization == "asked" else rules.normalization
    if asked == "1":
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
        p = rules.domain_target(closing.kind, x, y)
        seen = slot.domain.sees[kept, _row(kept)] | (not rules.visibility_in_z)
        if not rules.maker_in_z:
            seen = seen & (kept != k)
        Z = Z + _if_in_domain(p, seen, counted)
    return Z


def _all_counted(slots: list[Slot], M: Bounded, rules: Rules) -> Bounded:
    """The divisor of 1/M."""
    if rules.counted_as == "rest":
        return M - slots[0].M
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
        return exact((slots[k].M.value > 0).astype(float), M.rounding)
    if rules.counted_as == "merged" and slots[k].domain is None:
        return M
    return slots[k].M


def _if_in_domain(p: Bounded, seen: Masks, M: Bounded) -> Bounded:
    """M where the target is positive and the sample is seen; either, if uncertain."""
    sure = p.surely_positive | p.surely_not_positive | ((p.value == 0) & (p.error == 0))
    value = np.where(seen & (p.value > 0), M.value, 0.0)
    error = np.where(seen & ~sure, M.value, 0.0) + M.error
    return Bounded(value, error, M.rounding)


def _source_target(
    slots: list[Slot], kept: Indices, y: SamplePoint, p_hat: Bounded, closing: Closing
) -> Bounded:
    rules = Rules()
    for k, slot in enumerate(slots):
        if slot.domain is not None:
            there = rules.target(closing.kind, slot.domain.x, y)
            p_hat = choose(kept == k, there, p_hat)
    return p_hat

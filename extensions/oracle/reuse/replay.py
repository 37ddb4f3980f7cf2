"""Replay of generalized resampling on tables."""

from dataclasses import dataclass, replace

import numpy as np

from restir_gi.extensions.oracle.reuse.rules import reusing
from restir_gi.extensions.oracle.reuse.tables import ReuseTables, tables_of
from restir_gi.extensions.oracle.reuse.weights import arriving, divisor, of_kept, total
from restir_gi.reference.numerics.arrays import Indices, Masks
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.replay.bounded import Bounded, exact, rounding_of
from restir_gi.reference.oracle.replay.formulas import capped
from restir_gi.reference.oracle.replay.halves import (
    beside_halves,
    counted_in_half,
    held_in_half,
    up_to_the_largest,
)
from restir_gi.reference.oracle.replay.judgement import (
    Compared,
    Decisions,
    Judgement,
    beside,
)
from restir_gi.reference.oracle.replay.rules import Rules
from restir_gi.reference.oracle.replay.stream import (
    by_chance,
    choices_of,
    left_open,
    sums_of,
)
from restir_gi.reference.oracle.replay.verbs import choose


@dataclass(frozen=True, slots=True, eq=False)
class _Slot:
    w: Bounded
    u: Bounded


def judge_path_reuse(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``path_reuse``.

    Where the backend's choice is one that rounding allows, the weight that goes with it
    is asked for.
    """
    rounding, part = rounding_of(precision), reusing(rules)
    t = _as_held(tables_of(case, part, rounding), part.held)
    w = arriving(t, part)
    numbers = [t.one - u for u in t.u] if part.u_turned else t.u
    slots = [_Slot(*each) for each in zip(w, numbers, strict=True)]
    sums = sums_of(slots, rules)
    S, empty = sums[-1], sums[-1].value == 0
    allowed, surely = choices_of(slots, sums, rules)
    row, found = np.arange(case.rows), outputs["slot"].astype(np.int64)
    known = (found >= 0) & (found < len(slots))
    kept = np.where(known & ~empty, found, surely)
    illegal = ~empty & ~(known & allowed[kept, row])
    Z, here = divisor(t, kept, part), of_kept(t.here, kept)
    M = total(t.M)
    W = S / here / Z
    if part.capped == "W":
        W = W * (capped(M, t.cap) / M)
    W = choose(empty, exact(np.zeros(case.rows), rounding), W)
    M = M if part.capped in ("never", "before") else capped(M, t.cap)
    drawn = by_chance(slots)
    differs = int(((kept != surely) & ~illegal & ~empty & drawn).sum())
    terms = {f"w of slot {k}": slot.w.value for k, slot in enumerate(slots)}
    terms |= {f"u of slot {k}": slot.u.value for k, slot in enumerate(slots) if k}
    terms |= {"sum of w": S.value, "Z": Z.value, "p_hat": here.value}
    return Judgement(
        (
            Compared("slot", found, surely, np.where(illegal, 0.0, np.inf)),
            _kept_target(case, outputs, kept, illegal | empty),
            beside("W", up_to_the_largest(outputs["W"]), held_in_half(W, part.held)),
            beside("M", outputs["M"], counted_in_half(M, part.held)),
            *beside_halves("W", outputs["W"], part.held),
            *beside_halves("M", outputs["M"], part.held),
        ),
        terms,
        Decisions(illegal, differs, left_open(slots, sums)),
        case.random,
    )


def _as_held(t: ReuseTables, how: str) -> ReuseTables:
    """Reservoirs as they come out of storage."""
    return replace(
        t,
        W=[held_in_half(W, how) for W in t.W],
        M=[counted_in_half(M, how) for M in t.M],
    )


def _kept_target(case: Case, outputs: Buffers, kept: Indices, free: Masks) -> Compared:
    """What is kept has its target here; nobody asks what an empty reservoir holds."""
    here = case.inputs["target_here"][np.arange(len(kept)), kept]
    return Compared("p_hat", outputs["p_hat"], here, np.where(free, np.inf, 0.0))

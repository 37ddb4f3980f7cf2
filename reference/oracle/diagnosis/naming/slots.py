"""The stream of each row, slot by slot, with what its weights are made of."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars
from restir_gi.reference.oracle.cases import SOURCES, Buffers, Case
from restir_gi.reference.oracle.diagnosis.naming.factors import (
    RowFacts,
    of_sample,
    of_shift,
)
from restir_gi.reference.oracle.replay.bounded import Bounded, Rounding, exact
from restir_gi.reference.oracle.replay.cached import target_by
from restir_gi.reference.oracle.replay.formulas import target
from restir_gi.reference.oracle.replay.judgement import Compared, Judgement
from restir_gi.reference.oracle.replay.points import (
    ReceiverPoint,
    SamplePoint,
    point_of,
    receiver_of,
    same_points,
    with_given,
)

STREAMS: Mapping[str, tuple[str, ...]] = {
    "temporal": ("the past", "the new sample"),
    "moved": ("the past", "the new sample"),
    "spatial": ("the past", "the pixel's own", "the neighbours"),
    "fused": ("the pixel's own", "the neighbours"),
}
"""Kinds of reservoirs of each pass; the slots from the last on are of the last kind."""


@dataclass(frozen=True, slots=True, eq=False)
class SlotFacts:
    """A slot of each row's stream.

    Attributes
    ----------
    kind : str; of `STREAMS`
    w, M, u : (N,) float64; weight and confidence by the contract, and what decides
    held : (N,) bool; whether the backend has kept this very sample
    facts : RowFacts; factors of its weight are among them
    """

    kind: str
    w: Scalars
    M: Scalars
    u: Scalars
    held: Masks
    facts: RowFacts

    def values(self, name: str) -> Scalars | None:
        """A factor of the weight, or the weight "w", (N,); ``None`` if it has none."""
        if name == "w":
            return self.w
        factor = self.facts.factors.get(name)
        return factor.value if factor is not None else None


@dataclass(frozen=True, slots=True, eq=False)
class StreamFacts:
    """A case of a pass that merges reservoirs.

    Attributes
    ----------
    kept : (N,) int; slot that the backend has kept
    illegal : (N,) bool; where no rounding explains that
    W : Compared; contribution weights
    given : (N, S) float or None; weights by the backend, where it tells them
    ordinary : (N,) bool; rows within the working range
    start : int; number of the first row among those of all cases
    """

    slots: list[SlotFacts]
    kept: Indices
    illegal: Masks
    W: Compared
    given: NDArray[Any] | None
    ordinary: Masks
    start: int


def stream_of(
    case: Case,
    judgement: Judgement,
    outputs: Buffers,
    ordinary: Masks,
    start: int,
    rounding: Rounding,
) -> StreamFacts:
    """The stream of each row, in the contract's order.

    Parameters
    ----------
    outputs : mapping of str to array; by the backend
    ordinary : (N,) bool; rows within the working range
    start : int; number of the first row among those of all cases
    """
    terms, kinds = judgement.terms, STREAMS[case.pass_name]
    slots = []
    for k in range(sum(name.startswith("w of slot ") for name in terms)):
        kind = kinds[min(k, len(kinds) - 1)]
        y, M, facts = _slot(case, kind, k - len(kinds) + 1, rounding)
        w, u = terms[f"w of slot {k}"], terms.get(f"u of slot {k}", np.zeros(case.rows))
        slots.append(SlotFacts(kind, w, M, u, same_points(outputs, y), facts))
    W = next(c for c in judgement.compared if c.name == "W")
    none = np.zeros(case.rows, bool)
    illegal = none if judgement.decisions is None else judgement.decisions.illegal
    given = outputs.get("term_w")
    return StreamFacts(slots, terms["kept slot"], illegal, W, given, ordinary, start)


def _slot(
    case: Case, kind: str, k: int, rounding: Rounding
) -> tuple[SamplePoint, Scalars, RowFacts]:
    """Sample, confidence and factors of a slot; of neighbours, that of neighbour k."""
    given, x = case.inputs, receiver_of(case.inputs, rounding)
    if kind == "the new sample":
        y = with_given(point_of(given, rounding, "new_"), case, 0)
        p_hat, pdf = _target(case, x, y), exact(given["new_pdf"], rounding)
        seen = of_sample(x, y)
        return y, np.ones(case.rows), seen | RowFacts({"p_hat": p_hat, "pdf": pdf})
    prefix = "past_" if kind == "the past" else ""
    own = with_given(point_of(given, rounding, prefix), case, -1 if prefix else 0)
    y, x_from = own, None
    W, M = (exact(given[prefix + name], rounding) for name in ("W", "M"))
    there = np.ones(case.rows, bool)
    if kind == "the neighbours":
        around = SOURCES[case.pass_name]
        row = given[around.rows][:, k]
        there, row = row >= 0, np.maximum(row, 0)
        y = point_of(given, rounding, around.prefix).rows(row)
        y = with_given(y, case, 1 + k)
        x_from = receiver_of(given, rounding, around.prefix).rows(row)
        W, M = (exact(given[around.prefix + n][row], rounding) for n in ("W", "M"))
    elif case.pass_name == "moved":
        x_from = receiver_of(given, rounding, "past_")
    factors = {"p_hat": _target(case, x, y), "W": W, "M": M}
    seen, cap = of_sample(x, y), float(case.settings["cap"])
    shift = of_shift(x_from, x, y) if x_from else RowFacts()
    if x_from and kind == "the neighbours":
        turned = of_shift(x_from, x, replace(y, normal=own.normal)).factors["J"]
        factors["J with the normal of the pixel's own sample"] = turned
    conditions = {"M is at the cap": M.value == cap, "M is above 1": M.value > 1}
    facts = seen | RowFacts(factors, conditions) | shift
    return y, np.where(there, M.value, 0.0), facts


def _target(case: Case, x: ReceiverPoint, y: SamplePoint) -> Bounded:
    return target_by(target, case.settings["target"], x, y)


def of_kept(
    case: Case, stream: StreamFacts, judgement: Judgement, rounding: Rounding
) -> RowFacts:
    """What is known of the sample that is kept, and of how its reservoir is closed."""
    slots, kept = stream.slots, stream.kept
    names = dict.fromkeys(name for slot in slots for name in slot.facts.factors)
    factors = {
        name if name not in ("W", "M") else f"{name} of what is kept": _picked(
            [slot.facts.factors.get(name) for slot in slots], kept, rounding
        )
        for name in names
    }
    terms = {"Z": judgement.terms["Z"], "Σw": judgement.terms["sum of w"]}
    total = np.sum([slot.M for slot in slots], axis=0)
    terms |= {"ΣM": total, "cap": np.full(case.rows, float(case.settings["cap"]))}
    terms["its number of reservoirs"] = np.sum([s.M > 0 for s in slots], axis=0) * 1.0
    for kind in dict.fromkeys(slot.kind for slot in slots):
        own = np.sum([slot.M for slot in slots if slot.kind == kind], axis=0)
        terms |= {f"M of {kind}": own, f"ΣM without {kind}": total - own}
    factors |= {name: _known(values, rounding) for name, values in terms.items()}
    return RowFacts(factors, _when_kept(case, slots, judgement, total))


def _when_kept(
    case: Case, slots: list[SlotFacts], judgement: Judgement, total: Scalars
) -> dict[str, Masks]:
    kept, cap = judgement.terms["kept slot"], float(case.settings["cap"])
    kinds, all_in = (
        np.array([s.kind for s in slots])[kept],
        judgement.terms["Z"] == total,
    )
    found: dict[str, Masks] = {
        "one of the neighbours is kept"
        if kind == "the neighbours"
        else f"{kind} is kept": kinds == kind
        for kind in dict.fromkeys(s.kind for s in slots)
    }
    found |= {
        "ΣM is above the cap": total > cap,
        "ΣM is at most the cap": total <= cap,
        "ΣM reaches the cap": total >= cap,
        "ΣM is below the cap": total < cap,
        "Z is ΣM": all_in,
        "Z is less than ΣM": ~all_in,
        **{
            f"{name} is {value}": np.ones(case.rows, bool)
            for name, value in case.settings.items()
            if isinstance(value, str)
        },
    }
    if case.pass_name == "moved":
        seen = case.inputs["visible"][:, 0] & 2 != 0
        found |= {"x does not see the past's sample": ~seen}
    rows = np.arange(case.rows)
    for name in slots[0].facts.conditions:
        of_slots = [s.facts.conditions.get(name) for s in slots]
        known = [c for c in of_slots if c is not None]
        if len(known) == len(slots):
            found[name] = np.stack(known)[kept, rows]
    return found


def _picked(parts: list[Bounded | None], kept: Indices, rounding: Rounding) -> Bounded:
    """A number of the slot that is kept; not a number where it has none."""
    rows = np.arange(len(kept))
    none = np.full(len(kept), np.nan)
    value = np.stack([none if p is None else p.value for p in parts])
    error = np.stack([none if p is None else p.error for p in parts])
    return Bounded(value[kept, rows], error[kept, rows], rounding)


def _known(values: Scalars, rounding: Rounding) -> Bounded:
    return Bounded(values, 4 * rounding.unit * np.abs(values), rounding)

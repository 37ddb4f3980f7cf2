"""The tables of a case, as bounded numbers, slot by slot."""

from dataclasses import dataclass

import numpy as np

from restir_gi.extensions.oracle.reuse.rules import ReuseRules
from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.replay.bounded import Bounded, Rounding, constant, exact
from restir_gi.reference.oracle.replay.formulas import capped
from restir_gi.reference.oracle.replay.verbs import choose

PAIRS = ("pairwise", "defensive")


@dataclass(frozen=True, slots=True, eq=False)
class ReuseTables:
    """What K slots bring, and what the weights make of it.

    Attributes
    ----------
    W, M, u, here, jacobian, made : list of (N,) Bounded
        Of each slot: what is given, with M as it counts, and the target where its
        sample was made, in the receiver's measure.
    at_others : (N, K, K) Bounded; of the sample of a slot, at a source
    canonical : int; slot that stands
    mis : str; what is asked for
    """

    W: list[Bounded]
    M: list[Bounded]
    u: list[Bounded]
    here: list[Bounded]
    jacobian: list[Bounded]
    made: list[Bounded]
    at_others: Bounded
    canonical: int
    mis: str
    cap: float

    @property
    def sources(self) -> list[int]:
        """Slots but the canonical one."""
        return [k for k in range(len(self.W)) if k != self.canonical]

    @property
    def one(self) -> Bounded:
        """The number, (N,)."""
        return constant(1.0, self.W[0])


def tables_of(case: Case, rules: ReuseRules, rounding: Rounding) -> ReuseTables:
    """Read a case; slots without a source bring nothing."""
    given = {
        name: exact(array, rounding)
        for name, array in case.inputs.items()
        if name not in ("there", "target_at")
    }
    slots = range(given["W"].value.shape[1])
    there = [case.inputs["there"][:, k] == 1 for k in slots]
    none = exact(np.zeros(case.rows), rounding)
    W = [choose(there[k], given["W"][:, k], none) for k in slots]
    M = [given["M"][:, k] for k in slots]
    if not rules.empty_count:
        M = [choose(there[k], M[k], none) for k in slots]
    if not rules.nulls_count:
        M = [choose(W[k].value > 0, M[k], none) for k in slots]
    cap = float(case.settings["cap"])
    if rules.capped == "before":
        M = [capped(m, cap) for m in M]
    here, base, jacobian = (
        [given[name][:, k] for k in slots]
        for name in ("target_here", "target_base", "jacobian")
    )
    if rules.target_base:
        here = base
    return ReuseTables(
        W,
        M,
        u=[given["u"][:, k] for k in slots],
        here=here,
        jacobian=jacobian,
        made=[
            _made(b, h, j, rules) for b, h, j in zip(base, here, jacobian, strict=True)
        ],
        at_others=exact(case.inputs["target_at"], rounding),
        canonical=int(case.settings["canonical"]),
        mis=str(case.settings["mis"]),
        cap=cap,
    )


def _made(base: Bounded, here: Bounded, J: Bounded, rules: ReuseRules) -> Bounded:
    none = exact(np.zeros_like(J.value), J.rounding)
    found = {
        "over": base / J,
        "none": choose(J.value > 0, base, none),
        "times": base * J,
        "here": here,
    }
    return found[rules.made]

"""A known mistake, as rules that a replay can calculate with."""

from dataclasses import dataclass, replace
from typing import Any, Literal

from restir_gi.reference.oracle.replay.rules import CONTRACT_RULES, Rules

TEMPORAL, SPATIAL = ("temporal", "moved"), ("spatial",)
REUSE = (*TEMPORAL, *SPATIAL)
SHIFTED = ("moved", "spatial")


Departure = Literal["", "order", "confidence", "target", "filter"]
"""What a mistake leaves alone.  'order': the distribution of every run, as where other
random numbers decide in the same way; 'confidence': the mean, as W is rebuilt from what
is stored and any M that depends on no sample will do; 'target': the mean, as p̂ cancels
between weight and W where it is the same in both; 'filter': all runs of the loop, which
has no such pass.  Empty: nothing."""


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """One mistake.

    Attributes
    ----------
    name : str; also the anchor of its paragraph in the documentation
    mistake : str; what was done, in one line
    wrong, right : str; the formula as it was, and as it should be
    passes : tuple of str; where it can show
    rules : Rules; the contract with the mistake in it
    seen : tuple of str; where it has happened: papers, projects, changes
    departure : str
        Whether it is no mistake but a departure from the contract, and of which kind.
    """

    name: str
    mistake: str
    wrong: str
    right: str
    passes: tuple[str, ...]
    rules: Rules
    seen: tuple[str, ...] = ()
    departure: Departure = ""


def mistake(
    name: str,
    what: str,
    wrong: str,
    right: str,
    passes: tuple[str, ...],
    *seen: str,
    departure: Departure = "",
    **rules: Any,
) -> Hypothesis:
    """A hypothesis, from what differs from the contract.

    Parameters
    ----------
    name, what, wrong, right : str; name and mistake, and both formulas
    passes : tuple of str; where it can show
    **rules : Any; fields of `Rules`
    """
    changed = replace(CONTRACT_RULES, **rules)
    return Hypothesis(name, what, wrong, right, passes, changed, seen, departure)

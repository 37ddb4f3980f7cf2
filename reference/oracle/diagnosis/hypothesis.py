"""A known difference from the contract, as rules that a replay can calculate with."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import lru_cache
from typing import Any, Literal

from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.replay.rules import CONTRACT_RULES, Rules
from restir_gi.reference.oracle.replay.target_rules import TargetRules

TEMPORAL, SPATIAL = ("temporal", "moved"), ("spatial", "fused")
REUSE = (*TEMPORAL, *SPATIAL)
SHIFTED = ("moved", *SPATIAL)


Departure = Literal[
    "",
    "order",
    "confidence",
    "target",
    "mis",
    "domain",
    "visibility",
    "storage",
    "filter",
    "neighbors",
    "bias",
]
"""What a choice leaves alone.  'order': the distribution of every run, as where other
random numbers decide in the same way; 'confidence': the mean, as W is rebuilt from what
is stored and any M that depends on no sample will do; 'target': the mean, as p̂ cancels
between weight and W where it is the same in both; 'mis': the mean, as the weights of
those that could have made a sample sum to 1; 'domain': the mean, as what is refused one
way is not expected the other way; 'visibility': the mean of what a receiver sees;
'storage': the mean, to the rounding of a format; 'filter': all runs of the loop, which
has no such pass; 'neighbors': the mean, as who is a neighbour hangs on no sample;
'bias': nothing but the rows, as its formula is known to be biased and
is declared all the same.  Empty: nothing."""


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """One difference from the contract.

    Attributes
    ----------
    name : str; also the anchor of its paragraph in the documentation
    mistake : str; what was done, in one line
    wrong, right : str; the formula as it was, and as it should be
    passes : tuple of str; where it can show
    rules : Rules; the contract with the difference in it
    seen : tuple of str; where it has happened: papers, projects, changes
    departure : str
        Whether it is no mistake but a departure from the contract, and of which kind.
    declared : str
        The kind of departure that it is for a backend that declares it by name.
    needs : tuple of str
        A pass, and the hypothesis that has to explain it: else it is no departure.
    only : tuple of str and tuple of str, or None
        A setting, and its values with which it shows; ``None``: whatever is set.
    """

    name: str
    mistake: str
    wrong: str
    right: str
    passes: tuple[str, ...]
    rules: Rules
    seen: tuple[str, ...] = ()
    departure: Departure = ""
    declared: Departure = ""
    needs: tuple[str, str] | None = None
    only: tuple[str, tuple[str, ...]] | None = None

    def shows_in(self, case: Case) -> bool:
        """Whether it can show in a case, by pass and settings."""
        if case.pass_name not in self.passes:
            return False
        return self.only is None or case.settings.get(self.only[0]) in self.only[1]


def mistake(
    name: str,
    what: str,
    wrong: str,
    right: str,
    passes: tuple[str, ...],
    *seen: str,
    departure: Departure = "",
    declared: Departure = "",
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
    return Hypothesis(
        name, what, wrong, right, passes, changed, seen, departure, declared
    )


def as_declared(h: Hypothesis) -> Hypothesis:
    """A choice of the kind that it is for a backend that declares it."""
    return replace(h, departure=h.departure or h.declared or "bias")


@lru_cache(maxsize=1024)
def changes(rules: Rules) -> Mapping[str, Any]:
    """What differs from the contract: fields, and their values.

    A field of the target is written as ``target.kind``.
    """
    return dict(_differences("", CONTRACT_RULES, rules))


def _differences(prefix: str, base: Any, other: Any) -> Iterator[tuple[str, Any]]:
    for field in fields(base):
        a, b = getattr(base, field.name), getattr(other, field.name)
        if a is b or a == b:
            continue
        if isinstance(a, TargetRules) and isinstance(b, TargetRules):
            yield from _differences(f"{field.name}.", a, b)
        else:
            yield prefix + field.name, b


def compatible(hypotheses: Sequence[Hypothesis]) -> bool:
    """Whether all can hold at once, and none of them is part of the others."""
    found = [changes(h.rules) for h in hypotheses]
    whole: dict[str, Any] = {}
    for one in found:
        for name, value in one.items():
            if whole.setdefault(name, value) != value:
                return False
    if "target" in whole and any(name.startswith("target.") for name in whole):
        return False
    others = [{n for b in found if b is not a for n in b} for a in found]
    return not any(set(a) <= more for a, more in zip(found, others, strict=True))


def combined(hypotheses: Iterable[Hypothesis]) -> Rules:
    """The contract with several differences in it, which are compatible."""
    of_rules: dict[str, Any] = {}
    of_target: dict[str, Any] = {}
    for h in hypotheses:
        for name, value in changes(h.rules).items():
            prefix, _, field = name.rpartition(".")
            (of_target if prefix else of_rules)[field] = value
    if of_target:
        of_rules["target"] = replace(TargetRules(), **of_target)
    return replace(CONTRACT_RULES, **of_rules)

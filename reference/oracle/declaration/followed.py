"""Whether a backend does what it declares, pass by pass, and what that does to it."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import Literal

from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.declaration.declared import Declaration
from restir_gi.reference.oracle.diagnosis.diagnose import Diagnosis, follows
from restir_gi.reference.oracle.diagnosis.hypothesis import (
    Hypothesis,
    combined,
    compatible,
)
from restir_gi.reference.oracle.diagnosis.innocence import (
    BiasOfLight,
    bias_of,
    bias_of_light,
)
from restir_gi.reference.oracle.levels.probe import Answer
from restir_gi.reference.oracle.replay.mis import OWN
from restir_gi.reference.oracle.replay.reuse import STREAMS
from restir_gi.reference.oracle.replay.rules import CONTRACT_RULES

State = Literal["followed", "not shown", "otherwise", "unknown", "not asked"]

Names = tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Followed:
    """What a pass does of what was declared.

    Attributes
    ----------
    declared : tuple of str; names of the choices that it is said to make
    state : str
        'followed'; 'not shown': it changes none of the rows that were asked for;
        'otherwise': the rows are those of other choices; 'unknown': of none; 'not
        asked': weights of its own, of which nobody has asked for the mean.
    found : tuple of str
        Names of the choices and mistakes that the rows are those of; none: the
        contract's.
    """

    pass_name: str
    declared: Names
    state: State
    found: Names = ()

    @property
    def undeclared(self) -> Names:
        """What was found besides."""
        return tuple(name for name in self.found if name not in self.declared)

    @property
    def text(self) -> str:
        """In words."""
        said = ", ".join(self.declared)
        declares = f"{self.pass_name} declares {said}"
        if self.state == "not shown":
            return f"{declares}: its rows are the contract's, with it and without it"
        if self.state == "followed":
            more = ", ".join(self.undeclared)
            besides = f", and besides {more}, which it does not declare" if more else ""
            return f"{self.pass_name} follows {said}{besides}"
        if self.state == "not asked":
            return f"{declares}, which level L1 alone can judge: it was not asked"
        but = f"{declares}, but its rows are not those of {said}"
        if self.state == "unknown":
            return f"{but}, nor of anything known"
        return f"{but}: they are those of {', '.join(self.found) or 'the contract'}"


def followed_in(
    pass_name: str,
    declared: tuple[Hypothesis, ...],
    answers: Sequence[Answer],
    diagnosis: Diagnosis | None,
    precision: Precision,
) -> Followed:
    """What a pass does of its declared choices, which are one at least.

    Parameters
    ----------
    answers : sequence of Answer; all that a replay can explain
    diagnosis : Diagnosis or None; of a pass that is not the contract's
    """
    said = tuple(h.name for h in declared)
    if diagnosis is None or not diagnosis.explanations:
        if diagnosis is not None:
            own = any(h.rules.normalization == OWN for h in declared)
            asked = any(a.probe.level == "L1" for a in answers)
            state: State = "not asked" if own and not asked else "unknown"
            return Followed(pass_name, said, state)
        shown = not follows(answers, declared, precision)
        return Followed(pass_name, said, "otherwise" if shown else "not shown")
    best = diagnosis.explanations[0]
    names = tuple(h.name for h in best.hypotheses)
    missing = tuple(h for h in declared if h.name not in names)
    if missing:
        whole = (*best.hypotheses, *missing)
        idle = compatible(whole) and follows(answers, whole, precision)
        if not idle:
            return Followed(pass_name, said, "otherwise", names)
    return Followed(pass_name, said, "followed", names)


@dataclass(frozen=True, slots=True)
class BiasByDesign:
    """The bias that a declared choice brings to a pass.

    Attributes
    ----------
    names : tuple of str; choices that bring it
    size : BiasOfLight or None; calculated; ``None`` of a pass that reuses nothing
    accepted : bool; whether the declaration accepts all of them
    more : str; what else is to be told of it
    """

    pass_name: str
    names: Names
    size: BiasOfLight | None
    accepted: bool
    more: str = ""

    @property
    def text(self) -> str:
        """In words."""
        size = f", {self.size.text} (summed exactly)" if self.size else ""
        more = f"; {self.more}" if self.more else ""
        where = f"{self.pass_name} is biased by design in {', '.join(self.names)}"
        return f"{where}{size}{more}"


def biases_by_design(
    declaration: Declaration,
    followed: Sequence[Followed],
    diagnoses: Sequence[Diagnosis],
) -> list[BiasByDesign]:
    """Biases of passes that follow what is declared, or may."""
    found = []
    by_pass = {d.pass_name: d for d in diagnoses}
    for one in followed:
        declared = declaration.of_pass(one.pass_name)
        diagnosis = by_pass.get(one.pass_name)
        if one.state == "not shown":
            chosen, names = declared, _hidden_biases(one.pass_name, declared)
        elif diagnosis is not None and diagnosis.explanations:
            best = diagnosis.explanations[0]
            chosen = best.departures
            names = tuple(h.name for h in best.designed) if best.by_design else ()
        else:
            continue
        if names:
            accepted = all(map(declaration.accepts, names))
            size = _size(one.pass_name, chosen)
            found.append(BiasByDesign(one.pass_name, names, size, accepted))
    return found


def _hidden_biases(pass_name: str, declared: tuple[Hypothesis, ...]) -> Names:
    """Declared choices that are biased where no row that was asked shows them."""
    biased = bias_of(pass_name, declared)
    return tuple(
        h.name
        for h in declared
        if h.departure == "bias" and (biased or h.rules == CONTRACT_RULES)
    )


def _size(pass_name: str, chosen: tuple[Hypothesis, ...]) -> BiasOfLight | None:
    rules = combined(chosen)
    own = rules.normalization == OWN
    # How old samples are hangs on the frames before, of which nothing is known.
    if pass_name not in STREAMS or own or rules.max_age[1] < inf:
        return None
    return bias_of_light(pass_name, rules)

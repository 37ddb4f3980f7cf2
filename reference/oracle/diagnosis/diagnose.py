"""Which of the known mistakes reproduces what a backend gave."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.contract.weights import MIS
from restir_gi.reference.oracle.diagnosis.alternatives import ALTERNATIVES
from restir_gi.reference.oracle.diagnosis.choices import CHOICES
from restir_gi.reference.oracle.diagnosis.confidences import CONFIDENCES
from restir_gi.reference.oracle.diagnosis.declared_weights import DECLARED_WEIGHTS
from restir_gi.reference.oracle.diagnosis.directions import DIRECTIONS
from restir_gi.reference.oracle.diagnosis.hypothesis import Hypothesis, combined
from restir_gi.reference.oracle.diagnosis.innocence import bias_of, without_surfaces
from restir_gi.reference.oracle.diagnosis.jacobians import JACOBIANS
from restir_gi.reference.oracle.diagnosis.merging import MERGING
from restir_gi.reference.oracle.diagnosis.sample_rows import sample_of
from restir_gi.reference.oracle.diagnosis.search import (
    EMPTY,
    Set,
    SetSearch,
    beside,
    sets_that_explain,
    single,
)
from restir_gi.reference.oracle.diagnosis.shading import SHADING
from restir_gi.reference.oracle.diagnosis.subsets import explained as reproduces
from restir_gi.reference.oracle.diagnosis.subsets import judged, whole
from restir_gi.reference.oracle.diagnosis.surfaces import SURFACES
from restir_gi.reference.oracle.diagnosis.targets import TARGETS
from restir_gi.reference.oracle.diagnosis.weights import WEIGHTS
from restir_gi.reference.oracle.levels.probe import Answer
from restir_gi.reference.oracle.parts import parts
from restir_gi.reference.oracle.replay.blocks import BY_ROW
from restir_gi.reference.oracle.replay.mis import OWN
from restir_gi.reference.oracle.replay.rules import CONTRACT_RULES

HYPOTHESES: tuple[Hypothesis, ...] = (
    *JACOBIANS,
    *WEIGHTS,
    *CONFIDENCES,
    *CHOICES,
    *TARGETS,
    *SHADING,
    *DIRECTIONS,
    *MERGING,
    *ALTERNATIVES,
    *SURFACES,
    *DECLARED_WEIGHTS,
)


def known_mistakes() -> tuple[Hypothesis, ...]:
    """Hypotheses of all parts of the contract, those of the core first."""
    return (*HYPOTHESES, *(h for part in parts() for h in part.hypotheses))


@dataclass(frozen=True, slots=True)
class Explanation:
    """A set of differences from the contract, and how much of a pass it reproduces.

    Attributes
    ----------
    departures : tuple of Hypothesis
        Choices that bring no bias, and those whose bias is declared.
    mistakes : tuple of Hypothesis; what brings one that nobody declared
    right, rows : int; rows that are reproduced, to rounding, of how many
    bias : str; what they do to the mean together, calculated; empty: nothing
    declared : frozenset of str; names of those that the backend declares
    besides : str; what all that is not biased by itself does together; empty: nothing
    """

    departures: tuple[Hypothesis, ...]
    mistakes: tuple[Hypothesis, ...]
    right: int
    rows: int
    bias: str = ""
    declared: frozenset[str] = frozenset()
    besides: str = ""

    @property
    def innocent(self) -> bool:
        """Whether it is departures alone, which together bring no bias."""
        return not self.mistakes and not self.bias and not self.designed

    @property
    def designed(self) -> tuple[Hypothesis, ...]:
        """Declared choices that bring a bias: by themselves, or else all together."""
        alone = tuple(h for h in self.departures if h.departure == "bias")
        if alone or self.mistakes or not self.bias:
            return alone
        return () if self.undeclared else self.departures

    @property
    def by_design(self) -> bool:
        """Whether it is departures alone, and all that is biased is declared."""
        known = not (self.besides and self.undeclared)
        return not self.mistakes and bool(self.designed) and known

    @property
    def undeclared(self) -> tuple[Hypothesis, ...]:
        """Choices beside those that are declared."""
        return tuple(h for h in self.departures if h.name not in self.declared)

    @property
    def text(self) -> str:
        """What it says of a pass, in words."""
        wrong = " and ".join(f"{h.name} ({h.mistake})" for h in self.mistakes)
        others = " and ".join(h.name for h in self.departures)
        if self.mistakes:
            return wrong + (f", in a pass that departs in {others}" if others else "")
        words = " and ".join(f"{h.name} ({h.mistake})" for h in self.departures)
        if self.by_design:
            return f"is biased by design in {words}"
        if self.bias:
            return f"departs in {others}, which together are not right: {self.bias}"
        return f"departs in {words}"

    @property
    def share(self) -> str:
        """How much of the pass it reproduces, in words."""
        return f"{100 * self.right / self.rows:.3g} % of {self.rows} rows"

    @property
    def hypotheses(self) -> tuple[Hypothesis, ...]:
        """All of them, the mistakes first."""
        return (*self.mistakes, *self.departures)


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """What explains the answers of a pass.

    Attributes
    ----------
    explanations : tuple of Explanation
        Those that reproduce every answer of the pass, to rounding; several where the
        cases do not tell them apart, none where it is no known mistake.
    closest : Explanation or None
        Where there is none: what reproduces most rows, at least half of those that the
        contract does not.
    fit : str
        Where there is none: the first term that is wrong, and what it is in place of
        right; or empty.
    undecided : str
        What has to be known before the pass can be judged, where that would explain
        nearly all that is wrong; or empty.
    """

    pass_name: str
    explanations: tuple[Explanation, ...]
    closest: Explanation | None = None
    fit: str = ""
    undecided: str = ""

    @property
    def matches(self) -> tuple[Hypothesis, ...]:
        """Hypotheses of all explanations, each once."""
        found = [h for one in self.explanations for h in one.hypotheses]
        return tuple(dict.fromkeys(found))

    @property
    def text(self) -> str:
        """What is known of the pass, in words."""
        if self.explanations:
            return "; or ".join(one.text for one in self.explanations)
        known = "no known mistake"
        if self.closest is not None:
            known += f"; nearest, in {self.closest.share}: {self.closest.text}"
        return f"{self.fit}; {known}" if self.fit else known

    @property
    def kinds(self) -> frozenset[str]:
        """Kinds of departures that it may be where no surface is declared."""
        biased = ["bias"] * any(one.by_design for one in self.explanations)
        departs = [h for h in self.matches if h.departure and _is_everywhere(h)]
        return frozenset([*biased, *(h.departure for h in departs)])


def diagnose(
    pass_name: str,
    answers: Iterable[Answer],
    precision: Precision,
    declared: Sequence[Hypothesis] = (),
    explained: Sequence[Explanation] = (),
) -> Diagnosis:
    """Replay a pass that is wrong under known differences, and sets of them.

    A set is named if it explains *all* answers, within the working range.  So what it
    explains by accident in one case it must explain in the others.  What is declared is
    tried first, then one difference, then several departures, then mistakes on top.

    Parameters
    ----------
    answers : iterable of Answer; all that the backend gave for it, right and wrong
    declared : sequence of Hypothesis
        Choices that the backend declares for this pass, each of its kind.
    explained : sequence of Explanation
        What explained other passes of the backend: it may explain this one, too.
    """
    # Short cases that failed refute most hypotheses, and soonest.
    chosen = sorted((a for a in answers if a.outputs is not None), key=_effort)
    given = [whole(a.probe.case, a.outputs or {}) for a in chosen]
    plain = [judged(a, CONTRACT_RULES, precision) for a in given]
    right = [ok[a.rows] for a, (_, ok) in zip(given, plain, strict=True)]
    over = any(judgement.over_budget for judgement, _ in plain)
    # What the contract explains needs no mistake, and every mistake explains it too.
    all_right = all(ok.all() for ok in right)
    if all_right and not over:
        return Diagnosis(pass_name, ())
    wrong = [~ok for _, ok in plain]
    rows = sum(len(ok) for ok in right)
    said = frozenset(h.name for h in declared)
    if declared and follows(chosen, tuple(declared), precision):
        one = _explanation(pass_name, tuple(declared), rows, rows, said)
        return Diagnosis(pass_name, (one,))
    able = _able([a.probe.case for a in chosen], declared)
    named = [said, *_names(explained)] if declared else _names(explained)
    seeds = [tuple(h for h in able if h.name in names) for names in named]
    search = SetSearch(given, sample_of(given, wrong, precision), able, seeds)
    known = [h for h in declared if h in able or mean_is_right(chosen)]
    sets, nearest = beside(search, tuple(known)) if known else [], EMPTY
    sets = sets or single(search)
    # Sets are searched by rows that are wrong: not where decisions alone are too many.
    if not sets and pass_name in BY_ROW and not all_right:
        sets, nearest = sets_that_explain(search)
    if sets or not nearest:
        found = tuple(_explanation(pass_name, one, rows, rows, said) for one in sets)
        return Diagnosis(pass_name, found)
    ours = sum(int(ok.sum()) for ok in right)
    most = search.right(nearest)
    # A set that leaves most of what is wrong unexplained is nearest to nothing.
    is_near = most > ours and 2 * (most - ours) >= rows - ours
    closest = _explanation(pass_name, nearest, most, rows, said) if is_near else None
    return Diagnosis(pass_name, (), closest)


def follows(answers: Iterable[Answer], chosen: Set, precision: Precision) -> bool:
    """Whether a set reproduces all answers of a pass, within the working range.

    Of weights that nobody knows but the backend their mean has to be right as well.
    """
    given, rules = list(answers), combined(chosen)
    if rules.normalization == OWN and not mean_is_right(given):
        return False
    asked = (whole(a.probe.case, a.outputs or {}) for a in given)
    return all(reproduces(one, rules, precision) for one in asked)


def mean_is_right(answers: Iterable[Answer]) -> bool:
    """Whether level L1, which integrates any weights, was asked and has passed."""
    found = [a.finding for a in answers if a.probe.level == "L1" and a.finding]
    return bool(found) and all(finding.passed for finding in found)


def _able(cases: Sequence[Case], declared: Sequence[Hypothesis]) -> list[Hypothesis]:
    """What may show in cases: known differences, and those that are declared.

    Weights of a backend's own would explain whatever they are.
    """
    mine = {h.name: h for h in declared if h.rules.normalization != OWN}
    known = {h.name: h for h in known_mistakes() if any(map(h.shows_in, cases))}
    return list((known | mine).values())


def _names(explained: Iterable[Explanation]) -> list[frozenset[str]]:
    """Names of what explained other passes, each set once."""
    sets = (frozenset(h.name for h in one.hypotheses) for one in explained)
    return list(dict.fromkeys(sets))


def _is_everywhere(h: Hypothesis) -> bool:
    """Whether runs show it: they have no declared surface, and of weights their own."""
    if h.only is not None and h.only[0] == MIS.name:
        return False
    return h.only is None or without_surfaces(h.rules) != CONTRACT_RULES


def _explanation(
    pass_name: str, chosen: Set, right: int, rows: int, declared: frozenset[str]
) -> Explanation:
    departures = tuple(h for h in chosen if h.departure)
    mistakes = tuple(h for h in chosen if not h.departure)
    bias = "" if mistakes else bias_of(pass_name, departures)
    innocent = tuple(h for h in departures if h.departure != "bias")
    alone = bias_of(pass_name, innocent) if bias and innocent != departures else ""
    return Explanation(departures, mistakes, right, rows, bias, declared, alone)


def _effort(answer: Answer) -> tuple[bool, int]:
    passed = answer.finding is None or answer.finding.passed
    return passed, sum(a.nbytes for a in answer.probe.case.inputs.values())

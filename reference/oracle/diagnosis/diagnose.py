"""Which of the known mistakes reproduces what a backend gave."""

from collections.abc import Iterable
from dataclasses import dataclass

from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.diagnosis.choices import CHOICES
from restir_gi.reference.oracle.diagnosis.confidences import CONFIDENCES
from restir_gi.reference.oracle.diagnosis.directions import DIRECTIONS
from restir_gi.reference.oracle.diagnosis.hypothesis import Hypothesis
from restir_gi.reference.oracle.diagnosis.jacobians import JACOBIANS
from restir_gi.reference.oracle.diagnosis.merging import MERGING
from restir_gi.reference.oracle.diagnosis.shading import SHADING
from restir_gi.reference.oracle.diagnosis.targets import TARGETS
from restir_gi.reference.oracle.diagnosis.weights import WEIGHTS
from restir_gi.reference.oracle.levels.probe import Answer
from restir_gi.reference.oracle.parts import judge_of, parts
from restir_gi.reference.oracle.replay.rules import CONTRACT_RULES, Rules

HYPOTHESES: tuple[Hypothesis, ...] = (
    *JACOBIANS,
    *WEIGHTS,
    *CONFIDENCES,
    *CHOICES,
    *TARGETS,
    *SHADING,
    *DIRECTIONS,
    *MERGING,
)


def known_mistakes() -> tuple[Hypothesis, ...]:
    """Hypotheses of all parts of the contract, those of the core first."""
    return (*HYPOTHESES, *(h for part in parts() for h in part.hypotheses))


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """What explains the answers of a pass.

    Attributes
    ----------
    matches : tuple of Hypothesis
        Those that reproduce every answer of the pass, to rounding; several where the
        cases do not tell them apart, none where it is no known mistake.
    """

    pass_name: str
    matches: tuple[Hypothesis, ...]


def diagnose(
    pass_name: str, answers: Iterable[Answer], precision: Precision
) -> Diagnosis:
    """Replay a pass that is wrong under every hypothesis.

    A hypothesis is named if it explains *all* answers.  So what it explains by accident
    in one case it must explain in the others, and a second mistake beside the first
    leaves none.

    Parameters
    ----------
    answers : iterable of Answer; all that the backend gave for it, right and wrong
    """
    judge = judge_of(pass_name)
    # Short cases that failed refute most hypotheses, and soonest.
    given = sorted((a for a in answers if a.outputs is not None), key=_effort)

    def explained_by(rules: Rules) -> bool:
        return all(
            judge(a.probe.case, a.outputs or {}, rules, precision).passed for a in given
        )

    # What the contract explains needs no mistake, and every mistake explains it too.
    if explained_by(CONTRACT_RULES):
        return Diagnosis(pass_name, ())
    able = (h for h in known_mistakes() if pass_name in h.passes)
    return Diagnosis(pass_name, tuple(h for h in able if explained_by(h.rules)))


def _effort(answer: Answer) -> tuple[bool, int]:
    passed = answer.finding is None or answer.finding.passed
    return passed, sum(a.nbytes for a in answer.probe.case.inputs.values())

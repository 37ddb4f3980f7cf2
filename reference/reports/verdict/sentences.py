"""What is wrong with a pass, and what explains it, in plain words."""

from collections.abc import Iterable

import numpy as np

from restir_gi.reference.numerics.arrays import Indices
from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.diagnosis.diagnose import Diagnosis, Explanation
from restir_gi.reference.oracle.diagnosis.hypothesis import Hypothesis
from restir_gi.reference.oracle.replay.judgement import Compared, Judgement
from restir_gi.reference.oracle.replay.typical import excess_of, wrong_rows

ONE_WAY = 0.95
"""Share of the wrong rows that must be off to one side for "too large" to be said."""


def what_is_wrong(failed: Iterable[tuple[Case, Judgement]], rows: int) -> str | None:
    """Which output is off in most rows, to which side; ``None`` if no row is wrong.

    Parameters
    ----------
    failed : iterable of (Case, Judgement); of a pass, those that failed
    rows : int; of all its cases, also those that did not
    """
    pairs = list(failed)
    illegal = sum(
        int(judgement.decisions.illegal.sum())
        for _, judgement in pairs
        if judgement.decisions is not None
    )
    outputs: dict[str, list[Compared]] = {}
    for case, judgement in pairs:
        rows_of_case = wrong_rows(case, judgement)
        for compared in judgement.compared:
            outputs.setdefault(compared.name, []).append(_wrong(compared, rows_of_case))
    counts = {name: sum(len(c.found) for c in each) for name, each in outputs.items()}
    most = max(counts, key=lambda name: counts[name], default="")
    if not most or not max(counts[most], illegal):
        return None
    if illegal >= counts[most]:
        return f"another sample is kept than u decides, in {illegal:,} of {rows:,} rows"
    return f"{most} {_side(outputs[most])} in {counts[most]:,} of {rows:,} rows"


def _side(each: list[Compared]) -> str:
    if each[0].found.dtype.kind in "ui":
        return "is wrong"
    signs = np.concatenate([_signs(compared) for compared in each])
    for sign, words in ((1, "is too large"), (-1, "is too small")):
        if (signs == sign).mean() >= ONE_WAY:
            return words
    return "is wrong"


def _wrong(compared: Compared, rows: Indices) -> Compared:
    """The rows of an output that are wrong, of some rows."""
    wrong = rows[excess_of(compared)[rows] > 1]
    sides = (compared.found, compared.expected, compared.allowed)
    return Compared(compared.name, *(side[wrong] for side in sides))


def _signs(wrong: Compared) -> Indices:
    """(R,): on which side rows are; 0 where their components differ in that."""
    with np.errstate(invalid="ignore"):
        off = wrong.found.astype(np.float64) - wrong.expected
    off = np.nan_to_num(off).reshape(len(off), -1)
    above, below = (off > 0).any(axis=1), (off < 0).any(axis=1)
    sides: Indices = above.astype(np.int64) - below
    return sides


def cause(diagnosis: Diagnosis | None) -> str:
    """The end of a sentence that says what explains a wrong pass; empty if nothing."""
    if diagnosis is not None and len(diagnosis.explanations) == 1:
        (one,) = diagnosis.explanations
        return "; ".join(_clause(h) for h in one.mistakes or one.departures)
    if diagnosis is not None and diagnosis.explanations:
        return f"it is {_one_of(diagnosis.explanations)}"
    if diagnosis is not None and diagnosis.fit:
        return diagnosis.fit
    if diagnosis is not None and diagnosis.closest is not None:
        return f"closest is {_partly(diagnosis.closest)}"
    return ""


def conclusion(diagnosis: Diagnosis | None, replayed: bool) -> str:
    """What explains the answers of a pass.

    Parameters
    ----------
    replayed : bool; there are wrong numbers that a hypothesis could reproduce
    """
    if diagnosis is not None and len(diagnosis.explanations) == 1:
        return explained(diagnosis.explanations[0])
    if diagnosis is not None and diagnosis.explanations:
        return f"is {_one_of(diagnosis.explanations)}"
    if not replayed:
        return "no known mistake could be tried: there are no wrong numbers to replay"
    known = "no known mistake explains all rows"
    if diagnosis is not None and diagnosis.closest is not None:
        known += f"; closest: {_partly(diagnosis.closest)}"
    fit = diagnosis.fit if diagnosis is not None else ""
    return f"{fit}; {known}" if fit else known


def explained(one: Explanation) -> str:
    """Mistakes and departures of an explanation."""
    parts = []
    if one.mistakes:
        parts.append(f"is wrong in: {_names(one.mistakes)}")
    if one.by_design:
        parts.append(f"is biased by design in: {_names(one.designed)}")
    innocent = [h for h in one.departures if h not in one.designed]
    if innocent:
        parts.append(f"departs in: {_names(innocent)} (innocent)")
    return "; ".join(parts)


def _one_of(explanations: Iterable[Explanation]) -> str:
    each = [" with ".join(h.name for h in one.hypotheses) for one in explanations]
    return f"one of: {', '.join(each)}"


def _partly(one: Explanation) -> str:
    left = one.rows - one.right
    share = 100 * one.right / max(one.rows, 1)
    # All rows but some are not all: 99.96 % is not to read as 100 %.
    shown = f"{min(share, 99.9):.1f}" if left else "100"
    names = " with ".join(h.name for h in one.hypotheses)
    return (
        f"{names}, which explains {shown} % of the rows; unexplained:"
        f" {left:,} of {one.rows:,} rows"
    )


def _names(hypotheses: Iterable[Hypothesis]) -> str:
    return ", ".join(h.name for h in hypotheses)


def _clause(hypothesis: Hypothesis) -> str:
    """The mistake within a sentence: a small letter, unless it begins with a symbol."""
    text = hypothesis.mistake.rstrip(".")
    word = text.split(" ")[0]
    return text[:1].lower() + text[1:] if word[1:].islower() or word == "A" else text

"""Names without a list: the first term that is wrong, and what it is in place of right.

Where no known mistake explains a pass, its numbers still tell of the mistake: a formula
with a wrong power, a limit, a rounding, another row leaves its mark in each wrong row.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from restir_gi.reference.numerics.arrays import Masks
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.diagnosis.naming.claims import explained
from restir_gi.reference.oracle.diagnosis.naming.decisions import decisions_explained
from restir_gi.reference.oracle.diagnosis.naming.factors import RowFacts, facts_of
from restir_gi.reference.oracle.diagnosis.naming.fits import CHANCE_OF_NAMED
from restir_gi.reference.oracle.diagnosis.naming.landings import misplaced
from restir_gi.reference.oracle.diagnosis.naming.misreadings import misread
from restir_gi.reference.oracle.diagnosis.naming.numbers import (
    Numbers,
    joined,
    part_of,
)
from restir_gi.reference.oracle.diagnosis.naming.slots import (
    STREAMS,
    StreamFacts,
    of_kept,
    stream_of,
)
from restir_gi.reference.oracle.diagnosis.naming.targets import target_explained
from restir_gi.reference.oracle.diagnosis.naming.weights import weights_explained
from restir_gi.reference.oracle.diagnosis.subsets import whole
from restir_gi.reference.oracle.levels.probe import Answer
from restir_gi.reference.oracle.replay.bounded import rounding_of
from restir_gi.reference.oracle.replay.judgement import Compared, Judgement
from restir_gi.reference.oracle.replay.resampling import COPIED

GIVEN = {"p_hat": "term_p_hat", "Z": "term_Z"}
"""Terms of the replay, and the buffers in which a backend may give its own."""


@dataclass(frozen=True, slots=True)
class Told:
    """What is wrong with a pass that no known mistake explains.

    Attributes
    ----------
    term : str; the first that is wrong, in the order of the formula
    sentence : str; what it is in place of right, and in how many rows
    share : float; of the rows in which it is wrong, those that the sentence explains
    rows : int; in which it is wrong, within the working range
    """

    term: str
    sentence: str
    share: float
    rows: int


@dataclass(frozen=True, slots=True, eq=False)
class _Judged:
    """An answer with its replay, and what is known of its rows."""

    case: Case
    judgement: Judgement
    facts: RowFacts
    outputs: Buffers
    ordinary: Masks
    start: int
    stream: StreamFacts | None = None

    def compared(self, name: str) -> Compared:
        return next(c for c in self.judgement.compared if c.name == name)

    def wrong(self, name: str) -> Masks:
        """Rows within the working range in which a number is wrong, (N,) bool."""
        wrong: Masks = (self.compared(name).excess > 1) & self.ordinary
        return wrong


def first_wrong_term(answers: Sequence[Answer], precision: Precision) -> Told | None:
    """The first term of a pass that is wrong, where its wrong rows have one reason.

    Parameters
    ----------
    answers : sequence of Answer; all that the backend gave for one pass

    Returns
    -------
    Told or None
        ``None`` where nothing is wrong, and where no short sentence is true of nine in
        ten of the wrong rows and of all that are right.
    """
    # A factor may be 0, or too large for its powers; what it then predicts is refuted.
    with np.errstate(all="ignore"):
        judged = list(_judged(answers, precision))
        if not judged:
            return None
        return _first(judged, precision) or _misread(judged, answers, precision)


def _misread(
    judged: list[_Judged], answers: Sequence[Answer], precision: Precision
) -> Told | None:
    """What would be right if something else had been read, or rounded."""
    given = [whole(a.probe.case, a.outputs) for a in answers if a.outputs is not None]
    found = misplaced(given, precision) or misread(given, precision)
    if found is None:
        return None
    term = _wrong(judged)[0]
    count = _count(found.rows, found.of)
    text = f"{term} would be right, in {count} wrong rows, if {found.text}"
    return Told(term, text, found.rows / found.of, found.of)


def _first(judged: list[_Judged], precision: Precision) -> Told | None:
    streams = [j.stream for j in judged if j.stream is not None]
    if streams:
        found = _of_stream(judged, streams, precision)
        if found is not None:
            return found
    for name in _names(judged):
        if streams and name == "W":
            continue
        fit = explained(_numbers(judged, name, precision))
        if fit is not None:
            return _told(name, fit.text, fit.rows, fit.of)
    return None


def wrong_terms(answers: Sequence[Answer], precision: Precision) -> tuple[str, ...]:
    """The terms of a pass that are wrong, the first one first.

    Parameters
    ----------
    answers : sequence of Answer; all that the backend gave for one pass
    """
    with np.errstate(all="ignore"):
        judged = list(_judged(answers, precision))
        return _wrong(judged) if judged else ()


def first_wrong_place(answers: Sequence[Answer], precision: Precision) -> str:
    """The first term that is wrong, and in which rows alone, in words; or empty.

    Parameters
    ----------
    answers : sequence of Answer; all that the backend gave for one pass
    """
    with np.errstate(all="ignore"):
        judged = list(_judged(answers, precision))
        names = _wrong(judged) if judged else ()
    if not names:
        return ""
    where = _where(judged, names[0]) if names[0] != "the kept sample" else ""
    return f"the first wrong term is {names[0]}{where}"


def _where(judged: list[_Judged], name: str) -> str:
    """What holds in all rows in which a term is wrong, and not by accident."""
    every = [key for j in judged for key in j.facts.conditions]
    for key in dict.fromkeys(every):
        wrong = inside = 0
        for j in judged:
            none = np.zeros(j.case.rows, bool)
            here = j.facts.conditions.get(key, none)
            if here.ndim > 1 or (j.wrong(name) & ~here).any():
                break
            wrong += int(j.wrong(name).sum())
            inside += int((here & j.ordinary).sum())
        else:
            every_row = sum(int(j.ordinary.sum()) for j in judged)
            if wrong * np.log(inside / every_row) < CHANCE_OF_NAMED:
                return f", in {wrong:,} of {inside:,} rows where {key}, nowhere else"
    return ""


def _wrong(judged: list[_Judged]) -> tuple[str, ...]:
    wrong = [n for n in _names(judged) if any(j.wrong(n).any() for j in judged)]
    streams = [j.stream for j in judged if j.stream is not None]
    chosen = any((s.illegal & s.ordinary).any() for s in streams)
    return ("the kept sample", *wrong) if chosen else tuple(wrong)


def _of_stream(
    judged: list[_Judged], streams: list[StreamFacts], precision: Precision
) -> Told | None:
    """What is wrong with the weights, the choice, or W; the choice hangs on weights."""
    chosen = any((s.illegal & s.ordinary).any() for s in streams)
    numbers = _numbers(judged, "W", precision)
    if numbers.wrong.any():
        for name in GIVEN:
            given = _given(judged, name, precision)
            fit = explained(given) if given is not None else None
            if fit is not None:
                return _told(name, fit.text, fit.rows, fit.of)
    W = explained(numbers)
    if W is not None and not chosen:
        return _told("W", W.text, W.rows, W.of)
    unit = rounding_of(precision).unit
    weights = weights_explained(streams, precision)
    found = weights or target_explained(streams, unit)
    if found is None and chosen and all(j.case.tells_numbers for j in judged):
        found = decisions_explained(streams)
    if found is not None:
        return _told(found.term, found.text, found.rows, found.of)
    return _told("W", W.text, W.rows, W.of) if W is not None else None


def _given(judged: list[_Judged], name: str, precision: Precision) -> Numbers | None:
    """A term that a backend gives, to the relative bound of the W it leads to."""
    parts = []
    for j in judged:
        found, W = j.outputs.get(GIVEN[name]), j.compared("W")
        if found is None:
            return None
        right = j.judgement.terms[name]
        allowed = np.abs(right) * np.nan_to_num(W.allowed / W.expected, nan=np.inf)
        rows = np.flatnonzero(j.ordinary & np.isfinite(found))
        facts = j.facts.without(name)
        parts.append(part_of(found, right, allowed, facts, rows, j.start))
    return joined(name, parts, precision)


def _told(name: str, text: str, rows: int, of: int) -> Told:
    text = f"{name} {text}, in {_count(rows, of)} wrong rows"
    return Told(name, text, rows / of, of)


def _count(rows: int, of: int) -> str:
    return f"all {of:,}" if rows == of else f"{rows:,} of {of:,}"


def _names(judged: list[_Judged]) -> list[str]:
    """What all compare; what was copied with a kept sample is wrong with that."""
    every = [{c.name for c in j.judgement.compared} for j in judged]
    names = [c.name for c in judged[0].judgement.compared]
    copied = COPIED if judged[0].stream is not None else ()
    return [n for n in names if n not in copied and all(n in one for one in every)]


def _numbers(judged: list[_Judged], name: str, precision: Precision) -> Numbers:
    parts = []
    for j in judged:
        c, rows = j.compared(name), np.flatnonzero(j.ordinary)
        facts = j.facts.without(name)
        parts.append(part_of(c.found, c.expected, c.allowed, facts, rows, j.start))
    return joined(name, parts, precision)


def _judged(answers: Sequence[Answer], precision: Precision) -> Iterator[_Judged]:
    rounding, start = rounding_of(precision), 0
    for answer in answers:
        if answer.outputs is None or answer.finding is None:
            continue
        case, judgement = answer.probe.case, answer.finding.judgement
        if judgement is None:
            continue
        ordinary = np.ones(case.rows, bool) if case.beyond is None else ~case.beyond
        if case.pass_name not in STREAMS or not judgement.terms:
            facts = facts_of(case, judgement, answer.outputs, rounding)
            yield _Judged(case, judgement, facts, answer.outputs, ordinary, start)
        else:
            given = (case, judgement, answer.outputs)
            stream = stream_of(*given, ordinary, start, rounding)
            facts = of_kept(case, stream, judgement, rounding)
            yield _Judged(*given[:2], facts, given[2], ordinary, start, stream)
        start += case.rows

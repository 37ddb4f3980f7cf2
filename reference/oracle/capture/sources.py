"""Which buffer a pass has read, where it is not the one that it should have.

A buffer that is written while others read it, or two that were not swapped, leave rows
whose sample is none of the candidates.  So the pass is replayed with what else stood
in memory: reservoirs of another pass, or of another frame.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

import numpy as np

from restir_gi.reference.numerics.arrays import Masks
from restir_gi.reference.oracle.capture.cases import RecordedFrames, captured_cases
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.diagnosis.diagnose import Diagnosis
from restir_gi.reference.oracle.diagnosis.hypothesis import combined
from restir_gi.reference.oracle.diagnosis.subsets import judged, whole
from restir_gi.reference.oracle.replay.rules import Rules
from restir_gi.reference.oracle.verdict import Verdict

PRECISION: Precision = "float32"

WHAT = {
    "initial": "new samples",
    "temporal": "temporal reservoirs",
    "spatial": "reservoirs that Algorithm 4 has left",
    "fused": "reservoirs of the fused pass",
}

ENOUGH = 0.9
"""Share of the wrong rows that other buffers have to explain."""


@dataclass(frozen=True, slots=True)
class MisreadBuffers:
    """Buffers that may have been read in place of others.

    Attributes
    ----------
    words : str; what was read
    recorded : tuple of RecordedFrames; with these in their place, all or some of them
    mixed : bool; some rows may have read them, and others the right ones
    missing : str; what would tell whether it is so, where it was not dumped
    """

    words: str
    recorded: tuple[RecordedFrames, ...]
    mixed: bool = False
    missing: str = ""


def with_source(
    diagnosis: Diagnosis, verdict: Verdict, recorded: RecordedFrames
) -> Diagnosis:
    """A diagnosis, with what a wrong pass has read, if another buffer explains it.

    Named is what explains most of the rows that are wrong, and nine in ten of them at
    least: chance does not give a row the sample of a candidate that it never had.
    Where that is something that was not dumped, nothing is known of the pass.
    """
    if diagnosis.explanations:
        return diagnosis
    name = diagnosis.pass_name
    found = [
        (share, other)
        for rules in _rules(diagnosis, verdict)
        for share, other in _shares(name, rules, recorded)
    ]
    share, best = max(found, key=lambda each: each[0], default=(0.0, None))
    if best is None or share < ENOUGH:
        return diagnosis
    told = f"that explains {100 * share:.3g} % of the rows that are wrong"
    return replace(diagnosis, fit=f"{best.words}: {told}", undecided=best.missing)


def _rules(diagnosis: Diagnosis, verdict: Verdict) -> Iterator[Rules]:
    """By what the pass may calculate: what is declared, or explains other passes."""
    yield verdict.declaration.rules_of(diagnosis.pass_name)
    for other in verdict.settled:
        if other is not diagnosis:
            yield combined(other.explanations[0].hypotheses)
    if diagnosis.closest is not None:
        yield combined(diagnosis.closest.hypotheses)


def _shares(
    name: str, rules: Rules, recorded: RecordedFrames
) -> Iterator[tuple[float, MisreadBuffers]]:
    """Share of the wrong rows that each misreading explains."""
    ours = _right(recorded, name, rules)
    for other in _misread(name, recorded):
        theirs = [_right(one, name, rules) for one in other.recorded]
        wrong = explained = 0
        for frame in set(ours).intersection(*theirs):
            mine = ours[frame]
            right: Masks = np.any([one[frame] for one in theirs], axis=0)
            right = right | mine if other.mixed else right
            wrong += int((~mine).sum())
            explained += int((right & ~mine).sum()) - int((mine & ~right).sum())
        yield explained / max(wrong, 1), other


def _right(recorded: RecordedFrames, name: str, rules: Rules) -> dict[int, Masks]:
    """Rows of a pass that are right in each frame, of its pixels."""
    found = {}
    for one in captured_cases(recorded):
        if one.case.pass_name == name:
            asked = whole(one.case, one.outputs)
            right = judged(asked, rules, PRECISION)[1] | ~asked.rows
            found[one.frame] = right[: recorded.rows]
    return found


BITS = {
    "moved": "visible_temporal",
    "spatial": "visible_spatial",
    "fused": "visible_fused",
}
"""Roles that tell what a pass knows of visibility."""


def _misread(name: str, recorded: RecordedFrames) -> Iterator[MisreadBuffers]:
    """What may have been read in place of what should have been."""
    reads = recorded.reads
    bits = BITS.get(name)
    if bits and recorded.world is None and bits not in recorded.frames[-1]:
        missing = f"dump {bits}, or name the scene"
        words = f"all was taken to be visible, and some is not: {missing}"
        blind = [replace(recorded, blind=who) for who in _who_is_blind(name, recorded)]
        yield MisreadBuffers(words, tuple(blind), mixed=True, missing=missing)
    if name == "moved":
        for role, age in (("spatial", 1), ("temporal", 1), ("spatial", 2)):
            if (role, age) != reads.past:
                words = f"the past is that of the {WHAT[role]} {_ago(age)}"
                yield MisreadBuffers(words, (_reading(recorded, past=(role, age)),))
        yield MisreadBuffers(
            "the visible points of the past are those of this frame",
            (_reading(recorded, past_viewer=0),),
        )
    if name == "fused":
        words = f"the sources are the {WHAT['fused']} {_ago(2)}"
        yield MisreadBuffers(words, (_reading(recorded, sources=("fused", 2)),))
        yield MisreadBuffers(
            "the visible points of the sources are those of this frame",
            (_reading(recorded, past_viewer=0),),
        )
        words = "sources are read while they are written: some are already what this"
        now = (_reading(recorded, sources=("fused", 0)),)
        yield MisreadBuffers(f"{words} pass has left", now, mixed=True)
    if name == "spatial":
        for role, age in (("temporal", 1), ("initial", 0)):
            words = f"neighbours are read from the {WHAT[role]} {_ago(age)}"
            yield MisreadBuffers(words, (_reading(recorded, around=(role, age)),))
        written = [
            _reading(recorded, around=("spatial", 0), alone=k)
            for k in (None, *range(_count(recorded, "neighbors")))
        ]
        words = "neighbours are read while they are written: some are already what this"
        yield MisreadBuffers(f"{words} pass has left", tuple(written), mixed=True)


FEW = 4
"""Viewers of whom all subsets are tried; of more, one by one and all but the pixel."""


def _who_is_blind(name: str, recorded: RecordedFrames) -> list[frozenset[int]]:
    """Sets of viewers, 0 for the pixel, who may not see what others have found."""
    roles = {"spatial": "neighbors", "fused": "sources"}
    others = range(1, 2 if name == "moved" else 1 + _count(recorded, roles[name]))
    viewers = [0, *others]
    if len(viewers) > FEW:
        return [frozenset([k]) for k in viewers] + [frozenset(others)]
    sizes = range(1, len(viewers) + 1)
    return [frozenset(who) for k in sizes for who in combinations(viewers, k)]


def _count(recorded: RecordedFrames, role: str) -> int:
    """Others of whom a pixel reads."""
    return int(recorded.frames[-1][role][role].shape[1])


def _ago(age: int) -> str:
    return {0: "of this frame", 1: "of the last frame"}.get(age, f"{age} frames ago")


def _reading(recorded: RecordedFrames, **reads: Any) -> RecordedFrames:
    return replace(recorded, reads=replace(recorded.reads, **reads))

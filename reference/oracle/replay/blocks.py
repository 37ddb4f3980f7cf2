"""Replay of many rows a block at a time: a whole frame of an engine has to fit."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Indices
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.replay.judgement import (
    Compared,
    Decisions,
    Judgement,
)
from restir_gi.reference.oracle.replay.rules import Rules

Judge = Callable[[Case, Buffers, Rules, Precision], Judgement]

BY_ROW = (
    "target",
    "jacobian",
    "merge",
    "finalize",
    "similar",
    "initial",
    "temporal",
    "moved",
    "spatial",
    "fused",
    "shade",
)
"""Passes whose rows hang on nothing but their own numbers, and on their neighbours'."""

BLOCK = 2**16
"""Rows of a block.  A replay of Algorithm 4 takes some 12 KB for each."""


def rows_of(case: Case, rows: slice | Indices) -> Case:
    """Some rows of a case of a pass in `BY_ROW`; neighbours are still rows of all.

    Parameters
    ----------
    rows : slice or (K,) int; which
    """

    def taken(found: Buffers) -> Buffers:
        return {name: array[rows] for name, array in found.items()}

    return replace(
        case,
        inputs=taken(case.inputs),
        beyond=None if case.beyond is None else case.beyond[rows],
        decoded=None if case.decoded is None else taken(case.decoded),
        width=None,
        around=case.around or case,
    )


def blocks(case: Case) -> Iterator[tuple[slice, Case]]:
    """All rows of a case, each block with its place; the case itself if it is small."""
    if case.rows <= BLOCK:
        yield slice(0, case.rows), case
        return
    for first in range(0, case.rows, BLOCK):
        place = slice(first, min(first + BLOCK, case.rows))
        yield place, rows_of(case, place)


def in_blocks(judge: Judge) -> Judge:
    """A judge of a pass in `BY_ROW`, who is given no more than a block at once."""

    def judged(
        case: Case, outputs: Buffers, rules: Rules, precision: Precision
    ) -> Judgement:
        found = [
            judge(part, {n: a[place] for n, a in outputs.items()}, rules, precision)
            for place, part in blocks(case)
        ]
        return found[0] if len(found) == 1 else _joined(found)

    return judged


def _joined(found: Sequence[Judgement]) -> Judgement:
    """What was found in all blocks, as if they had been one."""
    first = found[0]

    def join(arrays: Iterator[NDArray[np.generic]]) -> NDArray[np.generic]:
        return np.concatenate(list(arrays))

    compared = tuple(
        Compared(
            one.name,
            join(f.compared[k].found for f in found),
            join(f.compared[k].expected for f in found),
            join(f.compared[k].allowed for f in found),
        )
        for k, one in enumerate(first.compared)
    )
    terms = {name: join(f.terms[name] for f in found) for name in first.terms}
    made = [f.decisions for f in found if f.decisions is not None]
    decisions = made[0] if made else None
    if decisions is not None:
        decisions = Decisions(
            np.concatenate([one.illegal for one in made]),
            sum(one.differing for one in made),
            sum(one.expected for one in made),
            decisions.what,
        )
    return Judgement(compared, terms, decisions, first.counted)

"""Whether samples were chosen as their weights say, from what was kept alone.

The bound is proven, for rows that draw independently of each other and of what they
were given.  It is shared among all sums that are looked at: most of the false alarms
that are allowed go to each candidate over all rows, some to its strata: rows in which
its chance is alike, and tiles of the image.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Masks
from restir_gi.reference.oracle.capture.cases import Answered
from restir_gi.reference.oracle.capture.shares import (
    StreamChances,
    accepted,
    candidates_of,
)
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.levels.probe import Finding
from restir_gi.reference.oracle.replay.rules import Rules
from restir_gi.reference.oracle.statistics.choices import Chances, Wins, wins

FALSE_ALARM = 1e-6
"""Largest probability with which a right renderer is accused, over all passes."""

PASSES = 3
"""Among which that is shared: `temporal`, `moved` and `spatial`."""

EVERYWHERE = 0.9
"""Share of it that goes to sums over all rows; strata have the rest."""

CHANCE_EDGES = (0.0, 0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 1.0)
TILES = 4
"""On a side of the image."""


@dataclass(frozen=True, slots=True, eq=False)
class Group:
    """Some rows of all frames, of one candidate.

    Attributes
    ----------
    words : str; where, for messages; empty: everywhere
    wins : Wins; of all frames
    """

    candidate: str
    words: str
    wins: Wins


def choice_findings(
    answered: Sequence[Answered], rules: Rules, precision: Precision
) -> Iterator[Finding]:
    """One finding of a pass in all its frames, if it chooses.

    Parameters
    ----------
    answered : sequence of Answered; of one pass
    rules : Rules; by which it calculates, as W has shown
    """
    frames = [
        (one, candidates_of(one.case, one.outputs, rules, precision))
        for one in answered
    ]
    known = [(one, found) for one, found in frames if found is not None]
    if known:
        yield _finding(known)


Frames = Sequence[tuple[Answered, StreamChances]]


def _finding(frames: Frames) -> Finding:
    pass_name = frames[0][0].case.pass_name
    groups = _groups(frames, None)
    worst = _worst(groups)
    if worst is None:
        return Finding(True, asked=(pass_name,))
    text = f"{pass_name}: {_told(worst)}"
    named = _named(frames)
    return Finding(False, f"{text}; {named}" if named else text, asked=(pass_name,))


def _worst(groups: Sequence[Group]) -> Group | None:
    """The group that accuses most, beyond what is allowed; overall before strata."""
    everywhere = [g for g in groups if not g.words]
    strata = [g for g in groups if g.words]
    for some, part in ((everywhere, EVERYWHERE), (strata, 1 - EVERYWHERE)):
        found = [g for g in some if g.wins.log_e >= evidence_needed(len(some), part)]
        if found:
            return max(found, key=lambda g: g.wins.log_e)
    return None


def evidence_needed(sums: int, part: float) -> float:
    """Logarithm of the evidence that accuses, of one sum among several.

    Parameters
    ----------
    part : float; of the false alarms of a pass that go to all of these
    """
    return float(np.log(PASSES * max(sums, 1) / (part * FALSE_ALARM)))


def _groups(frames: Frames, mistake: str | None) -> list[Group]:
    """All sums that are looked at."""
    parts: dict[tuple[str, str], list[Chances]] = {}
    for one, candidates in frames:
        tiles = _tile(one, candidates)
        shares = accepted(candidates, mistake) if mistake else candidates.shares()
        for name, chances in candidates.chances(shares):
            parts.setdefault((name, ""), []).append(chances)
            for words, rows in _strata(chances, tiles):
                parts.setdefault((name, words), []).append(chances.of(rows))
    return [
        Group(name, words, wins(found, len(frames)))
        for (name, words), found in parts.items()
    ]


def _strata(chances: Chances, tiles: Indices | None) -> Iterator[tuple[str, Masks]]:
    p = chances.middle
    for low, high in pairwise(CHANCE_EDGES):
        last = high == CHANCE_EDGES[-1]
        rows = (p >= low) & ((p <= high) if last else (p < high))
        yield f"where its chance is {low:g} to {high:g}", rows
    if tiles is not None:
        for tile in range(TILES * TILES):
            j, i = divmod(tile, TILES)
            yield f"in tile ({i}, {j}) of {TILES} × {TILES}", tiles == tile


def _tile(one: Answered, candidates: StreamChances) -> Indices | None:
    """Tile of each row that is shown, (N,)."""
    width = one.case.width
    if width is None:
        return None
    y, x = np.divmod(np.arange(one.case.rows), width)
    height = -(-one.case.rows // width)
    tile: Indices = (y * TILES // height) * TILES + x * TILES // width
    return tile[candidates.shown]


def _told(group: Group) -> str:
    found = group.wins
    where = f" {group.words}" if group.words else ""
    return (
        f"{group.candidate} was kept in {found.kept:,} of {found.rows:,} rows{where},"
        f" where the weights say {found.expected:,.0f} ± {found.deviation:,.0f}"
        f" ({100 * found.excess:+.2g} %; e-value 10^{found.log_e / np.log(10):.0f})"
    )


DECISIONS = (
    "accepts-by-the-old-sum",
    "always-accepts",
    "never-accepts",
    "one-number-for-all-decisions",
)


def _named(frames: Frames) -> str:
    """Which known mistake gives chances that nothing speaks against."""
    for mistake in DECISIONS:
        if _worst(_groups(frames, mistake)) is None:
            return f"the chances are those of {mistake}"
    return ""

"""What rules reproduce of a few rows of a pass, output by output."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Indices, Masks
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.diagnosis.subsets import (
    AskedRows,
    judged,
    some_rows,
)
from restir_gi.reference.oracle.replay.blocks import BY_ROW
from restir_gi.reference.oracle.replay.judgement import Compared
from restir_gi.reference.oracle.replay.resampling import COPIED, held_by
from restir_gi.reference.oracle.replay.reuse import stream_of
from restir_gi.reference.oracle.replay.rules import CONTRACT_RULES, Rules
from restir_gi.reference.oracle.replay.storage import in_format

WRONG_ROWS, RIGHT_ROWS, CASES = 32, 8, 3
"""Rows of a case that rules are first held against, and cases that are cut so."""

DECIDED = ("second", *COPIED)
"""Outputs that are right or wrong as a decision is."""

EVERYTHING = ""
"""Stands for a row in which every output is right, and the decision."""


@dataclass(frozen=True, slots=True, eq=False)
class Reproduced:
    """What some rules reproduce of a case, L rows that are looked at.

    Attributes
    ----------
    right : mapping of str to (L,) bool; of each output that is a number, and of
        `EVERYTHING`
    expected : mapping of str to (L, ...) array; each number, as the rules have it
    near : mapping of str to float; how near each number is, of all rows together
    """

    right: Mapping[str, Masks]
    expected: Mapping[str, NDArray[Any]]
    near: Mapping[str, float]

    def share(self, outputs: Sequence[str]) -> float:
        """Share of the rows in which all these outputs are right.

        Where several choices are needed until one row is, a number that is nearer says
        which of them is one.
        """
        share = float(np.all([self.right[name] for name in outputs], axis=0).mean())
        if share == 1:
            return share
        return 0.7 * share + 0.3 * self.near.get(outputs[-1], 0.0)


def _nearness(one: Compared, rows: Masks) -> float:
    """1 where found and expected numbers have the same ratio everywhere, 0 far off."""
    found, expected = one.found[rows].astype(np.float64), one.expected[rows]
    both = (found > 0) & (expected > 0) & np.isfinite(found) & np.isfinite(expected)
    if not both.any():
        return 0.0
    ratio = np.log(found[both] / expected[both])
    return float(np.exp(-np.abs(ratio - np.median(ratio)).mean()))


@dataclass(frozen=True, slots=True, eq=False)
class SampleRows:
    """A few rows of a pass, with what rules were found to reproduce of them.

    Attributes
    ----------
    asked : tuple of AskedRows; of cases that are unlike
    known : dict; results by place in ``asked`` and rules, each calculated once
    """

    asked: tuple[AskedRows, ...]
    precision: Precision
    known: dict[tuple[int, Rules], Reproduced] = field(default_factory=dict)

    @property
    def numbers(self) -> tuple[str, ...]:
        """Outputs that are numbers, M first: it hangs on the fewest choices."""
        names = self.reproduced(0, CONTRACT_RULES).expected
        return tuple(sorted(names, key=lambda name: name != "M"))

    def reproduced(self, place: int, rules: Rules) -> Reproduced:
        """What rules reproduce of one of the cases."""
        if (place, rules) not in self.known:
            asked = self.asked[place]
            self.known[place, rules] = _reproduced(asked, rules, self.precision)
        return self.known[place, rules]

    def score(self, rules: Rules, outputs: Sequence[str]) -> float:
        """Cases in which these outputs are right, and the share of rows in the next.

        A case is looked at when all before it is reproduced.
        """
        for place in range(len(self.asked)):
            share = self.reproduced(place, rules).share(outputs)
            if share < 1:
                return place + share
        return float(len(self.asked))

    def answer(self, rules: Rules, outputs: Sequence[str]) -> tuple[bytes, ...]:
        """What rules reproduce, and what they expect, as far as it is looked at.

        Rules with the same answer cannot be told apart by these rows.
        """
        found = [rules.storage.encode()]
        for place in range(len(self.asked)):
            one = self.reproduced(place, rules)
            found += [
                a.tobytes() for a in (*one.expected.values(), one.right[EVERYTHING])
            ]
            if one.share(outputs) < 1:
                break
        return tuple(found)

    def acts(self, rules: Rules, output: str) -> bool:
        """Whether rules expect another output than the contract, somewhere."""
        for place in range(len(self.asked)):
            ours, other = (
                self.reproduced(place, one).expected[output]
                for one in (CONTRACT_RULES, rules)
            )
            if not np.array_equal(ours, other, equal_nan=True):
                return True
        return False

    def complete(self, score: float) -> bool:
        """Whether all rows are reproduced."""
        return score >= len(self.asked)

    def held(self, rules: Rules) -> tuple[float, int]:
        """Share of the rows in which a given sample is kept, as far as storage tells.

        None where numbers are not those of the format; and how many outputs it is the
        format of.  Nothing else is asked of the rules: what is kept is one of those
        that were given, whatever the weights are.
        """
        shares, formats = [], 0
        for asked in self.asked:
            stored = in_format(asked.outputs, rules.storage)
            if any((one.excess > 1).any() for one in stored):
                return 0.0, 0
            slots, _ = stream_of(asked.case, rules, self.precision)
            held: Masks = np.any(held_by(asked.outputs, slots, rules), axis=0)
            shares.append(held[asked.rows].mean())
            formats = len(stored)
        return float(np.mean(shares)), formats

    def with_rows(self, asked: AskedRows, wrong: Masks) -> "SampleRows":
        """The same, and rows of a case that some rules did not reproduce.

        Parameters
        ----------
        wrong : (N,) bool; of the case
        """
        return replace(self, asked=(*self.asked, _cut(asked, wrong)))


def _reproduced(asked: AskedRows, rules: Rules, precision: Precision) -> Reproduced:
    judgement, everything = judged(asked, rules, precision)
    right, expected, near = {EVERYTHING: everything[asked.rows]}, {}, {}
    stored = {one.name for one in in_format(asked.outputs, rules.storage)}
    for one in judgement.compared:
        if one.name not in (*DECIDED, *stored):
            right[one.name] = (one.excess <= 1)[asked.rows]
            expected[one.name] = one.expected[asked.rows]
            near[one.name] = _nearness(one, asked.rows)
    return Reproduced(right, expected, near)


def sample_of(
    given: Sequence[AskedRows], wrong: Sequence[Masks], precision: Precision
) -> SampleRows:
    """Wrong and right rows of cases that are unlike, those with most wrong rows.

    Parameters
    ----------
    wrong : sequence of (N,) bool; rows of each that the contract does not explain
    """
    return SampleRows(tuple(_chosen(given, wrong)), precision)


def _chosen(given: Sequence[AskedRows], wrong: Sequence[Masks]) -> Iterator[AskedRows]:
    counts = [int((bad & a.rows).sum()) for a, bad in zip(given, wrong, strict=True)]
    seen: list[tuple[tuple[str, object], ...]] = []
    for k in np.argsort([-count for count in counts], kind="stable"):
        settings = tuple(given[k].case.settings.items())
        if counts[k] and settings not in seen and len(seen) < CASES:
            seen.append(settings)
            yield _cut(given[k], wrong[k])


def _cut(asked: AskedRows, wrong: Masks) -> AskedRows:
    if asked.case.pass_name not in BY_ROW:
        return asked
    bad = _spread(wrong & asked.rows, WRONG_ROWS)
    fine = _spread(~wrong & asked.rows, RIGHT_ROWS)
    return some_rows(asked, np.concatenate([bad, fine]))


def _spread(rows: Masks, count: int) -> Indices:
    """Some of the rows, from one end to the other."""
    found: Indices = np.flatnonzero(rows)
    places = np.linspace(0, len(found) - 1, count).astype(int)
    return found[places] if len(found) > count else found

"""Which wrong row is shown, and how its numbers are written."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Indices, Scalars
from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.replay.judgement import Compared, Judgement

DIGITS, MORE_DIGITS = 9, 17
"""Decimals that tell any two numbers of single and of double precision apart."""


def excess_of(compared: Compared) -> Scalars:
    """Largest difference of each row, in units of what rounding allows.

    Returns (N,) float; infinite where nothing was allowed; 0 where anything was.
    """
    with np.errstate(over="ignore"):
        excess = compared.excess
    return np.where(np.isnan(excess), 0.0, excess)


def row_excess(judgement: Judgement) -> Scalars:
    """(N,): largest excess of all outputs; infinite where a choice is illegal."""
    largest: Scalars = np.max([excess_of(c) for c in judgement.compared], axis=0)
    if judgement.decisions is not None:
        largest = np.where(judgement.decisions.illegal, np.inf, largest)
    return largest


def wrong_rows(case: Case, judgement: Judgement) -> Indices:
    """Rows that are wrong within the working range; if none is, all that are wrong.

    Returns (R,) int; in their order.
    """
    wrong = judgement.wrong
    within = wrong if case.beyond is None else wrong & ~case.beyond
    return np.flatnonzero(within if within.any() else wrong)


def typical_row(case: Case, judgement: Judgement) -> int:
    """The wrong row in the middle: as many are more wrong as are less."""
    rows = wrong_rows(case, judgement)
    order = np.argsort(row_excess(judgement)[rows], kind="stable")
    return int(rows[order[(len(rows) - 1) // 2]])


def told_rows(case: Case, judgement: Judgement) -> str:
    """How many rows are wrong, and what is wrong with a typical one.

    Parameters
    ----------
    judgement : Judgement; with at least one wrong row
    """
    row, wrong = typical_row(case, judgement), len(wrong_rows(case, judgement))
    share = f"{wrong:,} of {case.rows:,} rows are wrong"
    share += f"; in {place(case, row)}" + (", a typical one," if wrong > 1 else "")
    decisions = judgement.decisions
    if decisions is not None and decisions.illegal[row]:
        return f"{share} {decisions.what} differs from the exact rule by more than" + (
            f" rounding explains{_slots(judgement, row)}"
        )
    most = max(judgement.compared, key=lambda c: float(excess_of(c)[row]))
    found, expected = np.ravel(most.found[row]), np.ravel(most.expected[row])
    with np.errstate(invalid="ignore"):
        difference = np.abs(found.astype(np.float64) - expected)
    column = int(np.nan_to_num(difference, nan=np.inf).argmax())
    pair = written_pair(found[column], expected[column])
    return f"{share} {most.name} is {pair[0]} instead of {pair[1]}"


def place(case: Case, row: int) -> str:
    """A row as a pixel, if it is one."""
    if case.width is None:
        return f"row {row}"
    return f"pixel ({row % case.width}, {row // case.width})"


def written(value: Any, kind: str, digits: int = DIGITS) -> str:
    """A number as it is read: bits as bits, whole numbers as such, others as decimals.

    Parameters
    ----------
    kind : str; of NumPy: 'u' for bits, 'i' for row numbers, else a real
    """
    if kind not in "ui" or not np.isfinite(value):
        return f"{value:.{digits}g}"
    # Flags and counts are bits, too, and nobody reads 0x00000001.
    return f"0x{int(value):08x}" if kind == "u" and value > 9 else str(int(value))


def written_pair(found: NDArray[Any], expected: Any) -> tuple[str, str]:
    """Two numbers with as many digits as tell them apart.

    Parameters
    ----------
    found : scalar array; its type says what both are
    """
    kind = np.asarray(found).dtype.kind
    short = written(found, kind), written(expected, kind)
    if short[0] != short[1]:
        return short
    return written(found, kind, MORE_DIGITS), written(expected, kind, MORE_DIGITS)


def _slots(judgement: Judgement, row: int) -> str:
    """Which candidate the row kept, and which the exact rule keeps, where known."""
    names = ("kept slot", "slot in exact arithmetic")
    if not set(names) <= set(judgement.terms):
        return ""
    kept, exact = (int(judgement.terms[name][row]) for name in names)
    if kept == exact:
        return ": it is none of the candidates"
    return f": candidate {kept} of the stream in place of {exact}"

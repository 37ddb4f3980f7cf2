"""A failing case: how to ask for it again, a typical wrong row, and the worst ones."""

import shlex
from collections.abc import Iterator
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.oracle.cases import Buffers
from restir_gi.reference.oracle.levels.probe import Answer
from restir_gi.reference.oracle.replay.judgement import Compared, Judgement
from restir_gi.reference.oracle.replay.typical import (
    excess_of,
    typical_row,
    wrong_rows,
)
from restir_gi.reference.reports.verdict.worst import worst_rows

MOST_ROWS = 5
"""Of a case that are shown."""

SLOT = "w of slot "

DIFFERS = 1e-4
"""Relative difference from which a term of the backend is marked: more than rounding
makes of single precision where nothing cancels.  It is no verdict."""


def failing_case(answer: Answer, again: str = "") -> dict[str, Any]:
    """A wrong replay for programs: a typical row first, then the worst.

    Parameters
    ----------
    again : str; command of the check, to which the case is added; empty if unknown
    """
    assert answer.finding is not None
    case, judgement = answer.probe.case, answer.finding.judgement
    assert judgement is not None
    return {
        "case": case.name,
        "level": answer.probe.level,
        "settings": dict(case.settings),
        "command": command(answer, again),
        "wrong_rows": len(wrong_rows(case, judgement)),
        "rows": case.rows,
        "kinds": {name: array.dtype.kind for name, array in _buffers(answer)},
        "shown": [_row(answer, judgement, row) for row in _shown(answer, judgement)],
    }


def command(answer: Answer, again: str) -> str | None:
    """What asks for this case alone; ``None`` where the check has no command."""
    return f"{again} --case {shlex.quote(answer.probe.case.name)}" if again else None


def as_number(value: Any) -> Any:
    """A number, or nested lists of them; ``None`` in place of what JSON does not know.

    Parameters
    ----------
    value : number or array; of any type
    """
    plain = np.asarray(value).tolist()
    return [as_number(x) for x in plain] if isinstance(plain, list) else _finite(plain)


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not isfinite(value) else value


def _buffers(answer: Answer) -> Iterator[tuple[str, NDArray[Any]]]:
    yield from answer.probe.case.inputs.items()
    for compared in _sure(answer).compared:
        yield compared.name, compared.found


def _sure(answer: Answer) -> Judgement:
    assert answer.finding is not None
    assert answer.finding.judgement is not None
    return answer.finding.judgement


def _shown(answer: Answer, judgement: Judgement) -> list[int]:
    """Rows, a typical one first."""
    worst = [int(row) for row in worst_rows(judgement, MOST_ROWS)]
    if not judgement.wrong.any():
        return worst
    typical = typical_row(answer.probe.case, judgement)
    return [typical, *(row for row in worst if row != typical)][:MOST_ROWS]


def _row(answer: Answer, judgement: Judgement, row: int) -> dict[str, Any]:
    width, case = answer.probe.case.width, answer.probe.case
    wrong = judgement.wrong.any()
    return {
        "row": row,
        "typical": bool(wrong) and row == typical_row(case, judgement),
        "x": None if width is None else row % width,
        "y": None if width is None else row // width,
        "inputs": {name: as_number(a[row]) for name, a in case.inputs.items()},
        "neighbors": _neighbors(case.inputs, row),
        "outputs": {c.name: _compared(c, row) for c in judgement.compared},
        "terms": {
            name: _term(answer.outputs or {}, name, np.asarray(term), row)
            for name, term in judgement.terms.items()
        },
    }


def _neighbors(inputs: Buffers, row: int) -> list[dict[str, Any]]:
    """Inputs of the rows that a pass reads beside its own; decisions are its own."""
    if "neighbors" not in inputs:
        return []
    own = ("neighbors", "visible", "u_own", "u_neighbors")
    rows = [int(other) for other in np.ravel(inputs["neighbors"][row]) if other >= 0]
    return [
        {
            "row": other,
            "inputs": {
                n: as_number(a[other]) for n, a in inputs.items() if n not in own
            },
        }
        for other in dict.fromkeys(rows)
    ]


def _term(
    outputs: Buffers, name: str, expected: NDArray[Any], row: int
) -> dict[str, Any]:
    """Both sides of a term; ``found`` is ``None`` where the backend does not give it.

    A buffer of nothing but zeros was never written.
    """
    given = _given(outputs, name)
    if given is None or (not np.any(given) and np.any(expected)):
        return {"found": None, "expected": as_number(expected[row]), "differs": False}
    found, right = np.asarray(given[row], float), np.asarray(expected[row], float)
    return {
        "found": as_number(given[row]),
        "expected": as_number(expected[row]),
        "differs": not np.allclose(found, right, rtol=DIFFERS, atol=0, equal_nan=True),
    }


def _given(outputs: Buffers, name: str) -> NDArray[Any] | None:
    if name.startswith(SLOT) and "term_w" in outputs:
        column: NDArray[Any] = outputs["term_w"][:, int(name.removeprefix(SLOT))]
        return column
    return outputs.get(f"term_{name}")


def _compared(compared: Compared, row: int) -> dict[str, Any]:
    found, expected = compared.found[row], compared.expected[row]
    # Whole numbers were compared as such, though in double precision.
    if compared.found.dtype.kind in "ui" and np.isfinite(expected).all():
        expected = np.asarray(expected).astype(np.int64)
    return {
        "found": as_number(found),
        "expected": as_number(expected),
        "allowed": as_number(compared.allowed[row]),
        "excess": as_number(excess_of(compared)[row]),
    }

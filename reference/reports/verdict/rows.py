"""The worst rows of a case, with all that was compared and why it was expected."""

from math import isfinite
from typing import Any

import numpy as np

from restir_gi.reference.oracle.cases import Buffers
from restir_gi.reference.oracle.levels.probe import Answer
from restir_gi.reference.oracle.replay.judgement import Compared, Judgement
from restir_gi.reference.reports.verdict.worst import excess_of, worst_rows

MOST_ROWS = 5

SLOT = "w of slot "


def worst_case(answer: Answer) -> dict[str, Any]:
    """A wrong replay for programs.

    Name of the case, how many rows are wrong, and the `MOST_ROWS` worst.
    """
    assert answer.finding is not None
    case, judgement = answer.probe.case, answer.finding.judgement
    assert judgement is not None
    return {
        "case": case.name,
        "wrong_rows": int(judgement.wrong.sum()),
        "rows": case.rows,
        "worst": [
            _row(answer, judgement, int(row))
            for row in worst_rows(judgement, MOST_ROWS)
        ],
    }


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


def _row(answer: Answer, judgement: Judgement, row: int) -> dict[str, Any]:
    width, found = answer.probe.case.width, answer.outputs or {}
    return {
        "row": row,
        "x": None if width is None else row % width,
        "y": None if width is None else row // width,
        "outputs": {c.name: _compared(c, row) for c in judgement.compared},
        "terms": {
            name: {
                "found": as_number(_found(found, name, row)),
                "expected": as_number(term[row]),
            }
            for name, term in judgement.terms.items()
        },
    }


def _found(outputs: Buffers, name: str, row: int) -> Any:
    """The backend's side of a term; ``None`` where it does not give it."""
    if name.startswith(SLOT) and "term_w" in outputs:
        return outputs["term_w"][row, int(name.removeprefix(SLOT))]
    term = outputs.get(f"term_{name}")
    return None if term is None else term[row]


def _compared(compared: Compared, row: int) -> dict[str, Any]:
    sides = ("found", "expected", "allowed")
    numbers = {side: as_number(getattr(compared, side)[row]) for side in sides}
    return {**numbers, "excess": as_number(excess_of(compared)[row])}

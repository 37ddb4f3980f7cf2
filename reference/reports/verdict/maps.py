"""Pictures of a wrong pass: where it is off, to which side, and how far."""

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.oracle.levels.probe import Answer
from restir_gi.reference.oracle.replay.judgement import Compared, Judgement
from restir_gi.reference.oracle.replay.typical import excess_of
from restir_gi.reference.reports.comparison.maps import (
    SIGNED,
    UNSIGNED,
    ErrorMap,
    scale_of,
)
from restir_gi.reference.reports.verdict.worst import other_decisions

ALLOWED = (
    "(found − expected) / what rounding allows: red where the backend gives too much,"
    " blue where too little; a right backend stays within ±1."
)
RELATIVE = (
    "(found − expected) / the larger of the two: red where the backend gives too much,"
    " blue where too little."
)
DECISIONS = (
    "Bright where the backend kept another sample than exact arithmetic does, be it"
    " within rounding or not."
)


def error_maps(answer: Answer) -> list[ErrorMap]:
    """Pictures of a case.

    One for each wrong output, or for each that differs if none is wrong; then one of
    the decisions, if any differs.  None where the rows are no image or nothing was
    replayed.
    """
    judgement = answer.finding.judgement if answer.finding else None
    width = answer.probe.case.width
    if judgement is None or width is None:
        return []
    wrong = [c for c in judgement.compared if (excess_of(c) > 1).any()]
    differs = [c for c in judgement.compared if (c.found != c.expected).any()]
    maps = [signed_map(compared, width) for compared in wrong or differs]
    return [*maps, *_decisions(judgement, width)]


def signed_map(compared: Compared, width: int) -> ErrorMap:
    """Signed difference of a buffer, mean over the components.

    In units of what rounding allows; where it allows nothing or anything, relative.
    """
    found, expected, allowed = (
        _mean(array) for array in (compared.found, compared.expected, compared.allowed)
    )
    limited = bool((np.isfinite(allowed) & (allowed > 0)).any())
    size = np.maximum(np.abs(found), np.abs(expected))
    unit = allowed if limited else size
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        difference = found - expected
        values = np.where(difference == 0, 0.0, difference / unit)
    known = values[np.isfinite(values)]
    limit = scale_of(known) if known.size else 1.0
    limit = max(limit, 1.0) if limited else limit
    return ErrorMap(
        compared.name,
        f"Signed difference of {compared.name}",
        ALLOWED if limited else RELATIVE,
        values.reshape(-1, width),
        -limit,
        limit,
        SIGNED,
    )


def _decisions(judgement: Judgement, width: int) -> list[ErrorMap]:
    differs = other_decisions(judgement)
    if not differs.any():
        return []
    values = differs.astype(np.float64).reshape(-1, width)
    title = "Decisions that differ"
    return [ErrorMap("decisions", title, DECISIONS, values, 0.0, 1.0, UNSIGNED)]


def _mean(array: Scalars) -> Scalars:
    rows = array.astype(np.float64).reshape(len(array), -1)
    with np.errstate(invalid="ignore"):
        mean: Scalars = rows.mean(axis=1)
    return mean

"""L0: kernels beside exact arithmetic on the very numbers that they were given."""

from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.exact.numbers import Exact
from restir_gi.reference.oracle.levels.exact_formulas import FORMULAS, rows_of
from restir_gi.reference.oracle.levels.probe import Finding
from restir_gi.reference.oracle.levels.replayed import examined_by_replay, found_in
from restir_gi.reference.oracle.replay.judgement import Judgement


# A case is asked of many backends, and its exact numbers stay the same.
@lru_cache(maxsize=64)
def exact_outputs(case: Case) -> dict[str, Scalars]:
    """What the contract asks for, in 50 digits, rounded once.

    Parameters
    ----------
    case : Case
        Of a kernel with real numbers, or of ``shade``; N rows, all of which are
        calculated, at some 50 µs each.

    Returns
    -------
    dict of str to (N, ...) float64
        What the judge of the pass compares, by its names: the outputs, but for
        ``direction``, whose frame is the backend's own, the cosine with the normal,
        the length, the cosine of the azimuth from the first row of the same normal,
        and the density.  Decisions are 0 or 1, and as exact.  Where W overflows, from
        a quarter of the largest number of the inputs' type on, it is that number.
    """
    formula = FORMULAS[case.pass_name]
    found = [formula(row, case.settings) for row in rows_of(case)]
    outputs = {
        name: np.array([_nearest(one[name]) for one in found]) for name in found[0]
    }
    if "W" in outputs:
        outputs["W"] = _up_to_the_largest(outputs["W"], case.inputs["w"])
    for array in outputs.values():
        array.setflags(write=False)
    return outputs


def _nearest(value: Any) -> Any:
    """Nearest float64: infinite beyond the largest, perhaps rounded twice near 0."""
    if isinstance(value, tuple):
        return [_nearest(component) for component in value]
    return float(value.value if isinstance(value, Exact) else value)


def _up_to_the_largest(W: Scalars, w: Scalars) -> Scalars:
    most = float(np.finfo(w.dtype).max)
    return np.where(most / 4 < W, most, W)


def judged_exactly(case: Case, judgement: Judgement) -> Judgement:
    """A judgement with exact numbers as what is expected.

    What rounding may explain is as it was: the bounds and the decisions within
    rounding.
    """
    exact = exact_outputs(case)
    compared = (replace(c, expected=exact[c.name]) for c in judgement.compared)
    return replace(judgement, compared=tuple(compared))


def examined_exactly(case: Case, outputs: Buffers, precision: Precision) -> Finding:
    """Examine a kernel's answer beside exact numbers.

    Passed where each number within the working range is within the replay's bound of
    the exact one; with the judgement that says so.
    """
    judged = examined_by_replay(case, outputs, precision)
    assert judged.judgement is not None
    return found_in(case, judged_exactly(case, judged.judgement), precision)

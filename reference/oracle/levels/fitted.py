"""Cases as a backend has their pass: how many neighbours, and whether there is a past.

Neighbours that are too many are left out, and those that lack are none, row −1; a
spatial past that is not merged is empty.  Who takes targets as data, and has no other,
is given those of the contract.
"""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Scalars
from restir_gi.reference.oracle.backends.selected import Selection
from restir_gi.reference.oracle.cases import SOURCES, Buffers, Case
from restir_gi.reference.oracle.given_targets import FORMULAS, with_given_targets
from restir_gi.reference.oracle.levels.grades import graded
from restir_gi.reference.oracle.levels.probe import Probe


def fitted_probes(probes: Iterable[Probe], selection: Selection) -> list[Probe]:
    """Questions as a backend has their passes."""
    return [replace(p, case=fitted(p.case, selection)) for p in probes]


def fitted(case: Case, selection: Selection) -> Case:
    """A case as a backend has its pass; the same one if it has all of it."""
    if selection.takes_targets(case):
        case = with_given_targets(case, FORMULAS[str(case.settings["target"])])
        case = case if case.pass_name in SOURCES else graded(case)
    if case.pass_name not in SOURCES:
        return case
    inputs = fitted_inputs(case.pass_name, case.inputs, selection)
    return case if inputs is case.inputs else graded(replace(case, inputs=inputs))


def fitted_inputs(pass_name: str, inputs: Buffers, selection: Selection) -> Buffers:
    """Inputs of a pass with neighbours, the same ones if a backend has all of it."""
    count = inputs[SOURCES[pass_name].rows].shape[1]
    asked = selection.neighbors_for(count)
    if asked != count:
        inputs = with_neighbors(pass_name, inputs, asked)
    has_history = selection.history or pass_name != "spatial"
    if not has_history and np.any(inputs["past_M"]):
        none = np.zeros_like(inputs["past_M"])
        inputs = {**inputs, "past_W": none, "past_M": none}
    return inputs


def with_neighbors(pass_name: str, inputs: Buffers, count: int) -> Buffers:
    """Inputs of a pass with another number of neighbours.

    Parameters
    ----------
    count : int; the first ones that there are, and −1 for the rest
    """
    names = SOURCES[pass_name]
    around, u = inputs[names.rows], inputs[names.u]
    before = around.shape[1]
    kept = min(before, count)
    more = ((0, 0), (0, count - kept))
    words = inputs["visible"][:, : 1 + kept]
    if pass_name == "spatial":
        words = _moved_bits(words, before, count)
    given = inputs.get("p_hat_given")
    more_given = {} if given is None else {"p_hat_given": _given(given, kept, count)}
    return {
        **inputs,
        **more_given,
        names.rows: np.pad(around[:, :kept], more, constant_values=-1),
        names.u: np.pad(u[:, :kept], more, constant_values=0.5),
        "visible": np.pad(words, more),
    }


def _given(p_hat: Scalars, kept: int, count: int) -> Scalars:
    """Targets of points and samples; that of the spatial past stays the last."""
    past = p_hat.shape[1] != p_hat.shape[2]
    found = np.zeros((len(p_hat), 1 + count, 1 + count + past), p_hat.dtype)
    found[:, : 1 + kept, : 1 + kept] = p_hat[:, : 1 + kept, : 1 + kept]
    if past:
        found[:, : 1 + kept, -1] = p_hat[:, : 1 + kept, -1]
    return found


def _moved_bits(words: Indices, before: int, after: int) -> Indices:
    """Words whose last bit, that of the spatial past, stands in another place."""
    one = np.uint32(1)
    past = (words >> np.uint32(1 + before)) & one
    others = words & np.uint32((1 << (1 + min(before, after))) - 1)
    return others | (past << np.uint32(1 + after))

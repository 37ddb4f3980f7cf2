"""L1: passes integrated exactly, over every outcome and all decisions.

By the contract a decision between weights that are whole numbers has a threshold that
is known: a candidate of weight w is kept where u < w / S.  So each decision is asked
twice, just below its threshold and just above, and each answer counts with the length
of its side.  The sum over all outcomes is then the expectation of any backend that
decides as the contract does.  Where it is not what must come out, the backend has other
weights, another order, or a bias: its own thresholds are looked for, and the
expectation that is printed is that of its own distribution.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Scalars
from restir_gi.reference.oracle.backends.backend import Backend
from restir_gi.reference.oracle.backends.selected import Selection, selection_of
from restir_gi.reference.oracle.buffers import given
from restir_gi.reference.oracle.cases import (
    NO_TIME,
    SOURCES,
    Buffers,
    Case,
    Failure,
    Outcome,
    Unasked,
    refused,
)
from restir_gi.reference.oracle.contract.fields import Passes, Precision
from restir_gi.reference.oracle.contract.targets import DATA
from restir_gi.reference.oracle.contract.weights import MIS
from restir_gi.reference.oracle.given_targets import FORMULAS, given_targets
from restir_gi.reference.oracle.levels.enumeration import (
    LatticeEnumeration,
    declared_enumerations,
    enumerations,
    enumerations_around,
)
from restir_gi.reference.oracle.levels.expectation import (
    ROUNDINGS,
    bias,
    expectations,
    kept_by,
    other_confidence,
)
from restir_gi.reference.oracle.levels.fitted import fitted_inputs
from restir_gi.reference.oracle.levels.probe import Finding, Probe
from restir_gi.reference.oracle.levels.replayed import replayed
from restir_gi.reference.oracle.levels.thresholds import own_expectation
from restir_gi.reference.oracle.steps import LevelStep, asked

AROUND = (2, 1)
"""Neighbours of a pass that has them."""

NEARLY_0 = 2.0**-20
"""A number u where nothing is left to decide."""


def lattice_probes(
    precision: Precision,
    chosen: Sequence[LatticeEnumeration] | None = None,
) -> list[Probe]:
    """Expectations of the passes that choose, of level L1.

    They are exact, so that a right backend that decides as the contract does cannot
    fail.  One that decides otherwise is examined as a replay examines it.

    Parameters
    ----------
    chosen : sequence of LatticeEnumeration, optional
        Those of weights that nobody need declare, unless others are given.
    """
    every = enumerations() if chosen is None else chosen
    return [_merge(precision), *(_probe(e, precision) for e in every)]


def enumerations_for(selection: Selection) -> list[LatticeEnumeration]:
    """What a backend is asked, as it has the passes: with one neighbour, too.

    Weights that have to be declared come last.
    """
    found: list[LatticeEnumeration] = []
    has_more = selection.declares(MIS.name)
    for declared in (False, True) if has_more else (False,):
        every = declared_enumerations() if declared else enumerations()
        found += [_fitted(e, selection) for e in every if e.pass_name not in SOURCES]
        for count in AROUND:
            if selection.neighbors_for(count) >= count:
                about = count, selection.history, declared
                found += [_fitted(e, selection) for e in enumerations_around(*about)]
    return found


def every_enumeration() -> list[LatticeEnumeration]:
    """What any backend may be asked; of neighbours, as many as count."""
    forms = product(AROUND, (True, False), (True, False))
    around = [e for form in forms for e in enumerations_around(*form)]
    return [*enumerations(), *declared_enumerations(), *around]


def _fitted(e: LatticeEnumeration, selection: Selection) -> LatticeEnumeration:
    """The same with more neighbours, that there are not, and with targets as data."""
    settings = e.settings
    data = selection.takes_targets(Case(e.name, e.pass_name, settings, {}))
    if not selection.neighbors and not data:
        return e

    def inputs(outcome: Indices, u: Scalars) -> Buffers:
        found = e.inputs(outcome, u)
        if data:
            formula = FORMULAS[str(settings["target"])]
            p_hat = given_targets(e.pass_name, found, formula)
            found = {**found, "p_hat_given": p_hat}
        if e.pass_name not in SOURCES:
            return found
        return fitted_inputs(e.pass_name, found, selection)

    return replace(
        e, inputs=inputs, settings={**settings, "target": DATA} if data else settings
    )


def lattice_step(passes: Passes, backend: Backend) -> LevelStep:
    """Expectations of a backend that can be asked, each of its own distribution.

    Of a pass that is off, one case is integrated over the backend's own decisions, and
    all of them if that one is right: some 26 batches each time, of all passes together.
    """
    precision = backend.precision
    chosen = enumerations_for(selection_of(backend))
    step = asked("L1", "lattices", passes, backend, lattice_probes(precision, chosen))
    known = {e.name: e for e in chosen}
    off = [
        known[a.probe.case.name]
        for a in step.answers
        if a.finding and a.finding.judgement and not a.finding.passed
    ]
    first = {e.pass_name: e for e in reversed(off)}
    found = _in_step(passes, backend, list(first.values()))
    wrong = {e.pass_name for e in first.values() if _is_wrong(found[e.name])}
    rest = [e for e in off if e.pass_name not in wrong and e.name not in found]
    return _settled(step, found | _in_step(passes, backend, rest))


Found = Finding | Unasked


def _is_wrong(found: Found) -> bool:
    return isinstance(found, Finding) and not found.passed


def _settled(step: LevelStep, found: dict[str, Found]) -> LevelStep:
    """A step with findings in place of some of its own."""
    answers, unasked = [], list(step.unasked)
    for answer in step.answers:
        name = answer.probe.case.name
        finding = found.get(name, answer.finding)
        if isinstance(finding, Unasked):
            unasked.append(f"{name}: {finding.reason}")
        else:
            answers.append(replace(answer, finding=finding))
    return replace(step, answers=answers, unasked=unasked)


def _in_step(
    passes: Passes, backend: Backend, chosen: Sequence[LatticeEnumeration]
) -> dict[str, Found]:
    """Integrate all, with one batch of cases for each step of them together."""
    found: dict[str, Found] = {}
    searches = {e.name: own_expectation(e, backend.precision) for e in chosen}
    waiting = {name: next(search) for name, search in searches.items()}
    while waiting:
        outcomes: list[Outcome] = [NO_TIME] * len(waiting)
        if backend.remaining() > 0:
            outcomes = backend.run(passes, list(waiting.values()))
        for (name, case), outcome in zip(list(waiting.items()), outcomes, strict=True):
            answered = _answered(passes, backend.precision, case, outcome)
            if isinstance(answered, Finding | Unasked):
                found[name] = answered
                del waiting[name]
                continue
            try:
                waiting[name] = searches[name].send(answered)
            except StopIteration as end:
                found[name] = end.value
                del waiting[name]
    return found


def _answered(
    passes: Passes, precision: Precision, case: Case, outcome: Outcome
) -> Buffers | Finding | Unasked:
    """Outputs; or what is said where there are none that can be judged."""
    if outcome is None:
        return Finding(False, f"{case.name}: no answer, where there were some before")
    if isinstance(outcome, Unasked):
        return outcome
    if not isinstance(outcome, Failure):
        bad = refused(passes, case, precision, outcome)
        if bad is None:
            return outcome
        outcome = bad
    return Finding(False, outcome.reason)


def _probe(e: LatticeEnumeration, precision: Precision) -> Probe:
    outcome, u, share = _both_sides(e.weights, precision)
    inputs = given(e.inputs(outcome, u), precision)

    def examine(case: Case, out: Buffers, precision: Precision) -> Finding:
        values = kept_by(out, len(outcome))
        if bias(e, expectations(e, outcome, share, values), precision):
            # Not an expectation: the thresholds may be others.
            return replayed("L1", case).examine(case, out, precision)
        odd = other_confidence(e, outcome, values)
        return Finding(False, f"{case.name}: {odd}") if odd else Finding(True)

    return Probe("L1", Case(e.name, e.pass_name, e.settings, inputs), examine)


def _both_sides(w: Scalars, precision: Precision) -> tuple[Indices, Scalars, Scalars]:
    """Decisions of a stream of whole weights, asked on either side of each threshold.

    Returns the row that each line belongs to, (L, D) numbers u, and its share.  They
    are 4 times as far from a threshold as rounding can move it: weights that are known
    to a relative r move w / S by at most r / 2.
    """
    sums = np.cumsum(w, axis=1)[:, 1:]
    t = np.divide(w[:, 1:], sums, out=np.zeros_like(sums), where=sums > 0)
    away = max(ROUNDINGS * float(np.finfo(precision).eps), 2 * NEARLY_0)
    below = np.where(t == 1, 1 - NEARLY_0, t - away)
    above = np.where(t == 0, NEARLY_0, t + away)
    lines, numbers, shares = [], [], []
    for side in product((True, False), repeat=w.shape[1] - 1):
        share = np.where(side, t, 1 - t).prod(axis=1)
        row = np.flatnonzero(share > 0)
        lines.append(row)
        numbers.append(np.where(side, below, above)[row])
        shares.append(share[row])
    return np.concatenate(lines), np.concatenate(numbers), np.concatenate(shares)


def _merge(precision: Precision) -> Probe:
    weights = np.array(list(product(range(4), repeat=2)), float)
    weights = weights[
        weights.sum(axis=1) > 0
    ]  # of two that weigh nothing either may be
    line, u, _ = _both_sides(weights, precision)
    a, b = np.tile(weights[line], (2, 1)).T
    # The other way round too: who reads u as 1 - u has the same distribution.
    both = np.concatenate([u[:, 0], 1 - u[:, 0]])
    inputs = {"w_a": a, "M_a": a * 0 + 1, "w_b": b, "M_b": b * 0 + 2, "u": both}

    def examine(case: Case, out: Buffers, precision: Precision) -> Finding:
        kept = np.split(out["second"] != 0, 2)
        threshold = b[: len(line)] / (a + b)[: len(line)]
        bad = [k != (u[:, 0] < threshold) for k in kept]
        if all(rows.any() for rows in bad):
            row = int(np.flatnonzero(bad[0])[0])
            return Finding(
                False,
                f"{case.name}: of weights {a[row]:g} and {b[row]:g} the second is"
                f" {'kept' if kept[0][row] else 'not kept'} at u = {u[row, 0]:.9g}"
                f" instead of below {threshold[row]:.9g} alone",
            )
        return Finding(True)

    case = Case("lattice-merge", "merge", {}, given(inputs, precision))
    return Probe("L1", case, examine)

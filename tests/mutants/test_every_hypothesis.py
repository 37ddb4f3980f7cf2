"""Every hypothesis calculates what a backend with its mistake answers, and is named.

Where the right answers refute a hypothesis, its mistake shows, and there it must
reproduce what its plant answers: so it is among the names, and they are not wrong.
Nothing here is by chance.
"""

import warnings
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from itertools import chain
from time import perf_counter

import pytest

from restir_gi.reference.oracle.cases import for_ever
from restir_gi.reference.oracle.diagnosis.diagnose import diagnose, known_mistakes
from restir_gi.reference.oracle.frames import frame_cases
from restir_gi.reference.oracle.ladder import ladder, scene_probes
from restir_gi.reference.oracle.levels.kernels import kernel_probes
from restir_gi.reference.oracle.levels.probe import Answer, Finding, Probe
from restir_gi.reference.oracle.levels.replayed import replayed
from restir_gi.reference.oracle.parts import judge_of, parts, whole_contract
from restir_gi.reference.oracle.prepared_frame import SCENES, prepare_frame
from restir_gi.reference.oracle.replay.rules import CONTRACT_RULES
from restir_gi.reference.oracle.verdict import departs, run_ladder
from restir_gi.reference.scene.catalogue.registry import find_scene
from tests.mutants import shift_of_tables
from tests.mutants.every_hypothesis import (
    CONTRACT_LAYOUT,
    HERE,
    PLANTS,
    Plant,
    built_in,
    plants_of,
    rewritten,
)
from tests.mutants.harness import ASIDE
from tests.mutants.plant import source_of

PRECISION = "float32"
OPEN = "cell-level-of-another-rule"
"""Of any rule: the contract's rows do not refute it; see its tests of choices."""

HYPOTHESES = [h for h in known_mistakes() if h.only is None and h.name != OPEN]
"""All but those of declared surfaces, which `test_oracle_surfaces` plants."""

NAMES = [h.name for h in HYPOTHESES]
BY_NAME = dict(zip(NAMES, HYPOTHESES, strict=True))

CONTRACT = whole_contract()
OF_PARTS_ASIDE = {
    p.name for part in parts() if part.title in ASIDE for p in part.passes
}
"""Passes of steps that stand aside."""

DEPARTURES = [h for h in HYPOTHESES if h.departure]

NO_NUMBERS = "kernel-target-extremes"
"""Where a mistake in the target may leave the number type, and then says nothing."""


@dataclass(frozen=True, eq=False)
class Bench:
    """What plants are asked.

    Attributes
    ----------
    probes : dict of str to list of Probe; of each pass, those with few rows first
    """

    probes: dict[str, list[Probe]]

    def explain(self, rules, pass_name, outputs):
        """Whether rules reproduce all answers of a pass."""
        asked = zip(self.probes[pass_name], outputs, strict=True)
        return all(explains(rules, probe, given) for probe, given in asked)

    def cases(self, pass_name):
        """All cases of a pass."""
        return [probe.case for probe in self.probes[pass_name]]

    def shows(self, hypothesis, pass_name):
        """Whether the right answers refute a hypothesis."""
        right = right_answers(self, pass_name)
        return not self.explain(hypothesis.rules, pass_name, right)

    def reproduced(self, hypothesis, pass_name):
        """Answers of the plants that show in a pass, if the hypothesis gives them."""
        for plant in plants_of(hypothesis.name):
            given = answers(self, plant, pass_name)
            seen = not self.explain(CONTRACT_RULES, pass_name, given)
            if seen and self.explain(hypothesis.rules, pass_name, given):
                yield given


def explains(rules, probe, outputs):
    """Whether rules reproduce an answer, within the working range."""
    case = probe.case
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        judgement = judge_of(case.pass_name)(case, outputs, rules, PRECISION)
    if case.beyond is None:
        return judgement.passed
    return not (judgement.over_budget or (judgement.wrong & ~case.beyond).any())


@cache
def right_answers(bench, pass_name):
    return list(map(built_in, bench.cases(pass_name)))


@lru_cache(maxsize=16)
def answers(bench, plant, pass_name):
    return plant.answers(bench.cases(pass_name))


def bench_of(frames: Iterable[Probe]):
    """A bench of frames, kernels and the passes of all parts."""
    found = [*kernel_probes(PRECISION), *frames]
    for part in parts():
        found += [p for p in part.probes(PRECISION) if p.level != "L1"]
        found += part.frames(PRECISION, frozenset(p.name for p in part.passes))
    return judged_bench(found)


def judged_bench(found: Iterable[Probe]):
    """A bench of probes whose right answers the replay finds right."""
    by_pass = {}
    for probe in sorted(found, key=lambda p: p.case.rows):
        silent = probe.case.name.startswith(NO_NUMBERS)
        # What the replay does not know, as a Jacobian at points that touch.
        if silent or not explains(CONTRACT_RULES, probe, built_in(probe.case)):
            continue
        by_pass.setdefault(probe.case.pass_name, []).append(probe)
    return Bench(by_pass)


def changed(case):
    """A case with confidences beyond a byte, and samples that show their back."""
    inputs = dict(case.inputs)
    for name in {"M", "past_M"} & {*inputs}:
        inputs[name] = inputs[name] * inputs[name].dtype.type(60.25)
    for name in {"normal", "past_normal", "new_normal"} & {*inputs}:
        inputs[name] = inputs[name].copy()
        inputs[name][::3] *= -1
    return replace(case, inputs=inputs, settings={**case.settings, "cap": 300.5})


@cache
def small():
    """Two scenes in which all shows, but for a Jacobian above 8 among neighbours."""
    cases = [
        case
        for scene in ("cornell-box", "many-lights")
        for case in frame_cases(prepare_frame(find_scene(scene), 24, 1), PRECISION)
    ]
    cases += [changed(case) for case in cases if "cap" in case.settings]
    # A search that goes on within its least radius never halves it.
    wide = frame_cases(prepare_frame(find_scene("cornell-box"), 48, 1), PRECISION)
    wide = (case for case in wide if case.pass_name == "neighbors")
    return bench_of(replayed("L3", case) for case in (*cases, *wide))


@cache
def declared():
    """What is asked of those alone who declare values of settings."""
    return judged_bench(chain.from_iterable(part.more(PRECISION) for part in parts()))


def bench_for(hypothesis):
    """Where a mistake shows."""
    shows = (small().shows(hypothesis, name) for name in hypothesis.passes)
    return small() if any(shows) else declared()


@cache
def whole():
    """All frames of the ladder."""
    return bench_of(chain.from_iterable(scene_probes(s, PRECISION) for s in SCENES))


def check_the_name(bench, hypothesis, pass_name):
    """It is told, alone or as one of several; and what is a mistake is no departure."""
    given = next(bench.reproduced(hypothesis, pass_name))
    asked = zip(bench.probes[pass_name], given, strict=True)
    told = [Answer(p, o, Finding(explains(CONTRACT_RULES, p, o), "")) for p, o in asked]
    diagnosis = diagnose(pass_name, told, PRECISION)
    assert hypothesis in diagnosis.matches
    assert departs(diagnosis) <= bool(hypothesis.departure)


def without_a_plant(names, plants=PLANTS):
    """Hypotheses that nobody has planted."""
    return [name for name in names if not plants_of(name, plants)]


each_hypothesis = pytest.mark.parametrize("hypothesis", HYPOTHESES, ids=NAMES)


def test_every_hypothesis_has_a_plant():
    assert without_a_plant(NAMES) == []


def test_control_a_hypothesis_without_a_plant_is_seen():
    assert without_a_plant([*NAMES, "new"]) == ["new"]
    assert without_a_plant(["jacobian-root"], HERE) == ["jacobian-root"]


def test_every_plant_is_of_a_hypothesis():
    assert [p.name for p in PLANTS if not set(p.expected) <= {*NAMES, OPEN}] == []


def test_every_edit_has_its_place():
    for plant in HERE:
        for module, old, _ in plant.edits:
            assert source_of(module).count(old) == 1, (plant.name, module)


def test_control_the_pass_by_hand_is_right():
    given = list(map(shift_of_tables.shift, small().cases("shift")))
    assert small().explain(CONTRACT_RULES, "shift", given)


def test_control_the_layout_by_hand_is_the_contracts():
    for case in small().cases("unpack"):
        words = case.inputs["words"]
        assert (rewritten(words, CONTRACT_LAYOUT, CONTRACT_LAYOUT) == words).all()


@each_hypothesis
def test_it_calculates_what_its_plant_answers(hypothesis):
    """In every pass in which it shows, and it does in one."""
    bench = bench_for(hypothesis)
    shows = [name for name in hypothesis.passes if bench.shows(hypothesis, name)]
    assert shows
    for name in shows:
        assert any(True for _ in bench.reproduced(hypothesis, name)), name


def test_control_another_formula_is_seen():
    """The mistake of one hypothesis, under the rules of another."""
    rules = BY_NAME["path-jacobian-without-onward-density"].rules
    wrong = replace(BY_NAME["path-jacobian-densities-omitted"], rules=rules)
    for name in ("path_jacobian", "shift"):
        assert small().shows(wrong, name)
        assert list(small().reproduced(wrong, name)) == []


@each_hypothesis
@pytest.mark.few(40)
def test_it_is_named(hypothesis):
    """In the first of the passes in which it shows, which is judged soonest."""
    bench = bench_for(hypothesis)
    shows = (name for name in hypothesis.passes if bench.shows(hypothesis, name))
    check_the_name(bench, hypothesis, next(shows))


@pytest.mark.campaign
@each_hypothesis
def test_it_is_named_wherever_it_shows(hypothesis):
    for name in hypothesis.passes:
        if whole().shows(hypothesis, name):
            check_the_name(whole(), hypothesis, name)


@dataclass(frozen=True)
class PlantedBackend:
    """A plant as a backend of the ladder."""

    plant: Plant
    precision: str = PRECISION

    def run(self, passes, cases):
        """Outcome of each case."""
        return self.plant.answers(cases)

    def remaining(self):
        """For ever."""
        return for_ever()


@pytest.mark.campaign
@pytest.mark.parametrize("hypothesis", DEPARTURES, ids=[h.name for h in DEPARTURES])
def test_a_departure_passes_the_ladder(hypothesis):
    """In the steps of its passes: to draw other directions is to walk another way."""
    plant = plants_of(hypothesis.name)[-1]
    aside = set(hypothesis.passes) <= OF_PARTS_ASIDE
    levels = (
        s for s in ladder(CONTRACT, PlantedBackend(plant)) if (s[1] in ASIDE) == aside
    )
    verdict = run_ladder(
        CONTRACT, PRECISION, levels, float("inf"), perf_counter, lambda title: None
    )
    assert hypothesis.name in {h.name for d in verdict.diagnoses for h in d.matches}
    assert verdict.status == "PASS", [f for t in verdict.steps for f in t.step.faults]

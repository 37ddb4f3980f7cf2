"""Verdicts on backends that are other than the contract's, and bring no bias."""

import numpy as np
import pytest

from restir_gi.reference.oracle.cases import for_ever
from restir_gi.reference.oracle.checking import judge
from restir_gi.reference.oracle.parts import whole_contract
from restir_gi.reference.oracle.steps import LevelStep
from restir_gi.reference.oracle.verdict import departs
from restir_gi.reference.reports.verdict.page import write_page
from restir_gi.reference.reports.verdict.plain import as_plain
from tests.mutants.catalogue import BY_NAME
from tests.mutants.harness import Planted

DEPARTURES = {
    "the target lacks the cosine": "target-without-cosine",
    "the target is twice as large": "target-doubled",
    "M is not capped": "never-capped",
    "u is used as 1 − u": "keeps-the-other-side",
    "the stream runs backwards": "stream-reversed",
}


class ChangedCalls:
    """The planted backend, with another change of one pass on top."""

    precision = "float32"

    def __init__(self, name, pass_name, change):
        self._planted = Planted(BY_NAME[name])
        self._pass_name, self._change = pass_name, change

    def run(self, passes, cases):
        """Outcome of each case."""
        found = self._planted.run(passes, cases)
        return [
            self._change(outcome) if case.pass_name == self._pass_name else outcome
            for case, outcome in zip(cases, found, strict=True)
        ]

    def remaining(self):
        """For ever."""
        return for_ever()

    def close(self):
        """Nothing is held."""
        return 0


@pytest.fixture(scope="module")
def verdicts():
    return {
        name: judge(Planted(BY_NAME[name]), 120.0, statistics=False)
        for name in DEPARTURES
    }


@pytest.mark.parametrize("name", DEPARTURES)
def test_a_departure_passes_under_its_name(verdicts, name):
    verdict = verdicts[name]
    assert verdict.status == "PASS"
    assert verdict.diagnoses
    assert all(map(departs, verdict.diagnoses))
    named = {h.name for d in verdict.diagnoses for h in d.matches}
    assert DEPARTURES[name] in named


def test_the_report_tells_it(verdicts, tmp_path):
    verdict = verdicts["the target lacks the cosine"]
    plain = as_plain(verdict, "mine", whole_contract())
    assert plain["first_wrong_pass"] is None
    status = {p["name"]: p["status"] for p in plain["passes"]}
    assert status["target"] == status["spatial"] == "departs"
    assert "no bias comes of the others: target, initial" in plain["headline"]
    write_page(tmp_path, verdict, plain)
    text = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert "no bias comes of it: target" in text
    assert "not held against the backend" in text
    assert "First wrong pass" not in text


def test_what_relies_on_the_targets_numbers_says_nothing(verdicts):
    verdict = verdicts["the target lacks the cosine"]
    silent = {t.step.title for t in verdict.steps} - {s.title for s in verdict.binding}
    long = {"furnace of 40 frames", "half-lit sphere of 40 frames"}
    assert silent == {"spheres", "relations", *long}
    order = verdicts["the stream runs backwards"]
    assert len(order.binding) == len(order.steps)


def test_what_stands_in_binds_only_where_the_bound_is_void():
    proof = LevelStep("L4", "mean", relies_on=("target", "mis"))
    statistics = LevelStep("L4", "mean by its variance", only_under=("target", "mis"))
    for kinds in (set(), {"order"}, {"mis"}, {"mis", "order"}):
        assert proof.binds(kinds) != statistics.binds(kinds)
        assert proof.binds(kinds) == ("mis" not in kinds)


def nan(outcome):
    color = outcome["color"].copy()
    color[0] = np.nan
    return {"color": color}


def darker(outcome):
    return {"color": outcome["color"] * np.float32(0.9)}


@pytest.mark.parametrize("change", [nan, darker])
def test_a_mistake_beside_a_departure_fails(change):
    backend = ChangedCalls("the target lacks the cosine", "shade", change)
    verdict = judge(backend, 120.0, statistics=False)
    assert verdict.status == "FAIL"
    plain = as_plain(verdict, "mine", whole_contract())
    assert plain["first_wrong_pass"] == "shade"


def test_a_mistake_within_the_same_pass_fails():
    def wrong(outcome):
        return {"p_hat": outcome["p_hat"] * (outcome["p_hat"] < 1)}

    backend = ChangedCalls("the target lacks the cosine", "target", wrong)
    assert judge(backend, 120.0, statistics=False).status == "FAIL"


def test_an_answer_that_cannot_be_judged_is_no_departure():
    def sometimes(outcome):
        return outcome if len(outcome["p_hat"]) % 2 else replace_first(outcome)

    def replace_first(outcome):
        p_hat = outcome["p_hat"].copy()
        p_hat[0] = np.inf
        return {"p_hat": p_hat}

    backend = ChangedCalls("the target lacks the cosine", "target", sometimes)
    verdict = judge(backend, 120.0, statistics=False)
    assert verdict.status == "FAIL"
    plain = as_plain(verdict, "mine", whole_contract())
    assert plain["first_wrong_pass"] == "target"

"""What continuous integration reads: JUnit, SARIF, the schema, a baseline, --quick."""

import json
import os
import re
import subprocess
import sys
from copy import deepcopy
from pathlib import Path
from xml.etree import ElementTree as Xml

import junitparser
import pydantic
import pytest
import yaml
from sarif_pydantic import Sarif

from restir_gi.reference.cli.main import main
from restir_gi.reference.oracle.builtin.backend import FLOAT32
from restir_gi.reference.oracle.checking import judge
from restir_gi.reference.oracle.parts import whole_contract
from restir_gi.reference.reports.integration.baseline import compared
from restir_gi.reference.reports.integration.faults import faults
from restir_gi.reference.reports.integration.junit import junit_text
from restir_gi.reference.reports.integration.sarif import sarif_of
from restir_gi.reference.reports.pictures.plain import as_plain as pictures_plain
from restir_gi.reference.reports.verdict.schema import (
    VERSION,
    fault_of_form,
    verdict_schema,
)
from restir_gi.reference.system.json_text import json_text
from tests.captures.dump import dump
from tests.captures.engine import Engine
from tests.contracts.synthetic_pictures import judged, light, pictures_of
from tests.mutants.catalogue import BY_NAME, MUTANTS
from tests.mutants.harness import Planted

SOURCE = """
import numpy as np
from restir_gi.reference.oracle.builtin.backend import FLOAT32


def right(out):
    return out


def inverted(out):
    J = out["jacobian"].astype(float)
    J = np.divide(1, J, where=J > 0, out=np.zeros_like(J))
    return {{"jacobian": np.minimum(J, 1e38).astype(np.float32)}}


def larger(out):
    return {{"jacobian": out["jacobian"] * np.float32({factor})}}


def fails(out):
    raise ValueError("{words}")


class Backend:
    precision = "float32"

    def jacobian(self, **given):
        return {jacobian}(FLOAT32.jacobian(**given))

    def similar(self, **given):
        return {similar}(FLOAT32.similar(**given))


BACKEND = Backend()
"""

DOCS = Path(__file__).parents[2] / "docs"
QUICK = ("check", "mine.py", "--quick")
MADE: dict[str, str] = {}
"""Verdicts as JSON, by how the backend was written."""


@pytest.fixture
def write(tmp_path, monkeypatch):
    """Write the backend ``mine.py``, whose passes are as they are named."""
    monkeypatch.chdir(tmp_path)

    def written(jacobian="right", similar="right", factor=1.01, words="no device"):
        about = {"jacobian": jacobian, "similar": similar}
        text = SOURCE.format(**about, factor=factor, words=words)
        Path("mine.py").write_text(text)

    return written


@pytest.fixture
def check(capsys):
    """Run a check; its exit code, and what it said."""

    def run(*words):
        code = main(list(words))
        return code, capsys.readouterr()

    return run


@pytest.fixture
def verdict(write, check):
    """The quick verdict of a backend, of each once for all tests."""

    def run(*words, **how):
        write(**how)
        key = repr((words, how))
        if key not in MADE:
            MADE[key] = check(*QUICK, "--json", *words)[1].out
        return json.loads(MADE[key])

    return run


def plain_of_pictures(verdict):
    """As it is after a trip through JSON."""
    return json.loads(json_text(pictures_plain(verdict, "renderer", 1.0)))


# ---------------------------------------------------------------- the schema


def test_report_and_json_are_one_object_with_a_schema(write, check):
    write("inverted")
    code, said = check(*QUICK, "--json", "--out", "report")
    told = json.loads(said.out)
    assert (code, told["schema"], told["kind"]) == (1, VERSION, "passes")
    assert json.loads(Path("report/verdict.json").read_text()) == told
    assert fault_of_form(told) == ""


def test_the_schema_is_shown(check):
    code, said = check("check", "--verdict-schema")
    assert code == 0
    assert json.loads(said.out) == verdict_schema()


@pytest.mark.parametrize(
    "spoil",
    [
        lambda v: v.pop("schema"),
        lambda v: v.pop("backend"),
        lambda v: v.update(status="FINE"),
        lambda v: v.update(schema="restir-verdict 2"),
        lambda v: v["passes"][0].pop("reason"),
        lambda v: v["steps"][0].update(seconds="long"),
    ],
)
def test_control_what_is_no_verdict_is_seen(verdict, spoil):
    found = verdict()
    assert fault_of_form(found) == ""
    spoil(found)
    assert fault_of_form(found)


# ---------------------------------------------------------------- JUnit


def suites(text):
    """Suites of JUnit XML, as an independent reader has them."""
    read = junitparser.JUnitXml.fromstring(text.encode())
    return {suite.name: {case.name: case for case in suite} for suite in read}


def result_of(case):
    """The one result of a case: its tag, message and text."""
    (result,) = case.result
    return result._tag, result.message, result.text


def test_each_pass_is_a_test_case(write, check):
    write("inverted")
    code, _ = check(*QUICK, "--only", "jacobian,random", "--junit", "out.xml")
    assert code == 1
    text = Path("out.xml").read_text()
    passes = suites(text)["restir.passes"]
    assert list(passes) == list(whole_contract())
    tag, message, told = result_of(passes["jacobian"])
    assert tag == "failure"
    assert "is divided by the Jacobian" in message
    assert "\n" not in message
    assert "jacobian-inverted" in told
    assert "restir check mine.py --case kernel-jacobian" in told
    assert result_of(passes["random"])[:2] == (
        "skipped",
        "the backend does not have it",
    )
    assert result_of(passes["similar"])[:2] == ("skipped", "not asked")
    assert result_of(suites(text)["restir.verdict"]["verdict"])[0] == "failure"


def test_counts_are_those_of_the_cases(verdict):
    root = Xml.fromstring(junit_text(verdict(jacobian="inverted", similar="fails")))
    for suite in root:
        cases = suite.findall("testcase")
        assert int(suite.get("tests")) == len(cases) > 0
        for key, tag in (("failures", "failure"), ("skipped", "skipped")):
            assert int(suite.get(key)) == sum(c.find(tag) is not None for c in cases)
    assert int(root.get("failures")) == 3  # two passes, and the verdict


def test_a_right_backend_has_no_failure(verdict):
    root = Xml.fromstring(junit_text(verdict()))
    assert (root.get("failures"), root.get("errors")) == ("0", "0")


def test_undecided_is_an_error(write, check):
    write()
    code, _ = check("check", "mine.py", "--budget", "0", "--junit", "out.xml")
    assert code == 3
    found = suites(Path("out.xml").read_text())
    assert result_of(found["restir.verdict"]["verdict"])[0] == "error"


def test_what_a_backend_says_cannot_break_the_file(verdict):
    evil = "]]></failure><testcase/>&\x1b[2J\x00\udcff\ufffe"
    found = verdict(jacobian="inverted")
    wrong = next(p for p in found["passes"] if p["status"] == "wrong")
    wrong["sentence"] = wrong["faults"][0] = found["backend"] = evil
    read = suites(junit_text(found))
    assert (
        "</failure><testcase/>&\\x1b[2J"
        in result_of(read["restir.passes"]["jacobian"])[2]
    )


def biased(found, accepted):
    """The verdict, with a declared bias."""
    bias = {
        "pass": "jacobian",
        "choices": ["jacobian-clamped"],
        "accepted": accepted,
        "light": {"beside": -0.1, "least": -0.1, "most": 0.0},
        "told": "jacobian is biased by design: -10 %",
    }
    found["declaration"] = {
        "has": {},
        "choices": {"jacobian-clamped": ["jacobian"]},
        "accept": [],
        "generator": None,
        "followed": [],
        "biases": [bias],
        "measured": None,
        "to_accept": None if accepted else "accept it by --accept jacobian-clamped",
    }
    found["status"] = "PASS" if accepted else "FAIL"
    assert fault_of_form(found) == ""
    return found


def test_an_accepted_bias_is_told_and_fails_nothing(verdict):
    found = biased(verdict(), accepted=True)
    text = junit_text(found)
    assert 'failures="0"' in text.splitlines()[1]
    assert (
        "biased by design: -10 %"
        in suites(text)["restir.passes"]["jacobian"].system_out
    )
    (result,) = sarif_of(found)["runs"][0]["results"]
    assert result["level"] == "note"


def test_a_bias_that_is_not_accepted_fails(verdict):
    found = biased(verdict(), accepted=False)
    (case,) = suites(junit_text(found))["restir.requirements"].values()
    assert result_of(case)[0] == "failure"
    (result,) = sarif_of(found)["runs"][0]["results"]
    assert (result["level"], result["ruleId"]) == ("error", "biased-by-design")


# ---------------------------------------------------------------- SARIF


def results(found):
    """Results, held against an independent model of the format."""
    log = json.loads(json_text(sarif_of(found)))
    Sarif.model_validate(log)
    (run,) = log["runs"]
    rules = [rule["id"] for rule in run["tool"]["driver"]["rules"]]
    assert len(set(rules)) == len(rules)
    for result in run["results"]:
        assert rules[result["ruleIndex"]] == result["ruleId"]
        assert result["message"]["text"]
    return run["results"]


def test_a_mistake_is_a_rule_and_its_place_the_method(write, check):
    write("inverted")
    _, said = check(*QUICK, "--json", "--sarif", "out.sarif")
    log = json.loads(Path("out.sarif").read_text())
    Sarif.model_validate(log)
    (result,) = log["runs"][0]["results"]
    assert (result["ruleId"], result["level"]) == ("jacobian-inverted", "error")
    (place,) = result["locations"]
    line = place["physicalLocation"]["region"]["startLine"]
    assert (
        "def jacobian"
        in SOURCE.format(
            jacobian="inverted", similar="right", factor=1, words=""
        ).splitlines()[line - 1]
    )
    where = place["physicalLocation"]["artifactLocation"]
    assert where == {"uri": "mine.py", "uriBaseId": "%SRCROOT%"}
    assert results(json.loads(said.out)) == log["runs"][0]["results"]


def test_an_unknown_mistake_has_a_rule_of_its_own(verdict):
    found = results(verdict(jacobian="larger"))
    (result,) = (one for one in found if one["level"] == "error")
    assert result["ruleId"] == "no-known-mistake"
    assert "1.01" in result["message"]["text"]


def test_a_command_is_a_logical_place(verdict):
    found = verdict(jacobian="inverted")
    found["backend"] = "./mine {directory}"
    (result,) = results(found)
    (place,) = result["locations"]
    assert place == {
        "logicalLocations": [
            {
                "name": "jacobian",
                "fullyQualifiedName": "./mine {directory}/jacobian",
            }
        ]
    }


def test_extremes_warn_and_fail_only_if_they_are_asked_for(verdict):
    found = verdict()
    line = "kernel-jacobian: at extremes alone: jacobian is nan, 1 of 3 such rows"
    found["at_extremes"] = [line]
    assert [r["level"] for r in results(found)] == ["warning"]
    found["asked"]["extremes"], found["status"] = True, "FAIL"
    assert [r["level"] for r in results(found)] == ["error"]


@pytest.mark.parametrize(
    "spoil",
    [
        lambda log: log["runs"][0].pop("tool"),
        lambda log: log["runs"][0]["results"][0].pop("message"),
        lambda log: log["runs"][0]["results"][0].update(level="fatal"),
    ],
)
def test_control_what_is_no_sarif_is_seen(verdict, spoil):
    log = json.loads(json_text(sarif_of(verdict(jacobian="inverted"))))
    spoil(log)
    with pytest.raises(pydantic.ValidationError):
        Sarif.model_validate(log)


# ---------------------------------------------------------------- captures, pictures


def test_a_capture_has_all_of_it(tmp_path, check, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("frames").mkdir()
    dump(Engine(16), Path("frames"), 2)
    # An empty baseline of itself: whatever is wrong is known, or nothing is.
    words = ["check", "frames", "--out", "report", "--junit", "a.xml"]
    code, _ = check(*words, "--sarif", "a.sarif")
    found = json.loads(Path("report/verdict.json").read_text())
    assert (found["kind"], fault_of_form(found)) == ("capture", "")
    Sarif.model_validate(json.loads(Path("a.sarif").read_text()))
    passes = suites(Path("a.xml").read_text())["restir.passes"]
    assert passes["spatial"].result == [] or code == 1
    again, said = check("check", "frames", "--baseline", "report/verdict.json")
    assert again in (0, code)
    assert "beside the baseline report/verdict.json" in said.out


def test_a_wrong_capture_is_shown_at_its_manifest(tmp_path, verdict):
    found = verdict(jacobian="inverted")
    found["kind"], found["backend"] = "capture", "frames"
    (result,) = results(found)
    place = result["locations"][0]["physicalLocation"]
    assert place["artifactLocation"]["uri"] == "frames/capture.toml"


def bright(factor, count=60, **more):
    """A verdict on pictures that are so many times too bright."""
    return plain_of_pictures(judged(pictures_of(factor * light(), count, **more)))


def test_pictures_have_all_of_it():
    found = bright(1.3)
    assert (found["status"], fault_of_form(found)) == ("FAIL", "")
    (result,) = results(found)
    assert (result["ruleId"], result["level"]) == ("pictures", "error")
    case = suites(junit_text(found))["restir.pictures"]["pictures"]
    assert result_of(case)[0] == "failure"


def test_pictures_without_a_truth_are_a_verdict_too():
    short = {"schema": VERSION, "kind": "pictures", "status": "UNDECIDED"}
    short |= {"backend": "r", "headline": "no time", "asked": {}}
    assert fault_of_form(short) == ""
    assert results(short) == []
    assert (
        result_of(suites(junit_text(short))["restir.verdict"]["verdict"])[0] == "error"
    )
    assert compared(short, bright(1.3)).unjudged


# ---------------------------------------------------------------- the baseline


def beside(now, before):
    """What is new, and what the exit code says."""
    found = compared(now, before)
    return found, found.status(now)


def test_what_is_known_is_let_through_by_name(write, check):
    write("inverted")
    assert check(*QUICK, "--out", "old")[0] == 1
    code, said = check(
        *QUICK,
        "--out",
        "new",
        "--baseline",
        "old/verdict.json",
        "--junit",
        "a.xml",
        "--sarif",
        "a.sarif",
    )
    assert code == 0
    assert "1 known fault is let through: jacobian (jacobian-inverted)" in said.out
    assert "FAIL: mine.py" in said.out
    page = Path("new/index.html").read_text()
    assert "1 known fault is let through" in page
    assert "Not asked, by <code>--quick</code>: " in page
    found = suites(Path("a.xml").read_text())
    assert result_of(found["restir.passes"]["jacobian"])[0] == "skipped"
    (result,) = json.loads(Path("a.sarif").read_text())["runs"][0]["results"]
    assert result["baselineState"] == "unchanged"
    assert result["suppressions"][0]["kind"] == "external"


def test_another_wrong_pass_is_new(write, check):
    write("inverted")
    check(*QUICK, "--out", "old")
    write("inverted", "fails")
    code, said = check(*QUICK, "--baseline", "old/verdict.json", "--json")
    found = json.loads(said.out)["baseline"]
    assert code == 1
    assert found["known"] == ["jacobian (jacobian-inverted)"]
    assert len(found["new"]) == 1
    assert "similar" in found["new"][0]


@pytest.mark.parametrize(
    ("before", "now"),
    [
        ({"jacobian": "inverted"}, {"jacobian": "larger"}),
        ({"jacobian": "larger"}, {"jacobian": "inverted"}),
        ({"jacobian": "larger"}, {"jacobian": "larger", "factor": 1.02}),
        ({"jacobian": "fails"}, {"jacobian": "fails", "words": "out of memory"}),
        ({"jacobian": "fails"}, {"jacobian": "larger"}),
        ({}, {"jacobian": "larger"}),
    ],
)
def test_another_reason_is_new(verdict, before, now):
    found, status = beside(verdict(**now), verdict(**before))
    assert status == "FAIL"
    assert (len(found.new), found.known) == (1, [])


@pytest.mark.parametrize(
    "how",
    [{"jacobian": "inverted"}, {"jacobian": "larger"}, {"similar": "fails"}],
)
def test_control_the_same_reason_is_known(verdict, how):
    found, status = beside(verdict(**how), verdict(**how))
    assert status == "QUICK"
    assert (found.new, len(found.known), found.changed) == ([], 1, [])


def test_what_is_gone_is_told(write, check):
    write("inverted")
    check(*QUICK, "--out", "old")
    write()
    code, said = check(*QUICK, "--baseline", "old/verdict.json")
    assert code == 0
    assert "fixed since the baseline: jacobian (jacobian-inverted)" in said.out


def test_a_pass_that_is_not_judged_any_more_is_not_fixed(write, check):
    write("inverted")
    check(*QUICK, "--out", "old")
    more = ("--only", "similar", "--baseline", "old/verdict.json")
    code, said = check(*QUICK, *more)
    assert code == 0
    assert "in the baseline, and not judged now: jacobian" in said.out
    assert "fixed" not in said.out


@pytest.fixture
def unexplained(verdict):
    """A wrong pass that no known mistake explains, and its entry."""
    found = verdict(jacobian="larger")
    one = next(p for p in found["passes"] if p["status"] == "wrong")
    return found, one


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (
            lambda p: p["excess"].update(jacobian=2 * p["excess"]["jacobian"]),
            "further off",
        ),
        (lambda p: p["excess"].update(jacobian=None), "beyond all numbers"),
        (lambda p: p["reason"]["cases"].append("kernel-other"), "further cases"),
        (lambda p: p["reason"]["outputs"].append("W"), "further outputs"),
        (lambda p: p["reason"]["tests"].append("reciprocal"), "further tests"),
        (lambda p: p["reason"]["failed"].append("kernel-x: crash"), "further calls"),
        (lambda p: p["reason"].update(nearest=["jacobian-omitted"]), "baseline has"),
        (lambda p: p.update(rows=3 * p["rows"], wrong_rows=3 * p["rows"]), "more rows"),
    ],
)
def test_a_fault_that_has_grown_is_new(unexplained, change, told):
    before, one = unexplained
    one["wrong_rows"] = one["rows"] // 2
    now = deepcopy(before)
    assert beside(now, before)[1] == "QUICK"
    change(next(p for p in now["passes"] if p["name"] == one["name"]))
    found, status = beside(now, before)
    assert status == "FAIL"
    assert told in found.new[0]


def test_a_few_rows_more_are_told(unexplained):
    before, one = unexplained
    one["wrong_rows"] = one["rows"] // 2
    now = deepcopy(before)
    wrong = next(p for p in now["passes"] if p["name"] == one["name"])
    wrong["wrong_rows"] += 1
    wrong["sentence"] += ", and one more"
    found, status = beside(now, before)
    assert status == "QUICK"
    assert len(found.changed) == 1


def measured(relative, error=0.001):
    return {"relative": relative, "error": error, "runs": 100, "told": f"{relative:+}"}


@pytest.mark.parametrize(
    ("before", "now", "status"),
    [
        (0.05, 0.05, "QUICK"),
        (0.05, 0.053, "QUICK"),
        (0.05, 0.08, "FAIL"),
        (0.05, -0.08, "FAIL"),
        (0.08, 0.05, "QUICK"),
    ],
)
def test_a_bias_of_the_mean_that_grows_is_new(verdict, before, now, status):
    found = verdict(jacobian="inverted")
    later = deepcopy(found)
    found["measured"], later["measured"] = measured(before), measured(now)
    assert beside(later, found)[1] == status


def test_a_test_of_several_passes_is_known_by_itself(verdict):
    before = verdict(jacobian="inverted")
    now = deepcopy(before)
    step = now["steps"][0]
    step["together"] = ["sphere furnace, frame 0: pixel 0 is 2 instead of 1"]
    found, status = beside(now, before)
    assert (status, len(found.new)) == ("FAIL", 1)
    assert beside(now, now)[1] == "QUICK"
    assert beside(before, now)[0].fixed == []  # quick steps are not all


def test_what_had_no_time_is_no_success(verdict):
    before = verdict(jacobian="inverted")
    now = deepcopy(before)
    now["left"] = ["L3 cornell-box"]
    assert beside(now, before)[1] == "UNDECIDED"
    now["left"], now["steps"][0]["unasked"] = [], ["kernel-merge: no time"]
    assert beside(now, before)[1] == "UNDECIDED"


def test_nothing_judged_is_never_let_through(verdict):
    found = verdict("--require", "shade")
    assert (found["status"], len(faults(found))) == ("FAIL", 1)
    assert beside(found, found)[1] == "QUICK"  # others were judged
    for one in found["passes"]:
        one["status"] = "not judged"
    assert beside(found, found)[1] == "UNDECIDED"
    found["missing"], found["near"] = [], ["jacobain is no pass of the contract"]
    assert beside(found, found)[1] == "FAIL"


def test_of_pictures_the_same_bias_is_known():
    before = bright(1.3)
    assert beside(bright(1.3), before)[1] == "PASS"
    assert beside(bright(1.3, seed=1), before)[1] == "PASS"


@pytest.mark.parametrize("factor", [1.6, 0.7, 2.0])
def test_of_pictures_another_bias_is_new(factor):
    found, status = beside(bright(factor), bright(1.3))
    assert status == "FAIL"
    assert "in the baseline" in found.new[0]


def test_of_pictures_a_smaller_bias_on_the_same_side_is_known():
    assert beside(bright(1.3), bright(1.6))[1] == "PASS"


def test_pictures_that_are_broken_are_never_let_through():
    repeated = plain_of_pictures(judged(iter([*pictures_of(light(), 1)] * 8)))
    assert (repeated["status"], repeated["evidence"]) == ("FAIL", "broken")
    assert beside(repeated, repeated)[1] == "FAIL"
    assert beside(repeated, bright(1.3))[1] == "FAIL"


def test_pictures_that_are_noisier_leave_it_undecided():
    before = bright(1.3)
    now = deepcopy(before)
    for mean in now["means"]:
        mean["error"] *= 4
    assert beside(now, before)[1] == "UNDECIDED"


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda v: v.pop("schema"), "it has no key schema"),
        (lambda v: v.update(schema="restir-verdict 9"), "'restir-verdict 9'"),
        (lambda v: v.pop("backend"), "'backend' is a required property"),
        (lambda v: v.update(backend="yours.py"), "BACKEND is yours.py there"),
        (lambda v: v.update(kind="capture"), "what is judged is capture there"),
        (lambda v: v["asked"].update(seed=5), "seed is 5 there"),
        (lambda v: v["asked"].update(quick=False), "quick is False there"),
    ],
)
def test_another_baseline_is_refused(write, check, spoil, words):
    write()
    check(*QUICK, "--out", "old")
    path = Path("old/verdict.json")
    found = json.loads(path.read_text())
    spoil(found)
    path.write_text(json.dumps(found))
    code, said = check(*QUICK, "--baseline", str(path))
    assert (code, said.out) == (2, "")
    assert words in said.err
    assert said.err.count("\n") == 1


@pytest.mark.parametrize("text", ["", "[]", "{", "[" * 100_000, "\x00", "3"])
def test_what_is_no_json_is_refused(write, check, text):
    write()
    Path("old.json").write_text(text)
    code, said = check(*QUICK, "--baseline", "old.json")
    assert (code, said.err.count("\n")) == (2, 1)


# ---------------------------------------------------------------- quick


def test_quick_is_no_verdict_of_the_whole(write, check):
    write()
    code, said = check(*QUICK)
    assert code == 0
    assert "QUICK: mine.py: " in said.out
    assert "no verdict of the whole" in said.out
    assert "PASS" not in said.out


def test_quick_knows_what_is_wrong(write, check):
    write("larger")
    code, said = check(*QUICK)
    assert code == 1
    assert "FAIL: mine.py" in said.out


def test_nothing_that_was_judged_is_no_success(write, check):
    write()
    assert check(*QUICK, "--only", "spatial")[0] == 3
    assert check(*QUICK, "--budget", "0")[0] == 3


def test_quick_asks_every_pass():
    verdict = judge(FLOAT32, 600.0, quick=True)
    assert verdict.status == "QUICK"
    assert verdict.judged == set(whole_contract())
    assert "L4 whole runs" in verdict.not_asked


IMPORTED = """
import sys
from restir_gi.reference.cli.main import main
main(["check", "float32", "--quick", "--only", "jacobian", "--json"])
sys.exit("scipy.stats" in sys.modules)
"""


def test_quick_imports_nothing_that_takes_as_long_as_it_does():
    """``scipy.stats`` takes a second, a fourth of the whole."""
    about = os.environ | {"PYTHONPATH": str(DOCS.parent)}
    line = [sys.executable, "-c", IMPORTED]
    assert subprocess.run(line, env=about, capture_output=True).returncode == 0


OF_SPATIAL = (
    "Z asks for light, not for the horizon",
    "the distances are upside down",
    "Z does not ask for visibility",
)


def quick_status(name):
    return judge_planted(BY_NAME[name])


def judge_planted(mutant):
    """Status of the quick steps of the built-in pass with a mistake in it."""
    from restir_gi.reference.oracle.backends.selected import SelectedBackend, Selection
    from restir_gi.reference.oracle.ladder import ladder, quick_levels

    only = Selection(only=frozenset({"spatial"}))
    levels = ladder(
        whole_contract(), SelectedBackend(Planted(mutant), only), frames=False
    )
    return any(take().faults for _, _, take in quick_levels(levels, []))


@pytest.mark.parametrize("name", OF_SPATIAL)
def test_quick_sees_mistakes_of_a_pass(name):
    assert quick_status(name)


def test_control_quick_sees_nothing_in_what_is_right():
    assert not judge_planted(None)


@pytest.mark.slow
def test_quick_sees_all_that_the_whole_ladder_sees_of_pass_spatial():
    """50 of 75 biases reach the pass: all that any level without statistics sees."""
    seen = [m.name for m in MUTANTS if m.kind == "bias" and judge_planted(m)]
    assert len(seen) >= 50


# ---------------------------------------------------------------- refused


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--junit", "out.txt"), "--junit out.txt: name a file that ends in .xml"),
        (("--sarif", "out.json"), "name a file that ends in .sarif"),
        (("--junit", "nowhere/out.xml"), "there is no folder nowhere"),
        (("--baseline", "nowhere.json"), "cannot read nowhere.json"),
        (("--quick", "--case", "kernel-jacobian"), "and so does --case"),
        (("--quick", "--against", "golden"), "and so does --against"),
    ],
)
def test_what_makes_no_sense_is_refused(write, check, words, told):
    write()
    code, said = check("check", "mine.py", *words)
    assert (code, said.out) == (2, "")
    assert told in said.err
    assert said.err.count("\n") == 1


def test_quick_is_for_passes_that_can_be_called(tmp_path, check, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("frames").mkdir()
    dump(Engine(16), Path("frames"), 2)
    for words in (["frames"], ["render {seed} {out}"]):
        code, said = check("check", *words, "--quick")
        assert (code, said.err.count("\n")) == (2, 1)
        assert "--quick" in said.err


def test_old_files_stay_where_the_new_ones_cannot_be_made(write, check):
    """A folder in the way of the file is refused before anything is asked."""
    write()
    Path("out.xml").mkdir()
    code, said = check(*QUICK, "--junit", "out.xml")
    assert (code, said.out) == (2, "")
    assert re.search("out.xml is not a regular file", said.err)


# ---------------------------------------------------------------- documentation

HOWTO = DOCS / "howto" / "index.md"


def test_the_page_names_every_key_of_the_schema():
    text = (DOCS / "reference" / "verdict.md").read_text("utf-8")
    schema = verdict_schema()
    forms = [schema["then"]["then"], schema["else"], schema["$defs"]["reason"]]
    keys = {key for form in forms for key in form["properties"]}
    assert len(keys) > 40
    assert {key for key in keys if f"`{key}`" not in text} == set()


def section():
    """What the how-to says of continuous integration."""
    text = HOWTO.read_text("utf-8")
    return text.split("## In continuous integration\n")[1].split("\n## ")[0]


def shell_lines():
    """Lines that a shell runs: of the blocks for shells, and of each recipe."""
    blocks = re.findall(r"^```(\w+)\n(.*?)^```", section(), re.MULTILINE | re.DOTALL)
    for kind, block in blocks:
        if kind == "sh":
            yield from block.splitlines()
            continue
        for place, value in leaves(yaml.safe_load(block)):
            if {"run", "script", "entry"} & set(place):
                yield from value.splitlines()


def leaves(tree, place=()):
    """All texts of a tree, and where they stand."""
    if isinstance(tree, dict | list):
        pairs = tree.items() if isinstance(tree, dict) else enumerate(tree)
        for key, value in pairs:
            yield from leaves(value, (*place, key))
    elif isinstance(tree, str):
        yield place, tree


@pytest.fixture
def shell(tmp_path, write):
    """Run a line in a scratch project, by a shell; its exit code."""
    command = tmp_path / "bin" / "restir"
    command.parent.mkdir()
    command.write_text(
        f'#!/bin/sh\nexec {sys.executable} -m restir_gi.reference "$@"\n'
    )
    command.chmod(0o755)
    path = f"{command.parent}{os.pathsep}{os.environ['PATH']}"
    about = os.environ | {"PATH": path, "PYTHONPATH": str(DOCS.parent)}

    def run(line):
        done = subprocess.run(
            line, shell=True, env=about, capture_output=True, text=True
        )
        return done.returncode

    return run


def test_the_recipes_run_as_they_are_written(write, shell):
    """First with a known fault, then with a new one, then with none."""
    install, make, *checks = sorted(set(shell_lines()), key=order)
    assert install == "pip install --quiet ./oracle"  # the tests' own environment
    on_ci, *quick = checks
    assert ("--baseline" in on_ci, len(quick)) == (True, 2)
    write("inverted")
    assert shell(make) == 1
    assert shell(on_ci) == 0
    passes = suites(Path("junit.xml").read_text())["restir.passes"]
    assert result_of(passes["jacobian"])[0] == "skipped"
    Sarif.model_validate(json.loads(Path("restir.sarif").read_text()))
    assert (Path("report") / "index.html").is_file()
    assert [shell(line) for line in quick] == [1, 1]
    write("larger")
    assert shell(on_ci) == 1
    write()
    assert [shell(line) for line in quick] == [0, 0]


def order(line):
    """The installation, the baseline, the job, and what is quick."""
    return [word in line for word in ("--quick", "--baseline", "--out baseline")], line


def test_what_a_recipe_uploads_is_what_its_command_writes():
    (line,) = {line for line in shell_lines() if "--baseline" in line}
    text = section()
    for name in ("junit.xml", "restir.sarif", "report"):
        assert name in line.split()
        assert text.count(name) >= 3

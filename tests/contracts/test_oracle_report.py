"""The report of a verdict: what it tells, and that nothing breaks out of it."""

import json
import re
import time
from collections import Counter
from dataclasses import replace
from functools import cache, partial
from io import BytesIO, StringIO

import numpy as np
import pytest
from PIL import Image as Pillow
from rich.console import Console

from restir_gi.reference.images.display import encode_png
from restir_gi.reference.oracle.builtin.backend import FLOAT32
from restir_gi.reference.oracle.cases import Case, Failure
from restir_gi.reference.oracle.diagnosis.diagnose import Diagnosis, Explanation
from restir_gi.reference.oracle.diagnosis.jacobians import JACOBIANS
from restir_gi.reference.oracle.frames import frame_cases
from restir_gi.reference.oracle.levels.kernels import kernel_probes
from restir_gi.reference.oracle.levels.probe import Finding, examined
from restir_gi.reference.oracle.levels.replayed import replayed
from restir_gi.reference.oracle.parts import parts, whole_contract
from restir_gi.reference.oracle.prepared_frame import prepare_frame
from restir_gi.reference.oracle.replay.judgement import (
    Compared,
    Decisions,
    Judgement,
    exactly,
)
from restir_gi.reference.oracle.replay.typical import told_rows, typical_row
from restir_gi.reference.oracle.steps import LevelStep
from restir_gi.reference.oracle.verdict import Timed, Verdict, run_ladder
from restir_gi.reference.reports.verdict.maps import error_maps, signed_map
from restir_gi.reference.reports.verdict.page import write_page
from restir_gi.reference.reports.verdict.plain import as_plain
from restir_gi.reference.reports.verdict.schema import fault_of_form
from restir_gi.reference.reports.verdict.sentences import what_is_wrong
from restir_gi.reference.reports.verdict.table import pieces, table, was_asked
from restir_gi.reference.reports.verdict.worst import (
    answers_of,
    worst_answer,
    worst_rows,
)
from restir_gi.reference.scene.catalogue.registry import find_scene
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.json_text import json_text
from tests.contracts.elements import Page

CONTRACT = whole_contract()

EVIL = "</style><script>alert(1)</script>\"'<img src=x>\x1b[2J\udcff"
FURNACE = Finding(False, "furnace: too bright", asked=("temporal", "spatial"))
OUTPUT = f"the device is lost\n{EVIL}"
EMPTY = Verdict("UNDECIDED", [], [], [], [])


@cache
def probes():
    """Questions of two levels, by level."""
    at = prepare_frame(find_scene("cornell-box"), 16, 1)
    cases = frame_cases(at, "float32")
    frames = [replayed("L3", case) for case in cases]
    further = [probe for part in parts() for probe in part.probes("float32")]
    return {"L0": [*kernel_probes("float32"), *further], "L3": frames}


def answered(change, probe):
    """The right answer of a probe, changed."""
    case = probe.case
    right = getattr(FLOAT32, case.pass_name)(**case.inputs, **case.settings)
    outcome = change(case, dict(right))
    return examined(CONTRACT, "float32", probe, outcome)


def verdict_of(change, budget=np.inf, findings=()):
    """Verdict on the built-in backend with changed answers."""

    def step(level):
        return LevelStep(level, "asked", [answered(change, p) for p in probes()[level]])

    def spheres():
        return LevelStep("L2", "spheres", findings=list(findings))

    levels = [("L0", "asked", partial(step, "L0")), ("L2", "spheres", spheres)]
    levels.append(("L3", "asked", partial(step, "L3")))
    steps = iter(levels)
    return run_ladder(
        CONTRACT, "float32", steps, budget, time.monotonic, lambda title: None
    )


def right(case, out):
    """Change nothing."""
    return out


def planted(case, out):
    """Invert J, enlarge W of spatial, move points of temporal, crash, lack a pass."""
    match case.pass_name:
        case "jacobian":
            J = out["jacobian"].astype(float)
            inverse = np.divide(1, J, where=J > 0, out=np.zeros_like(J))
            out["jacobian"] = np.minimum(inverse, 1e38).astype(np.float32)
        case "spatial":
            out["W"] = out["W"] * np.float32(1.01)
            out["term_Z"] = out["W"] * 0 + np.float32(7)
            slots = case.inputs["neighbors"].shape[1] + 2
            out["term_w"] = np.zeros((case.rows, slots), np.float32) + np.float32(3)
        case "temporal":
            moved = np.flatnonzero(out["W"] > 0)[::9]
            out["position"] = out["position"].copy()
            out["position"][moved] += np.float32(1)
        case "shade":
            return Failure(f"shade crashed: {EVIL}", output=OUTPUT)
        case "merge":
            return None
    return out


@pytest.fixture(scope="module")
def wrong():
    """A verdict on a backend with every kind of fault, and its plain form."""
    verdict = verdict_of(planted, findings=[FURNACE])
    verdict.left.append("L3 many-lights")
    return verdict, as_plain(verdict, "planted", CONTRACT)


@pytest.fixture(scope="module")
def fine():
    """A verdict on the built-in backend, and its plain form."""
    verdict = verdict_of(right)
    return verdict, as_plain(verdict, "float32", CONTRACT)


def of_pass(plain, name):
    """Entry of a pass."""
    (found,) = [p for p in plain["passes"] if p["name"] == name]
    return found


def written(out, verdict, plain):
    """Text of the page."""
    write_page(out, verdict, plain)
    return (out / "index.html").read_text(encoding="utf-8")


def printed(plain, width=120):
    """What a terminal shows."""
    file = StringIO()
    Console(file=file, width=width).print(table(plain))
    return file.getvalue()


# ---------------------------------------------------------------- for programs


@pytest.mark.parametrize("which", ["wrong", "fine"])
def test_the_verdict_has_the_published_form(which, request):
    _, plain = request.getfixturevalue(which)
    assert fault_of_form(json.loads(json_text(plain))) == ""


@pytest.mark.parametrize("which", ["wrong", "fine"])
def test_json_holds_the_whole_verdict(which, request):
    _, plain = request.getfixturevalue(which)
    assert json.loads(json.dumps(plain, allow_nan=False)) == plain


def test_control_a_right_backend_has_no_wrong_pass(fine, tmp_path):
    verdict, plain = fine
    assert plain["status"] == "PASS"
    assert plain["first_wrong_pass"] is None
    assert {p["status"] for p in plain["passes"]} == {"right"}
    assert all(p["failing"] is p["fault"] is None for p in plain["passes"])
    assert all(p["wrong_rows"] == 0 < p["cases"] for p in plain["passes"])
    assert max(x for p in plain["passes"] for x in p["excess"].values()) <= 1
    text = written(tmp_path, verdict, plain)
    assert "<h2>Wrong" not in text
    assert 'class="failed"' not in text
    assert not Page(text).all("img")
    assert "PASS: float32: all that was asked is right" in printed(plain)


def test_a_pass_is_told_where_no_row_of_it_is_wrong(monkeypatch, tmp_path):
    """Too many decisions lean on rounding, of which each alone is right."""
    monkeypatch.setattr(Decisions, "budget", -1)
    verdict = verdict_of(right)
    plain = as_plain(verdict, "float32", CONTRACT)
    first = of_pass(plain, plain["first_wrong_pass"])
    assert first["failing"]["shown"] == []
    assert "decisions differ where rounding leaves" in printed(plain)
    assert "decisions differ where rounding leaves" in written(tmp_path, verdict, plain)


def test_what_is_said_of_each_pass(wrong):
    _, plain = wrong
    assert [p["name"] for p in plain["passes"]] == list(CONTRACT)
    told = {p["name"]: p["status"] for p in plain["passes"]}
    failed = {name for name, status in told.items() if status == "wrong"}
    assert failed == {"jacobian", "temporal", "spatial", "shade"}
    assert told["merge"] == "not judged"
    assert plain["absent"] == ["merge"]
    assert told["moved"] == "right"
    assert plain["first_wrong_pass"] == "jacobian"
    assert plain["headline"].startswith("jacobian is wrong in ")
    assert plain["headline"].endswith("; also wrong: temporal, spatial, shade")


def test_what_each_rung_has_killed(wrong):
    _, plain = wrong
    first, spheres, frames = plain["steps"]
    assert first["wrong_passes"] == ["shade", "jacobian"]
    assert first["asked"] == len(probes()["L0"])
    count = Counter(p.case.pass_name for p in probes()["L0"])
    assert first["unanswered"] == count["merge"]
    # One of those of the Jacobian asks for less than its value.
    assert first["failed"] == count["shade"] + count["jacobian"] - 1
    assert spheres["faults"] == ["furnace: too bright"]
    assert (spheres["asked"], spheres["wrong_passes"]) == (1, [])
    assert frames["wrong_passes"] == ["temporal", "spatial", "shade"]
    assert plain["left"] == ["L3 many-lights"]


def test_a_known_mistake_is_named(wrong):
    found = of_pass(wrong[1], "jacobian")
    assert found["diagnosis"] == ["jacobian-inverted"]
    entry = next(m for m in wrong[1]["mistakes"] if m["name"] == "jacobian-inverted")
    assert entry["seen"]
    assert found["conclusion"] == "is wrong in: jacobian-inverted"
    told = "no known mistake explains all rows"
    assert of_pass(wrong[1], "spatial")["conclusion"].endswith(f"; {told}")


def test_several_mistakes_may_explain_a_pass(wrong, tmp_path):
    found = tuple(Explanation((), (h,), 1, 1) for h in JACOBIANS[:2])
    verdict = replace(wrong[0], diagnoses=[Diagnosis("jacobian", found)])
    plain = as_plain(verdict, "planted", CONTRACT)
    told = "is one of: jacobian-inverted, jacobian-omitted"
    assert "it is one of: jacobian-inverted" in plain["headline"]
    assert of_pass(plain, "jacobian")["conclusion"] == told
    text = written(tmp_path, verdict, plain)
    assert "do not tell them apart" in text
    for mistake in JACOBIANS[:2]:
        assert f"<code>{mistake.wrong}</code>" in text


def test_the_worst_rows_carry_both_sides_and_all_terms(wrong):
    found = of_pass(wrong[1], "spatial")
    assert (found["cases"], found["rows"]) == (3, 3 * 256)
    rows = found["failing"]["shown"]
    assert len(rows) == 5
    for row in rows:
        assert row["row"] == row["x"] + 16 * row["y"]
        fields = CONTRACT["spatial"].inputs
        assert set(row["inputs"]) == {f.name for f in fields if f.only is None}
        beside = {n for n in row["inputs"]["neighbors"] if n >= 0}
        assert {other["row"] for other in row["neighbors"]} == beside
        W = row["outputs"]["W"]
        assert W["found"] == pytest.approx(1.01 * W["expected"], rel=1e-5)
        assert W["excess"] > 1 > W["allowed"]
        terms = row["terms"]
        assert {"Z", "p_hat", "sum of w", "kept slot"} <= set(terms)
        assert (terms["Z"]["found"], terms["w of slot 1"]["found"]) == (7, 3)
        assert terms["p_hat"]["found"] is None
        assert terms["Z"]["expected"] == pytest.approx(round(terms["Z"]["expected"]))
    assert [row["typical"] for row in rows] == [True, False, False, False, False]
    typical, *sizes = [row["outputs"]["W"]["excess"] for row in rows]
    assert typical < sizes[-1]
    assert sizes == sorted(sizes, reverse=True)
    assert sizes[0] == found["excess"]["W"]
    assert found["excuses"]["used"] <= found["excuses"]["budget"]


def test_rows_that_are_no_pixels_have_no_place(wrong):
    row = of_pass(wrong[1], "jacobian")["failing"]["shown"][0]
    assert row["x"] is row["y"] is None


def test_a_failure_without_a_judgement_has_no_rows_and_no_diagnosis(wrong):
    found = of_pass(wrong[1], "shade")
    assert found["fault"].startswith("shade crashed")
    assert (found["cases"], found["rows"]) == (3, 0)
    assert found["failing"] is None
    assert found["diagnosis"] == []
    assert found["excess"] == {}
    assert found["conclusion"].startswith("no known mistake could be tried")
    assert [f["output"] for f in found["failures"]] == [OUTPUT] * 3


def test_what_nothing_was_allowed_for_is_infinitely_wrong(wrong):
    found = of_pass(wrong[1], "temporal")
    assert found["excess"]["position"] is None
    first = found["failing"]["shown"][0]
    assert first["outputs"]["position"]["excess"] is None


def test_an_empty_verdict(tmp_path):
    plain = as_plain(EMPTY, "nobody", CONTRACT)
    assert {p["status"] for p in plain["passes"]} == {"not judged"}
    assert plain["headline"] == "nothing was judged"
    text = written(tmp_path, EMPTY, plain)
    assert "None was run" in text
    Page(text)
    assert printed(plain) == "UNDECIDED: nobody: nothing was judged\n"


def test_without_time_nothing_is_said(tmp_path):
    verdict = verdict_of(right, budget=0)
    plain = as_plain(verdict, "slow", CONTRACT)
    assert plain["headline"] == "nothing was judged"
    assert "no time left" in written(tmp_path, verdict, plain)
    assert "no time for: L0 asked, L2 spheres, L3 asked" in printed(plain)


def with_mean(verdict, status, **more):
    """A verdict with a step of statistics."""
    mean = Timed(LevelStep("L4", "mean", findings=[Finding(True)], **more), 1.0)
    return replace(verdict, status=status, steps=[*verdict.steps, mean])


def test_a_bound_is_told(fine, tmp_path):
    verdict = with_mean(fine[0], "PASS", certified=0.00449)
    plain = as_plain(verdict, "float32", CONTRACT)
    assert plain["certified"] == plain["steps"][-1]["certified"] == 0.00449
    assert "at most 0.449 %" in written(tmp_path, verdict, plain)
    asked = {a.probe.case.pass_name for t in verdict.steps for a in t.step.answers}
    told = f"in {len(asked)} passes; bias of the mean ≤ 0.45%"
    assert told in printed(plain)


def test_what_more_time_would_buy(fine, tmp_path):
    told = "0.5 % after 100 seconds"
    verdict = with_mean(fine[0], "UNDECIDED", certified=np.inf, more=told)
    plain = as_plain(verdict, "float32", CONTRACT)
    assert plain["certified"] is None
    assert plain["headline"] == "nothing is wrong so far, but more time is wanted"
    assert f"L4 mean: {told}" in printed(plain)
    assert f"L4 mean: {told}" in written(tmp_path, verdict, plain)


def test_steps_without_time_are_counted(fine):
    verdict = replace(fine[0], status="UNDECIDED", left=["L4 mean"])
    told = "nothing is wrong so far, 1 step had no time"
    assert as_plain(verdict, "float32", CONTRACT)["headline"] == told


def test_when_only_the_loop_is_wrong():
    verdict = verdict_of(right, findings=[FURNACE])
    plain = as_plain(verdict, "loop", CONTRACT)
    assert (plain["status"], plain["first_wrong_pass"]) == ("FAIL", None)
    assert "furnace: too bright" in printed(plain)
    told = "each pass is right by itself, and together they are wrong: furnace"
    assert told in " ".join(printed(plain).split())


# ---------------------------------------------------------------- rows


def judgement(found, expected, allowed=0.0, **more):
    """Of one buffer."""
    found, expected = np.array(found, float), np.array(expected, float)
    room = np.broadcast_to(allowed, found.shape)
    return Judgement((Compared("W", found, expected, room),), **more)


def test_among_infinitely_wrong_rows_the_largest_difference_is_worst():
    found = judgement([1.0, 2.0, 1.0, 9.0], [1.0, 1.0, 0.9, 1.0])
    assert worst_rows(found, 2).tolist() == [3, 1]


def test_where_only_the_budget_is_exceeded_the_differing_rows_are_worst():
    kept = {"kept slot": np.array([0, 1, 1]), "slot in exact arithmetic": np.ones(3)}
    decisions = Decisions(np.zeros(3, bool), 1, 0.0)
    found = judgement(
        [1, 1, 1], [1, 1, 1], 1, terms=kept, decisions=decisions, counted=True
    )
    assert not found.passed
    assert worst_rows(found, 5).tolist() == [0]


def case_of(rows, beyond=None):
    """A case of so many rows that are no pixels."""
    return Case("rows", "target", {}, {"W": np.zeros(rows)}, beyond=beyond)


def test_the_row_that_is_shown_first_is_in_the_middle():
    """One row is off by a billion, one by next to nothing; neither is typical."""
    found = judgement([1e9, 2.0, 1.1, 1.0, 1.0001], np.ones(5), 1e-5)
    assert typical_row(case_of(5), found) == 2
    assert worst_rows(found, 1).tolist() == [0]


def test_the_row_that_is_shown_first_is_within_the_working_range():
    found = judgement([1.5, 2.0, 3.0], np.ones(3), 0.1)
    beyond = np.array([False, True, True])
    assert typical_row(case_of(3, beyond), found) == 0
    assert typical_row(case_of(3, ~np.zeros(3, bool)), found) == 1
    assert "1 of 3 rows are wrong; in row 0 W is 1.5" in told_rows(
        case_of(3, beyond), found
    )


def test_bits_are_told_as_bits_and_row_numbers_as_such():
    words = np.array([[0x32B0C49B, 7], [1, 1]], np.uint32)
    right = np.array([[0x32B0C49A, 7], [1, 1]])
    found = Judgement((exactly("words", words, right),))
    told = "words is 0x32b0c49b instead of 0x32b0c49a"
    assert told_rows(case_of(2), found).endswith(told)
    assert pieces([2**31, 1], kind="u") == ["0x80000000", "1"]
    assert pieces([-1, 12345678], kind="i") == ["-1", "12345678"]


def test_numbers_that_nine_digits_do_not_tell_apart_have_more():
    found = np.array([1.0 + 2**-40])
    told = told_rows(case_of(1), Judgement((exactly("W", found, np.ones(1)),)))
    assert "W is 1.0000000000009095 instead of 1" in told


def test_a_choice_that_u_does_not_allow_says_which():
    kept = {"kept slot": np.array([2]), "slot in exact arithmetic": np.array([0])}
    found = judgement(
        [1], [1], 1, terms=kept, decisions=Decisions(np.ones(1, bool), 0, 0.0)
    )
    told = told_rows(case_of(1), found)
    assert told.endswith("candidate 2 of the stream in place of 0")


@pytest.mark.parametrize(
    ("found", "told"),
    [
        ([2.0, 3.0, 1.0], "W is too large in 2 of 3 rows"),
        ([0.5, 1.0, 1.0], "W is too small in 1 of 3 rows"),
        ([0.5, 2.0, 1.0], "W is wrong in 2 of 3 rows"),
        ([1.0, 1.0, 1.0], None),
    ],
)
def test_the_side_to_which_an_output_is_off(found, told):
    assert what_is_wrong([(case_of(3), judgement(found, np.ones(3)))], 3) == told


def test_rows_at_extremes_are_not_counted_as_wrong():
    found = judgement([2.0, 2.0, 1.0], np.ones(3))
    case = case_of(3, np.array([False, True, True]))
    assert what_is_wrong([(case, found)], 9) == "W is too large in 1 of 9 rows"


def test_a_term_of_nothing_but_zeros_was_never_given(wrong):
    """A buffer that a backend did not write is no value that it found."""
    verdict = verdict_of(
        lambda case, out: (
            planted(case, out)
            | {"term_Z": out["W"] * 0, "term_p_hat": out["W"] * 0 + 1}
            if case.pass_name == "spatial"
            else out
        )
    )
    plain = as_plain(verdict, "zeros", CONTRACT)
    terms = of_pass(plain, "spatial")["failing"]["shown"][0]["terms"]
    assert (terms["Z"]["found"], terms["Z"]["differs"]) == (None, False)
    assert (terms["p_hat"]["found"], terms["p_hat"]["differs"]) == (1, True)


# ---------------------------------------------------------------- explanations


def explained_as(verdict, tmp_path, *explanations, closest=None, fit=""):
    """Conclusion on the Jacobian, and text of the page, for some explanations."""
    found = Diagnosis("jacobian", tuple(explanations), closest, fit)
    changed = replace(verdict, diagnoses=[found])
    plain = as_plain(changed, "planted", CONTRACT)
    return of_pass(plain, "jacobian"), written(tmp_path, changed, plain)


def test_departures_and_mistakes_are_told_apart(wrong, tmp_path):
    both = Explanation(JACOBIANS[2:3], JACOBIANS[:1], 9, 9)
    found, text = explained_as(wrong[0], tmp_path, both)
    told = "is wrong in: jacobian-inverted; departs in: jacobian-unsquared (innocent)"
    assert found["conclusion"] == told
    assert [e["innocent"] for e in found["explanations"]] == [False]
    for name in ("jacobian-inverted", "jacobian-unsquared"):
        assert f'id="mistake-{name}"' in text
    assert "the weight is divided by the Jacobian" in found["sentence"]


def test_what_explains_most_rows_says_how_many_it_leaves(wrong, tmp_path):
    most = Explanation((), JACOBIANS[:1], 2304 - 69, 2304)
    found, text = explained_as(wrong[0], tmp_path, closest=most)
    assert "jacobian-inverted, which explains 97.0 % of the rows" in found["conclusion"]
    assert "unexplained: 69 of 2,304 rows" in found["conclusion"]
    assert "What remains unexplained: 69 of 2,304 rows" in text
    nearly = Explanation((), JACOBIANS[:1], 99_999, 100_000)
    found, _ = explained_as(wrong[0], tmp_path, closest=nearly)
    assert "explains 99.9 % of the rows" in found["conclusion"]


def test_the_first_wrong_term_is_told_where_no_mistake_explains_a_pass(wrong, tmp_path):
    fit = "W is right times d^2 / cos phi in 2,290 of 2,304 rows"
    found, text = explained_as(wrong[0], tmp_path, fit=fit)
    assert found["fit"] == fit
    assert found["sentence"].endswith(f"; {fit}")
    assert f"<p>{fit}.</p>" in text


def test_what_is_wrong_at_extremes_alone_has_its_own_place(fine, tmp_path):
    told = "kernel-random: row 9 is infinite"
    answer = fine[0].steps[0].step.answers[0]
    rows = answer.probe.case.rows
    beyond = Judgement((Compared("u", np.ones(rows), np.zeros(rows), np.zeros(rows)),))
    case = replace(answer.probe.case, beyond=np.ones(rows, bool))
    probe = replace(answer.probe, case=case)
    finding = Finding(True, judgement=beyond, at_extremes=told)
    step = LevelStep("L0", "extremes", [replace(answer, probe=probe, finding=finding)])
    verdict = replace(fine[0], steps=[*fine[0].steps, Timed(step, 0.1)])
    plain = as_plain(verdict, "float32", CONTRACT)
    assert plain["at_extremes"] == [told]
    of_random = of_pass(plain, "random")
    assert (of_random["status"], of_random["wrong_rows"]) == ("right", 0)
    assert of_random["failing"] is None
    assert max(of_random["excess"].values()) == 0
    assert "Wrong at extremes alone" in written(tmp_path, verdict, plain)
    assert f"at extremes alone: {told}" in printed(plain)
    assert plain["status"] == "PASS"


def test_a_relation_that_one_pass_breaks_is_that_pass_fault():
    """Nobody says that all together are wrong where one pass alone was asked."""
    bad = Finding(False, "temporal-cornell-box: light times 2^9", asked=("temporal",))
    plain = as_plain(verdict_of(right, findings=[bad]), "loop", CONTRACT)
    assert plain["first_wrong_pass"] == "temporal"
    told = "temporal is wrong: temporal-cornell-box: light times 2^9"
    assert plain["headline"] == told
    assert plain["steps"][1]["wrong_passes"] == ["temporal"]


def test_the_command_asks_for_one_case(wrong, tmp_path):
    verdict, _ = wrong
    plain = as_plain(verdict, "planted", CONTRACT, "restir check 'my shader.py'")
    case = of_pass(plain, "spatial")["failing"]
    command = f"restir check 'my shader.py' --case {case['case']}"
    assert case["command"] == command
    assert command.replace("'", "&#39;") in written(tmp_path, verdict, plain)
    assert "--case kernel-jacobian" in " ".join(printed(plain).split())


def test_steps_that_asked_nothing_of_the_backend_are_not_listed(fine):
    plain = as_plain(fine[0], "float32", CONTRACT)
    assert "spheres" not in printed(plain)
    assert not was_asked(plain["steps"][1])


# ---------------------------------------------------------------- pictures


def test_pictures_of_what_is_wrong(wrong):
    verdict, _ = wrong
    worst = worst_answer(answers_of(verdict, "spatial"))
    (W, *others) = error_maps(worst)
    assert [m.name for m in others] in ([], ["decisions"])
    assert (W.name, W.values.shape) == ("W", (16, 16))
    assert W.low == -W.high
    assert (W.values >= -1).all()  # too much, but for rounding
    png = encode_png(W.pixels())
    with Pillow.open(BytesIO(png)) as picture:
        assert (picture.size, picture.mode) == ((16, 16), "RGB")


def test_rows_that_are_no_pixels_have_no_picture(wrong):
    verdict, _ = wrong
    assert error_maps(worst_answer(answers_of(verdict, "jacobian"))) == []
    assert worst_answer(answers_of(verdict, "shade")) is None


def test_the_sign_and_the_unit_of_a_picture():
    expected, allowed = np.full(4, 2.0), np.array([0.5, 0.5, 0.5, np.inf])
    found = np.array([3.0, 1.0, 2.0, 9.0])
    values = signed_map(Compared("W", found, expected, allowed), 2).values
    np.testing.assert_array_equal(values, [[2, -2], [0, 0]])


def test_where_nothing_is_allowed_a_picture_is_relative():
    bits = np.array([[4, 0], [1, 1]], np.uint32)
    picture = signed_map(exactly("words", bits, np.array([[2, 0], [1, 1]])), 2)
    np.testing.assert_array_equal(picture.values, [[0.5, 0.0]])
    assert "larger of the two" in picture.meaning


# ---------------------------------------------------------------- the page


def test_the_page_tells_all(wrong, tmp_path):
    verdict, plain = wrong
    text = written(tmp_path, verdict, plain)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["index.html", "verdict.json"]
    stored = json.loads((tmp_path / "verdict.json").read_text(encoding="utf-8"))
    assert stored == plain
    names = ("jacobian-inverted", "many-lights", "furnace: too bright", "merge")
    assert "the device is lost" in text
    for words in (*names, "w of slot 0", "C2-Renderer fcd7c28", "pixel (", "budget"):
        assert words in text
    for name in CONTRACT:
        assert f">{name}<" in text
    for row in of_pass(plain, "spatial")["failing"]["shown"]:
        assert pieces(row["outputs"]["W"]["found"])[0] in text


def test_the_page_needs_no_network_and_no_other_file(wrong, tmp_path):
    text = written(tmp_path, *wrong)
    page = Page(text)
    assert not re.search(r"https?:|@import|url\(", text)
    assert not page.all("link")
    assert not page.all("script")
    images = page.all("img")
    assert len(images) >= 2
    assert all(i["src"].startswith("data:image/png;base64,") for i in images)
    assert all(i["alt"] for i in images)
    anchors = {a["href"] for a in page.all("a")}
    places = [p for kind in ("section", "details", "article") for p in page.all(kind)]
    assert anchors == {f"#{place['id']}" for place in places if "id" in place}


def test_the_same_verdict_makes_the_same_page(wrong, tmp_path):
    assert written(tmp_path / "a", *wrong) == written(tmp_path / "b", *wrong)


def test_what_a_backend_says_cannot_break_out(wrong, tmp_path):
    verdict, _ = wrong
    plain = as_plain(verdict, EVIL, CONTRACT)
    text = written(tmp_path, verdict, plain)
    page = Page(text)
    assert not page.all("script")
    assert all(i["src"].startswith("data:") for i in page.all("img"))
    assert "&lt;script&gt;alert(1)&lt;/script&gt;" in text
    shown = printed(plain)
    assert "\x1b" not in shown
    assert "\udcff" not in shown
    assert "<script>" in shown


def test_a_folder_that_cannot_be_made(wrong, tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(UsageError, match="cannot make the folder") as error:
        write_page(tmp_path / "file" / "below", *wrong)
    assert len(str(error.value).splitlines()) == 1


# ---------------------------------------------------------------- the terminal


def test_the_terminal_shows_rungs_faults_and_the_verdict(wrong):
    text = printed(wrong[1])
    assert max(map(len, text.splitlines())) <= 120
    for words in ("L0", "L2", "L3", "jacobian-inverted", "no known mistake", "merge"):
        assert words in text
    assert "FAIL: planted: jacobian is wrong in" in text


def test_brackets_are_no_markup(fine):
    verdict, _ = fine
    assert "PASS: [bold]x[/]: all" in printed(as_plain(verdict, "[bold]x[/]", CONTRACT))


def test_numbers_as_they_are_read():
    assert pieces(0.1) == ["0.1"]
    assert pieces(3) == ["3"]
    assert pieces(None, "anything") == ["anything"]
    assert pieces([None, None], "anything") == ["anything"]
    assert pieces([1.5, None], "–") == ["1.5", "–"]


@pytest.mark.parametrize(
    ("term", "told"),
    [
        (np.zeros(3, np.float32), "term_Z has shape (3,) instead of (256,)"),
        (np.zeros(256), "term_Z is float64 instead of float32"),
    ],
)
def test_terms_have_their_form_and_need_not_be_finite(term, told):
    probe = next(p for p in probes()["L3"] if p.case.pass_name == "temporal")
    bad = answered(lambda case, out: out | {"term_Z": term}, probe)
    assert told in bad.finding.text
    unknown = np.full(256, np.nan, np.float32)
    assert answered(lambda case, out: out | {"term_Z": unknown}, probe).finding.passed

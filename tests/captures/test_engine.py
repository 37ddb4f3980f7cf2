"""An engine's own frames, judged without our random numbers."""

import tomllib

import numpy as np
import pytest

from restir_gi.reference.cli.main import main
from restir_gi.reference.oracle.capture.cases import recorded_of
from restir_gi.reference.oracle.capture.judge import judge_captured
from restir_gi.reference.oracle.capture.record import Capture
from restir_gi.reference.oracle.declaration.declared import NOTHING_DECLARED
from restir_gi.reference.oracle.declaration.read import read_declaration
from restir_gi.reference.oracle.parts import whole_contract
from restir_gi.reference.reports.verdict.plain import as_plain
from restir_gi.reference.system.errors import UsageError
from tests.captures import mistakes
from tests.captures.dump import DECLARATION, dump
from tests.captures.engine import Engine, GlossyEngine

DECLARED = read_declaration(tomllib.loads(DECLARATION))
BUDGET = 600.0


def verdict_on(engine, folder, frames=4, declaration=DECLARED):
    """What is said of some frames of an engine."""
    return verdict_on_folder(dump(engine, folder, frames), declaration)


def verdict_on_folder(folder, declaration):
    """What is said of a capture on disk."""
    return judge_captured(recorded_of(Capture.read(folder)), BUDGET, declaration)


def said(verdict):
    """All that names a mistake, in one text."""
    found = [d.text for d in verdict.diagnoses]
    found += [f.text for f in verdict.steps[-1].step.findings]
    return "; ".join(found)


@pytest.mark.parametrize("engine", [Engine(48, 1), Engine(48, 2), GlossyEngine(48, 3)])
def test_a_right_engine_passes(tmp_path, engine):
    verdict = verdict_on(engine, tmp_path)
    assert verdict.status == "PASS", said(verdict)
    assert verdict.judged == {"moved", "spatial", "shade"}
    assert [one.state for one in verdict.followed] == ["followed", "followed"]
    assert verdict.at_extremes == []


@pytest.mark.slow
def test_what_it_departs_in_is_recognised(tmp_path):
    # Whether a pixel sees its sample is asked when it is shaded: that has to be told.
    declaration = read_declaration(
        {"schema": "restir-declaration 1", "choices": {"visibility": "shading"}}
    )
    verdict = verdict_on(Engine(64), tmp_path, declaration=declaration)
    assert verdict.status == "PASS", said(verdict)
    names = {h.name for d in verdict.departures for h in d.matches}
    assert {"capped-on-arrival", "balance-without-jacobian"} <= names


@pytest.mark.slow
def test_control_nothing_declared_is_wrong_where_only_shading_looks(tmp_path):
    verdict = verdict_on(Engine(32), tmp_path, 3, NOTHING_DECLARED)
    assert verdict.status == "FAIL"


def test_what_is_no_number_fails_and_is_told(tmp_path, capsys):
    dump(mistakes.QuotientOfZeros(24), tmp_path, 2)
    assert main(["check", str(tmp_path)]) == 1
    told = capsys.readouterr()
    assert "W holds NaN" in told.out
    assert "W of spatial" in told.err


QUICK = (mistakes.JacobianLeftOut, mistakes.SumBefore, mistakes.TemporalAgain)


@pytest.mark.parametrize(
    "mistake",
    [
        pytest.param(one, marks=() if one in QUICK else pytest.mark.slow)
        for one in mistakes.MISTAKES
    ],
    ids=lambda one: one.__name__,
)
def test_a_mistake_fails_and_is_named(tmp_path, mistake):
    verdict = verdict_on(mistake(mistake.size), tmp_path)
    assert verdict.status == "FAIL"
    text = said(verdict)
    assert all(words in text for words in mistake.named), text


def test_enough_mistakes_have_names():
    assert len(mistakes.MISTAKES) >= 15
    assert sum(bool(one.named) for one in mistakes.MISTAKES) >= 9


def test_the_command_tells_pass_and_fail(tmp_path, capsys):
    right, wrong = tmp_path / "right", tmp_path / "wrong"
    right.mkdir()
    wrong.mkdir()
    dump(Engine(32), right, 3)
    dump(mistakes.TemporalAgain(24), wrong, 3)
    assert main(["check", str(right), "--out", str(tmp_path / "report")]) == 0
    assert "follows own-first" in capsys.readouterr().out
    assert (tmp_path / "report" / "index.html").exists()
    assert main(["check", str(wrong / "capture.toml")]) == 1
    assert "temporal reservoirs of the last frame" in capsys.readouterr().out


@pytest.mark.parametrize(
    "option", [["--only", "moved"], ["--seed", "3"], ["--precision", "float64"]]
)
def test_options_of_calls_are_refused(tmp_path, capsys, option):
    dump(Engine(16), tmp_path, 1)
    assert main(["check", str(tmp_path), *option]) == 2
    assert f"{option[0]} says nothing to a capture" in capsys.readouterr().err


def test_a_buffer_that_was_read_is_asked_for(tmp_path):
    capture = Capture.read(dump(Engine(16), tmp_path, 2))
    for frame in capture.frames:
        del frame.roles["history"]
    with pytest.raises(UsageError, match=r"frame 1 has no history\.row"):
        judge_captured(recorded_of(capture), BUDGET, DECLARED)


def test_a_decoder_may_round(tmp_path):
    # What the engine has read is decoded in single precision, and here in double.
    verdict = verdict_on(Engine(64, seed=3), tmp_path, 2)
    assert verdict.status == "PASS", said(verdict)
    capture = Capture.read(tmp_path)
    normals = capture.frames[0]["temporal"]["normal"]
    assert np.abs(normals - normals.astype(np.float32)).max() > 0


def without_bits(engine, folder):
    """A capture that leaves out which rays the sources have traced."""
    dump(engine, folder, 3)
    manifest = folder / "capture.toml"
    text = manifest.read_text("utf-8")
    start = text.index("[buffers.visible_spatial]")
    end = text.index("[buffers.", start + 1)
    manifest.write_text(text[:start] + text[end:], "utf-8")
    return verdict_on_folder(folder, DECLARED)


def test_a_right_engine_whose_bits_are_missing_is_not_accused(tmp_path):
    # The rays that its sources trace are known to nobody then.
    verdict = without_bits(Engine(32), tmp_path)
    assert verdict.status == "UNDECIDED"
    assert "dump visible_spatial" in said(verdict)
    plain = as_plain(verdict, "capture", whole_contract(), kind="capture")
    assert plain["headline"].startswith("spatial cannot be judged yet")
    statuses = {p["name"]: p["status"] for p in plain["passes"]}
    assert statuses["spatial"] == "undecided"


@pytest.mark.slow
@pytest.mark.parametrize(
    "wrong",
    [mistakes.TemporalAgain, mistakes.JacobianInverted, mistakes.QuotientOfZeros],
)
def test_control_a_wrong_engine_whose_bits_are_missing_fails(tmp_path, wrong):
    assert without_bits(wrong(24), tmp_path).status == "FAIL"

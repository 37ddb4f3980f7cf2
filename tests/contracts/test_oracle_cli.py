"""``restir check`` and ``restir golden``: exit codes, JSON, reports."""

import json
import shutil
from pathlib import Path

import pytest

from restir_gi.reference.cli.main import main

BACKENDS = Path(__file__).parent / "oracle_backends.py"


@pytest.fixture(scope="module")
def golden(tmp_path_factory):
    out = tmp_path_factory.mktemp("cli") / "golden"
    assert main(["golden", "cornell-box", "--out", str(out), "--size", "12"]) == 0
    return out


def run(capsys, *arguments):
    code = main(list(arguments))
    return code, capsys.readouterr()


def test_a_right_backend_passes_what_is_golden(golden, capsys):
    code, said = run(capsys, "check", "float32", "--against", str(golden), "--json")
    found = json.loads(said.out)
    assert code == 0
    assert found["status"] == "PASS"


def test_a_wrong_one_fails_and_has_a_report(golden, capsys, tmp_path):
    backend, out = f"{BACKENDS}:NAN", tmp_path / "report"
    code, said = run(
        capsys, "check", backend, "--against", str(golden), "--out", str(out)
    )
    assert code == 1
    assert "FAIL" in said.out
    assert "holds NaN" in said.out
    assert json.loads((out / "verdict.json").read_text())["status"] == "FAIL"
    assert "holds NaN" in (out / "index.html").read_text()


def test_a_folder_without_outputs_is_undecided(golden, capsys):
    code, said = run(capsys, "check", str(golden))
    assert code == 3
    assert "UNDECIDED" in said.out


def test_no_budget_is_undecided(capsys):
    code, said = run(capsys, "check", "float32", "--budget", "0", "--json")
    found = json.loads(said.out)
    assert code == 3
    assert found["left"]


def test_a_folder_with_expected_outputs_passes(golden, capsys, tmp_path):
    copy = shutil.copytree(golden, tmp_path / "copy")
    for case in (path for path in copy.iterdir() if path.is_dir()):
        shutil.copytree(case / "expected", case / "out", dirs_exist_ok=True)
    code, _ = run(capsys, "check", str(copy))
    assert code == 0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["check", "nobody"], "unknown backend 'nobody'"),
        (["check", "nobody.py"], "no file nobody.py"),
        (["check", "float32", "--against", "nowhere"], "cannot read"),
        (["check", "./no-such {directory}"], "cannot run ./no-such"),
        (["check", "'unbalanced {directory}"], "is not a command line"),
        (["golden", "nowhere", "--out", "x"], "nowhere"),
        (["golden", "glossy-floor", "--out", "x"], "materials that are not diffuse"),
    ],
)
def test_bad_requests_are_one_line(capsys, arguments, words):
    code, said = run(capsys, *arguments)
    assert code == 2
    assert words in said.err
    assert said.err.count("\n") == 1


def test_precisions_must_agree(golden, capsys):
    code, said = run(capsys, "check", "float64", "--against", str(golden))
    assert code == 2
    assert "calculates in float64" in said.err

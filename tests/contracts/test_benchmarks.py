"""The command that makes every table anew: what it asks for is there to be asked."""

import subprocess
import sys
from pathlib import Path

import pytest

from restir_gi.reference.cli.main import build_parser
from restir_gi.reference.system.errors import UsageError
from tests.benchmarks.__main__ import parts
from tests.mutants import matrix

PACKAGE = "restir_gi.reference"


@pytest.mark.parametrize("quick", [True, False])
def test_commands_are_understood(quick):
    modules = [command[2:] for command in parts(Path("out"), quick).values()]
    commands = [words for module, *words in modules if module == PACKAGE]
    assert {words[0] for words in commands} == {"figures", "tradeoff", "plan"}
    for words in commands:
        build_parser().parse_args(words)


def test_control_a_size_of_one_number_is_not_understood():
    with pytest.raises(UsageError, match="WIDTHxHEIGHT"):
        build_parser().parse_args(["tradeoff", "x", "--out", "y", "--size", "24"])


def test_every_script_is_among_them(monkeypatch):
    monkeypatch.setenv("RESTIR_SCENES", "scenes")
    modules = {c[2] for c in parts(Path("out"), True).values()} - {PACKAGE}
    folder = Path(__file__).parents[1] / "benchmarks"
    assert modules == {f"tests.benchmarks.{f.stem}" for f in folder.glob("bench_*.py")}


def test_the_kill_matrix_says_what_its_command_writes():
    page = Path(__file__).parents[2] / "docs" / "explanation" / "kill_matrix.md"
    text = page.read_text("utf-8")
    said = [matrix.INTRODUCTION, matrix.KNOWN, matrix.FURTHER, matrix.SHIFTS]
    said += [matrix.REUSE, matrix.GRID, matrix.PAIRS, matrix.UNSEEN, matrix.BLIND]
    assert [part for part in said if part not in text] == []


COUNT = """
from tests.benchmarks.mitsuba_side import passes_over_all_paths
print("passes", passes_over_all_paths("cornell-box", 8, 4))
"""


@pytest.mark.slow
def test_mitsuba_traces_its_paths_once():
    """A peer is measured at its best: not once for each channel."""
    done = subprocess.run(
        [sys.executable, "-c", COUNT], capture_output=True, text=True, check=False
    )
    if "LLVM" in done.stderr.upper():
        pytest.skip(f"no LLVM for Mitsuba here: {done.stderr[-200:]}")
    assert done.stdout == "passes 1\n"

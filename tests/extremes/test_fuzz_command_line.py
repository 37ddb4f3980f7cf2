"""Thousands of command lines that nobody means: what is promised holds for each.

`tests.extremes.mutants` makes and judges them; here a fixed handful is run, and the
judge itself is shown what it must report.
"""

import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from restir_gi.reference.cli.main import COMMANDS, main
from restir_gi.reference.images.exr import write_exr
from restir_gi.reference.images.image import Image
from tests.extremes.mutants import (
    ROOM,
    SpoiledCommand,
    commands,
    mutants,
    run,
    run_all,
    summary,
    violations,
)

pytestmark = [
    pytest.mark.skipif(
        not Path("/proc/self/clear_refs").exists(),
        reason="measures memory as Linux does",
    ),
    pytest.mark.skipif(
        threading.current_thread() is not threading.main_thread(),
        reason="alarms ring in the main thread",
    ),
]
QUICK, MANY = 150, 400


def assert_all_is_well(outcomes):
    """No violation; and the mutants came past the parser, and reached every command."""
    text = summary(outcomes)
    assert not [o for o in outcomes if o.violations], text
    codes = {outcome.code for outcome in outcomes}
    assert {0, 2} <= codes, text


def test_a_handful_of_mutants(tmp_path):
    assert_all_is_well(run_all(0, range(QUICK), tmp_path, slow=False))


@pytest.mark.slow
@pytest.mark.parametrize("part", range(10))
def test_thousands_of_mutants(tmp_path, part):
    numbers = range(1000 + part * MANY, 1000 + (part + 1) * MANY)
    assert_all_is_well(run_all(0, numbers, tmp_path, slow=part == 0))


def test_every_command_and_option_is_reached(tmp_path):
    """Made, not run: some mutant holds each option that the parser has."""
    parsers = commands()
    assert parsers.keys() == COMMANDS.keys()
    made = [m.argv for m in mutants(0, range(6000), tmp_path, [], slow=True)
            if not m.files]  # fmt: skip
    for name, parser in parsers.items():
        words = {word for argv in made if name in argv for word in argv}
        options = {a.option_strings[-1] for a in parser._actions if a.option_strings}
        assert options - words <= {"--help"}


def test_a_mutant_is_made_of_its_number(tmp_path):
    first, *_ = mutants(3, [17], tmp_path, [], slow=False)
    *_, again = mutants(3, [4, 17], tmp_path, [], slow=False)
    assert first == again


# ---------------------------------------------------------------- the judge is judged


def writes(out="", err="", code=0):
    """A command that only writes."""

    def command(argv):
        sys.stdout.write(out)
        sys.stderr.write(err)
        return code

    return command


def hangs(argv):
    """Wait for longer than a mutant may."""
    time.sleep(5)
    return 0


def hangs_in_a_call(argv):
    """The same, and make an exit code of the alarm, as `main` does."""
    try:
        time.sleep(5)
    except BaseException:
        return 2
    return 0


def takes(argv):
    """Take more memory than there is room."""
    np.ones(ROOM // 8 + 2**20)
    return 0


def fails(argv):
    """Raise what nobody expects."""
    raise ZeroDivisionError("of the tool")


def leaves(argv):
    """Leave half of a file."""
    Path(".0123.part").write_bytes(b"half")
    return 0


def paints(value):
    """Write a picture."""

    def command(argv):
        color = np.full((2, 2, 3), value, np.float32)
        write_exr(Path("x.exr"), Image({"color": color}, {"method": "path"}))
        return 0

    return command


LINE = "restir: no such file\n"
PLANTED = {
    "a traceback": (writes(err="Traceback (most recent call last):\n"), "on stderr"),
    "a name of Python": (writes(err="restir: KeyError: 'x'\n", code=2), "Python"),
    "a code of its own": (writes(code=70, err=LINE), "exit code 70"),
    "a verdict of no judge": (writes(code=1, err=LINE), "exit code 1"),
    "an error without a word": (writes(code=2), "without a word"),
    "an error and a result": (writes("x\n", LINE, 2), "on stdout"),
    "a line of somebody else": (writes(err="libfoo: oops\n"), "on stderr"),
    "escape codes": (writes(err="restir: \x1b[31mred\n", code=2), "control"),
    "no JSON": (writes(out="{"), "no JSON"),
    "a hang": (hangs, "it took"),
    "a hang that is caught": (hangs_in_a_call, "it took"),
    "memory": (takes, "MiB taken"),
    "an exception": (fails, "exit code 70"),
    "half a file": (leaves, "left behind"),
    "NaN": (paints(np.nan), "NaN in x.exr"),
    "negative light": (paints(-1.0), "negative light"),
}


@pytest.mark.parametrize("name", PLANTED)
def test_control_the_judge_finds(tmp_path, name):
    command, what = PLANTED[name]
    mutant = SpoiledCommand(0, ("render", "--json"))
    found = run(
        mutant, tmp_path / "box", command, longest=0.2 if "hang" in name else 20
    )
    assert any(what in violation for violation in found.violations), found


@pytest.mark.parametrize(
    "command", [writes("{}\n"), writes(err=LINE, code=2), paints(0.5)]
)
def test_control_the_judge_is_content(tmp_path, command):
    argv = ("render",) if command is not PLANTED["no JSON"][0] else ()
    found = run(SpoiledCommand(0, argv), tmp_path / "box", command)
    assert not found.violations


def test_the_real_program_is_judged(tmp_path):
    found = run(SpoiledCommand(0, ("render", "x")), tmp_path / "box", main)
    assert found.code == 2
    assert found.err.startswith("restir: the following arguments are required")
    assert not list(violations(found, tmp_path / "box", late=False))

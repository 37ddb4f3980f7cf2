"""What needs no rendering answers at once: nothing heavy is imported for it."""

import ast
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

from restir_gi.reference.cli.main import COMMANDS, build_parser

ROOT = Path(__file__).parents[2]
HEAVY = {"numpy", "embreex", "scipy", "OpenEXR", "PIL", "matplotlib", "rich", "trimesh"}
SCRIPT = """
import sys
from restir_gi.reference.cli.main import main
code = main(sys.argv[1:])
sys.stdout.flush()
print()
print(sorted(set(sys.modules) & {heavy}), code)
"""


def loaded(*arguments):
    """Heavy modules that a command line imports, and its exit code."""
    result = subprocess.run(
        [sys.executable, "-c", SCRIPT.format(heavy=HEAVY), *arguments],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    names, _, code = result.stdout.splitlines()[-1].rpartition(" ")
    return set(ast.literal_eval(names)), int(code)


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (["--version"], 0),
        (["--help"], 0),
        ([], 0),
        (["rendr"], 2),
        (["--loud", "rendr"], 2),
        (["--loud"], 2),
    ],
)
def test_nothing_heavy_is_imported(arguments, code):
    assert loaded(*arguments) == (set(), code)


def test_control_a_command_imports_what_it_needs():
    found, code = loaded("compare", "--help")
    assert code == 0
    assert {"numpy", "rich"} <= found


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_is_what_the_table_says(name):
    """The table is known before the module is: its first line says the same."""
    module = import_module(f"restir_gi.reference.cli.{name.replace('-', '_')}")
    first = module.__doc__.partition("\n")[0]
    assert first == f"``restir {name}``: {COMMANDS[name]}"


def test_every_module_with_arguments_is_a_command():
    folder = ROOT / "reference" / "cli"
    sources = {path.stem: path.read_text() for path in folder.glob("*.py")}
    commands = {n.replace("_", "-") for n, s in sources.items() if "\ndef run(" in s}
    assert commands == COMMANDS.keys()


def test_one_command_is_enough_for_a_parser():
    """Others are named, and know no arguments."""
    parser = build_parser(["scenes"])
    assert parser.parse_args(["scenes", "--json"]).json
    assert set(COMMANDS) == set(parser._subparsers._group_actions[0].choices)

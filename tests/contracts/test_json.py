"""``--json`` of every command: one object, whose numbers are numbers."""

import argparse
import json
import re

import numpy as np
import pytest

from restir_gi.reference.cli import console
from restir_gi.reference.cli.main import build_parser, main
from restir_gi.reference.reports.comparison.likeness import SAME

NUMBER = re.compile(r"\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?\s*|nan|inf|-inf", re.I)
OTHER = {"True", "False", "true", "false", "None", "null"}  # "none" is a word, too
TEXTS = {"label"}  # what a knob was turned to, as it stands on the command line
SMALL = ("--size", "8x8")


def numbers_in_text(value, place=""):
    """Strings that ought to be numbers, booleans or null, and where they stand."""
    if isinstance(value, dict):
        return [
            found
            for key, item in value.items()
            if key not in TEXTS
            for found in numbers_in_text(item, f"{place}.{key}")
        ]
    if isinstance(value, list):
        return [f for v in value for f in numbers_in_text(v, f"{place}[]")]
    if isinstance(value, str) and (NUMBER.fullmatch(value) or value in OTHER):
        return [f"{place}={value!r}"]
    return []


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with two pictures that were rendered, and a golden folder's place."""
    folder = tmp_path_factory.mktemp("json")
    for name, method in (("a", "restir-gi-biased"), ("b", "path")):
        out = str(folder / f"{name}.exr")
        line = ["render", "cornell-box", "--method", method, *SMALL, "--out", out]
        assert main(line) == 0
    return folder


def lines(folder):
    """A quick command line of each command, and whether its verdict matters."""
    a, b = str(folder / "a.exr"), str(folder / "b.exr")
    new = str(folder / "new")
    quick = {
        "scenes": (),
        "render": ("cornell-box", "--method", "restir-gi-unbiased", "--frames", "2",
                   "--out", f"{new}.exr", *SMALL),
        "reference": ("cornell-box", "--spp", "2", "--out", f"{new}.exr", *SMALL),
        "compare": (a, b, "--tolerance", "0.5", "--out", new),
        "inspect": (a, "--out", f"{new}.html"),
        "plan": ("cornell-box", "--frames", "2", *SMALL),
        "check": ("float32", "--budget", "12"),
        "capture-template": ("--layout", "rtxdi", "--out", f"{new}-capture"),
        "demo": ("cornell-box", "--spp", "2", "--frames", "1", "--runs", "2",
                 "--out", new, *SMALL),
    }  # fmt: skip
    slow = {
        "golden": ("cornell-box", "--size", "8", "--out", f"{new}-golden"),
        "figures": ("jacobian", "--size", "16", "--runs", "2", "--out", new),
        "tradeoff": ("cornell-box", "--design", "0", "--runs", "3", "--frames", "1",
                     "--spp", "2", "--sweep", "radius=0.1,0.2", "--processes", "1",
                     "--out", f"{new}-tradeoff", *SMALL),
    }  # fmt: skip
    return quick, slow


def of_command(folder, capsys, name):
    """The object that a command writes."""
    quick, slow = lines(folder)
    code = main([name, *(quick | slow)[name], "--json"])
    out, err = capsys.readouterr()
    assert code in (0, 1, 3)
    assert err == ""
    return json.loads(out)


@pytest.mark.parametrize(
    "name",
    [
        "scenes",
        "render",
        "reference",
        "compare",
        "inspect",
        "plan",
        "capture-template",
    ],
)
def test_numbers_are_numbers(folder, capsys, name):
    assert numbers_in_text(of_command(folder, capsys, name)) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", ["check", "demo", "golden", "figures", "tradeoff"])
def test_numbers_are_numbers_in_what_takes_longer(folder, capsys, name):
    assert numbers_in_text(of_command(folder, capsys, name)) == []


def test_every_command_is_looked_at(folder):
    """A new command with --json has a line here."""
    quick, slow = lines(folder)
    (chosen,) = (
        action
        for action in build_parser()._actions
        if isinstance(action, argparse._SubParsersAction)
    )
    with_json = {
        name
        for name, parser in chosen.choices.items()
        if any("--json" in action.option_strings for action in parser._actions)
    }
    assert with_json == quick.keys() | slow.keys()


def test_metadata_of_a_picture(folder, capsys):
    words = of_command(folder, capsys, "render")["metadata"]
    assert words["frames"] == 2
    assert words["settings.temporal"] is True
    assert isinstance(words["settings.radius"], float)
    assert words["settings.target"] == "scattered"
    assert words["rays.primary"] == 64
    assert isinstance(words["seconds"], float)


def test_control_numbers_in_text_are_found():
    planted = {"a": [{"spp": "64"}], "b": "True", "c": "1e-3", "d": "-0.5", "e": "nan"}
    found = numbers_in_text(planted | {"fine": "0.1.0", "also": "64 spp", "n": 1.5})
    assert [place.partition("=")[0] for place in found] == [
        ".a[].spp", ".b", ".c", ".d", ".e",
    ]  # fmt: skip


def test_numbers_of_numpy(capsys):
    console.emit(
        {
            "a": np.float32(0.5),
            "b": np.int64(7),
            "c": np.bool_(True),
            "d": np.arange(3),
            "e": np.float64("nan"),
            "f": (np.float16("inf"), None, "text"),
        }
    )
    assert json.loads(capsys.readouterr().out) == {
        "a": 0.5, "b": 7, "c": True, "d": [0, 1, 2], "e": None,
        "f": [None, None, "text"],
    }  # fmt: skip


def test_what_has_no_form_is_refused_and_not_made_text():
    with pytest.raises(TypeError, match="complex"):
        console.emit({"a": 1j})


def test_differences_have_names(folder, capsys):
    found = of_command(folder, capsys, "compare")
    assert found["tolerance"] == 0.5
    assert found["within"] in (True, False)
    assert {one["what"] for one in found["differences"]} <= SAME.keys()

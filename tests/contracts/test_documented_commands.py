"""Commands of the documentation are understood, and run.

Every command of a shell block is parsed as it is printed.  Those of the pages below run
as they are printed, one after the other in one folder, with fewer pixels, frames and
samples: `smaller` puts these behind the words, where the last one counts.  What else
stands in a shell block is listed with the reason why it does not run here, and each
such reason must still be needed.
"""

import os
import re
import sys
from functools import cache

import pytest
import trimesh

from restir_gi.reference.cli.main import build_parser, main
from restir_gi.reference.reports.figures.registry import figure_names
from restir_gi.reference.system.errors import UsageError
from tests.captures.dump import dump
from tests.captures.engine import Engine
from tests.contracts.documented import (
    ROOT,
    commands_in,
    documented,
    in_prose,
    mentioned,
)

RUN = ("docs/tutorial/index.md", "docs/explanation/inspector.md", "docs/howto/index.md")
QUICK = RUN[:2]

ELSEWHERE = {
    "python3 -m venv": "an environment: .ci/run makes it by this very line",
    ".venv/bin/pip install": "an environment: .ci/run makes it by this very line",
    ".venv-test/bin/pip install": "an environment: .ci/run makes it",
    ".venv-docs/bin/pip install": "an environment: .ci/run makes it",
    ".venv-docs/bin/sphinx-build": "all pages: .ci/run builds them",
    ".venv-test/bin/python -m pytest": "these tests",
    ".ci/run": "these tests and more",
    "source .venv-test/bin/activate": "a shell's own; .ci/run",
    "pytest": "these tests",
    "ruff": "style: .ci/run",
    "mypy": "types: .ci/run",
    "lint-imports": "floors: .ci/run",
    "pre-commit install": "needs a package that is no dependency",
    "python -m tests.benchmarks": "hours; test_benchmarks.py parses what it starts",
    "python -m tests.extremes": "thousands; its tests run some of them",
    "python docs/examples/slang": "test_foreign_shaders.py compiles each pass",
    "g++": "test_foreign_cpp.py compiles and runs it",
    "pip install": "an environment: the tests' own has it",
}
"""Beginnings of commands of other programs, and why they do not run here."""

LONG = {
    "restir figures --out figures": "minutes at any size; test_figures.py draws each",
}
"""Commands of our own that are parsed and do not run, and why."""


parser = cache(build_parser)


def parsed(words):
    return parser().parse_args(list(words))


# ---------------------------------------------------------------- parsed


def ours():
    return sorted({c.asked for c in documented() if c.asked})


def name_of(words):
    return " ".join(words)[:60]


@pytest.mark.parametrize("words", ours(), ids=name_of)
def test_a_printed_command_is_understood(words):
    parsed(words)


def test_control_a_misspelt_option_is_not_understood():
    (command,) = commands_in("```sh\nrestir scenes --jsno  # text\n```\n")
    with pytest.raises(UsageError, match="--jsno"):
        parsed(command.asked)


def test_lines_are_read_as_a_shell_reads_them():
    text = """```sh
A=1 python -m x && .venv/bin/restir check 'a {b}' \\
    --out c # no
```"""
    found = [command.words for command in commands_in(text)]
    check = (".venv/bin/restir", "check", "a {b}", "--out", "c")
    assert found == [("python", "-m", "x"), check]
    assert list(commands_in("```python\nrestir nonsense\n```")) == []


def options_of(command, capsys):
    """All words of its help that begin with two dashes."""
    with pytest.raises(SystemExit):
        parsed([command, "--help"])
    return set(re.findall(r"--[a-z][a-z-]*", capsys.readouterr().out))


def faults(words, capsys):
    """Options and names of figures that there are not."""
    command, *rest = words
    options = {word.partition("=")[0] for word in rest if word.startswith("--")}
    unknown = options - options_of(command, capsys)
    if command == "figures":
        names = [word for word in rest if re.fullmatch("[a-z]+[a-z-]*", word)]
        unknown |= {name for name in names if name not in figure_names()}
    return unknown


def test_a_command_in_running_text_has_options_and_figures_that_there_are(capsys):
    found = [c for c in mentioned() if c.words != ("restir", "figures", "my-figure")]
    assert len(found) > 20
    for command in found:
        assert faults(command.asked, capsys) == set(), (command.page, command.text)


def test_control_of_running_text(capsys):
    text = "So `restir figures equal-tim --outt` says; `restir plan` says nothing."
    (command,) = in_prose(text)
    assert faults(command.asked, capsys) == {"--outt", "equal-tim"}


def usage():
    """Entries of the README's list of commands: name and text."""
    text = (ROOT / "README.md").read_text("utf-8")
    block = text.split("## The command line\n\n```\n")[1].split("```")[0]
    return [entry.partition(" ")[::2] for entry in block.split("restir ")[1:]]


def test_the_list_of_commands_is_whole_and_its_options_exist(capsys):
    with pytest.raises(SystemExit):
        parsed(["--help"])
    known = re.findall(r"^ {4}([a-z-]+)(?: |$)", capsys.readouterr().out, re.MULTILINE)
    listed = {name: text for name, text in usage() if not name.startswith("-")}
    assert sorted(listed) == sorted(known)
    for name, text in listed.items():
        named = set(re.findall(r"--[a-z][a-z-]*", text))
        assert named <= options_of(name, capsys), name


# ---------------------------------------------------------------- nothing is left out


def test_what_does_not_run_here_has_a_reason_and_every_reason_is_needed():
    others = [c.text for c in documented() if c.asked is None]
    used = {text: [b for b in ELSEWHERE if text.startswith(b)] for text in others}
    assert [text for text, reasons in used.items() if not reasons] == []
    assert {b for reasons in used.values() for b in reasons} == set(ELSEWHERE)
    assert set(LONG) <= {c.text for c in documented()}


def test_commands_of_our_own_on_other_pages_run_in_other_tests():
    """The demo by test_cli.py; foreign backends and frames by their own tests."""
    left = {c.text for c in documented() if c.asked and c.page not in RUN}
    assert left == {
        ".venv/bin/restir demo --out out",
        "restir check './restir_backend {directory}'",
        "restir check './restir_backend {directory} --plant jacobian-divided'"
        " --out report",
        "restir check docs/examples/arrays/backend.py",
        "restir check docs/examples/cuda/backend.py",
        "restir check docs/examples/wgsl/backend.py",
        "restir check docs/examples/wgsl/backend.py --out report",
        "restir check docs/examples/slang/backend.py",
        "restir check docs/examples/slang/backend.py --out report",
        "restir capture-template --layout rtxdi --size 640x360 --out capture",
        "restir check capture --out report",
    }


# ---------------------------------------------------------------- run

COUNTS = {"--frames": "2", "--spp": "2", "--runs": "3", "--budget": "4"}
SIZES = {
    "render": "16x16",
    "reference": "16x16",
    "demo": "16x16",
    "plan": "8x8",
    "tradeoff": "8x8",
    "golden": "8",
    "figures": "16",
}
ALWAYS = {
    "tradeoff": ("--runs", "3", "--frames", "2", "--spp", "2", "--processes", "1"),
    "figures": ("--runs", "4"),
    "check": ("--budget", "4"),
}


def smaller(words):
    """The words, and behind them a smaller size and smaller numbers."""
    command = words[0]
    more = list(ALWAYS.get(command, ()))
    for option, value in COUNTS.items():
        if option in words and option not in more:
            more += [option, value]
    if command in SIZES:
        more += ["--size", SIZES[command]]
    if command == "check" and "--size" in words:
        more += ["--size", "8"]
    return [*words, *more]


RENDERER = """#!/bin/sh
# my-renderer --scene S --seed N --frames F --size WxH --out X
exec {python} -m restir_gi.reference render "$2" --method restir-gi-unbiased \\
    --seed "$4" --frames "$6" --size "$8" --out "${{10}}"
"""

SCENE = """<scene version="3.0.0">
<sensor type="perspective"><transform name="to_world">
  <lookat origin="0, 1, 3" target="0, 0.5, 0" up="0, 1, 0"/></transform></sensor>
<shape type="rectangle"><transform name="to_world">
  <rotate x="1" angle="-90"/></transform></shape>
<shape type="rectangle"><transform name="to_world">
  <translate z="-1"/></transform></shape>
<shape type="rectangle"><transform name="to_world">
  <scale value="0.5"/><rotate x="1" angle="90"/><translate y="1.5"/></transform>
  <emitter type="area"><rgb name="radiance" value="5"/></emitter></shape>
</scene>
"""

BACKEND = """
from restir_gi.reference.oracle.builtin.backend import FLOAT32 as BACKEND
"""


PICTURES = {
    "mine": ("--method", "restir-gi-unbiased"),
    "theirs": ("--method", "restir-gi-unbiased", "--seed", "1", "--aov", "depth"),
    "unbiased": ("--method", "restir-gi-unbiased", "--seed", "2"),
    "biased": ("--method", "restir-gi-biased"),
    "truth": ("--method", "path", "--spp", "4"),
}


def render_pictures():
    for name, how in PICTURES.items():
        small = ["--size", "16x16", "--out", f"{name}.exr"]
        assert main(["render", "cornell-box", *how, *small]) == 0


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """What a reader has: a scene, a backend and a renderer of their own."""
    floor = trimesh.creation.box((4, 0.1, 4))
    chair = trimesh.creation.box((0.5, 1, 0.5))
    chair.apply_translation((0, 0.7, 0))
    kitchen = trimesh.Scene({"floor": floor, "chair": chair})
    (tmp_path / "kitchen.glb").write_bytes(kitchen.export(file_type="glb"))
    (tmp_path / "mine.xml").write_text(SCENE)
    (tmp_path / "mine.py").write_text(BACKEND)
    (tmp_path / "mine.toml").write_text('schema = "restir-declaration 1"\n')
    for name, body in (
        ("backend", "#!/bin/sh\nexit 0\n"),
        ("my-renderer", RENDERER.format(python=sys.executable)),
    ):
        (tmp_path / name).write_text(body)
        (tmp_path / name).chmod(0o755)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.setenv(
        "PYTHONPATH", os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    )
    return tmp_path


@pytest.mark.parametrize(
    "page",
    [
        pytest.param(page, marks=() if page in QUICK else pytest.mark.slow)
        for page in RUN
    ],
)
def test_the_commands_of_a_page_run(page, folder, capsys):
    """One after the other; a check of a second or four may stay undecided."""
    pytest.importorskip("mitsuba", reason="reads mine.xml")
    if page not in QUICK:
        render_pictures()
        assert main(["golden", "cornell-box", "--size", "8", "--out", "failing"]) == 0
    commands = [c for c in documented() if c.page == page and c.text not in LONG]
    ran = 0
    for command in commands:
        if command.asked is None:
            continue
        words = smaller(command.asked)
        if words[:2] == ["check", "frames"]:
            dump(Engine(16), folder / "frames", 2)  # what the reader's engine copies
        code = main(words)
        # A verdict on pictures that are small, of a sample or two, is as it may be.
        allowed = {0, 3} if words[0] == "check" else {0}
        # In so short a time not every pass that is required is judged.
        allowed |= {1} if {"--tolerance", "--require"} & set(words) else set()
        assert code in allowed, (command.text, capsys.readouterr())
        ran += 1
        capsys.readouterr()
    assert ran >= 3

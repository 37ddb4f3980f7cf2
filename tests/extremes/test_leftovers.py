"""What killed processes have left is swept; what others hold or own is not."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from restir_gi.reference.cli.main import main
from restir_gi.reference.cli.targets import MADE_BY, new_folder
from restir_gi.reference.oracle.verdict import Verdict
from restir_gi.reference.reports.verdict.page import write_page
from restir_gi.reference.reports.verdict.plain import as_plain
from restir_gi.reference.system.files import write_file
from restir_gi.reference.system.leftovers import (
    LOCK,
    part_beside,
    scratch_folder,
    sweep,
)

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no such locks there")

ROOT = Path(__file__).parents[2]

OURS = ".restir-0123456789abcdef.part"
OTHERS = [
    ".0123456789abcdef.part",
    "restir-0123456789abcdef.part",
    ".restir-0123456789abcdef.part.txt",
    ".restir-0123456789ABCDEF.part",
    "restir-cases-mine",
]


@pytest.fixture(autouse=True)
def next_process():
    """Folders are swept once a process: each test plays a new one."""
    sweep.cache_clear()


def test_a_part_without_a_writer_is_swept_by_the_next(tmp_path):
    for name in (OURS, *OTHERS):
        (tmp_path / name).write_bytes(b"half")
    write_file(tmp_path / "a", b"whole")
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted(["a", *OTHERS])


def test_a_folder_without_a_holder_is_swept_by_the_next(tmp_path):
    stale = tmp_path / "restir-cases-0123abcd"
    no_lock = tmp_path / "restir-cases-0123abce"
    link = tmp_path / "restir-cases-0123abcf"
    elsewhere = tmp_path / "elsewhere"
    for folder in (stale, no_lock, elsewhere):
        folder.mkdir()
        (folder / "numbers.raw").touch()
    (stale / LOCK).touch()
    (elsewhere / LOCK).touch()
    link.symlink_to(elsewhere)
    with scratch_folder("cases", tmp_path):
        assert not stale.exists()
        assert (no_lock / "numbers.raw").exists()
        assert (elsewhere / "numbers.raw").exists()


def test_what_is_held_is_left_alone(tmp_path):
    with (
        part_beside(tmp_path / "a") as (part, file),
        scratch_folder("golden", tmp_path) as folder,
    ):
        file.write(b"half")
        sweep.cache_clear()
        sweep(tmp_path)
        assert part.exists()
        assert folder.exists()
    assert list(tmp_path.iterdir()) == []


WRITER = """
import sys, time
from pathlib import Path
from restir_gi.reference.system.leftovers import part_beside, scratch_folder
place = Path(sys.argv[1])
with part_beside(place / "a") as (part, file), scratch_folder("render", place):
    (place / "ready").touch()
    time.sleep(300)
"""


def test_the_things_of_a_process_are_swept_when_it_was_killed_and_not_before(tmp_path):
    run = subprocess.Popen([sys.executable, "-c", WRITER, str(tmp_path)], cwd=ROOT)
    try:
        while not (tmp_path / "ready").exists():
            assert run.poll() is None
            time.sleep(0.02)
        before = sorted(os.listdir(tmp_path))
        assert len(before) == 3
        sweep(tmp_path)
        assert sorted(os.listdir(tmp_path)) == before
    finally:
        run.kill()
        run.wait()
    sweep.cache_clear()
    sweep(tmp_path)
    assert os.listdir(tmp_path) == ["ready"]


# ---------------------------------------------------------------- pages of others


def test_a_page_of_somebody_else_is_not_overwritten(tmp_path, capsys):
    page = tmp_path / "index.html"
    page.write_text("<!doctype html><title>my site</title>")
    for command in (["check", "float32"], ["compare", "a.exr", "b.exr"]):
        assert main([*command, "--out", str(tmp_path)]) == 2
        assert "index.html" in capsys.readouterr().err
    assert page.read_text() == "<!doctype html><title>my site</title>"


def test_a_page_of_ours_is_replaced(tmp_path):
    write_page(tmp_path, Verdict("PASS", [], [], [], []), NOTHING)
    assert new_folder(str(tmp_path)) == tmp_path


NOTHING = as_plain(Verdict("PASS", [], [], [], []), "nobody", {})


TEMPLATES = {path.name: path for path in ROOT.glob("reference/**/templates/*.html")}
NO_PAGES = {"page.html", "pieces.html", "cell.html"}  # frame, parts, and a notebook's
PAGES = sorted(TEMPLATES.keys() - NO_PAGES)


@pytest.mark.parametrize("name", PAGES)
def test_every_page_of_a_folder_says_who_made_it(name):
    """The frame does, before anything of a page; one page names no folder as ours."""
    frame, page = (TEMPLATES[n].read_bytes() for n in ("page.html", name))
    assert b"{% include" not in frame[: frame.index(MADE_BY)]
    assert b'{% extends "page.html" %}' in page.splitlines()[0]
    silent = name == "inspector.html"  # a file that is named by the user
    assert (b"{% block made_by %}" in page) == silent


def test_control_the_templates_are_those_of_all_pages():
    assert PAGES == [
        "comparison.html", "demo.html", "inspector.html", "pictures.html",
        "tradeoff.html", "verdict.html",
    ]  # fmt: skip

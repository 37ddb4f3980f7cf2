"""Every equation and algorithm of the papers leads to code, a test and a figure."""

import ast
import inspect
import json
import os
import re
import subprocess
import sys
from pkgutil import resolve_name

import pytest

from restir_gi.reference.reports.figures.registry import figure_names
from tests.contracts.traceability import PAGE, ROOT, entries, page, seen_link

PAPERS, ROWS = entries()
ALL = [(paper, number) for paper in PAPERS for number in ROWS[paper]]
every_row = pytest.mark.parametrize(
    ("paper", "number"), ALL, ids=lambda part: part.replace(" ", "")
)


@pytest.mark.parametrize("paper", PAPERS)
def test_no_number_is_missing(paper):
    about = PAPERS[paper]
    wanted = [f"Eq. {n}" for n in range(1, about["equations"] + 1)]
    wanted += [f"Alg. {n}" for n in range(1, about["algorithms"] + 1)]
    assert list(ROWS[paper]) == wanted


@every_row
def test_the_code_is_there(paper, number):
    found = resolve_name(ROWS[paper][number]["code"])
    assert callable(found)
    assert found.__doc__


@every_row
def test_the_test_is_there(paper, number):
    path, _, name = ROWS[paper][number]["test"].partition("::")
    tree = ast.parse((ROOT / path).read_text("utf-8"))
    functions = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
    assert name in functions


@every_row
def test_the_figure_is_there(paper, number):
    seen = ROWS[paper][number]["seen"]
    assert seen.startswith("lesson ") or seen in figure_names()
    assert seen_link(seen).startswith("["), f"no page of the gallery shows {seen}"


def test_what_the_code_cites_is_in_the_table():
    """No docstring cites an equation that the papers do not have."""
    numbers = {paper: set(ROWS[paper]) for paper in PAPERS}
    for folder in (
        "reference",
        "extensions",
        "hashgrid",
        "gradient_domain",
        "docs/figures",
    ):
        for source in (ROOT / folder).rglob("*.py"):
            text = source.read_text("utf-8")
            for paper, inside in re.findall(
                r"\[(Ouyang21|Boisse21|Wang25), ([^\]]*)\]", text
            ):
                for kind, number in re.findall(r"(Eq|Alg)s?\. (\d+)", inside):
                    assert f"{kind}. {number}" in numbers[paper], (source, inside)


def test_the_page_is_written():
    """``python -m tests.contracts.traceability`` writes it."""
    assert PAGE.read_text("utf-8") == page()


# ------------------------------------------------------- each test can fail

BROKEN = [
    (paper, number, change)
    for paper, number in ALL
    for change in range(len(ROWS[paper][number]["breaks"]))
]


def outcome(row, module, old, new):
    """How pytest ends on a row's test while one line of a module is another."""
    test = row["test"] + (f"[{row['case']}]" if "case" in row else "")
    words = ["-n", "0", "-q", "-x", "-m", "slow or not slow", test]
    return subprocess.run(
        [sys.executable, "-m", "pytest", "-p", "tests.contracts.broken", *words],
        cwd=ROOT,
        env={**os.environ, "RESTIR_BROKEN": json.dumps([module, old, new])},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.parametrize(("paper", "number", "change"), BROKEN)
@pytest.mark.few(6)
def test_the_test_fails_where_the_code_is_something_else(paper, number, change):
    """In the function that the row names: a test that cannot fail proves nothing."""
    row = ROWS[paper][number]
    module, _, _ = row["code"].partition(":")
    old, new = row["breaks"][change]
    ended = outcome(row, module, old, new)
    assert ended.returncode == 1, ended.stdout
    assert "1 failed" in ended.stdout


@pytest.mark.parametrize(("paper", "number"), [ALL[4], ALL[-1]])
def test_control_a_change_that_changes_nothing_is_survived(paper, number):
    row = ROWS[paper][number]
    module, _, _ = row["code"].partition(":")
    old, _ = row["breaks"][0]
    assert outcome(row, module, old, old).returncode == 0


@every_row
def test_every_change_has_its_place(paper, number):
    """In the module that the row names, once."""
    row = ROWS[paper][number]
    source = inspect.getsource(resolve_name(row["code"].partition(":")[0]))
    assert row["breaks"]
    for old, new in row["breaks"]:
        assert source.count(old) == 1, old
        assert new != old

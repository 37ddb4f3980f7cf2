"""Every equation and algorithm of the papers leads to code, a test and a figure."""

import ast
import re
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

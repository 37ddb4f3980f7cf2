"""The folder of a verdict: one page that needs nothing else, and its numbers."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from restir_gi.reference.images.display import encode_png
from restir_gi.reference.oracle.verdict import Verdict
from restir_gi.reference.reports.comparison.maps import ErrorMap
from restir_gi.reference.reports.page import render_page
from restir_gi.reference.reports.verdict.maps import error_maps
from restir_gi.reference.reports.verdict.table import (
    left_running,
    pieces,
    was_asked,
)
from restir_gi.reference.reports.verdict.worst import answers_of, worst_answer
from restir_gi.reference.system.files import make_folder, write_file
from restir_gi.reference.system.json_text import json_text

PACKAGE = "restir_gi.reference.reports.verdict"
"""Whose templates these are."""


def write_page(out: Path, verdict: Verdict, plain: Mapping[str, Any]) -> None:
    """Write ``verdict.json``, and last ``index.html``.

    Raises UsageError: the folder or a file cannot be written.

    Parameters
    ----------
    out : Path; folder; made if it is missing
    """
    page = page_of(verdict, plain)
    make_folder(out)
    write_file(out / "verdict.json", json_text(plain).encode())
    write_file(out / "index.html", page)


def page_of(verdict: Verdict, plain: Mapping[str, Any]) -> bytes:
    """The page alone, UTF-8."""
    maps = {one["name"]: _maps(verdict, one["name"]) for one in plain["passes"]}
    return _page(plain, maps)


def cell_of(verdict: Verdict, plain: Mapping[str, Any]) -> str:
    """The verdict in short, for a cell of a notebook: HTML with a table and pictures.

    A line for each pass that was asked; of the first wrong one, where it is wrong.
    """
    first = plain["first_wrong_pass"]
    of_frames = [a for a in answers_of(verdict, first) if a.probe.case.width]
    worst = worst_answer(of_frames)
    maps = [] if worst is None else error_maps(worst)
    values = {"verdict": plain, "maps": maps, "pictures": _encoded(maps)}
    return render_page(PACKAGE, "cell.html", values).decode()


def _maps(verdict: Verdict, pass_name: str) -> list[ErrorMap]:
    worst = worst_answer(answers_of(verdict, pass_name))
    return [] if worst is None else error_maps(worst)


def _page(plain: Mapping[str, Any], maps: Mapping[str, list[ErrorMap]]) -> bytes:
    pictures = {name: _encoded(each) for name, each in maps.items()}
    return render_page(
        PACKAGE,
        "verdict.html",
        {"verdict": plain, "maps": maps, "pictures": pictures},
        {
            "pieces": pieces,
            "left_running": left_running,
            "was_asked": lambda steps: [step for step in steps if was_asked(step)],
        },
    )


def _encoded(maps: Sequence[ErrorMap]) -> list[bytes]:
    return [encode_png(error.pixels()) for error in maps]

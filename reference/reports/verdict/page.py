"""The folder of a verdict: one page that needs nothing else, and its numbers."""

from collections.abc import Mapping
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


def write_page(out: Path, verdict: Verdict, plain: Mapping[str, Any]) -> None:
    """Write ``verdict.json``, and last ``index.html``.

    Raises UsageError: the folder or a file cannot be written.

    Parameters
    ----------
    out : Path; folder; made if it is missing
    """
    maps = {one["name"]: _maps(verdict, one["name"]) for one in plain["passes"]}
    page = _page(plain, maps)
    make_folder(out)
    write_file(out / "verdict.json", json_text(plain).encode())
    write_file(out / "index.html", page)


def _maps(verdict: Verdict, pass_name: str) -> list[ErrorMap]:
    worst = worst_answer(answers_of(verdict, pass_name))
    return [] if worst is None else error_maps(worst)


def _page(plain: Mapping[str, Any], maps: Mapping[str, list[ErrorMap]]) -> bytes:
    pictures = {
        name: [encode_png(error.pixels()) for error in each]
        for name, each in maps.items()
    }
    return render_page(
        "restir_gi.reference.reports.verdict",
        "verdict.html",
        {"verdict": plain, "maps": maps, "pictures": pictures},
        {
            "pieces": pieces,
            "left_running": left_running,
            "was_asked": lambda steps: [step for step in steps if was_asked(step)],
        },
    )

"""The folder of a verdict on pictures: a page that needs nothing else, its numbers."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from restir_gi.reference.images.display import encode_png
from restir_gi.reference.oracle.blackbox.judge import PicturesVerdict, with_error
from restir_gi.reference.reports.figures.canvas import png_of
from restir_gi.reference.reports.page import render_page
from restir_gi.reference.reports.pictures.chart import convergence
from restir_gi.reference.reports.pictures.maps import error_maps, shown, tints
from restir_gi.reference.reports.pictures.table import allowed, share
from restir_gi.reference.system.files import make_folder, write_file
from restir_gi.reference.system.json_text import json_text


def write_page(out: Path, verdict: PicturesVerdict, plain: Mapping[str, Any]) -> None:
    """Write ``verdict.json``, and last ``index.html``.

    Raises UsageError: the folder or a file cannot be written.

    Parameters
    ----------
    out : Path; folder; made if it is missing
    """
    page = _page(verdict, plain)
    make_folder(out)
    write_file(out / "verdict.json", json_text(plain).encode())
    write_file(out / "index.html", page)


def _page(verdict: PicturesVerdict, plain: Mapping[str, Any]) -> bytes:
    truth, mean = shown(verdict)
    tiles = [one for one in plain["means"] if one["x"] is not None]
    values = {
        "verdict": plain,
        "truth": truth,
        "mean": mean,
        "maps": error_maps(verdict),
        "grid": sorted(tiles, key=lambda one: (one["y"], one["x"])),
        "tints": tints(tiles),
        "charts": list(_charts(plain)),
    }
    return render_page(
        "restir_gi.reference.reports.pictures",
        "pictures.html",
        values,
        {
            "share": share,
            "allowed": allowed,
            "with_error": with_error,
            "png": encode_png,
        },
    )


def _charts(plain: Mapping[str, Any]) -> Iterator[tuple[str, bytes]]:
    """Of the picture and its worst tile; of those that should have light."""
    looks = plain["looks"]
    counts = [look["pictures"] for look in looks]
    known = (looks, [look["worst_tile"] for look in looks])
    for one, means in zip(plain["means"][:2], known, strict=False):
        if one["truth"]:
            margin = one["margin"]
            allowed_share = None if margin is None else margin / one["truth"]
            chart = convergence(counts, means, allowed_share)
            yield one["name"], png_of(chart)

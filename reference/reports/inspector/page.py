"""The page: one file that needs nothing else, with all numbers in it."""

import json
import zlib
from typing import Any

import numpy as np
from markupsafe import Markup

from restir_gi.reference.reports.page import base64, render_page
from restir_gi.reference.system.errors import UsageError

MOST = 256 << 20
"""Bytes of numbers: a browser still opens the page."""

SCRIPTS = ("data.js", "picture.js", "room.js", "tables.js", "main.js")


def page(title: str, runs: list[dict[str, Any]], exposure: float) -> bytes:
    """Write the page.  HTML.

    Raises UsageError: there are more numbers than a browser can be expected to hold.

    Parameters
    ----------
    runs : list of dict
        One or two of one size: ``label``, ``name``, ``words``, ``standing``,
        ``replayed``, ``width``, ``height`` and ``frames``.
    exposure : float; factor on the light that is shown
    """
    shown = ("width", "height", "frames")
    manifest, block = packed(
        {"runs": [{key: run[key] for key in shown} for run in runs]}
    )
    if len(block) > MOST:
        raise UsageError(
            f"the page would hold {len(block) >> 20} MiB of numbers, and {MOST >> 20}"
            " is the most: keep fewer frames with --last, or render a smaller picture"
        )
    manifest["exposure"] = exposure
    text = json.dumps(manifest, allow_nan=False).replace("<", "\\u003c")
    values = {
        "title": title,
        "runs": runs,
        "manifest": Markup(text),
        "block": base64(zlib.compress(block)),
        "scripts": SCRIPTS,
    }
    return render_page(
        "restir_gi.reference.reports.inspector", "inspector.html", values
    )


def packed(value: Any) -> tuple[Any, bytes]:
    """Nested structure, and the numbers of its arrays in one block.

    Parameters
    ----------
    value : dict, list, array, or anything of JSON
        Nested at will; an array that is met twice is kept once.

    Returns
    -------
    structure, bytes
        Arrays became ``{"kind", "offset", "length"}``, in units of bytes and numbers.
    """
    places: dict[int, Any] = {}
    block = bytearray()

    def put(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: put(item) for key, item in value.items()}
        if isinstance(value, list):
            return [put(item) for item in value]
        if not isinstance(value, np.ndarray):
            return value
        if id(value) not in places:
            block.extend(bytes(-len(block) % 8))
            place = {
                "kind": value.dtype.name,
                "offset": len(block),
                "length": value.size,
            }
            block.extend(np.ascontiguousarray(value).tobytes())
            places[id(value)] = place
        return places[id(value)]

    return put(value), bytes(block)

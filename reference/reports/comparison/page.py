"""The folder of a comparison: PNG pictures, and one page that needs nothing else."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from restir_gi.reference.images.display import encode_png, to_display
from restir_gi.reference.images.image import Image
from restir_gi.reference.reports.comparison.histogram import histogram_bars
from restir_gi.reference.reports.comparison.labels import NUMBERS
from restir_gi.reference.reports.comparison.likeness import SAME, differences
from restir_gi.reference.reports.comparison.maps import ErrorMap
from restir_gi.reference.reports.page import base64, render_page
from restir_gi.reference.system.files import make_folder, write_file

MOST_PROBED = 2**18  # pixels whose values the page carries: 8 MiB of text at most


def write_pages(
    out: Path,
    images: tuple[Image, Image],
    names: tuple[str, str],
    numbers: Mapping[str, Any],
    maps: Sequence[ErrorMap],
) -> None:
    """Write ``a.png``, ``b.png``, a PNG a map, and last ``index.html``.

    The page embeds the pictures, so it stays whole when it is moved or mailed, and
    an older page stays whole when this one cannot be written.

    Parameters
    ----------
    out : Path; folder; made if it is missing
    images : (Image, Image); A and the truth B; displayed at one exposure
    maps : sequence of ErrorMap; the signed difference first

    Raises
    ------
    UsageError
        The folder or a file cannot be written.
    """
    shown = [to_display(image.color, numbers["exposure"]) for image in images]
    files = {"a": encode_png(shown[0]), "b": encode_png(shown[1])}
    files |= {error.name: encode_png(error.pixels()) for error in maps}
    page = _page(images, names, numbers, maps, files)
    make_folder(out)
    for name, contents in files.items():
        write_file(out / f"{name}.png", contents)
    write_file(out / "index.html", page)


def _page(
    images: tuple[Image, Image],
    names: tuple[str, str],
    numbers: Mapping[str, Any],
    maps: Sequence[ErrorMap],
    files: Mapping[str, bytes],
) -> bytes:
    size = numbers["width"] * numbers["height"]
    metadata = [image.metadata for image in images]
    different = differences(*metadata)
    first = {SAME[one.what] for one in different}
    keys = {key for words in metadata for key in words}
    values = {
        "names": names,
        "numbers": numbers,
        "rows": [row for row in NUMBERS if numbers[row.name] is not None],
        "maps": maps,
        "pictures": files,
        "bars": histogram_bars(maps[0].values, maps[0].high),
        "differences": different,
        "keys": sorted(keys, key=lambda key: (key not in first, key)),
        "metadata": metadata,
        "probes": [_values(image) for image in images] if size <= MOST_PROBED else None,
    }
    return render_page(
        "restir_gi.reference.reports.comparison", "comparison.html", values
    )


def _values(image: Image) -> str:
    """Colours as base64 of little-endian float32, for the page's probe."""
    return base64(image.color.astype(np.dtype("<f4")).tobytes())

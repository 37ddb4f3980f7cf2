"""Parts of an OpenEXR file, judged before they are believed."""

import os
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from io import BytesIO, StringIO
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR

from restir_gi.reference.system.errors import UsageError

MAGIC = b"\x76\x2f\x31\x01"
MOST_PIXELS = 2**28  # 16384 x 16384
MOST_EXPANSION = 1100  # bytes in memory for one in the file: deflate ends at 1032
REC709 = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)


def decode(path: Path, contents: bytes, most_pixels: int = MOST_PIXELS) -> list[Any]:
    """Parts of a file that holds flat full frames of one size.

    At least one, with headers and single channels.

    Raises UsageError: not OpenEXR, truncated, corrupt, of absurd size, or no such
    frames.

    Parameters
    ----------
    most_pixels : int; that a part may have
    """
    if not contents.startswith(MAGIC):
        state = "not an OpenEXR file" if contents else "empty"
        raise UsageError(f"{path} is {state}; name an .exr file that a renderer wrote")
    try:
        with _silent():
            promised = OpenEXR.File(BytesIO(contents), header_only=True).parts
            for part in promised:
                _refuse_absurd_size(path, part.header, len(contents), most_pixels)
                _refuse_what_is_no_flat_frame(path, part.header)
            # Layers as single channels: merged, "RGB" might be R, G, B or its own name.
            parts = OpenEXR.File(BytesIO(contents), separate_channels=True).parts
    except (RuntimeError, ValueError, MemoryError) as error:
        is_text = isinstance(error, UnicodeDecodeError)
        problem = (
            "text that is not UTF-8" if is_text else "a header that makes no sense"
        )
        raise UsageError(f"{path} has {problem}; write the file again") from error
    # The library does not raise on bad pixels: it leaves the part out.
    if not parts or len(parts) < len(promised):
        raise UsageError(f"{path} is truncated or corrupt; write the file again")
    return list(parts)


def _refuse_absurd_size(
    path: Path, header: dict[str, Any], size: int, most_pixels: int
) -> None:
    """Raise before the library takes memory for what a corrupt header claims."""
    low, high = header["dataWindow"]
    width, height = (int(high[i]) - int(low[i]) + 1 for i in (0, 1))
    expanded = 4 * width * height * len(header["channels"])
    if width * height > most_pixels or expanded > 2**26 + MOST_EXPANSION * size:
        raise UsageError(
            f"{path} claims {width}x{height} pixels in {size} bytes; write it again, in"
            f" at most {most_pixels} pixels"
        )


def _refuse_what_is_no_flat_frame(path: Path, header: dict[str, Any]) -> None:
    """Raise unless all pixels of the part lie on the grid that the file shows."""
    data, display = (np.array(header[k]) for k in ("dataWindow", "displayWindow"))
    subsampled = [
        c.name for c in header["channels"] if (c.xSampling, c.ySampling) != (1, 1)
    ]
    primaries = header.get("chromaticities", REC709)
    if header["type"] not in (OpenEXR.scanlineimage, OpenEXR.tiledimage):
        problem = "holds deep samples; flatten it"
    elif not np.array_equal(data, display):
        problem = "holds a crop or an overscan; render the full frame alone"
    elif subsampled:
        problem = f"has subsampled channels {subsampled}; save it as RGB"
    elif not np.allclose(primaries, REC709, atol=1e-3):
        problem = "has other primaries than Rec. 709; convert it to linear sRGB"
    else:
        return
    raise UsageError(f"{path} {problem}")


@contextmanager
def _silent() -> Iterator[None]:
    """Keep the library's own lines about a bad file out of the output.

    It prints some to ``sys.stdout``, into the JSON, and its C core writes others to
    descriptor 2, past Python, beside the only line of an error.
    """
    with redirect_stdout(StringIO()), open(os.devnull, "wb") as null:
        saved = os.dup(2)
        os.dup2(null.fileno(), 2)
        try:
            yield
        finally:
            os.dup2(saved, 2)
            os.close(saved)

"""OpenEXR files: float32 layers and metadata, bit for bit, and foreign ones judged."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR

from reference.errors import UsageError
from reference.exr_channels import channels_of_layers, layers_of_channels
from reference.files import read_file, write_file
from reference.images import Image

PREFIX = "restir:"  # keeps our metadata apart from the standard's own attributes
MAGIC = b"\x76\x2f\x31\x01"
MOST_PIXELS = 2**28  # 16384 x 16384; a corrupt header can claim any size
REC709 = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)


def write_exr(path: Path, image: Image) -> None:
    """Write all layers as float32, losslessly compressed, with the metadata.

    Parameters
    ----------
    path : Path
        Replaced in one step.
    image : Image
        ``"color"`` becomes the channels R, G, B; a layer of three components
        ``name.R``, ``name.G``, ``name.B``; of one component ``name``.

    Raises
    ------
    UsageError
        The file cannot be written; see `write_file`.
    """
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    for key, text in image.metadata.items():
        # A path from the command line may hold bytes that are not text.
        header[PREFIX + key] = text.encode(errors="backslashreplace").decode()
    buffer = BytesIO()
    OpenEXR.File(header, channels_of_layers(image.layers)).write(buffer)
    write_file(path, buffer.getvalue())


def read_exr(path: Path) -> Image:
    """Read an image, ours or foreign.

    Parameters
    ----------
    path : Path
        Scan lines or tiles, half or float, one part or several of one size.

    Returns
    -------
    Image
        Colours as `layers_of_channels` finds them; NaN and infinities as they are.
        The metadata are the text attributes of the first part, ours without prefix.

    Raises
    ------
    UsageError
        Unreadable, not OpenEXR, truncated, corrupt, of absurd size, or not a flat
        full-frame image in Rec. 709 primaries.
    """
    parts = _decode(path, read_file(path))
    channels = {}
    for number, part in enumerate(parts):
        prefix = f"{part.name()}." if number else ""
        for name, channel in part.channels.items():
            channels[prefix + name] = channel.pixels.astype(np.float32)
    metadata = {
        name.removeprefix(PREFIX): text
        for name, text in parts[0].header.items()
        if isinstance(text, str)
    }
    return Image(layers_of_channels(channels, path), metadata)


def _decode(path: Path, contents: bytes) -> list[Any]:
    """Parts of the file, with pixels."""
    if not contents.startswith(MAGIC):
        state = "not an OpenEXR file" if contents else "empty"
        raise UsageError(f"{path} is {state}; name an .exr file that a renderer wrote")
    try:
        with _silent_stderr():
            promised = OpenEXR.File(BytesIO(contents), header_only=True).parts
            for part in promised:
                _refuse_what_is_no_flat_frame(path, part.header, promised[0].header)
            # Layers as single channels: merged, "RGB" might be R, G, B or its own name.
            parts = OpenEXR.File(BytesIO(contents), separate_channels=True).parts
    except (RuntimeError, ValueError, MemoryError) as error:
        raise UsageError(
            f"{path} has a header that cannot be understood ({error});"
            " write the file again"
        ) from error
    # The library does not raise on bad pixels: it leaves the part out.
    if not parts or len(parts) < len(promised):
        raise UsageError(f"{path} is truncated or corrupt; write the file again")
    return list(parts)


def _refuse_what_is_no_flat_frame(
    path: Path, header: dict[str, Any], first: dict[str, Any]
) -> None:
    """Raise unless all pixels of the part lie on the grid that the file shows."""
    data, display = (np.array(header[k]) for k in ("dataWindow", "displayWindow"))
    width, height = (data[1].astype(np.int64) - data[0] + 1).tolist()
    subsampled = [
        c.name for c in header["channels"] if (c.xSampling, c.ySampling) != (1, 1)
    ]
    primaries = header.get("chromaticities", REC709)
    if header["type"] not in (OpenEXR.scanlineimage, OpenEXR.tiledimage):
        problem = "holds deep samples; flatten it"
    elif width * height > MOST_PIXELS:
        problem = f"claims {width}x{height} pixels; the most is {MOST_PIXELS}"
    elif not np.array_equal(data, display):
        problem = "holds a crop or an overscan; render the full frame alone"
    elif not np.array_equal(data, first["dataWindow"]):
        problem = "has parts of different sizes; save them to files of their own"
    elif subsampled:
        problem = f"has subsampled channels {subsampled}; save it as RGB"
    elif not np.allclose(primaries, REC709, atol=1e-3):
        problem = "has other primaries than Rec. 709; convert it to linear sRGB"
    else:
        return
    raise UsageError(f"{path} {problem}")


@contextmanager
def _silent_stderr() -> Iterator[None]:
    """Keep the library's C core from adding its own lines to the one error line."""
    if sys.stderr is None:  # closed by the caller: descriptor 2 may be any file now
        yield
        return
    saved = os.dup(2)
    try:
        with open(os.devnull, "wb") as null:
            os.dup2(null.fileno(), 2)
        yield
    finally:
        os.dup2(saved, 2)
        os.close(saved)

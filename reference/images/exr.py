"""OpenEXR files: layers and metadata, bit for bit, and what foreign ones hold."""

from io import BytesIO
from pathlib import Path

import numpy as np
import OpenEXR

from restir_gi.reference.images.exr_channels import (
    channels_of_layers,
    layers_of_channels,
)
from restir_gi.reference.images.exr_parts import decode
from restir_gi.reference.images.image import Image
from restir_gi.reference.system.files import read_file, write_file

PREFIX = "restir:"  # keeps our metadata apart from the standard's own attributes


def write_exr(path: Path, image: Image) -> None:
    """Write all layers as float32, losslessly compressed, with the metadata.

    Parameters
    ----------
    path : Path; replaced in one step
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


def read_exr(path: Path, layer: str | None = None) -> Image:
    """Read an image, ours or foreign.

    Parameters
    ----------
    path : Path; scan lines or tiles, half or float, one part or several of one size
    layer : str, optional
        Which of several pictures is the colour; see `layers_of_channels`.

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
    parts = decode(path, read_file(path))
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
    return Image(layers_of_channels(channels, path, layer), metadata)

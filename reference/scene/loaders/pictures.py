"""Picture files as linear colours: textures and environment maps."""

import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from reference.arrays import Scalars, Vec3s
from reference.errors import UsageError
from reference.exr import read_exr
from reference.files import read_file
from reference.scene.loaders.ledger import Ledger

if TYPE_CHECKING:
    from PIL import Image

RESOLUTION = re.compile(rb"-Y (\d+) \+X (\d+)")


def decode_srgb(encoded: Scalars) -> Scalars:
    """Linear light of encoded values in [0, 1], exactly by IEC 61966-2-1.

    Parameters
    ----------
    encoded : (...) float64
        As stored in a picture.

    Returns
    -------
    (...) float64
        c / 12.92 up to 0.04045, ((c + 0.055) / 1.055)^2.4 above.
    """
    power = ((encoded + 0.055) / 1.055) ** 2.4
    linear: Scalars = np.where(encoded <= 0.04045, encoded / 12.92, power)
    return linear


def read_picture(path: Path, ledger: Ledger, raw: bool = False) -> Vec3s:
    """Linear colours of a picture file.

    Parameters
    ----------
    path : Path
        What Pillow reads (PNG, JPEG, ...: sRGB), or .exr or .hdr (linear).
    ledger : Ledger
        Takes the notes.
    raw : bool
        The values are linear already, whatever the format.

    Returns
    -------
    (h, w, 3) float64
        Row 0 is the top.

    Raises
    ------
    UsageError
        Missing, or not a picture.
    """
    suffix = path.suffix.lower()
    if suffix == ".exr":
        return read_exr(path).color.astype(np.float64)
    contents = read_file(path)
    if suffix in (".hdr", ".rgbe", ".pic"):
        return decode_radiance_hdr(contents, path)
    return decode_picture(contents, str(path), ledger, raw)


def decode_picture(
    contents: bytes, name: str, ledger: Ledger, raw: bool = False
) -> Vec3s:
    """Linear colours of a picture in memory.

    Parameters
    ----------
    contents : bytes
        What Pillow reads.
    name : str
        For messages.
    ledger : Ledger
        Takes the notes.
    raw : bool
        The values are linear already.

    Returns
    -------
    (h, w, 3) float64
        In [0, 1]; the alpha channel is ignored.

    Raises
    ------
    UsageError
        Not a picture, or truncated.
    """
    with _opened(contents, name) as picture:
        deep = picture.mode.startswith("I;16")
        stored = np.asarray(picture if deep else picture.convert("RGB"))
    if deep:
        encoded = np.repeat(stored[..., None] / 65535.0, 3, axis=-1)
    else:
        encoded = stored / 255.0
        if contents.startswith(b"\x89PNG") and contents[24] == 16:
            ledger.note(f"{name} has 16 bits a channel and is read with 8")
    return encoded if raw else decode_srgb(encoded)


def decode_alpha(contents: bytes, name: str) -> Scalars:
    """Opacity of a picture in memory.

    Parameters
    ----------
    contents : bytes
        What Pillow reads.
    name : str
        For messages.

    Returns
    -------
    (h, w) float64
        In [0, 1]; 1 everywhere where the picture has no transparency.

    Raises
    ------
    UsageError
        Not a picture, or truncated.
    """
    with _opened(contents, name) as picture:
        if not picture.has_transparency_data:
            return np.ones((picture.height, picture.width))
        return np.asarray(picture.convert("RGBA"))[..., 3] / 255.0


def picture_size(contents: bytes, name: str) -> tuple[int, int]:
    """Width and height of a picture in memory, before it is decoded.

    Parameters
    ----------
    contents : bytes
        What Pillow reads.
    name : str
        For messages.

    Returns
    -------
    int, int
        As its header promises.

    Raises
    ------
    UsageError
        Not a picture.
    """
    with _opened(contents, name) as picture:
        return picture.size


@contextmanager
def _opened(contents: bytes, name: str) -> Iterator["Image.Image"]:
    from PIL import Image

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            picture = Image.open(BytesIO(contents))
        with picture:
            yield picture
    # Pillow's decoders raise OSError, SyntaxError, ValueError, struct.error, ...; what
    # they say is about their own insides.
    except Exception as error:
        raise UsageError(
            f"{name} cannot be read as a picture: it is damaged, too large, or of"
            " another kind than PNG, JPEG, EXR and HDR"
        ) from error


def decode_radiance_hdr(contents: bytes, path: Path) -> Vec3s:
    """Radiance of a Radiance .hdr file.

    Parameters
    ----------
    contents : bytes
        The file.
    path : Path
        For messages.

    Returns
    -------
    (h, w, 3) float64
        (R, G, B) · 2^(E - 136).

    Raises
    ------
    UsageError
        Not such a file, truncated, or of the layout of before 1991.
    """
    head, separator, body = contents.partition(b"\n\n")
    line, _, data = body.partition(b"\n")
    size = RESOLUTION.fullmatch(line)
    if not head.startswith(b"#?") or not separator or not size:
        raise UsageError(f"{path} is no Radiance file with rows from the top left")
    height, width = int(size[1]), int(size[2])
    packed = len(data) != 4 * width * height
    try:
        rgbe = _unpack(data, height, width) if packed else np.frombuffer(data, np.uint8)
        channels = rgbe.reshape(height, width, 4).astype(np.float64)
    except (IndexError, ValueError) as error:
        raise UsageError(f"{path} is truncated or corrupt") from error
    return np.ldexp(channels[..., :3], channels[..., 3:].astype(np.int64) - 136)


def _unpack(data: bytes, height: int, width: int) -> Scalars:
    rows = np.empty((height, 4, width), np.uint8)
    at = 0
    for row in rows:
        if data[at : at + 4] != bytes([2, 2, width >> 8, width & 255]):
            raise ValueError("no run-length encoded row")
        at += 4
        for channel in row:
            x = 0
            while x < width:
                count = data[at]
                run = count > 128
                count -= 128 if run else 0
                stop = at + 1 + (1 if run else count)
                if count == 0 or x + count > width or stop > len(data):
                    raise ValueError("a run leaves its row")
                channel[x : x + count] = np.frombuffer(data[at + 1 : stop], np.uint8)
                x, at = x + count, stop
    return rows.transpose(0, 2, 1)

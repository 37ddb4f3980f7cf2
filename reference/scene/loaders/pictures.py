"""Picture files as linear colours: textures and environment maps."""

import re
import warnings
from io import BytesIO
from typing import Literal

import numpy as np

from restir_gi.reference.images.exr import read_exr
from restir_gi.reference.numerics.arrays import Scalars, Vec3s
from restir_gi.reference.scene.loaders.ledger import Ledger
from restir_gi.reference.system.errors import UsageError

FORMATS = ("PNG", "JPEG", "BMP", "TGA", "TIFF", "GIF", "WEBP", "PPM")
PICTURE_BYTES = 32  # of memory a pixel: three float64 beside what Pillow holds
HDR_BYTES = 72  # of memory a pixel: six float64, the exponents, and the packed bytes
RESOLUTION = re.compile(rb"-Y (\d{1,6}) \+X (\d{1,6})")


def decode_srgb(encoded: Scalars) -> Scalars:
    """Linear light of encoded values in [0, 1], exactly by IEC 61966-2-1.

    Parameters
    ----------
    encoded : (...) float64; as stored in a picture

    Returns
    -------
    (...) float64; c / 12.92 up to 0.04045, ((c + 0.055) / 1.055)^2.4 above
    """
    power = ((encoded + 0.055) / 1.055) ** 2.4
    linear: Scalars = np.where(encoded <= 0.04045, encoded / 12.92, power)
    return linear


def read_picture(name: str, ledger: Ledger, raw: bool = False) -> Vec3s:
    """Linear colours of a picture file, (h, w, 3) float64; row 0 is the top.

    Parameters
    ----------
    name : str
        Path from the scene's folder, or an absolute one, of what Pillow reads (PNG,
        JPEG, ...: sRGB), or of an .exr or .hdr file (linear).
    ledger : Ledger; of the scene: it says which files may be read, and takes the notes
    raw : bool; the values are linear already, whatever the format

    Raises
    ------
    UsageError
        Missing, or not a picture.
    """
    path = ledger.locate(name)
    suffix = path.suffix.lower()
    if suffix == ".exr":
        return read_exr(path).color.astype(np.float64)
    contents = ledger.read(name)
    if suffix in (".hdr", ".rgbe", ".pic"):
        return decode_radiance_hdr(contents, name, ledger)
    return decode_picture(contents, name, ledger, raw)


def decode_picture(
    contents: bytes, name: str, ledger: Ledger, raw: bool = False
) -> Vec3s:
    """Linear colours of a picture in memory.

    Parameters
    ----------
    ledger : Ledger; of the scene: it bounds the memory, and takes the notes
    raw : bool; the values are linear already

    Returns
    -------
    (h, w, 3) float64; in [0, 1]; the alpha channel is ignored

    Raises
    ------
    UsageError
        Not a picture, truncated, or of more pixels than its bytes make believable.
    """
    stored = _stored(contents, name, ledger, "RGB")
    if stored.dtype == np.uint16:
        return np.repeat(_decoded(stored, raw)[..., None], 3, axis=-1)
    if contents.startswith(b"\x89PNG") and contents[24] == 16:
        ledger.note(f"{name} has 16 bits a channel and is read with 8")
    return _decoded(stored, raw)


def decode_alpha(contents: bytes, name: str, ledger: Ledger) -> Scalars:
    """Alpha channel of a picture in memory.

    Parameters
    ----------
    ledger : Ledger; of the scene: it bounds the memory

    Returns
    -------
    (h, w) float64; in [0, 1]; 1 everywhere if the picture has none

    Raises
    ------
    UsageError
        As of `decode_picture`.
    """
    stored = _stored(contents, name, ledger, "RGBA")
    if stored.ndim == 2:  # 16 bits of grey
        return np.ones(stored.shape)
    return _decoded(stored[..., 3], True)


def read_mask(name: str, ledger: Ledger) -> Vec3s:
    """How opaque a picture file says that a surface is.

    Parameters
    ----------
    name : str; path from the scene's folder, or an absolute one

    Returns
    -------
    (h, w, 3) float64
        The alpha channel where the picture has one, else its grey; three times.

    Raises
    ------
    UsageError
        Missing, or not a picture.
    """
    stored = _stored(ledger.read(name), name, ledger, "alpha")
    return np.repeat(_decoded(stored, True)[..., None], 3, axis=-1)


def _stored(
    contents: bytes, name: str, ledger: Ledger, wanted: Literal["RGB", "RGBA", "alpha"]
) -> Scalars:
    """Numbers as the picture stores them: (h, w, 3 or 4) or, of one channel, (h, w)."""
    from PIL import Image

    try:
        with warnings.catch_warnings():  # Pillow warns of what it thinks too large
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            picture = Image.open(BytesIO(contents), formats=FORMATS)
        with picture:
            width, height = picture.size
            _take(width * height * PICTURE_BYTES, name, picture.size, contents, ledger)
            if picture.mode in ("I", "F"):
                raise OSError("it has 32 bits a channel")
            if picture.mode.startswith("I;16"):
                return np.asarray(picture).astype(np.uint16)
            if wanted == "alpha":
                has_alpha = "A" in picture.getbands() or "transparency" in picture.info
                if has_alpha:
                    return np.asarray(picture.convert("RGBA").getchannel("A"))
                return np.asarray(picture.convert("L"))
            same = picture.mode == wanted
            return np.asarray(picture if same else picture.convert(wanted))
    except UsageError:
        raise
    except (Image.DecompressionBombWarning, Image.DecompressionBombError) as error:
        raise UsageError(
            f"{name} claims too many pixels; {Image.MAX_IMAGE_PIXELS:,} can be read"
        ) from error
    # Pillow's decoders raise OSError, SyntaxError, ValueError, struct.error, ...
    except Exception as error:
        raise UsageError(
            f"{name} is damaged, or not a picture of a format that can be read:"
            f" {', '.join(FORMATS)}, EXR or HDR, with 8 bits a channel or 16 of grey"
        ) from error


def _decoded(stored: Scalars, raw: bool) -> Scalars:
    """Values in [0, 1]; a table is as exact as the formula and takes less memory."""
    table = np.arange(np.iinfo(stored.dtype).max + 1) / np.iinfo(stored.dtype).max
    decoded: Scalars = (table if raw else decode_srgb(table))[stored]
    return decoded


def _take(
    memory: int, name: str, size: tuple[int, int], contents: bytes, ledger: Ledger
) -> None:
    width, height = size
    ledger.take(
        memory, f"{name} claims {width}x{height} pixels in {len(contents):,} bytes"
    )


def decode_radiance_hdr(contents: bytes, name: str, ledger: Ledger) -> Vec3s:
    """Radiance of a Radiance .hdr file, (h, w, 3) float64; (R, G, B) · 2^(E - 136).

    Parameters
    ----------
    ledger : Ledger; of the scene: it bounds the memory

    Raises
    ------
    UsageError
        Not such a file, truncated, of the layout of before 1991, or of more pixels
        than its bytes make believable.
    """
    head, separator, body = contents.partition(b"\n\n")
    line, _, data = body.partition(b"\n")
    size = RESOLUTION.fullmatch(line)
    if not head.startswith(b"#?") or not separator or not size:
        raise UsageError(f"{name} is not a Radiance file with rows from the top left")
    height, width = int(size[1]), int(size[2])
    if not height or not width:
        raise UsageError(f"{name} has no pixels; {width}x{height} in its header")
    _take(width * height * HDR_BYTES, name, (width, height), contents, ledger)
    packed = len(data) != 4 * width * height
    try:
        rgbe = _unpack(data, height, width) if packed else np.frombuffer(data, np.uint8)
        channels = rgbe.reshape(height, width, 4)
    except (IndexError, ValueError) as error:
        raise UsageError(f"{name} is truncated or corrupt") from error
    exponents = channels[..., 3:].astype(np.int32) - 136
    return np.ldexp(channels[..., :3].astype(np.float64), exponents)


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

"""glTF textures: pictures, how they go on beyond their edges, and where they lie."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars, Vec3s
from restir_gi.reference.scene.loaders.gltf_buffers import (
    Document,
    resolve_uri,
    view_bytes,
)
from restir_gi.reference.scene.loaders.gltf_check import replace_word
from restir_gi.reference.scene.loaders.gltf_forms import shown
from restir_gi.reference.scene.loaders.ledger import Ledger
from restir_gi.reference.scene.loaders.pictures import decode_alpha, decode_picture
from restir_gi.reference.scene.textures import Bitmap, Wrap
from restir_gi.reference.system.errors import UsageError

WRAPS: dict[int, Wrap] = {10497: "repeat", 33648: "mirror", 33071: "clamp"}
REPEAT, NEAREST = 10497, 9728

Decoder = Callable[[bytes, str, Ledger], Scalars]
Reference = Mapping[str, Any]
"""Of a material to a texture."""


def read_colors(document: Document, texture: Reference, where: str) -> Vec3s:
    """Linear colours of a texture whose picture is in sRGB.

    Returns (h, w, 3) float64; mid grey where a lenient loader cannot read it.
    """
    grey = np.full((1, 1, 3), 0.5)
    return _decoded(document, texture, where, "colors", decode_picture, grey)


def read_numbers(document: Document, texture: Reference, where: str) -> Vec3s:
    """Values of a texture as they are stored.

    Returns
    -------
    (h, w, 3) float64; in [0, 1]; one half where a lenient loader cannot read it
    """
    half = np.full((1, 1, 3), 0.5)
    return _decoded(
        document, texture, where, "numbers", partial(decode_picture, raw=True), half
    )


def read_alpha(document: Document, texture: Reference, where: str) -> Scalars:
    """Alpha of a texture.

    Returns (h, w) float64; in [0, 1]; 1 where a lenient loader cannot read it.
    """
    opaque = np.ones((1, 1))
    return _decoded(document, texture, where, "alpha", decode_alpha, opaque)


def bitmap(document: Document, texture: Reference, pixels: Vec3s) -> Bitmap:
    """Texture with the sampler that the file gives it.

    Parameters
    ----------
    pixels : (h, w, 3) float64; what it shows

    Returns
    -------
    Bitmap; bilinear unless the file wants the nearest texel
    """
    entry = document.entry("textures", texture["index"])
    sampler = {}
    if "sampler" in entry:
        sampler = document.entry("samplers", entry["sampler"])
    # Upside down, a mirrored picture is the same as a picture mirrored.
    wraps = (sampler.get("wrapS", REPEAT), sampler.get("wrapT", REPEAT))
    return Bitmap(
        pixels=pixels,
        filter="nearest" if sampler.get("magFilter") == NEAREST else "bilinear",
        wrap=(WRAPS[wraps[0]], WRAPS[wraps[1]]),
    )


def placement(texture: Reference) -> tuple[int, Scalars]:
    """Which texture coordinates a texture reads, and what becomes of them first.

    Returns
    -------
    int and (3, 3) float64
        Number of the set, and the matrix of KHR_texture_transform (translation ·
        rotation · scale) in glTF's frame, v downwards.
    """
    given = texture.get("extensions", {}).get("KHR_texture_transform", {})
    offset = given.get("offset", [0.0, 0.0])
    scale = given.get("scale", [1.0, 1.0])
    c, s = np.cos(given.get("rotation", 0.0)), np.sin(given.get("rotation", 0.0))
    turned = np.array([[c, s], [-s, c]]) * scale
    matrix = np.block([[turned, np.reshape(offset, (2, 1))], [np.eye(3)[2:]]])
    return given.get("texCoord", texture.get("texCoord", 0)), matrix


def _decoded(
    document: Document,
    texture: Reference,
    where: str,
    purpose: str,
    decode: Decoder,
    otherwise: Scalars,
) -> Scalars:
    source = _source(document, texture, where)
    if source is None:
        return otherwise
    name = f"image {source}"
    known = document.pictures.get((source, purpose))
    if known is not None:
        # A factor makes another picture of it.
        document.claim(2 * known.nbytes, f"{where} reads {name} once more")
        return known
    image = document.entry("images", source)
    contents = b""
    if "bufferView" in image:
        contents = bytes(view_bytes(document, image["bufferView"]))
    try:
        if "bufferView" not in image:
            contents = _linked(document, image)
        pixels = document.pictures[source, purpose] = decode(
            contents, name, document.ledger
        )
    except UsageError as error:
        _unreadable(document, texture, where, f"{name}: {error}")
        return otherwise
    document.claim(2 * pixels.nbytes, f"{where} reads {name}")
    return pixels


def _source(document: Document, texture: Reference, where: str) -> int | None:
    entry = document.entry("textures", texture["index"])
    webp = entry.get("extensions", {}).get("EXT_texture_webp", {})
    source: int | None = webp.get("source", entry.get("source"))
    if source is None:
        others = ", ".join(map(shown, entry.get("extensions", {}))) or "nothing else"
        _unreadable(document, texture, where, f"it has no source, but {others}")
    return source


def _linked(document: Document, image: Mapping[str, Any]) -> bytes:
    if "uri" not in image:
        raise UsageError("it has neither a uri nor a bufferView")
    return resolve_uri(image["uri"], document)


def _unreadable(
    document: Document, texture: Reference, where: str, reason: str
) -> None:
    problem = f"texture {texture['index']}: {reason}"
    row = "texture", "no source that can be read"
    replace_word(document.ledger, *row, where, problem)

"""glTF 2.0 containers: JSON, buffers, and accessors as arrays."""

import base64
import json
from dataclasses import dataclass
from typing import Any
from urllib.parse import unquote_to_bytes

import numpy as np

from reference.arrays import Scalars
from reference.errors import UsageError
from reference.scene.loaders.ledger import Ledger

MAGIC, JSON_CHUNK, BINARY_CHUNK = b"glTF", b"JSON", b"BIN\0"
COMPONENTS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2"}
COMPONENTS |= {5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


@dataclass(frozen=True, slots=True)
class Document:
    """A glTF file with its buffers.

    Attributes
    ----------
    tree : dict
        The JSON.
    buffers : list of bytes
        As the JSON lists them.
    ledger : Ledger
        Of this file.
    """

    tree: dict[str, Any]
    buffers: list[bytes]
    ledger: Ledger


def read_document(ledger: Ledger) -> Document:
    """Open a .gltf or .glb file.

    Parameters
    ----------
    ledger : Ledger
        Of this file.

    Returns
    -------
    Document
        With all its buffers.

    Raises
    ------
    UsageError
        No glTF 2 file, truncated, or with a buffer missing.
    """
    contents = ledger.contents()
    binary = b""
    if contents.startswith(MAGIC):
        contents, binary = _split_glb(contents, ledger)
    tree = json.loads(contents.decode("utf-8"))
    version = str(tree["asset"]["version"])
    if version.split(".")[0] != "2":
        ledger.stop(f"this is glTF {version}; version 2.0 can be read")
    buffers = []
    for i, entry in enumerate(tree.get("buffers", [])):
        try:
            data = resolve_uri(entry["uri"], ledger) if "uri" in entry else binary
        except UsageError as error:
            ledger.stop(f"buffer {i}: {error}")
        if len(data) < entry["byteLength"]:
            ledger.stop(
                f"buffer {i} has {len(data)} of its {entry['byteLength']} bytes;"
                " the file is truncated"
            )
        buffers.append(data)
    return Document(tree, buffers, ledger)


def _split_glb(contents: bytes, ledger: Ledger) -> tuple[bytes, bytes]:
    version, length = np.frombuffer(contents[4:12], "<u4").tolist()
    if version != 2:
        ledger.stop(f"this is binary glTF {version}; version 2 can be read")
    if length > len(contents):
        ledger.stop(f"the file is truncated: {len(contents)} of {length} bytes")
    chunks: dict[bytes, bytes] = {}
    at = 12
    while at + 8 <= length:
        size = int(np.frombuffer(contents[at : at + 4], "<u4")[0])
        kind = contents[at + 4 : at + 8]
        chunks.setdefault(kind, contents[at + 8 : at + 8 + size])
        at += 8 + size
    return chunks[JSON_CHUNK], chunks.get(BINARY_CHUNK, b"")


def resolve_uri(uri: str, ledger: Ledger) -> bytes:
    """Contents of a file beside the scene, or of a data URI.

    Parameters
    ----------
    uri : str
        Relative path, percent-encoded, or ``data:...;base64,...``.
    ledger : Ledger
        Of the scene file.

    Returns
    -------
    bytes
        All of it.

    Raises
    ------
    UsageError
        The file cannot be read.
    """
    if uri.startswith("data:"):
        header, _, payload = uri.partition(",")
        if header.endswith(";base64"):
            return base64.b64decode(payload, validate=True)
        return unquote_to_bytes(payload)
    return ledger.read(unquote_to_bytes(uri).decode("utf-8"))


def view_bytes(document: Document, index: int) -> bytes:
    """Bytes of a buffer view.

    Parameters
    ----------
    document : Document
        The file.
    index : int
        Of the view.

    Returns
    -------
    bytes
        Its part of its buffer.
    """
    view = document.tree["bufferViews"][index]
    start = view.get("byteOffset", 0)
    data: bytes = document.buffers[view["buffer"]][start : start + view["byteLength"]]
    if len(data) < view["byteLength"]:
        document.ledger.stop(f"buffer view {index} reaches beyond its buffer")
    return data


def read_accessor(document: Document, index: int) -> Scalars:
    """Values of an accessor.

    Parameters
    ----------
    document : Document
        The file.
    index : int
        Of the accessor.

    Returns
    -------
    (count, width) int64 or float64
        Normalized integers as the fractions that they stand for.
    """
    entry = document.tree["accessors"][index]
    count, width = entry["count"], WIDTHS[entry["type"]]
    kind = np.dtype(COMPONENTS[entry["componentType"]])
    values = np.zeros((count, width), kind)
    if "bufferView" in entry:
        start = entry.get("byteOffset", 0)
        values = _elements(document, entry["bufferView"], start, count, width, kind)
    if "sparse" in entry:
        sparse = entry["sparse"]
        at, new = sparse["indices"], sparse["values"]
        where = _elements(
            document,
            at["bufferView"],
            at.get("byteOffset", 0),
            sparse["count"],
            1,
            np.dtype(COMPONENTS[at["componentType"]]),
        )
        values = values.copy()
        values[where[:, 0]] = _elements(
            document,
            new["bufferView"],
            new.get("byteOffset", 0),
            sparse["count"],
            width,
            kind,
        )
    if kind.kind == "f":
        return values.astype(np.float64)
    if entry.get("normalized", False):
        return np.maximum(values / float(np.iinfo(kind).max), -1.0)
    return values.astype(np.int64)


def _elements(
    document: Document, view: int, start: int, count: int, width: int, kind: Any
) -> Scalars:
    data = view_bytes(document, view)
    size = width * kind.itemsize
    stride = document.tree["bufferViews"][view].get("byteStride", size)
    if count < 0 or start + (count - 1) * stride + size > len(data):
        document.ledger.stop(f"an accessor reads beyond buffer view {view}")
    return np.ndarray((count, width), kind, data, start, (stride, kind.itemsize))

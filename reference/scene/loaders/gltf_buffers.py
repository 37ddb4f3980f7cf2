"""glTF 2.0 containers: JSON, buffers, and accessors as arrays.

Everything is held against the bytes that there are before an array is made of it.
"""

import base64
import binascii
import json
import re
from dataclasses import dataclass, field
from typing import Any, NoReturn
from urllib.parse import unquote_to_bytes

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.scene.loaders.gltf_forms import shown
from restir_gi.reference.scene.loaders.ledger import Ledger
from restir_gi.reference.system.errors import UsageError

MAGIC, JSON_CHUNK, BINARY_CHUNK = b"glTF", b"JSON", b"BIN\0"
COMPONENTS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2"}
COMPONENTS |= {5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


@dataclass(frozen=True, slots=True)
class Document:
    """A glTF file, whose words have been checked when readers see it.

    Attributes
    ----------
    binary : bytes; the second chunk of a .glb; empty in a .gltf
    files : dict of str to bytes; those that were read so far, by their URI
    arrays : dict of int to array; accessors that were read so far
    pictures : dict
        Those that were decoded so far, by their image and what they are read for.
    """

    tree: dict[str, Any]
    binary: bytes
    ledger: Ledger
    files: dict[str, bytes] = field(default_factory=dict)
    arrays: dict[int, Scalars] = field(default_factory=dict)
    pictures: dict[tuple[int, str], Scalars] = field(default_factory=dict)

    def entry(self, name: str, index: int) -> dict[str, Any]:
        """Element of one of the lists of the file.

        Parameters
        ----------
        name : str; "nodes", "accessors", ...
        """
        found: dict[str, Any] = self.tree[name][index]
        return found

    def claim(self, memory: int, what: str) -> None:
        """Ask for memory before arrays are made.

        Raises UsageError: it is more than the bytes of the files make believable.

        Parameters
        ----------
        memory : int; bytes, with those of the arrays on the way
        """
        try:
            self.ledger.take(memory, what)
        except UsageError as error:
            self.ledger.stop(str(error))


def read_document(ledger: Ledger) -> Document:
    """Open a .gltf or .glb file: its JSON as it is; no buffer is read yet.

    Raises UsageError: no glTF 2 file, or truncated.
    """
    contents = ledger.contents()
    binary = b""
    if contents.startswith(MAGIC):
        contents, binary = _split_glb(contents, ledger)
    tree = _parse(contents, ledger)
    asset = tree.get("asset")
    if not isinstance(asset, dict) or not isinstance(asset.get("version"), str):
        ledger.stop('not a valid glTF file: it has no "asset" with a "version"')
    if not re.fullmatch(r"2(\.\d+)?", asset["version"]):
        version = shown(asset["version"])[1:-1]
        ledger.stop(f"this is glTF {version}; version 2.0 can be read")
    return Document(tree, binary, ledger)


def _parse(contents: bytes, ledger: Ledger) -> dict[str, Any]:
    def refuse(constant: str) -> NoReturn:
        raise ValueError(constant)

    try:
        tree = json.loads(contents.decode("utf-8-sig"), parse_constant=refuse)
    except UnicodeDecodeError as error:
        problem = f"byte {error.start} is not UTF-8"
    except json.JSONDecodeError as error:
        problem = f"line {error.lineno}, column {error.colno}: {error.msg}"
    except RecursionError:
        problem = "its JSON is nested too deep"
    except ValueError:
        problem = "a number of its JSON is none, or has thousands of digits"
    else:
        problem = "its JSON is not an object"
        if isinstance(tree, dict):
            return tree
    return ledger.stop(f"not a valid glTF file: {problem}")


def _split_glb(contents: bytes, ledger: Ledger) -> tuple[bytes, bytes]:
    if len(contents) < 20:
        ledger.stop(f"the file is truncated: {len(contents)} bytes")
    version, length = np.frombuffer(contents[4:12], "<u4").tolist()
    if version != 2:
        ledger.stop(f"this is binary glTF {version}; version 2 can be read")
    if length > len(contents):
        ledger.stop(f"the file is truncated: {len(contents)} of {length} bytes")
    chunks: dict[bytes, bytes] = {}
    at = 12
    while at + 8 <= length:
        size = int(np.frombuffer(contents[at : at + 4], "<u4")[0])
        if at + 8 + size > length:
            ledger.stop(f"the chunk at byte {at} reaches beyond the end of the file")
        kind = contents[at + 4 : at + 8]
        if kind in (JSON_CHUNK, BINARY_CHUNK):
            chunks.setdefault(kind, contents[at + 8 : at + 8 + size])
        at += 8 + size
    if JSON_CHUNK not in chunks:
        ledger.stop("not a valid glTF file: it has no JSON chunk")
    return chunks[JSON_CHUNK], chunks.get(BINARY_CHUNK, b"")


def resolve_uri(uri: str, document: Document) -> bytes:
    """Contents of a file beside the scene, or of a data URI.

    Raises UsageError: the file cannot be read.

    Parameters
    ----------
    uri : str; relative path, percent-encoded, or ``data:...;base64,...``
    """
    if uri.startswith("data:"):
        header, _, payload = uri.partition(",")
        if not header.endswith(";base64"):
            return unquote_to_bytes(payload)
        try:
            return base64.b64decode(payload, validate=True)
        except (binascii.Error, ValueError):
            raise UsageError("its data URI is not base64; save it again") from None
    if uri not in document.files:
        try:
            name = unquote_to_bytes(uri).decode("utf-8")
        except UnicodeError:
            raise UsageError(f"{shown(uri)} is not a file name") from None
        document.files[uri] = document.ledger.read(name)
    return document.files[uri]


def view_bytes(document: Document, index: int) -> memoryview:
    """Bytes of a buffer view.

    Raises UsageError: the buffer cannot be read, or has not so many bytes.
    """
    view = document.entry("bufferViews", index)
    start, length = view.get("byteOffset", 0), view["byteLength"]
    data = _buffer(document, view["buffer"])
    if start + length > len(data):
        document.ledger.stop(
            f"buffer view {index} reaches beyond its buffer: to byte {start + length}"
            f" of {len(data)}"
        )
    return data[start : start + length]


def _buffer(document: Document, index: int) -> memoryview:
    entry, ledger = document.entry("buffers", index), document.ledger
    data = document.binary
    if "uri" in entry:
        try:
            data = resolve_uri(entry["uri"], document)
        except UsageError as error:
            ledger.stop(f"buffer {index}: {error}")
    elif index > 0 or not data:
        ledger.stop(f'buffer {index} has no "uri", so no bytes')
    if len(data) < entry["byteLength"]:
        ledger.stop(
            f"buffer {index} has {len(data)} of its {entry['byteLength']} bytes;"
            " the file is truncated"
        )
    return memoryview(data)[: entry["byteLength"]]


def read_accessor(
    document: Document, index: int, types: tuple[str, ...], where: str
) -> Scalars:
    """Values of an accessor.

    Parameters
    ----------
    types : tuple of str; those that its use allows: "VEC3"
    where : str; its use, for messages: 'mesh "floor", POSITION'

    Returns
    -------
    (count, width) int64 or float64
        Normalized integers as the fractions that they stand for.

    Raises
    ------
    UsageError
        It has another type, or not the bytes that it promises.
    """
    entry = document.entry("accessors", index)
    where = f"{where} (accessor {index})"
    if entry["type"] not in types:
        needs = f"it must be {' or '.join(types)}"
        document.ledger.stop(f"{where} is of type {entry['type']}; {needs}")
    if index not in document.arrays:
        document.arrays[index] = _values(document, entry, where)
    return document.arrays[index]


def _values(document: Document, entry: dict[str, Any], where: str) -> Scalars:
    count, width = entry["count"], WIDTHS[entry["type"]]
    kind = np.dtype(COMPONENTS[entry["componentType"]])
    document.claim(3 * 8 * count * width, f"{where} has {count} elements")
    if "bufferView" in entry:
        start = entry.get("byteOffset", 0)
        values = _elements(
            document, entry["bufferView"], start, (count, width), kind, where
        )
    else:
        values = np.zeros((count, width), kind)
    if "sparse" in entry:
        values = _with_sparse(document, entry["sparse"], values, where)
    if kind.kind == "f":
        return values.astype(np.float64)
    if entry.get("normalized", False):
        return np.maximum(values / float(np.iinfo(kind).max), -1.0)
    return values.astype(np.int64)


def _with_sparse(
    document: Document, sparse: dict[str, Any], values: Scalars, where: str
) -> Scalars:
    at, new, count = sparse["indices"], sparse["values"], sparse["count"]
    kind = np.dtype(COMPONENTS[at["componentType"]])
    place = _elements(
        document, at["bufferView"], at.get("byteOffset", 0), (count, 1), kind, where
    )[:, 0]
    if count and place.max() >= len(values):
        problem = f"{where} has {len(values)} elements, but sparse ones up to"
        document.ledger.stop(f"{problem} number {place.max()}")
    shape = (count, values.shape[1])
    start = new.get("byteOffset", 0)
    changed = values.copy()
    changed[place] = _elements(
        document, new["bufferView"], start, shape, values.dtype, where
    )
    return changed


def _elements(
    document: Document,
    view: int,
    start: int,
    shape: tuple[int, int],
    kind: np.dtype[Any],
    where: str,
) -> Scalars:
    data = view_bytes(document, view)
    count, width = shape
    size = width * kind.itemsize
    stride = document.entry("bufferViews", view).get("byteStride", size)
    if stride < size:
        problem = f"{where} has elements of {size} bytes every {stride} bytes"
        document.ledger.stop(f"{problem}; they must not overlap")
    if count == 0:
        return np.zeros(shape, kind)
    end = start + (count - 1) * stride + size
    if end > len(data):
        document.ledger.stop(
            f"{where} reads beyond buffer view {view}: to byte {end} of {len(data)}"
        )
    return np.ndarray(shape, kind, data, start, (stride, kind.itemsize))

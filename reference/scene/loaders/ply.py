"""PLY files: ASCII and both orders of bytes, through one table of types."""

import struct
from dataclasses import dataclass

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Scalars
from restir_gi.reference.scene.loaders.ascii_table import numbers_of
from restir_gi.reference.scene.loaders.ledger import Ledger
from restir_gi.reference.scene.loaders.parts import MeshPart, fans, linear_colors
from restir_gi.reference.scene.loaders.words import Use, Word

TYPES = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("float", "float32"), "f4"),
    **dict.fromkeys(("double", "float64"), "f8"),
}
ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
INDICES = ("vertex_indices", "vertex_index")
NORMAL = ("nx", "ny", "nz")
PLACES_ON_PICTURE = (("u", "v"), ("s", "t"), ("texture_u", "texture_v"))
COLORS = (("red", "green", "blue"), ("diffuse_red", "diffuse_green", "diffuse_blue"))
WORDS = (
    Word("element", "vertex", Use.MODELLED),
    Word("element", "face", Use.MODELLED, "fans of triangles"),
    Word("element", "tristrips", Use.MODELLED, "-1 begins a new strip"),
    Word("element", "edge", Use.HARMLESS, "an edge has no area"),
    Word("element", "any other", Use.HARMLESS, "noted"),
    Word("vertex", "x, y, z", Use.MODELLED),
    Word("vertex", "nx, ny, nz", Use.MODELLED),
    *(Word("vertex", f"{u}, {v}", Use.MODELLED) for u, v in PLACES_ON_PICTURE),
    *(
        Word("vertex", ", ".join(rgb), Use.MODELLED, "whole numbers are sRGB")
        for rgb in COLORS
    ),
    Word("vertex", "alpha", Use.REPLACED, "opaque; the largest value is harmless"),
    Word("vertex", "any other", Use.HARMLESS, "no part of a surface"),
    *(Word("face, tristrips", name, Use.MODELLED) for name in INDICES),
    Word("face", "red, green, blue", Use.REPLACED, "ignored"),
    Word("face", "texcoord", Use.HARMLESS, "a PLY file names no picture"),
    Word("face", "any other", Use.HARMLESS, "no part of a surface"),
)


@dataclass(frozen=True, slots=True)
class _Property:
    name: str
    type: str
    length: str | None  # type of the length of a list
    most: float  # what stands for 1 in a colour
    single: bool  # the file means float32, be it written as text


@dataclass(frozen=True, slots=True)
class _Element:
    name: str
    count: int
    properties: tuple[_Property, ...]

    @property
    def least(self) -> int:
        """Bytes of a row with empty lists."""
        return sum(np.dtype(p.length or p.type).itemsize for p in self.properties)


@dataclass(frozen=True, slots=True, eq=False)
class _Column:
    """Values of a property, row after row; of a list, how many each row has."""

    values: Scalars
    sizes: Indices
    most: float


class _TooShortError(Exception):
    """The file ends too early."""


def read_ply(contents: bytes, name: str, ledger: Ledger) -> MeshPart:
    """All triangles of a PLY file; nothing is merged or dropped.  Without a material.

    Parameters
    ----------
    name : str; of the file, for messages: empty for the scene file, else with a colon

    Raises
    ------
    UsageError
        Not such a file, truncated, or without triangles.
    """
    elements, body = _header(contents, name, ledger)
    tables: dict[str, dict[str, _Column]] = {}
    at = 0
    for element in elements:
        if element.count * element.least > len(body) - at:
            ledger.stop(
                f"{name}it promises {element.count:,} rows of {element.name!r} and has"
                f" {len(body) - at:,} bytes for them; it is truncated or corrupt"
            )
        try:
            tables[element.name], at = _table(element, body, at)
        except _TooShortError:
            ledger.stop(f"{name}it is truncated or corrupt: rows of {element.name!r}")
    return _part(tables, name, ledger)


def _header(contents: bytes, name: str, ledger: Ledger) -> tuple[list[_Element], bytes]:
    """Elements that a file promises, and its rows; those of a text as float64."""
    head, end, body = contents.partition(b"end_header")
    lines = head.decode("latin-1").split("\n" if b"\n" in head else "\r")
    if lines[0].strip() != "ply" or not end:
        ledger.stop(f"{name}not a valid PLY file (its header is incomplete)")
    order: str | None = None
    elements: list[_Element] = []
    wrong = ""
    for line in lines[1:]:
        match line.split():
            case ["format", form, _] if form in ORDERS and not elements:
                order = ORDERS[form]
            case ["element", element, count] if (
                order is not None and count.isascii() and count.isdigit()
            ):
                elements.append(_Element(element, int(count[:18]), ()))
            case ["property", "list", length, kind, key] if (
                elements and length in TYPES and kind in TYPES
            ):
                _add(elements, key, kind, length, order)
            case ["property", kind, key] if elements and kind in TYPES:
                _add(elements, key, kind, None, order)
            case [] | ["comment" | "obj_info", *_]:
                pass
            case _:
                wrong = wrong or " ".join(line.split())[:60]
    names = [e.name for e in elements]
    names += [f"{e.name} {p.name}" for e in elements for p in e.properties]
    wrong = wrong or next((x for x in names if names.count(x) > 1), "")
    if wrong:
        ledger.stop(f'{name}not a valid PLY file (its header has "{wrong}" wrongly)')
    body = body[2:] if body.startswith(b"\r\n") else body[1:]
    return elements, body if order else _as_doubles(body, name, ledger)


def _add(
    elements: list[_Element], key: str, kind: str, length: str | None, order: str | None
) -> None:
    last = elements[-1]
    dtype = np.dtype(TYPES[kind])
    column = _Property(
        name=key,
        type=order + TYPES[kind] if order else "<f8",
        length=length and (order + TYPES[length] if order else "<f8"),
        most=1.0 if dtype.kind == "f" else float(np.iinfo(dtype).max),
        single=dtype == np.float32,
    )
    elements[-1] = _Element(last.name, last.count, (*last.properties, column))


def _as_doubles(body: bytes, name: str, ledger: Ledger) -> bytes:
    values, wrong = numbers_of(np.frombuffer(body, np.uint8))
    if wrong is not None:
        word = body.split()[wrong][:30].decode("latin-1")
        ledger.stop(f'{name}value {wrong + 1} after its header is "{word}", no number')
    return values.astype("<f8").tobytes()


def _table(element: _Element, body: bytes, at: int) -> tuple[dict[str, _Column], int]:
    """Columns of an element, and where the next one begins."""
    if not element.count:
        return {
            p.name: _Column(np.zeros(0), np.zeros(0, int), p.most)
            for p in element.properties
        }, at
    # Most files have lists of one length: then a row is a record.
    sizes = _sizes(element, body, at)
    fields: list[tuple[str, str, tuple[int, ...]]] = []
    for i, (column, n) in enumerate(zip(element.properties, sizes, strict=True)):
        if column.length:
            fields.append((f"length {i}", column.length, ()))
        fields.append((f"value {i}", column.type, (n,) if column.length else ()))
    row = np.dtype(fields)
    if element.count * row.itemsize <= len(body) - at:
        rows = np.frombuffer(body, row, element.count, at)
        lists = [i for i, p in enumerate(element.properties) if p.length]
        if all((rows[f"length {i}"] == sizes[i]).all() for i in lists):
            table = {
                p.name: _column(
                    p,
                    rows[f"value {i}"].reshape(-1),
                    np.full(element.count, sizes[i]),
                )
                for i, p in enumerate(element.properties)
            }
            return table, at + element.count * row.itemsize
    return _table_row_by_row(element, body, at)


def _column(column: _Property, values: Scalars, sizes: Indices) -> _Column:
    with np.errstate(over="ignore"):
        stored = values.astype(np.float32) if column.single else values
    return _Column(stored, sizes, column.most)


def _sizes(element: _Element, body: bytes, at: int) -> list[int]:
    """How many values each property of one row has."""
    sizes = []
    for column in element.properties:
        n = 1
        if column.length:
            width = np.dtype(column.length).itemsize
            if at + width > len(body):
                raise _TooShortError
            (length,) = struct.unpack_from(_code(column.length), body, at)
            if not 0 <= length <= len(body) or length != int(length):
                raise _TooShortError
            n, at = int(length), at + width
        sizes.append(n)
        at += n * np.dtype(column.type).itemsize
        if at > len(body):
            raise _TooShortError
    return sizes


def _code(kind: str) -> str:
    return kind[0] + np.dtype(kind).char


def _table_row_by_row(
    element: _Element, body: bytes, at: int
) -> tuple[dict[str, _Column], int]:
    columns = element.properties
    lengths = [struct.Struct(_code(p.length)) if p.length else None for p in columns]
    widths = [np.dtype(p.type).itemsize for p in columns]
    starts: list[list[int]] = [[] for _ in columns]
    sizes: list[list[int]] = [[] for _ in columns]
    steps = list(zip(lengths, widths, starts, sizes, strict=True))
    try:
        for _ in range(element.count):
            for length, width, begins, counts in steps:
                n = 1
                if length:
                    n = int(length.unpack_from(body, at)[0])
                    at += length.size
                    if n < 0:
                        raise _TooShortError
                begins.append(at)
                counts.append(n)
                at += n * width
    except (struct.error, ValueError, OverflowError) as error:
        raise _TooShortError from error
    if at > len(body):
        raise _TooShortError
    octets = np.frombuffer(body, np.uint8)
    table = {}
    for column, width, begins, counts in zip(
        columns, widths, starts, sizes, strict=True
    ):
        each = np.array(counts) * width
        shift = np.array(begins) - (np.cumsum(each) - each)
        places = np.arange(each.sum()) + np.repeat(shift, each)
        values = octets[places].view(column.type)
        table[column.name] = _column(column, values, np.array(counts))
    return table, at


def _part(tables: dict[str, dict[str, _Column]], name: str, ledger: Ledger) -> MeshPart:
    vertex = tables.get("vertex", {})
    if not {"x", "y", "z"} <= vertex.keys():
        ledger.stop(f"{name}its vertices lack x, y or z")
    for other in sorted(tables.keys() - {"vertex", "face", "tristrips", "edge"}):
        ledger.note(f"{name}its element {other!r} is ignored")
    face = tables.get("face", {})
    triangles = np.concatenate(
        [
            _faces(face, name, ledger),
            _strips(tables.get("tristrips", {}), name, ledger),
        ]
    )
    if not len(triangles):
        ledger.stop(f"{name}it has no triangles; name a PLY file with faces")
    if face.keys() & {"red", "green", "blue"}:
        ledger.replace(f"{name}colours of faces are not modelled", "ignored")
    if "alpha" in vertex and (vertex["alpha"].values < vertex["alpha"].most).any():
        ledger.replace(f"{name}alpha of vertices is not modelled", "taken as opaque")
    rgb, uv = (_present(vertex, choices) for choices in (COLORS, PLACES_ON_PICTURE))
    colors = None
    if rgb:
        most = np.array([vertex[key].most for key in rgb])
        colors = _columns(vertex, rgb) / most
        if (most > 1).any():  # whole numbers are sRGB, as in pictures
            colors = linear_colors(colors, name, ledger)
    return MeshPart(
        material=None,
        vertices=_columns(vertex, ("x", "y", "z")),
        faces=triangles,
        normals=_columns(vertex, NORMAL) if set(NORMAL) <= vertex.keys() else None,
        uv=_columns(vertex, uv) if uv else None,
        colors=colors,
    )


def _present(
    table: dict[str, _Column], choices: tuple[tuple[str, ...], ...]
) -> tuple[str, ...]:
    """The first of some sets of properties that is there."""
    return next((keys for keys in choices if set(keys) <= table.keys()), ())


def _columns(table: dict[str, _Column], keys: tuple[str, ...]) -> Scalars:
    columns: Scalars = np.stack(
        [table[key].values.astype(np.float64) for key in keys], axis=-1
    )
    return columns


def _indices(
    table: dict[str, _Column], what: str, name: str, ledger: Ledger
) -> tuple[Indices, Indices]:
    """Indices of vertices, list after list, and the sizes of the lists."""
    key = next((key for key in INDICES if key in table), None)
    if key is None:
        if table:
            ledger.stop(f"{name}its {what} lack {' or '.join(INDICES)}")
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    values, sizes = table[key].values, table[key].sizes
    whole = values.dtype.kind != "f" or (
        (np.abs(values) < 2**53) & (values == np.floor(values))
    )
    if not np.all(whole):
        ledger.stop(f"{name}an index of its {what} is not a whole number")
    return values.astype(np.int64), sizes


def _faces(table: dict[str, _Column], name: str, ledger: Ledger) -> Indices:
    indices, sizes = _indices(table, "faces", name, ledger)
    if (sizes < 3).any():
        at = int(np.argmax(sizes < 3))
        ledger.stop(f"{name}face {at} has {sizes[at]} corners; it needs 3")
    return indices[fans(sizes)[0]]


def _strips(table: dict[str, _Column], name: str, ledger: Ledger) -> Indices:
    """Triangles of strips: each index makes one with the two before it."""
    indices, sizes = _indices(table, "tristrips", name, ledger)
    ends = indices < 0
    starts = np.zeros(len(indices) + 1, bool)
    starts[np.cumsum(sizes) - sizes] = True
    starts[1:][ends] = True
    strip = np.cumsum(starts[:-1])
    first = np.searchsorted(strip, strip)  # of each one's strip
    third = np.flatnonzero(~ends)
    third = third[third - first[third] >= 2]
    odd = (third - first[third]) % 2 == 1
    triangles: Indices = np.stack(
        [
            indices[third - 2],
            indices[np.where(odd, third, third - 1)],
            indices[np.where(odd, third - 1, third)],
        ],
        axis=-1,
    )
    return triangles

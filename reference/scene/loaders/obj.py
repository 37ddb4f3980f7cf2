"""Wavefront OBJ files: words first, then numbers, all lines of a kind at a time."""

import re
from bisect import bisect_right
from codecs import BOM_UTF8, BOM_UTF16_BE, BOM_UTF16_LE
from dataclasses import dataclass

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars, Vec3s
from restir_gi.reference.scene.loaders.ascii_table import (
    Bytes,
    numbers_of,
    whole_numbers,
    words_of,
)
from restir_gi.reference.scene.loaders.ledger import Ledger
from restir_gi.reference.scene.loaders.parts import MeshPart, fans, linear_colors
from restir_gi.reference.scene.loaders.words import Use, Word

FREE_FORM = (
    *("vp", "cstype", "deg", "bmat", "step", "curv", "curv2", "surf", "parm", "trim"),
    *("hole", "scrv", "sp", "end", "con", "call", "csh"),
)
WORDS = (
    Word("line", "v", Use.MODELLED, "x y z; r g b after them are sRGB vertex colours"),
    Word("line", "vt", Use.MODELLED, "u v"),
    Word("line", "vn", Use.MODELLED),
    Word("line", "f", Use.MODELLED, "fans of triangles; indices may count backwards"),
    Word("line", "mtllib", Use.MODELLED, "one file or several; names with spaces"),
    Word("line", "usemtl", Use.MODELLED),
    Word("line", "g", Use.HARMLESS, "a name"),
    Word("line", "o", Use.HARMLESS, "a name"),
    Word("line", "s", Use.REPLACED, "flat faces; harmless where faces have vn, and 0"),
    Word("line", "l", Use.HARMLESS, "a line has no area"),
    Word("line", "p", Use.HARMLESS, "a point has no area"),
    Word("line", "mg", Use.HARMLESS, "for free-form surfaces"),
    Word("line", "lod", Use.HARMLESS, "for viewers"),
    *(Word("line", name, Use.REPLACED, "left out") for name in FREE_FORM),
)
HARMLESS = {word.name for word in WORDS if word.use is Use.HARMLESS}
NUMBERS = {"v": 3, "vt": 1, "vn": 3}  # that a line has at least
FIELDS = {"v": "vertex", "vt": "texture coordinate", "vn": "normal"}  # of a corner


@dataclass(frozen=True, slots=True, eq=False)
class ObjText:
    """Lines of an OBJ file by their keys, and its words; no number is read yet.

    Attributes
    ----------
    name : str; of the file, for messages: empty for the scene file, else with a colon
    text : (B,) uint8
        Of the same length, without keys of numbers, comments, and continuations.
    starts : (L,) int; where each line begins
    rows : dict of str to (L,) bool; which lines are "v", "vt", "vn", "f"
    libraries : tuple of str; what stands after each mtllib
    materials : tuple of (int, str); each usemtl: its line and the name
    smooth : tuple of (int, str); each s: its line and the group
    """

    name: str
    original: bytes
    text: Bytes
    starts: Indices
    rows: dict[str, Masks]
    libraries: tuple[str, ...]
    materials: tuple[tuple[int, str], ...]
    smooth: tuple[tuple[int, str], ...]

    def where(self, line: int) -> str:
        """Place of a line, for messages, as an editor counts.

        Parameters
        ----------
        line : int; from 0, continuations joined
        """
        return f"{self.name}line {1 + self.original.count(10, 0, self.starts[line])}"

    def lines(self, key: str) -> tuple[Bytes, Indices]:
        """All lines of a key, (b,) uint8, (l,) int; their text; their numbers.

        Parameters
        ----------
        key : str; one of ``rows``
        """
        rows = self.rows[key]
        lengths = np.diff(self.starts, append=len(self.text))
        return self.text[np.repeat(rows, lengths)], np.flatnonzero(rows)


def read_obj_words(contents: bytes, name: str, ledger: Ledger) -> ObjText:
    """Sort the lines of an OBJ file, and refuse the words that are not modelled.

    Parameters
    ----------
    contents : bytes; UTF-8, or UTF-16 with its mark
    name : str; of the file, for messages: empty for the scene file, else with a colon

    Raises
    ------
    UsageError
        It is no text.
    """
    plain = _plain_text(contents, name, ledger)
    # What is taken out leaves blanks, so that places stay what they are.
    clean = re.sub(rb"\\\r?\n", lambda m: b" " * len(m[0]), plain)
    clean = re.sub(rb"#(?<!\S#)[^\n]*", lambda m: b" " * len(m[0]), clean)
    # The key changes places with the blanks before it.
    clean = re.sub(rb"\n([ \t]+)([^\s]+)", rb"\n\2\1", b"\n" + clean)[1:]
    text = np.frombuffer(clean, np.uint8).copy()
    starts = np.append(0, np.flatnonzero(text == 10)[:-1] + 1)
    first, second = text[starts], text[np.minimum(starts + 1, len(text) - 1)]
    alone = (second == 32) | (second == 9)
    rows = {
        "v": (first == ord("v")) & alone,
        "vt": (first == ord("v")) & (second == ord("t")),
        "vn": (first == ord("v")) & (second == ord("n")),
        "f": (first == ord("f")) & alone,
    }
    for key, mask in rows.items():
        for place in range(len(key)):
            text[starts[mask] + place] = 32
    words = _words(clean, starts, ~np.any(list(rows.values()), axis=0) & (first > 32))
    found = ObjText(
        name=name,
        original=plain,
        text=text,
        starts=starts,
        rows=rows,
        libraries=tuple(rest for _, key, rest in words if key == "mtllib" and rest),
        materials=tuple((i, rest) for i, key, rest in words if key == "usemtl"),
        smooth=tuple((i, rest) for i, key, rest in words if key == "s"),
    )
    _refuse_words(words, found, ledger)
    return found


def _plain_text(contents: bytes, name: str, ledger: Ledger) -> bytes:
    if contents.startswith((BOM_UTF16_LE, BOM_UTF16_BE)):
        contents = contents.decode("utf-16", "replace").encode()
    contents = contents.removeprefix(BOM_UTF8)
    if b"\0" in contents:
        ledger.stop(f"{name}this is not text; an OBJ file is UTF-8 text")
    if b"\n" not in contents:
        contents = contents.replace(b"\r", b"\n")
    return contents + b"\n"


def _words(clean: bytes, starts: Indices, rows: Masks) -> list[tuple[int, str, str]]:
    """Line, key and the rest of all lines that hold no numbers."""
    ends = np.append(starts[1:], len(clean))
    lines = []
    for i in np.flatnonzero(rows).tolist():
        key, _, rest = (
            clean[starts[i] : ends[i]].decode("utf-8", "replace").partition(" ")
        )
        lines.append((i, key.strip(), rest.strip()))
    return lines


def _refuse_words(
    words: list[tuple[int, str, str]], text: ObjText, ledger: Ledger
) -> None:
    known = HARMLESS | {"mtllib", "usemtl", "s"}
    seen = set()
    for line, key, _ in words:
        if key not in known and key not in seen:
            seen.add(key)
            ledger.replace(f'{text.where(line)}: "{key}" is not modelled', "left out")


def read_obj_faces(text: ObjText, ledger: Ledger) -> list[MeshPart]:
    """All triangles of an OBJ file; nothing is merged or dropped.

    Returns
    -------
    list of MeshPart
        Of one material each, in the order of their names; one whose faces differ in
        having normals or texture coordinates makes several.

    Raises
    ------
    UsageError
        A line makes no sense, or there is no face.
    """
    if not text.rows["f"].any():
        ledger.stop(f"{text.name}it has no faces; name an OBJ file with some")
    vertices, colors = _vertices(text, ledger)
    normals = _table(text, "vn", ledger)[0][:, :3]
    uv = _table(text, "vt", ledger)[0][:, :2]
    corners, sizes = _corners(text, (len(vertices), len(uv), len(normals)), ledger)
    triangles, face = fans(sizes)
    corners = corners[triangles]
    # A part has one material, and all of its corners or none have uv and normals.
    names, material = _materials(text)
    has_uv, has_normals = ((corners[..., i] >= 0).all(axis=1) for i in (1, 2))
    _refuse_smooth(text, face[~has_normals], ledger)
    group = material[face] * 4 + has_uv * 2 + has_normals
    parts = []
    for key in np.unique(group).tolist():
        triples = corners[group == key].reshape(-1, 3)
        kept, faces = _distinct(triples * [1, has := key >> 1 & 1, key & 1])
        v, t, n = triples[kept].T
        parts.append(
            MeshPart(
                material=names[key // 4],
                vertices=vertices[v],
                faces=faces.reshape(-1, 3),
                normals=normals[n] if key & 1 else None,
                uv=uv[t] if has else None,
                colors=None if colors is None else colors[v],
            )
        )
    return parts


def _distinct(triples: Indices) -> tuple[Indices, Indices]:
    """First row of each distinct triple; which of those each row is."""
    size = triples.max(axis=0, initial=0) + 1
    if float(size[0]) * float(size[1]) * float(size[2]) < 2**62:
        keys = (triples[:, 0] * size[1] + triples[:, 1]) * size[2] + triples[:, 2]
        _, kept, inverse = np.unique(keys, return_index=True, return_inverse=True)
    else:
        _, kept, inverse = np.unique(
            triples, axis=0, return_index=True, return_inverse=True
        )
    return kept, inverse


def _materials(text: ObjText) -> tuple[list[str | None], Indices]:
    """Names of materials, sorted; which of them each face has."""
    uses = [name or None for _, name in text.materials]
    names = sorted({*uses, None}, key=lambda name: name or "")
    number = np.array([names.index(name) for name in [None, *uses]])
    return names, number[_last(text, [line for line, _ in text.materials])]


def _last(text: ObjText, lines: list[int]) -> Indices:
    """How many of these lines stand before each face."""
    return np.searchsorted(np.array(lines, int), np.flatnonzero(text.rows["f"]))


def _refuse_smooth(text: ObjText, flat: Indices, ledger: Ledger) -> None:
    smooth = np.array([False, *(s not in ("off", "0") for _, s in text.smooth)])
    lines = [line for line, _ in text.smooth]
    asked = smooth[_last(text, lines)[flat]]
    if asked.any():
        line = int(np.flatnonzero(text.rows["f"])[flat[asked][0]])
        group = lines[bisect_right(lines, line) - 1]
        ledger.replace(
            f"{text.where(group)}: smoothing of faces without normals (vn) is not"
            " modelled",
            "taken as flat",
        )


def _table(text: ObjText, key: str, ledger: Ledger) -> tuple[Scalars, Indices]:
    """Numbers of all lines of a key, NaN after the last; how many each line has."""
    lines, numbers = text.lines(key)
    words = words_of(lines)
    least = NUMBERS[key]
    if len(words.counts) and words.counts.min() < least:
        row = int(np.argmax(words.counts < least))
        ledger.stop(
            f"{text.where(numbers[row])}: {key} has {words.counts[row]} numbers; it"
            f" needs {least}"
        )
    values, wrong = numbers_of(lines)
    if wrong is not None:
        word = lines[words.starts[wrong] : words.stops[wrong]].tobytes()
        ledger.stop(
            f"{text.where(numbers[words.lines[wrong]])}: {key} has"
            f' "{word.decode(errors="replace")}"; it needs numbers'
        )
    width = min(int(words.counts.max(initial=least)), 6)
    table = np.full((len(words.counts), max(width, 2)), 0.0)
    if (words.counts == width).all():
        table[:, :width] = values.reshape(-1, width)
    else:
        at = np.cumsum(words.counts) - words.counts
        for column in range(width):
            has = words.counts > column
            table[has, column] = values[at[has] + column]
    return table, words.counts


def _vertices(text: ObjText, ledger: Ledger) -> tuple[Vec3s, Vec3s | None]:
    table, counts = _table(text, "v", ledger)
    colored = counts >= 6
    if not colored.any():
        return table[:, :3], None
    stored = np.where(colored[:, None], table[:, 3:6], 1.0)
    return table[:, :3].copy(), linear_colors(stored, text.name, ledger)


def _corners(
    text: ObjText, totals: tuple[int, int, int], ledger: Ledger
) -> tuple[Indices, Indices]:
    """(C, 3) numbers of vertex, uv and normal from 0, or -1; corners of each face."""
    lines, numbers = text.lines("f")
    words = words_of(lines)
    if words.counts.min() < 3:
        row = int(np.argmax(words.counts < 3))
        ledger.stop(
            f"{text.where(numbers[row])}: a face has {words.counts[row]} corners; it"
            " needs 3"
        )
    slashes = np.flatnonzero(lines == ord("/"))
    before = np.searchsorted(slashes, words.starts)
    inside = np.searchsorted(slashes, words.stops) - before
    # A field that is not there ends where it begins.
    slashes = np.append(slashes, [len(lines)] * 2)
    first = np.where(inside > 0, slashes[before], words.stops)
    second = np.where(inside > 1, slashes[before + 1], words.stops)
    fields = [
        (words.starts, first),
        (np.minimum(first + 1, words.stops), second),
        (np.minimum(second + 1, words.stops), words.stops),
    ]
    corners = np.zeros((len(words.starts), 3), np.int64)
    given = np.zeros(corners.shape, bool)
    wrong = inside > 2
    for i, (start, stop) in enumerate(fields):
        if i == 0 or (stop > start).any():
            corners[:, i], given[:, i] = whole_numbers(lines, start, stop)
            wrong |= ~given[:, i] & ((stop > start) | (i == 0))
    if wrong.any():
        at = int(np.argmax(wrong))
        word = lines[words.starts[at] : words.stops[at]].tobytes()
        ledger.stop(
            f"{text.where(numbers[words.lines[at]])}: a face has the corner"
            f' "{word.decode(errors="replace")}"; it should be v, v/vt, v//vn or'
            " v/vt/vn"
        )
    for i, key in enumerate(FIELDS):
        if given[:, i].any():
            field = (corners[:, i], given[:, i], words.lines)
            _count_from_zero(key, *field, text, totals[i], ledger)
        else:
            corners[:, i] = -1
    return corners, words.counts


def _count_from_zero(
    key: str,
    column: Indices,
    given: Masks,
    face: Indices,
    text: ObjText,
    total: int,
    ledger: Ledger,
) -> None:
    """Turn indices from 1, or backwards from the last line before, into such from 0."""
    asked = column.copy()
    if (column < 0).any():
        seen = np.cumsum(text.rows[key])[np.flatnonzero(text.rows["f"])[face]]
        column[...] = np.where(column < 0, seen + column, column - 1)
        outside = given & ((asked == 0) | (column < 0) | (column >= total))
    else:
        column -= 1
        outside = given & ((column < 0) | (column >= total))
    column[~given] = -1
    if outside.any():
        at = int(np.argmax(outside))
        line = np.flatnonzero(text.rows["f"])[face[at]]
        which = f"{FIELDS[key]} {asked[at]}"
        right = f"they are 1 to {total}" if total else f"the file has no {key}"
        ledger.stop(f"{text.where(line)}: a face names {which}; {right}")

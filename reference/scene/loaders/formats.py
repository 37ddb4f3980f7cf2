"""The page of the documentation that lists every word of every file format."""

from collections.abc import Iterator
from importlib import import_module
from itertools import groupby

from restir_gi.reference.scene.loaders.ledger import MOST_EXPANSION, ROOM
from restir_gi.reference.scene.loaders.pictures import HDR_BYTES, PICTURE_BYTES
from restir_gi.reference.scene.loaders.words import Use, Word
from restir_gi.reference.system.files import MOST_BYTES

TABLES = {
    "glTF 2.0 (.gltf, .glb)": "gltf_words",
    "Wavefront OBJ (.obj)": "obj",
    "MTL (.mtl)": "mtl",
    "PLY (.ply)": "ply",
    "Mitsuba 3 (.xml)": "mitsuba_words",
    "scene.json (.json)": "json_words",
}
HEAD = f"""# Formats of scene files

This page is printed from the tables by which the loaders decide.

**One rule.** What changes the picture is modelled, or the file is refused. With
`--lenient` a word that is not modelled is replaced, and a note says by what. All
refusals of a file are told at once, in one line, before its meshes are read.

| use | is |
|---|---|
| {Use.MODELLED.name.lower()} | in the picture, within the limits beside it |
| {Use.HARMLESS.name.lower()} | ignored: it does not change the picture |
| {Use.REPLACED.name.lower()} | refused; under `--lenient` replaced as stands beside |
| {Use.REFUSED.name.lower()} | refused, also under `--lenient` |

A word that is not in the table of its format is not modelled: it is refused, or ignored
under `--lenient`.

## Files that are read

- A scene, and the files that it names, are regular files of at most
  {MOST_BYTES >> 30} GiB: no pipe, device or folder.
- The files that a scene names lie in its folder or below, wherever "..", links and
  absolute paths lead. With `--allow-outside` they may lie elsewhere on the machine.
  Names of other machines (`http://...`, `//host/...`, `\\\\host\\...`) are refused
  always.
- Reading a scene takes at most {ROOM >> 20} MiB of memory and {MOST_EXPANSION} bytes
  for each byte of its files. What a header promises (pixels, vertices, faces) is
  weighed against this bound, or against the bytes that are there, before memory is
  taken. A picture counts {PICTURE_BYTES} bytes a pixel, an HDR picture {HDR_BYTES}.

## Highlights of MTL files

Nearly every MTL file has `Ks` and `Ns`, so refusing them would refuse nearly every
file; but only some values of `illum` use them. With `illum` 0 or 1 they have no effect,
by the format's own definition. With `illum` 2, or where there is none, a highlight
Ks (N·H)^Ns lies over the diffuse colour. Its formula keeps no energy and is of no use
to a path tracer as it stands. The surface is taken as a coat of Beckmann's microfacets
with the formula's width, alpha² = 2 / (Ns + 2), and, where light comes from the
direction of the eye, its height: the coat reflects 8 Ks / (Ns + 2). Above 0.9 this is
no coat, and refused.
"""


def formats_page() -> str:
    """The whole page, in Markdown."""
    return "\n".join([HEAD, *(x for title in TABLES for x in _section(title))])


def words_of_format(title: str) -> tuple[Word, ...]:
    """Table of a format, in the order of the loader.

    Parameters
    ----------
    title : str; one of `TABLES`
    """
    module = import_module(f"restir_gi.reference.scene.loaders.{TABLES[title]}")
    words: tuple[Word, ...] = tuple(module.WORDS)
    return words


def _section(title: str) -> Iterator[str]:
    yield f"## {title}\n"
    yield "| in | word | use | remark |"
    yield "|---|---|---|---|"
    words = sorted(words_of_format(title), key=lambda word: word.element)
    for element, group in groupby(words, key=lambda word: word.element):
        shown = element
        alike = groupby(group, key=lambda word: (word.use, word.remark))
        for (use, remark), some in alike:
            names = ", ".join(f"`{word.name}`" for word in some)
            yield f"| {shown} | {names} | {use.name.lower()} | {_cell(remark)} |"
            shown = ""
    yield ""


def _cell(text: str) -> str:
    return text.replace("|", "\\|")

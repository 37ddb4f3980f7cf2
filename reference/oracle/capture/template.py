"""A folder to begin with: manifest, declaration, and what to copy when."""

import json
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from textwrap import wrap

from restir_gi.reference.oracle.capture.elements import wanted_bytes
from restir_gi.reference.oracle.capture.families import FAMILIES, Dump, Family
from restir_gi.reference.oracle.capture.manifest import NAME, manifest_of
from restir_gi.reference.oracle.capture.schema import FORM
from restir_gi.reference.oracle.declaration.read import read_declaration
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.files import make_folder, read_file, write_file
from restir_gi.reference.system.leftovers import sweep

DECLARATION, README = "declaration.toml", "README.md"

MANIFEST_HEAD = """\
# Buffers of {title}, frame by frame; README.md says what to copy, and when.
# Every key is explained in docs/reference/capture.md of restir-gi-oracle.

schema = "{form}"
width = {width}
height = {height}
frames = {frames}  # they stand for {{frame}} in the names of files
declaration = "declaration.toml"
# scene = "scene.xml"  # where there is one: built-in or a file; rays are traced in it

# One camera for all frames, or one for each; needed for positions from depths alone.
# [[cameras]]
# inverse_view_projection = [
#     [1, 0, 0, 0],
#     [0, 1, 0, 0],
#     [0, 0, 1, 0],
#     [0, 0, 0, 1],
# ]

{passes}"""

DECLARATION_TEXT = """\
# What the renderer does that others do otherwise.  This is typical of {title}: take out
# what is not so in yours.  What is not said is as the contract has it.

schema = "restir-declaration 1"
name = "{title}"
{accept}
{choices}"""

ACCEPT_TEXT = """
# These choices are biased by design.  The verdict says so, and is FAIL until this line
# is taken in, which accepts them:
# accept = {names}
"""

README_TEXT = """\
# Frames for restir check

Copy the buffers below in frames {first} to {last}, which should follow one another,
from {width}x{height} pixels of a renderer in the manner of {title}. Each buffer is a
file of its own for each frame, with the bytes as they stand on the GPU. Names, formats
and sizes are in `capture.toml`: change there what is otherwise in your engine, also
after the dump.

Then run `restir check` with this folder.

| file | format | bytes | when | if there is none |
|---|---|---|---|---|
{rows}

{total:,} bytes a frame, without those that are optional. Optional ones are commented
out in `capture.toml`.

## What to look at

- The resampling must run on these very numbers: dump what the shaders read, not what
  the CPU believes.
- Turn off what changes reservoirs between the passes that are dumped, or dump after it
  and say so in `declaration.toml`.
- Textures that are copied with padded rows: give `row_pitch`, in bytes.
- An image whose first row is the bottom one: give `flip = true`.
- The first frame may have no history: give `frames = [...]` to a buffer that is not
  there in all of them.
- A few frames are enough. A small image is as good as a large one.
"""


@dataclass(frozen=True, slots=True)
class Listed:
    """A buffer of a template.

    Attributes
    ----------
    file : str; name, with {frame}
    bytes : int; of one frame
    """

    dump: Dump
    file: str
    bytes: int


@dataclass(frozen=True, slots=True)
class Template:
    """What a folder begins with.

    Attributes
    ----------
    files : mapping of str to str; contents by name
    buffers : tuple of Listed; in the order of a frame
    """

    files: Mapping[str, str]
    buffers: tuple[Listed, ...]


def template(layout: str, width: int, height: int, frames: tuple[int, ...]) -> Template:
    """Files for renderers of a layout.

    Parameters
    ----------
    layout : str; a word of `FAMILIES`
    width, height : int, pixels
    frames : tuple of int; numbers in order
    """
    family = FAMILIES[layout]
    head = MANIFEST_HEAD.format(
        title=family.title,
        form=FORM,
        width=width,
        height=height,
        frames=list(frames),
        passes=family.passes,
    )
    whole = head + "".join(_table(dump, optional=False) for dump in family.dumps)
    manifest = manifest_of(tomllib.loads(whole), NAME, of_files=True)
    buffers = tuple(
        Listed(dump, buffer.file, wanted_bytes(buffer, width, height))
        for dump, buffer in zip(family.dumps, manifest.buffers, strict=True)
    )
    readme = README_TEXT.format(
        first=frames[0],
        last=frames[-1],
        width=width,
        height=height,
        title=family.title,
        rows="\n".join(map(_row, buffers)),
        total=sum(one.bytes for one in buffers if not one.dump.optional),
    )
    tables = "".join(_table(dump, dump.optional) for dump in family.dumps)
    declaration = DECLARATION_TEXT.format(
        title=family.title, accept=_accepted(family), choices=family.declaration
    )
    files = {README: readme, DECLARATION: declaration, NAME: head + tables}
    return Template(files, buffers)


def _accepted(family: Family) -> str:
    """The biased choices of a family, for the user to accept."""
    form = tomllib.loads(
        DECLARATION_TEXT.format(title="", accept="", choices=family.declaration)
    )
    choices = read_declaration(form).hypotheses
    biased = [h.name for h in choices if h.departure == "bias"]
    return ACCEPT_TEXT.format(names=json.dumps(biased)) if biased else ""


def write_template(folder: Path, files: Mapping[str, str]) -> None:
    """Write a template into a folder of its own; the manifest comes last.

    Raises UsageError: the folder holds something else, or cannot be written.

    Parameters
    ----------
    folder : Path
        New, or empty, or with these very files: whatever else is there stays, and so
        does a manifest that somebody has changed.
    files : mapping of str to str; contents by name
    """
    _refuse_others(folder, files)
    make_folder(folder)
    for name, text in files.items():
        write_file(folder / name, text.encode())


def _refuse_others(folder: Path, files: Mapping[str, str]) -> None:
    if not folder.is_dir():
        return
    sweep(folder)
    for path in sorted(folder.iterdir()):
        text = files.get(path.name)
        if text is None:
            raise UsageError(f"{folder} holds {path.name}; name a new or empty folder")
        if read_file(path) != text.encode():
            raise UsageError(
                f"{folder} holds another {path.name}; move it, or name a new folder"
            )


def _table(dump: Dump, optional: bool) -> str:
    """A buffer's table, with what it is; commented out if it is optional."""
    text = f"[buffers.{dump.name}]\n{dump.keys}"
    if optional:
        lines = "".join(f"# {line}\n" for line in text.splitlines())
        text = f"# Optional: take away the marks before these lines.\n{lines}"
    return f"\n{_comment(dump.form)}{_comment(dump.when)}{text}"


def _comment(text: str) -> str:
    """A sentence as lines of a comment."""
    lines = wrap(f"{text[0].upper()}{text[1:]}.", 86)
    return "".join(f"# {line}\n" for line in lines)


def _row(one: Listed) -> str:
    optional = " (optional)" if one.dump.optional else ""
    cells = (
        f"`{one.file}`{optional}",
        one.dump.form,
        f"{one.bytes:,}",
        one.dump.when,
        one.dump.otherwise,
    )
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"

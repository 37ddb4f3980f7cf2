"""Captures as a page of the documentation."""

from collections.abc import Iterator, Mapping
from typing import Any

from restir_gi.reference.oracle.capture.kinds import KINDS
from restir_gi.reference.oracle.capture.layouts import LAYOUTS
from restir_gi.reference.oracle.capture.roles import ROLES, TARGET_VALUES, Role
from restir_gi.reference.oracle.capture.schema import schema
from restir_gi.reference.oracle.contract.fields import Field

INTRODUCTION = """\
# Captures: frames of an engine

<!-- Written by restir_gi.reference.oracle.capture.describe; a test compares. -->

A capture is a folder with buffers that an engine's own ReSTIR GI has worked with, some
frames after one another, and `capture.toml`, which describes them. Nothing of the
engine has to be rewritten: its bits are decoded, and become arrays in the words of
[the contract](contract.md). `restir capture-template` writes a folder to begin with.

```toml
schema = "restir-capture 1"
width = 1280
height = 720
frames = [100, 101, 102]
declaration = "declaration.toml"

[buffers.temporal]                   # by a name of your own, or that of its role
file = "temporal.{frame}.bin"
layout = "rtxdi"

[buffers.normals]
role = "gbuffer"
file = "normals.{frame}.bin"
row_pitch = 5120                     # a texture of 32 bits a pixel, as it was copied
fields = [
    { name = "visible_normal", kind = "octahedral-snorm16" },
]

[buffers.surface]                    # a struct of your own
role = "gbuffer"
file = "surface.{frame}.bin"
stride = 32
fields = [
    { name = "visible_position", kind = "float32", offset = 0 },
    { name = "alpha", kind = "unorm16", offset = 12 },
    { name = "albedo", kind = "r11g11b10f", offset = 16 },
]

[buffers.history]
file = "history.{frame}.exr"
frames = [101, 102]                  # the first frame has none
fields = [
    { name = "row", channels = ["X", "Y"], given = "offsets", scale = [1280, 720] },
]
```

Files are bare bytes, `.npy`, `.npz` or `.exr`. Only regular files below the folder are
read, and none that is much larger than it should be. Sizes are exact: where a file has
another one, the message says which `stride`, `slots`, `order`, `row_pitch` or `offset`
would fit. Whatever is wrong is told at once, a line each: keys of the manifest, files,
and numbers that are not finite, with their count and the first pixel.

The form is a [JSON schema](https://json-schema.org) beside the code,
`reference/oracle/capture/capture.schema.json`.
"""

TITLES = {
    "": ("The manifest", "Keys at the top of `capture.toml`."),
    "temporal": (
        "Temporal reuse",
        "Keys of `[passes.temporal]`. The pass is judged as `moved` of the contract.",
    ),
    "spatial": (
        "Spatial reuse",
        "Keys of `[passes.spatial]`. The pass is judged as `spatial` of the contract.",
    ),
    "fused": (
        "Both in one",
        "Keys of `[passes.fused]`. The pass is judged as `fused` of the contract: the"
        " new sample as a reservoir, then sources, all of which are reservoirs that the"
        " pass left a frame ago. The pixel that is continued is one of them.",
    ),
    "buffer": (
        "Buffers",
        "Keys of `[buffers.NAME]`. A role may have several buffers, such as a texture"
        " for each field, and a file several buffers.",
    ),
    "field": (
        "Fields",
        "Keys of an item of `fields`. Without `kind` the numbers of an array or a"
        " picture are taken as they are; with it, its bytes are.",
    ),
    "camera": (
        "Cameras",
        "Keys of `[[cameras]]`: either a matrix or a pinhole. They are needed where"
        " positions are to follow from depths, and for nothing else. The view depth is"
        " what clip space has as w: matrices are those of perspective projections.",
    ),
}
"""Headings of the tables of keys, by the schema's definitions."""

KINDS_TEXT = """\

## Kinds of numbers

All numbers of more than one byte are in the buffer's byte order. What is packed is
described from the lowest bit on.

| kind | bytes | value |
|---|---|---|
"""

NOTES = {
    "logluv32": "; [bits](packing.md#radiance-in-logluv)",
    "rgb9e5": "; mantissas in bits 8:0, 17:9, 26:18, exponent in 31:27",
    "r11g11b10f": "; bits 10:0, 21:11, 31:22",
}

MAP_TEXT = """\

Octahedral coordinates are folded [as on the page of packing](packing.md#normals), u
first. Other codes for 1, such as 65534, are given as `unit`. Vectors that are stored by
component have the length that their rounding leaves them, unless `normalize` is given:
say what the engine's shaders do when they read them.
"""

LAYOUTS_TEXT = """\

## Known layouts

| `layout` | bytes | whose | order |
|---|---|---|---|
"""

AFTER_LAYOUTS = """\

Their fields stand on [the page of packing](packing.md). `slots` and `slot` are for
buffers that hold several arrays of reservoirs one after the other, as those of RTXDI
and of ReSTIR_PT do.
"""

ROLES_TEXT = """\

## Roles

A frame has what its buffers give: a pass is judged where its inputs and outputs are
there. Rows are pixels, y · width + x from the top left.

| role | what it is | fields |
|---|---|---|
"""

FIELDS_TEXT = """\

| field | shape | kind | meaning |
|---|---|---|---|
"""

CONVERSIONS = """\

## What follows from other numbers

| where there is no | but there is | it is |
|---|---|---|
| `visible_position` | `depth`, `cameras` | the point that the pixel's centre sees |
| `W` | `w_sum`, `M`, `p_hat` | w_sum / (M p_hat), 0 where that is 0 |
| `pdf` of role `initial` | `W` | 1 / W, 0 where W is 0 |

A depth is *given* along the camera's axis (`view`), along the ray (`distance`), or as a
depth buffer has it (`device`). `none` is the depth of pixels that see nothing, whatever
stands in their normals: 0, or the far end of a depth buffer; there depth, position and
normal become 0.

Pixels of the history and neighbours are *given* as row numbers (`rows`), as x, y
(`pixels`), or as x, y from the pixel's centre (`offsets`), such as motion vectors: with
`scale` these may be in any unit. Fractions are cut off to the pixel that they are in.
What lies outside of the image is none, and counted in a note; a row number that is no
row is an error. With `flip` they count from the bottom, like the buffer's own rows.

## From Python

```python
from restir_gi.reference.oracle.capture.record import Capture

capture = Capture.read("frames")
reservoirs = capture.frames[1]["temporal"]
reservoirs["W"]  # (N,) float64
reservoirs.storage  # "rtxdi"
reservoirs.formats["W"]  # "float32"
```

`Capture.from_arrays` takes arrays in place of files, one mapping of names to arrays for
each frame: of NumPy, with DLPack, with `__cuda_array_interface__` (CuPy, PyTorch; they
copy themselves to the host by `get` or `cpu`), or buffers. Its manifest is a mapping of
the same keys, of which `buffers` is enough, without files:

```python
capture = Capture.from_arrays(
    width=1280,
    height=720,
    frames=[{"temporal": reservoirs, "normals": normals}],
    manifest={
        "buffers": {
            "temporal": {"layout": "rtxdi"},
            "normals": {"role": "gbuffer", "fields": [{"name": "visible_normal"}]},
        }
    },
)
```
"""

EVERY_ROLE: Mapping[str, Role] = {**ROLES, "targets_NAME": TARGET_VALUES}


def describe() -> str:
    """Page of captures, in Markdown."""
    return "".join(
        [
            INTRODUCTION,
            *(_keys(table) for table in TITLES),
            KINDS_TEXT,
            *_kinds(),
            MAP_TEXT,
            LAYOUTS_TEXT,
            *_layouts(),
            AFTER_LAYOUTS,
            ROLES_TEXT,
            *_roles(),
            FIELDS_TEXT,
            *_fields(),
            CONVERSIONS,
        ]
    )


def _keys(table: str) -> str:
    title, text = TITLES[table]
    of = schema()["$defs"][table] if table else schema()
    rows = "".join(
        f"| `{key}` | {_values(form)} | {_default(key, form, of)} |"
        f" {_cell(form['description'])} |\n"
        for key, form in of["properties"].items()
    )
    head = "| key | values | default | meaning |\n|---|---|---|---|\n"
    return f"\n## {title}\n\n{text}\n\n{head}{rows}"


def _values(form: Mapping[str, Any]) -> str:
    """What a key may be, in a few words."""
    if "$ref" in form:
        name = form["$ref"].rpartition("/")[2]
        words = {"text": "text", "number": "number", "vector": "three numbers"}
        return words.get(name, "number, or some")
    if "const" in form:
        return f'`"{form["const"]}"`'
    if "enum" in form:
        words = form["enum"]
        return "see below" if len(words) > 8 else ", ".join(f"`{w}`" for w in words)
    if form["type"] == "array":
        return _items(form)
    names = {"integer": "whole number", "boolean": "true or false", "object": "tables"}
    return names.get(form["type"], "number")


def _items(form: Mapping[str, Any]) -> str:
    if form["items"].get("type") == "array":
        return "4 x 4 numbers"
    if form["items"].get("$ref", "").endswith(("field", "camera")):
        return "tables"
    kind = "texts" if "$ref" in form["items"] else "whole numbers"
    return f"two {kind}" if form.get("maxItems") == 2 else kind


def _default(key: str, form: Mapping[str, Any], of: Mapping[str, Any]) -> str:
    if key in of.get("required", ()):
        return "needed"
    if "default" not in form:
        return ""
    value = form["default"]
    return str(value).lower() if isinstance(value, bool) else str(value)


def _kinds() -> Iterator[str]:
    for name, kind in KINDS.items():
        meaning = kind.meaning + NOTES.get(name, "")
        yield f"| `{name}` | {kind.size} | {_cell(meaning)} |\n"


def _layouts() -> Iterator[str]:
    for name, layout in LAYOUTS.items():
        order = "rows"
        if layout.tile is not None:
            order = f"tiles of {layout.tile[0]} x {layout.tile[1]}"
        yield f"| `{name}` | {layout.stride} | {layout.title} | {order} |\n"


def _roles() -> Iterator[str]:
    for name, role in EVERY_ROLE.items():
        fields = ", ".join(f"`{field.name}`" for field in role.fields)
        yield f"| `{name}` | {_cell(role.meaning)} | {fields} |\n"


def _fields() -> Iterator[str]:
    """Each field once; of those that share a name, whose it is."""
    told: dict[Field, str] = {}
    for role, one in EVERY_ROLE.items():
        for field in one.fields:
            told.setdefault(field, role)
    names = [field.name for field in told]
    for field, role in told.items():
        whose = f", of `{role}`" if names.count(field.name) > 1 else ""
        shape = " × ".join(str(size) for size in ("N", *field.columns))
        meaning = _cell(field.meaning)
        yield f"| `{field.name}`{whose} | {shape} | {field.kind} | {meaning} |\n"


def _cell(text: str) -> str:
    return text.replace("|", "\\|")

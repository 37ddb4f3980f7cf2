"""Manifests of captures: their schema, and every way in which one can be wrong."""

import json
import pickle
import re
import tomllib
from copy import deepcopy
from importlib.resources import files
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator

from restir_gi.reference.oracle.capture.faults import MOST_TOLD, CaptureError
from restir_gi.reference.oracle.capture.kinds import KINDS
from restir_gi.reference.oracle.capture.layouts import LAYOUTS
from restir_gi.reference.oracle.capture.manifest import manifest_of, read_manifest
from restir_gi.reference.oracle.capture.roles import ROLES
from restir_gi.reference.oracle.capture.schema import schema
from restir_gi.reference.oracle.contract.registry import CONTRACT
from restir_gi.reference.system.errors import UsageError

DOCS = Path(__file__).parents[2] / "docs"

WHOLE = {
    "schema": "restir-capture 1",
    "width": 8,
    "height": 4,
    "frames": [0, 1],
    "buffers": {
        "temporal": {"file": "t.{frame}.bin", "layout": "rtxdi"},
        "place": {
            "role": "gbuffer",
            "file": "p.{frame}.bin",
            "fields": [{"name": "visible_position", "kind": "float32"}],
        },
        "history": {
            "file": "h.{frame}.npy",
            "frames": [1],
            "fields": [{"name": "row", "given": "pixels"}],
        },
        "light": {
            "role": "shade",
            "file": "s.{frame}.exr",
            "fields": [{"name": "color", "channels": ["R", "G", "B"]}],
        },
    },
}
PLACE = "buffers.place"
FIELD = "buffers.place.fields[0]"


def judged(data):
    return manifest_of(data, "capture.toml", of_files=True)


def faults(data):
    with pytest.raises(CaptureError) as caught:
        judged(data)
    assert str(caught.value).startswith("capture.toml: ")
    assert "\n" not in str(caught.value)
    return list(caught.value.faults)


def with_value(path, value):
    """The whole manifest with one value in place of another; ``...``: without it."""
    data = deepcopy(WHOLE)
    inner = data
    *above, last = [int(w) if w.isdigit() else w for w in re.findall(r"[\w-]+", path)]
    for key in above:
        inner = inner[key]
    if value is ...:
        del inner[last]
    else:
        inner[last] = value
    return data


# ---------------------------------------------------------------- the schema


def test_the_schema_is_one_and_comes_with_the_package():
    Draft202012Validator.check_schema(schema())
    packaged = files("restir_gi.reference.oracle.capture") / "capture.schema.json"
    assert json.loads(packaged.read_text("utf-8")) == schema()


def test_the_schema_knows_what_the_code_knows():
    tables = schema()["$defs"]
    assert set(tables["field"]["properties"]["kind"]["enum"]) == set(KINDS)
    assert set(tables["buffer"]["properties"]["layout"]["enum"]) == set(LAYOUTS)


def test_every_key_is_described():
    tables = [schema(), *schema()["$defs"].values()]
    for table in tables:
        for form in table.get("properties", {}).values():
            assert form["description"]


def test_words_are_those_of_the_contract():
    """But for those that a renderer alone has."""
    known = {f.name for p in CONTRACT.values() for f in (*p.inputs, *p.outputs)}
    used = {field.name for role in ROLES.values() for field in role.fields}
    own = {"w_sum", "age", "seed", "misc", "row", "view", "alpha", "f0"}
    assert used - known <= own


def test_a_whole_manifest():
    manifest = judged(WHOLE)
    assert [buffer.name for buffer in manifest.buffers] == list(WHOLE["buffers"])
    rtxdi, place, history, light = manifest.buffers
    assert (rtxdi.stride, rtxdi.tile) == (32, (16, 16))
    assert (place.role, place.stride, place.tile) == ("gbuffer", 12, None)
    assert place.path(7) == "p.7.bin"
    assert history.frames == (1,)
    assert light.fields[0].channels == ("R", "G", "B")


def test_the_examples_of_the_pages_are_right():
    found = 0
    for page in DOCS.rglob("*.md"):
        for text in re.findall(
            r"^```toml\n(.*?)^```", page.read_text("utf-8"), re.M | re.S
        ):
            data = tomllib.loads(text)
            if data.get("schema") == WHOLE["schema"]:
                assert list(Draft202012Validator(schema()).iter_errors(data)) == []
                judged(data)
                found += 1
    assert found >= 2


# ---------------------------------------------------------------- what is wrong

WRONG = [
    # the form
    ("schema", "restir-capture 2", "schema is 'restir-capture 2'; it should be"),
    ("schema", ..., "it lacks schema"),
    ("width", ..., "it lacks width"),
    ("width", "8", "width is '8'; it should be a whole number"),
    ("width", 8.5, "width is 8.5; it should be a whole number"),
    ("width", True, "width is true; it should be a whole number"),
    ("width", 0, "width is 0; it should be from 1 to 16384"),
    ("height", 10**30, "height is 1000"),
    ("frames", [], "frames has 0 entries; it should have from 1 to 4096"),
    ("frames", [1, 0], "frames is [1, 0]; each number should be above the one before"),
    ("frames", [1, 1], "each number should be above"),
    ("frames", [-1], "frames[0] is -1; it should be from 0"),
    ("frame", [0], "it: unknown key 'frame'; did you mean frames?"),
    ("declaration", 3, "declaration is 3; it should be a text"),
    ("scene", "", "scene has 0 letters; it should have from 1 to 1024"),
    ("buffers", {}, "buffers has 0 entries; it should have from 1 to 256"),
    ("buffers", [], "buffers is []; it should be a table"),
    ("buffers", {"a b": {}}, "buffers: 'a b' is no name; it should begin with"),
    # buffers
    (
        f"{PLACE}.role",
        "g-buffer",
        "place.role: unknown role 'g-buffer'; did you mean g",
    ),
    (f"{PLACE}.role", ..., "buffers.place has no `role`; unknown role 'place'"),
    (f"{PLACE}.file", ..., "buffers.place lacks `file`"),
    (f"{PLACE}.file", "a{x}.bin", "place.file is 'a{x}.bin'; in braces it should have"),
    (f"{PLACE}.file", "/a.bin", "should be a name below the manifest's folder"),
    (f"{PLACE}.file", "a/../../b", "should be a name below the manifest's folder"),
    (f"{PLACE}.frames", [0, 2], "place.frames has 2, which `frames` of the manifest"),
    (f"{PLACE}.layout", "rtxdi", "place has both of `layout` and `fields`; give one"),
    (f"{PLACE}.fields", ..., "place has neither of `layout` and `fields`; give one"),
    (f"{PLACE}.fields", [], "place.fields has 0 entries"),
    (
        "buffers.temporal.layout",
        "rtxd",
        "temporal.layout: unknown word 'rtxd'; did you",
    ),
    (
        "buffers.temporal.role",
        "gbuffer",
        "layout is of reservoirs, and gbuffer has none",
    ),
    ("buffers.temporal.file", "a.exr", "layout is of bytes, which a picture has not"),
    (
        "buffers.temporal.tile",
        [8, 8],
        'temporal.tile is for order = "tiles"; give that',
    ),
    (
        "buffers.temporal.row_pitch",
        256,
        'row_pitch is for order = "rows"; leave it out',
    ),
    ("buffers.temporal.stride", 16, "stride is 16, and its fields end at byte 28"),
    (f"{PLACE}.stride", 8, "stride is 8, and its fields end at byte 12; give at least"),
    (
        f"{PLACE}.row_pitch",
        90,
        "row_pitch is 90, and a row has 96 bytes; give at least",
    ),
    (f"{PLACE}.slot", 1, "place.slot is 1; it should be below `slots`, which is 1"),
    (f"{PLACE}.member", "a", "place.member is for .npz files; leave it out"),
    (f"{PLACE}.part", "a", "place.part is for .exr files; leave it out"),
    (f"{PLACE}.order", "row", "place.order: unknown word 'row'; did you mean rows?"),
    ("buffers.light.order", "rows", "light.order is for bytes; leave it out"),
    ("buffers.history.stride", 8, "history.stride is for bytes; leave it out"),
    # fields
    (f"{FIELD}.name", ..., "buffers.place.fields[0] lacks name"),
    (f"{FIELD}.name", "position", "name: unknown field 'position'; did you mean visib"),
    (f"{FIELD}.kind", "flot32", "fields[0].kind: unknown word 'flot32'; did you mean"),
    (f"{FIELD}.kind", 7, "fields[0].kind is 7; it should be one of float16, float32"),
    (
        f"{FIELD}.kind",
        ...,
        "fields[0] lacks `kind`, which bytes need; known are float1",
    ),
    (f"{FIELD}.kind", "uint64", "lacks `bits`, such as [0, 31], which uint64 needs"),
    (f"{FIELD}.channels", ["R"], "fields[0].channels is not for bytes; leave it out"),
    (f"{FIELD}.column", 1, "fields[0].column is not for bytes; leave it out"),
    (
        f"{FIELD}.count",
        4,
        "count is 4 from component 0 on; visible_position has 3 numb",
    ),
    (
        f"{FIELD}.count",
        2,
        "visible_position of gbuffer has the components 0 to 1; give",
    ),
    (f"{FIELD}.component", 1, "has the components 1; give 0 to 2 once"),
    (
        f"{FIELD}.bits",
        [0, 7],
        "bits is for uint8 to uint64, and not for float32; leave",
    ),
    (f"{FIELD}.bits", [0], "fields[0].bits has 1 entries; it should have 2"),
    (f"{FIELD}.unit", 127, "unit is for octahedral whole numbers, and not for float32"),
    (f"{FIELD}.scale", "2", "scale is '2'; it should be a number, or some numbers"),
    (f"{FIELD}.scale", [1, 2], "scale has 2 entries; it should have one, or 3"),
    (f"{FIELD}.scale", float("nan"), "fields[0].scale is no number; give one"),
    (f"{FIELD}.bias", float("inf"), "fields[0].bias is inf"),
    (
        f"{FIELD}.none",
        0,
        "none is for row, neighbors, sources, depth, and not for visible_pos",
    ),
    (
        f"{FIELD}.given",
        "pixels",
        "given is 'pixels'; of visible_position it should be l",
    ),
    ("buffers.history.fields[0].given", "view", "of row it should be one of rows, pix"),
    ("buffers.history.fields[0].count", 1, "count is 1; pixels are pairs of x and y"),
    (
        "buffers.history.fields[0].normalize",
        True,
        "normalize is for vectors, and not f",
    ),
    (
        "buffers.history.fields[0].bits",
        [0, 7],
        "bits is not for arrays of numbers; lea",
    ),
    ("buffers.light.fields[0].channels", ..., 'lacks `channels`, such as ["R", "G"'),
    ("buffers.light.fields[0].channels", ["R"], "color of shade has the components 0;"),
    ("buffers.light.fields[0].kind", "float32", "kind is not for pictures; leave it"),
    ("buffers.light.fields[0].count", 2, "channels has 3 entries; it should have 2"),
]


@pytest.mark.parametrize(("path", "value", "words"), WRONG)
def test_what_is_wrong_is_told(path, value, words):
    found = faults(with_value(path, value))
    assert any(words in fault for fault in found), found


def test_all_is_told_at_once():
    data = with_value("width", 0)
    data["height"], data["buffers"]["place"]["fields"][0]["kind"] = "4", "float"
    assert len(faults(data)) == 3
    data = with_value(f"{PLACE}.role", "x")
    data["buffers"]["temporal"]["slot"] = 3
    data["frames"] = [1, 0]
    assert len(faults(data)) == 3


def test_long_lists_are_cut_and_counted():
    buffers = {f"a{k}": {"layout": "paper", "file": "a"} for k in range(MOST_TOLD + 5)}
    with pytest.raises(CaptureError) as caught:
        judged({**WHOLE, "buffers": buffers})
    assert len(caught.value.faults) == MOST_TOLD + 5
    assert str(caught.value).endswith("; and 5 more")


def test_what_is_wrong_crosses_to_another_process():
    with pytest.raises(CaptureError) as caught:
        judged({})
    again = pickle.loads(pickle.dumps(caught.value))
    assert (str(again), again.faults) == (str(caught.value), caught.value.faults)


def test_a_field_that_two_buffers_have():
    data = deepcopy(WHOLE)
    data["buffers"]["more"] = {**data["buffers"]["place"]}
    (fault,) = faults(data)
    assert "visible_position of gbuffer has the components 0 to 2, 0 to 2" in fault


def test_bits_that_are_no_words():
    seed = {"name": "seed", "kind": "uint16", "bits": [4, 16]}
    data = deepcopy(WHOLE)
    data["buffers"]["more"] = {"role": "temporal", "file": "a", "fields": [seed]}
    (fault,) = faults(data)
    assert (
        "bits is [4, 16]; it should be a first and a last of the bits 0 to 15" in fault
    )
    seed |= {"bits": [0, 3], "scale": 2}
    (fault,) = faults(data)
    assert "scale is not for bits such as seed" in fault


MATRIX = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1], [0, 0, 1, 0]]


@pytest.mark.parametrize(
    ("cameras", "words"),
    [
        ([{"position": [0, 0, 0]}], "lacks inverse_view_projection, or position and"),
        ([{"position": [0, 0, 0], "target": [0, 0, 0]}], "cameras[0] has no view"),
        ([{"position": [0, 0, 0], "target": [0, 9, 0]}], "nor up along the view"),
        ([{"inverse_view_projection": [[0] * 4] * 4}], "has no inverse itself"),
        ([{"inverse_view_projection": [[0] * 3] * 4}], "has 3 entries"),
        ([{"inverse_view_projection": MATRIX, "fov": 3}], "fov is not for a matrix"),
        ([{"position": [0, 0, 0], "clip_y": "up"}], "clip_y is not for a pinhole"),
        ([{"inverse_view_projection": MATRIX}] * 3, "3 entries for 2 frames"),
        (
            [{"position": [0, 0, 0], "target": [1, 0, 0], "fov": 180}],
            "between 0 and 180",
        ),
    ],
)
def test_cameras_that_show_nothing(cameras, words):
    found = faults({**WHOLE, "cameras": cameras})
    assert any(words in fault for fault in found), found


def test_depths_that_need_a_camera():
    data = with_value(f"{FIELD}.name", "depth")
    field = data["buffers"]["place"]["fields"][0]
    judged(data)
    field["given"] = "distance"
    (fault,) = faults(data)
    assert "depth of gbuffer is given as distance, which needs `cameras`" in fault
    field["given"] = "device"
    data["cameras"] = [{"position": [0, 0, 0], "target": [1, 0, 0]}]
    (fault,) = faults(data)
    assert "needs a camera's inverse_view_projection" in fault
    data["cameras"] = [{"inverse_view_projection": MATRIX}]
    judged(data)


@pytest.mark.parametrize(
    ("contents", "words"),
    [
        (b"\xff", "is not text; write it in UTF-8"),
        (b"width = ", "is no TOML: "),
        (b"a = " + b"9" * 5000, "is no TOML: "),
        (b"a = " + b"[" * 5000, "is nested too deeply"),
        (b"#" * 2**21, "at most 1,048,576 can be read"),
        (b"", "it lacks schema"),
        (b"width = 1979-05-27", "it should be a whole number"),
    ],
)
def test_files_that_are_no_manifests(tmp_path, contents, words):
    path = tmp_path / "capture.toml"
    path.write_bytes(contents)
    with pytest.raises(UsageError) as caught:
        read_manifest(path)
    assert words in str(caught.value)

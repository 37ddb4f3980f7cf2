"""Spoiled captures: one line that says what is wrong, whatever was done to them."""

import shutil
from copy import deepcopy

import numpy as np
import OpenEXR
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from restir_gi.reference.cli.main import BAD_USAGE, main
from restir_gi.reference.oracle.capture.faults import CaptureError
from restir_gi.reference.oracle.capture.manifest import manifest_of
from restir_gi.reference.oracle.capture.record import Capture
from restir_gi.reference.resampling.packing import rtxdi
from restir_gi.reference.system.errors import UsageError

WIDTH, HEIGHT = 7, 4
ROWS = WIDTH * HEIGHT

MANIFEST = f"""
schema = "restir-capture 1"
width = {WIDTH}
height = {HEIGHT}
frames = [0]

[[cameras]]
position = [0, 1, 3]
target = [0, 0, 0]

[buffers.temporal]
file = "temporal.bin"
layout = "rtxdi"

[buffers.depth]
role = "gbuffer"
file = "depth.npy"
fields = [{{ name = "depth" }}]

[buffers.neighbors]
file = "neighbors.npz"
fields = [{{ name = "neighbors", count = 4, given = "offsets" }}]

[buffers.shade]
file = "shade.exr"
fields = [{{ name = "color", channels = ["R", "G", "B"] }}]

[buffers.normal]
role = "gbuffer"
file = "normal.bin"
row_pitch = 32
fields = [
    {{ name = "visible_normal", kind = "octahedral-unorm16", unit = 65534 }},
]
"""
FILES = ("temporal.bin", "depth.npy", "neighbors.npz", "shade.exr", "normal.bin")


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A folder that can be read."""
    folder = tmp_path_factory.mktemp("capture")
    rng = np.random.default_rng(3)
    (folder / "capture.toml").write_text(MANIFEST)
    np.zeros(256, rtxdi.RESERVOIR).tofile(folder / "temporal.bin")
    np.save(folder / "depth.npy", rng.random((HEIGHT, WIDTH)))
    offsets = rng.integers(-2, 3, (ROWS, 4))
    np.savez_compressed(folder / "neighbors.npz", offsets=offsets)
    channels = {c: np.ones((HEIGHT, WIDTH), np.float32) for c in "RGB"}
    OpenEXR.File({}, channels).write(str(folder / "shade.exr"))
    (folder / "normal.bin").write_bytes(bytes(32 * HEIGHT))
    capture = Capture.read(folder)
    assert set(capture.frames[0].roles) == {"temporal", "gbuffer", "neighbors", "shade"}
    return folder


@pytest.fixture
def folder(whole, tmp_path):
    """A copy of it, to be spoiled."""
    return shutil.copytree(whole, tmp_path / "copy")


def read_or_one_line(folder):
    """Either it can be read, and all is finite, or one line says why not."""
    try:
        capture = Capture.read(folder)
    except UsageError as error:
        line = str(error)
        assert line
        assert line == " ".join(line.splitlines())
        return None
    for frame in capture.frames:
        for buffers in frame.roles.values():
            for array in buffers.columns.values():
                assert len(array) == capture.rows
                assert np.isfinite(array).all()
    return capture


SPOILED = st.one_of(
    st.tuples(st.just("cut"), st.floats(0, 1), st.binary(max_size=0)),
    st.tuples(st.just("flip"), st.floats(0, 1), st.binary(min_size=1, max_size=4)),
    st.tuples(st.just("insert"), st.floats(0, 1), st.binary(min_size=1, max_size=64)),
    st.tuples(st.just("replace"), st.just(0.0), st.binary(max_size=256)),
)


def spoil(contents, how):
    """Bytes cut, turned over, put in between, or all others."""
    kind, place, data = how
    at = int(place * len(contents))
    if kind == "cut":
        return contents[:at]
    if kind == "insert":
        return contents[:at] + data + contents[at:]
    if kind == "replace":
        return data
    turned = bytes(a ^ b for a, b in zip(contents[at:], data, strict=False))
    return contents[:at] + turned + contents[at + len(turned) :]


# Each example writes into the same folder again.
again = settings(suppress_health_check=[HealthCheck.function_scoped_fixture])


@pytest.mark.parametrize("name", FILES)
@again
@given(how=SPOILED)
def test_spoiled_files(folder, whole, name, how):
    (folder / name).write_bytes(spoil((whole / name).read_bytes(), how))
    read_or_one_line(folder)


@again
@given(how=SPOILED)
def test_spoiled_manifests(folder, how):
    (folder / "capture.toml").write_bytes(spoil(MANIFEST.encode(), how))
    read_or_one_line(folder)


LINES = MANIFEST.splitlines()


@again
@given(
    st.lists(st.integers(0, len(LINES) - 1), min_size=1, max_size=3),
    st.randoms(use_true_random=False),
)
def test_manifests_of_which_lines_are_gone_or_elsewhere(folder, which, random):
    lines = [line for k, line in enumerate(LINES) if k not in which]
    for k in which:
        if random.random() < 0.5:
            lines.insert(random.randrange(len(lines)), LINES[k])
    (folder / "capture.toml").write_text("\n".join(lines))
    read_or_one_line(folder)


SCALARS = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-(2**70), 2**70),
    st.integers(-2, 40),
    st.floats(),
    st.text(max_size=8),
    st.sampled_from(
        ["rows", "tiles", "pixels", "device", "depth", "row", "W", "float32", "uint8",
         "rgb9e5", "octahedral-snorm8", "rtxdi", "paper", "gbuffer", "history", "big"]
    ),
)  # fmt: skip
VALUES = st.recursive(
    SCALARS,
    lambda inner: st.one_of(
        st.lists(inner, max_size=4),
        st.dictionaries(st.text(max_size=6), inner, max_size=3),
    ),
    max_leaves=8,
)
KEYS = (
    "role", "file", "frames", "member", "part", "layout", "fields", "stride", "offset",
    "byte_order", "order", "tile", "flip", "row_pitch", "slots", "slot", "name", "kind",
    "column", "channels", "count", "component", "bits", "unit", "scale", "bias", "none",
    "normalize", "given", "width", "height", "schema", "cameras", "buffers",
)  # fmt: skip


def tables(data):
    """All tables of a manifest."""
    if isinstance(data, dict):
        yield data
    for item in data.values() if isinstance(data, dict) else data:
        if isinstance(item, dict | list):
            yield from tables(item)


BASE = {
    "schema": "restir-capture 1",
    "width": WIDTH,
    "height": HEIGHT,
    "frames": [0, 1],
    "cameras": [{"position": [0, 1, 3], "target": [0, 0, 0]}],
    "buffers": {
        "temporal": {"layout": "rtxdi"},
        "gbuffer": {"fields": [{"name": "depth", "kind": "float32", "offset": 4}]},
        "history": {"fields": [{"name": "row", "kind": "int32", "given": "rows"}]},
        "neighbors": {
            "fields": [{"name": "neighbors", "count": 4, "given": "offsets"}]
        },
    },
}


def judged(data):
    """A manifest, or what is wrong with it."""
    try:
        return manifest_of(data, "it", of_files=False), ()
    except CaptureError as error:
        return None, error.faults


@given(
    st.lists(st.tuples(st.integers(0, 9), st.sampled_from(KEYS), VALUES), max_size=3)
)
def test_manifests_with_other_values(changes):
    """Judged, or told; and what was judged reads an empty array, or tells why not."""
    data = deepcopy(BASE)
    for number, key, value in changes:
        found = list(tables(data))
        found[number % len(found)][key] = value
    manifest, faults = judged(data)
    if manifest is None:
        assert faults
        assert all(fault and "\n" not in fault for fault in faults)
        return
    arrays = {name: np.zeros(0, np.uint8) for name in data["buffers"]}
    with pytest.raises(CaptureError):
        Capture.from_arrays(
            width=manifest.width,
            height=manifest.height,
            frames=[arrays] * len(manifest.frames),
            manifest=data,
        )


def test_the_command_line_has_one_line_and_its_exit_code(folder, capsys, monkeypatch):
    """As any command does that reads a capture."""
    from restir_gi.reference.cli import capture_template

    monkeypatch.setattr(capture_template, "run", lambda a: Capture.read(a.out) and 0)
    line = ["capture-template", "--layout", "paper", "--out", str(folder)]
    assert main(line) == 0
    for name, contents in (("capture.toml", b"width = 0"), ("depth.npy", b"")):
        before = (folder / name).read_bytes()
        (folder / name).write_bytes(contents)
        assert main(line) == BAD_USAGE
        out, err = capsys.readouterr()
        assert out == ""
        assert err.startswith("restir: ")
        assert err.count("\n") == 1
        (folder / name).write_bytes(before)


def test_control_what_is_no_line_is_seen(folder, monkeypatch):
    def fail(*arguments):
        raise KeyError

    assert read_or_one_line(folder) is not None
    monkeypatch.setattr("restir_gi.reference.oracle.capture.reading.parts_of", fail)
    with pytest.raises(KeyError):
        read_or_one_line(folder)

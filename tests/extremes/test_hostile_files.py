"""Files that mean harm: what they name, what they promise, and mutants of good ones."""

import json
import os
import re
import struct
import tracemalloc
import warnings
import zlib
from argparse import ArgumentParser
from importlib import import_module
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from restir_gi.reference.scene.loaders.ledger import MOST_EXPANSION, ROOM, Ledger
from restir_gi.reference.scene.loaders.load import load_scene
from restir_gi.reference.scene.loaders.pictures import read_picture
from restir_gi.reference.scene.validation import validate
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.files import read_file

PYTHON = re.compile(
    r"Error\b|Exception|Traceback|object at 0x|NoneType|<class|\bNone\b|dtype|ndarray"
    r"|module named|invalid literal|could not convert|out of range for"
)


def check_message(error: UsageError) -> None:
    """One line, in which nothing is Python's."""
    message = str(error)
    assert "\n" not in message
    assert not PYTHON.search(message), message


def refusal(path, *how):
    with pytest.raises(UsageError) as caught:
        load_scene(path, *how)
    check_message(caught.value)
    return str(caught.value)


# ---------------------------------------------------------------- what is read


def test_a_pipe_does_not_hold_the_reader_up(tmp_path):
    os.mkfifo(tmp_path / "a.obj")
    with pytest.raises(UsageError, match="it is a device or a pipe; name a file"):
        read_file(tmp_path / "a.obj")
    assert "is not a file" in refusal(tmp_path / "a.obj")


@pytest.mark.parametrize("name", ["/dev/zero", "/dev/full"])
def test_devices_are_not_read(tmp_path, name):
    with pytest.raises(UsageError, match="it is a device or a pipe; name a file"):
        read_file(tmp_path / name)


def test_folders_and_impossible_names(tmp_path):
    with pytest.raises(UsageError, match="it is a folder; name a file"):
        read_file(tmp_path)
    for name in ("a\0b", "\ud800", "a" * 300):
        with pytest.raises(UsageError) as caught:
            read_file(tmp_path / name)
        check_message(caught.value)


def test_files_larger_than_the_bound(tmp_path):
    with (tmp_path / "a").open("wb") as file:
        file.truncate(2**40)  # takes no room on the disk
    with pytest.raises(UsageError, match="it has 1,099,511,627,776 bytes; at most 4,"):
        read_file(tmp_path / "a")
    with pytest.raises(UsageError, match="at most 10 can be read"):
        read_file(tmp_path / "a", 10)


@pytest.fixture
def house(tmp_path):
    """Return a ledger of a scene in a folder, beside which there is a secret."""
    (tmp_path / "secret").write_bytes(b"secret")
    folder = tmp_path / "scene"
    (folder / "deep").mkdir(parents=True)
    (folder / "deep" / "in side.txt").write_bytes(b"inside")
    (folder / "link").symlink_to(tmp_path / "secret")
    (folder / "stays").symlink_to(folder / "deep" / "in side.txt")
    (folder / "ring").symlink_to(folder / "ring")
    return Ledger(folder / "scene.obj", False)


@pytest.mark.parametrize(
    "name", ["deep/in side.txt", "deep\\in side.txt", "./deep/../stays", "stays"]
)
def test_files_of_the_scenes_folder_are_read(house, name):
    assert house.read(name) == b"inside"
    assert house.read(str(house.path.parent / "stays")) == b"inside"


@pytest.mark.parametrize("name", ["../secret", "link", "deep/../../secret", "ABSOLUTE"])
def test_files_outside_are_read_if_allowed(house, name):
    name = name.replace("ABSOLUTE", str(house.path.parent.parent / "secret"))
    with pytest.raises(UsageError, match=r"lies outside the scene's folder.*--allow"):
        house.read(name)
    assert Ledger(house.path, False, True).read(name) == b"secret"


@pytest.mark.parametrize(
    "name",
    [
        "http://host/a",
        "HTTPS://host/a",
        "file:///etc/passwd",
        "//host/a",
        "\\\\host\\a",
    ],
)
@pytest.mark.parametrize("allowed", [False, True])
def test_names_of_other_machines_are_never_followed(house, name, allowed):
    with pytest.raises(UsageError, match="is not on this machine"):
        Ledger(house.path, True, allowed).read(name)


@pytest.mark.parametrize("name", ["ring", "a\0b", "\ud800", "a" * 300, "no"])
def test_names_that_lead_nowhere(house, name):
    with pytest.raises(UsageError) as caught:
        house.read(name)
    check_message(caught.value)


OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n"


def test_the_scenes_of_every_format_keep_to_their_folder(tmp_path):
    (tmp_path / "out.ply").write_bytes(PLY)
    (tmp_path / "out.mtl").write_text("newmtl m\nKd 1 0 0\n")
    (tmp_path / "in").mkdir()
    shape = {"file": "../out.ply", "material": "m"}
    tree = {"materials": {"m": {"type": "diffuse", "reflectance": 1}}}
    (tmp_path / "in/a.json").write_text(json.dumps({**tree, "shapes": [shape]}))
    (tmp_path / "in/a.obj").write_text(f"mtllib ../out.mtl\nusemtl m\n{OBJ}f 1 2 3\n")
    for name in ("a.json", "a.obj"):
        assert "outside the scene's folder" in refusal(tmp_path / "in" / name)
        scene = load_scene(tmp_path / "in" / name, allow_outside=True)
        assert len(scene.meshes) == 1


def test_impossible_names_in_scenes(tmp_path):
    long = "a" * 300
    shape = {"file": f"{long}.ply", "material": "m"}
    tree = {"materials": {"m": {"type": "diffuse", "reflectance": 1}}}
    (tmp_path / "a.json").write_text(json.dumps({**tree, "shapes": [shape]}))
    (tmp_path / "a.obj").write_text(f"mtllib {long}.mtl\n{OBJ}f 1 2 3\n")
    for name in ("a.json", "a.obj"):
        assert "is not a file path" in refusal(tmp_path / name)


def test_impossible_names_in_mitsuba_scenes(tmp_path):
    pytest.importorskip("mitsuba", reason="reads Mitsuba XML by the package mitsuba")
    name = f'<string name="filename" value="{"a" * 300}.obj"/>'
    text = f'<scene version="3.0.0"><shape type="obj">{name}</shape></scene>'
    (tmp_path / "a.xml").write_text(text)
    assert "is not a file path" in refusal(tmp_path / "a.xml")


# ---------------------------------------------------------------- what is promised


def png_of(width, height, data=b""):
    """PNG that promises a size and brings other bytes."""

    def chunk(kind, body):
        check = struct.pack(">I", zlib.crc32(kind + body))
        return struct.pack(">I", len(body)) + kind + body + check

    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", head)
        + chunk(b"IDAT", zlib.compress(data))
        + chunk(b"IEND", b"")
    )


def hdr_of(width, height):
    return f"#?RADIANCE\n\n-Y {height} +X {width}\n".encode()


def jpeg_of(width, height):
    buffer = BytesIO()
    Image.new("RGB", (8, 8)).save(buffer, "jpeg")
    small = bytearray(buffer.getvalue())
    at = small.index(b"\xff\xc0") + 5
    small[at : at + 4] = struct.pack(">HH", height, width)
    return bytes(small)


@pytest.mark.parametrize(
    ("name", "contents"),
    [
        ("a.png", png_of(9000, 9000)),
        ("a.png", png_of(30000, 30000)),
        ("a.png", png_of(2**31 - 1, 2**31 - 1)),
        ("a.jpg", jpeg_of(9000, 9000)),
        ("a.jpg", jpeg_of(65000, 65000)),
        ("a.hdr", hdr_of(32000, 60000)),
        ("a.hdr", hdr_of(999999, 999999)),
    ],
)
def test_promised_pixels_are_refused_before_memory_is_taken(tmp_path, name, contents):
    (tmp_path / name).write_bytes(contents)
    ledger = Ledger(tmp_path / "scene", False)
    tracemalloc.start()
    with pytest.raises(UsageError, match="claims") as caught:
        read_picture(name, ledger)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    check_message(caught.value)
    assert peak < 2**22  # Pillow is imported


def test_control_a_picture_of_one_colour_may_be_large(tmp_path):
    buffer = BytesIO()
    Image.new("RGB", (1024, 1024), (255, 0, 0)).save(buffer, "png")
    (tmp_path / "a.png").write_bytes(buffer.getvalue())
    pixels = read_picture("a.png", Ledger(tmp_path / "scene", False))
    assert pixels.shape == (1024, 1024, 3)
    assert np.ptp(pixels, axis=(0, 1)).max() == 0


def test_many_bombs_share_one_bound(tmp_path):
    ledger = Ledger(tmp_path / "scene", False)
    for _ in range(8):
        ledger.take(ROOM // 8, "a picture")
    with pytest.raises(UsageError, match="512 MiB and 1100 times"):
        ledger.take(1, "a picture")
    (tmp_path / "a").write_bytes(bytes(10))
    ledger.read("a")
    ledger.take(10 * MOST_EXPANSION, "what these bytes make believable")


def test_pictures_of_other_kinds_are_not_opened(tmp_path):
    """PostScript would be run by another program."""
    (tmp_path / "a.png").write_bytes(
        b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 9 9\n"
    )
    with pytest.raises(
        UsageError, match=r"a\.png is damaged, or not a picture"
    ) as caught:
        read_picture("a.png", Ledger(tmp_path / "scene", False))
    check_message(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('{"shapes": [], "shapes": []}', 'the key "shapes" stands twice'),
        ("[" * 100_000, "it is nested too deeply"),
        ('{"shapes": ' + "9" * 5000 + "}", "a value makes no sense"),
        ("\xff", "is not text in utf-8"),
        ('{"shapes": [', "line 1, column"),
    ],
)
def test_json_that_is_none(tmp_path, text, message):
    (tmp_path / "a.json").write_bytes(text.encode("latin-1"))
    assert message in refusal(tmp_path / "a.json")


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("height", "0", "height is 0; it should be a whole number from 1"),
        ("width", "NaN", "width is nan; it should be a whole number"),
        ("width", "1e308", "width is 1e+308; it should be a whole number"),
        ("width", "2.5", "width is 2.5; it should be a whole number"),
        ("fov_deg", "1" + "0" * 400, "fov_deg is 1000"),
        ("fov_deg", "[[]]", "fov_deg is [[]]; it should be a number"),
        ("fov_deg", "true", "fov_deg is true; it should be a number"),
        ("origin", "[1, 2]", "origin is [1, 2]; it should be three numbers"),
        ("up", '"' + "x" * 999 + '"', "..."),
    ],
)
def test_numbers_of_json(tmp_path, key, value, message):
    camera = {"origin": [0, 0, 4], "target": [0, 0, 0], "fov_deg": 40, key: "HERE"}
    text = json.dumps({"camera": camera, "shapes": []}).replace('"HERE"', value)
    (tmp_path / "a.json").write_text(text)
    told = refusal(tmp_path / "a.json")
    assert message in told
    assert len(told) < 400


@pytest.mark.parametrize("light", ["1e308", "1e31", "inf", "nan"])
def test_light_that_no_picture_holds(tmp_path, light):
    (tmp_path / "a.mtl").write_text(f"newmtl m\nKe {light} 0 0\n")
    (tmp_path / "a.obj").write_text(f"mtllib a.mtl\n{OBJ}usemtl m\nf 1 2 3\n")
    with pytest.raises(UsageError, match='mesh "m": emission') as caught:
        validate(load_scene(tmp_path / "a.obj"))
    check_message(caught.value)


@pytest.mark.parametrize(
    "command",
    ["render", "reference", "plan", "tradeoff", "demo", "check", "golden", "inspect"],
)
def test_every_command_that_reads_a_scene_can_be_told_how(command):
    parser = ArgumentParser()
    import_module(f"restir_gi.reference.cli.{command}").add_arguments(parser)
    told = parser.format_help()
    assert "--lenient" in told
    assert "--allow-outside" in told


# ---------------------------------------------------------------- mutants

PLY_HEAD = (
    b"ply\nformat %s 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
    b"property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
    b"element face 2\nproperty list uchar int vertex_indices\nend_header\n"
)
PLY = PLY_HEAD % b"ascii" + (
    b"0 0 0 9 9 9\n1 0 0 9 9 9\n0 1 0 9 9 9\n1 1 0 9 9 9\n3 0 1 2\n3 1 3 2\n"
)
BINARY = PLY_HEAD % b"binary_little_endian" + b"".join(
    struct.pack("<fffBBB", x, y, 0, 9, 9, 9) for y in (0, 1) for x in (0, 1)
)
BINARY += struct.pack("<B3iB4i", 3, 0, 1, 2, 4, 1, 3, 2, 0)
MTL = (
    b"newmtl m\nKd .5 .5 .5\nKs .1 .1 .1\nNs 50\nillum 2\nmap_Kd -s 2 2 1 t.png\n"
    b"newmtl l\nKd 0 0 0\nKe 3 3 3\nnewmtl g\nNi 1.5\nd .1\nillum 7\n"
)
FACES = "usemtl m\nf 1/1 2/2 3/3\nusemtl l\nf -3/-3 -2/-2 -1/-1\nusemtl g\nf 1 2 3\n"
TREE = {
    "camera": {"origin": [0, 0, 4], "target": [0, 0, 0], "fov_deg": 40, "width": 8},
    "materials": {"m": {"type": "ggx_conductor", "alpha": 0.3}},
    "shapes": [
        {"id": "w", "file": "a.ply", "material": "m", "emission": [1, 2, 3]},
        {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "m"},
    ],
    "lights": [
        {
            "type": "spot",
            "position": [0, 1, 0],
            "direction": [0, 1, 0],
            "intensity": 1,
            "cutoff_deg": 30,
            "beam_deg": 20,
        }
    ],
    "environment": {"file": "e.hdr"},
}
ENVIRONMENT = hdr_of(9, 2) + bytes(range(72))


def whole_files():
    buffer = BytesIO()
    Image.fromarray(np.arange(48, dtype=np.uint8).reshape(4, 4, 3)).save(buffer, "png")
    return {
        "a.obj": f"mtllib a.mtl\n{OBJ}{FACES}".encode(),
        "a.mtl": MTL,
        "a.ply": PLY,
        "b.ply": BINARY,
        "a.json": json.dumps(TREE).encode(),
        "t.png": buffer.getvalue(),
        "e.hdr": ENVIRONMENT,
    }


OPENED = {"a.mtl": "a.obj", "t.png": "a.obj", "e.hdr": "a.json"}
SPICE = (
    b"-1e38",
    b"nan",
    b"1e308",
    b"9" * 400,
    b"\0",
    b"\n",
    b"/",
    b"\\\n",
    b"\xff\xfe",
    b"../",
    b"0",
    b"-",
    b'"',
    b"[" * 60,
    b"4294967295",
    b" ",
    b"f 1 2 3\n",
)


def mutant(whole, rng):
    """A file with one to four cuts, copies, other bytes or other words."""
    data = bytearray(whole)
    for _ in range(rng.integers(1, 5)):
        at, span = rng.integers(0, len(data) + 1), rng.integers(1, 9)
        match rng.integers(0, 5):
            case 0:
                del data[at : at + span]
            case 1:
                data[at:at] = data[at : at + 8 * span]
            case 2:
                data[at : at + span] = rng.bytes(span)
            case 3:
                data[at : at + span] = SPICE[rng.integers(0, len(SPICE))]
            case _:
                data = data[: max(at, 1)] if rng.random() < 0.2 else data
    return bytes(data)


def drive(folder, name, count, seed):
    """Load mutants of one file; each is a scene, or refused in one plain line."""
    files = whole_files()
    for other, contents in files.items():
        (folder / other).write_bytes(contents)
    size = sum(map(len, files.values()))
    rng = np.random.default_rng(seed)
    loaded = refused = 0
    for _ in range(count):
        (folder / name).write_bytes(mutant(files[name], rng) or b"x")
        tracemalloc.reset_peak()
        before = tracemalloc.get_traced_memory()[0]
        try:
            validate(load_scene(folder / OPENED.get(name, name), bool(rng.integers(2))))
            loaded += 1
        except UsageError as error:
            check_message(error)
            refused += 1
        peak = tracemalloc.get_traced_memory()[1] - before
        assert peak < 2**21 + MOST_EXPANSION * size  # 2 MiB: modules, and this test
    return loaded, refused


@pytest.fixture
def traced():
    tracemalloc.start()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield
    tracemalloc.stop()


@pytest.mark.parametrize("name", whole_files())
def test_mutants(tmp_path, traced, name):
    loaded, refused = drive(tmp_path, name, 40, 1)
    # Else the mutants tell nothing: all as good, or none.
    assert loaded
    assert refused


@pytest.mark.slow
@pytest.mark.parametrize("name", whole_files())
def test_many_mutants(tmp_path, traced, name):
    drive(tmp_path, name, 400, 2)


@pytest.mark.parametrize("name", whole_files())
def test_control_the_whole_files_load(tmp_path, name):
    for other, contents in whole_files().items():
        (tmp_path / other).write_bytes(contents)
    scene = load_scene(tmp_path / OPENED.get(name, name))
    assert scene.meshes
    validate(scene)

"""Thousands of damaged glTF files: each is a scene, or is refused in plain words."""

import json
import re
import tracemalloc

import numpy as np
import pytest

from restir_gi.reference.scene.loaders import ledger
from restir_gi.reference.scene.loaders.gltf_buffers import Document
from restir_gi.reference.scene.loaders.load import load_scene
from restir_gi.reference.scene.validation import validate
from restir_gi.reference.system.errors import UsageError
from tests.analytic.rendering import path_traced, world_of
from tests.contracts.gltf_files import png
from tests.contracts.test_gltf_words import whole_file

PYTHON = re.compile(
    r"Error\b|Exception|Traceback|0x[0-9a-f]{6}|NoneType|numpy|_io\.|\bdict\b|\bndarray"
    r"|not subscriptable|index out of|unhashable|positional argument|\bModule"
)
HOSTILE = (
    None, True, -1, 0, 1, 2, 255, 2**31, 2**53, 10**400, 0.5, -0.0, 1e-300, -1e38, 3e38,
    1e308, float("nan"), float("inf"), "", "a.bin", "/dev/zero", "https://a.example/b",
    "data:;base64,AAAA", "data:,", "\ud800\x1b[31m\n", "MASK", "VEC4", [], [[]], [0, 0],
    [1e38, 1e38, 1e38], {}, {"index": 0},
)  # fmt: skip
DEEP = "[" * 5000 + "]" * 5000


def everywhere(tree):
    """Every place in a tree: a container and a key of it."""
    found, waiting = [], [tree]
    while waiting:
        container = waiting.pop()
        keys = container if isinstance(container, dict) else range(len(container))
        for key in keys:
            found.append((container, key))
            if isinstance(container[key], dict | list):
                waiting.append(container[key])
    return found


def with_a_wrong_value(rng, tree):
    """Replace, delete or copy one to three values."""
    for _ in range(rng.integers(1, 4)):
        spots = everywhere(tree)
        container, key = spots[rng.integers(len(spots))]
        deed = rng.integers(8)
        if deed == 0:
            del container[key]
        elif deed == 1:
            other, name = spots[rng.integers(len(spots))]
            container[key] = json.loads(json.dumps(other[name]))
        elif deed == 2 and isinstance(container, list):
            container.extend(container[key : key + 1] * int(rng.integers(1, 20)))
        else:
            container[key] = HOSTILE[rng.integers(len(HOSTILE))]


def with_wrong_bytes(rng, contents):
    """Change, drop or add one to four bytes; or cut the file short."""
    contents = bytearray(contents)
    for _ in range(rng.integers(1, 5)):
        at = int(rng.integers(len(contents)))
        deed = rng.integers(5)
        if deed == 0:
            del contents[at : at + int(rng.integers(1, 9))]
        elif deed == 1:
            contents[at:at] = rng.bytes(int(rng.integers(1, 9)))
        elif deed == 2 and rng.random() < 0.2:
            del contents[at:]
        elif len(contents) > at:
            contents[at] = rng.integers(256)
        if not contents:
            return b"{"
    return bytes(contents)


def mutant(seed, folder):
    """Damaged file: of its JSON or of its bytes, .gltf or .glb."""
    rng = np.random.default_rng(seed)
    path = folder / ("a.glb" if rng.random() < 0.5 else "a.gltf")
    gltf = whole_file()
    if rng.random() < 0.6:
        with_a_wrong_value(rng, gltf.tree)
    try:
        gltf.write(path)
    except (TypeError, KeyError, IndexError, AttributeError, UnicodeError):
        # The writer needs a first buffer that is an object.
        gltf.tree["buffers"] = [{}]
        gltf.write(path)
    contents = path.read_bytes()
    if rng.random() < 0.02:
        contents = contents.replace(b"0.7", DEEP.encode(), 1)
    if rng.random() < 0.4:
        contents = with_wrong_bytes(rng, contents)
    path.write_bytes(contents)
    return path


def outcome(path, lenient):
    """A validated scene, or why not in one line without Python's words."""
    try:
        return validate(load_scene(path, lenient))
    except UsageError as error:
        message = str(error).replace(str(path.parent), "")
        assert "\n" not in message
        assert message.isprintable(), message
        assert not PYTHON.search(message), message
        return message


def tried(seeds, folder):
    """Outcomes of many mutants; how many are scenes."""
    scenes = 0
    for seed in seeds:
        path = mutant(seed, folder)
        found = outcome(path, lenient=bool(seed % 2))
        scenes += not isinstance(found, str)
        path.unlink()
    return scenes


def test_damaged_files_are_scenes_or_refused(tmp_path):
    count = 300
    scenes = tried(range(count), tmp_path)
    # Mutants that all fail alike, or all load, would show nothing.
    assert 0.02 < scenes / count < 0.6


@pytest.mark.slow
def test_thousands_of_damaged_files_are_scenes_or_refused(tmp_path):
    assert tried(range(10_000, 13_000), tmp_path) > 80


@pytest.mark.slow
def test_pictures_of_damaged_files_are_finite_and_not_negative(tmp_path):
    shown = 0
    for seed in range(20_000, 20_200):
        scene = outcome(mutant(seed, tmp_path), lenient=True)
        if isinstance(scene, str):
            continue
        with np.errstate(all="ignore"):
            image = path_traced(world_of(scene, 3), "full")
        assert np.isfinite(image).all(), seed
        assert (image >= 0).all(), seed
        shown += 1
    assert shown > 10


# ---------------------------------------------------------------- memory


def peak_of(path):
    """Bytes of memory that loading takes at most, and what is told."""
    told = ""
    tracemalloc.start()
    try:
        load_scene(path)
    except UsageError as error:
        told = str(error)
    finally:
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
    return peak, told


def swollen(gltf, count):
    """An accessor of many elements and no bytes."""
    words = {"componentType": 5121, "count": count, "type": "VEC2"}
    gltf.tree["accessors"][2] = words


def crowded(gltf, count):
    """Many nodes with one mesh, of a thousand triangles."""
    corners = np.random.default_rng(0).random((3000, 3)).astype(np.float32)
    gltf.mesh({"POSITION": corners})
    first = len(gltf.tree["nodes"])
    gltf.tree["nodes"] += [{"mesh": 1}] * count
    gltf.tree["scenes"][1]["nodes"] += list(range(first, first + count))


def papered(gltf, count):
    """Many materials with one picture, each with a factor of its own."""
    picture = gltf.view(png(np.full((128, 128, 3), 99, np.uint8)))
    gltf.tree["images"][0] = {"bufferView": picture}
    first = len(gltf.tree["materials"])
    gltf.tree["materials"] += [gltf.tree["materials"][0]] * count
    primitive = gltf.tree["meshes"][0]["primitives"][0]
    worn = [primitive | {"material": first + i} for i in range(count)]
    gltf.tree["meshes"][0]["primitives"] += worn


BOMBS = {swollen: 3_000_000, crowded: 50, papered: 50}


@pytest.fixture
def small_room(monkeypatch):
    """So little memory besides the multiple of the bytes that small files show it."""
    monkeypatch.setattr(ledger, "ROOM", 2**20)
    monkeypatch.setattr(ledger, "MOST_EXPANSION", 200)


@pytest.mark.parametrize("bomb", BOMBS, ids=lambda bomb: bomb.__name__)
def test_memory_stays_within_the_stated_multiple(tmp_path, small_room, bomb):
    load_scene(whole_file().write(tmp_path / "b.glb"))  # all imports
    for count in (1, BOMBS[bomb]):
        gltf = whole_file()
        bomb(gltf, count)
        path = gltf.write(tmp_path / "a.glb")
        peak, told = peak_of(path)
        assert peak < ledger.ROOM + ledger.MOST_EXPANSION * path.stat().st_size
    assert "with it the scene takes more memory" in told


def test_control_without_the_claims_the_bound_is_exceeded(tmp_path, monkeypatch):
    gltf = whole_file()
    swollen(gltf, 3_000_000)
    path = gltf.write(tmp_path / "a.glb")
    monkeypatch.setattr(Document, "claim", lambda *_: None)
    peak, _ = peak_of(path)
    assert peak > 2**20 + 200 * path.stat().st_size

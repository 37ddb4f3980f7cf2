"""Hostile Mitsuba scenes: a scene, or one line that says what is wrong."""

import os
import re

import numpy as np
import pytest

from restir_gi.reference.scene.loaders.load import load_scene
from restir_gi.reference.scene.loaders.mitsuba_nodes import mitsuba_session
from restir_gi.reference.scene.validation import validate
from restir_gi.reference.system.errors import UsageError
from tests.contracts.test_mitsuba_forms import FORMS
from tests.contracts.test_mitsuba_room import furnish
from tests.contracts.test_mitsuba_words import serialized

pytest.importorskip("mitsuba", reason="reads Mitsuba XML by the package mitsuba")

PYTHON = re.compile(
    r"Error\b|Exception|Traceback|<[a-z_]+\.|object at 0x|\.py\b|\.cpp\b"
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("hostile")
    (path / "library" / "meshes").mkdir(parents=True)
    furnish(path)
    for name in ("flat.obj", "colored.ply"):
        (path / "library" / "meshes" / name).write_text((path / name).read_text())
    (path / "library" / "meshes" / "parts.serialized").write_bytes(serialized(2))
    (path / "outside").symlink_to("/")
    os.mkfifo(path / "pipe")
    with mitsuba_session():
        yield path


def outcome(folder, contents):
    """The message of the refusal, "" for a scene that loads and is valid."""
    path = folder / "scene.xml"
    path.write_bytes(contents)
    try:
        validate(load_scene(path))
    except UsageError as error:
        return str(error)
    return ""


def scene(body):
    return f'<scene version="3.0.0">{body}</scene>'.encode()


def lamp(radiance):
    emitter = (
        f'<emitter type="area"><rgb name="radiance" value="{radiance}"/></emitter>'
    )
    return scene(f'<shape type="rectangle">{emitter}</shape>')


def file_of(name):
    name = f'<string name="filename" value="{name}"/>'
    return scene(f'<shape type="ply" id="it">{name}</shape>')


CHAIN = "".join(
    f'<bsdf type="twosided" id="b{i}"><ref id="b{i + 1}"/></bsdf>' for i in range(99)
)
GROWTH = "".join(
    f'<shape type="merge" id="m{i}"><ref name="a" id="m{i + 1}"/>'
    f'<ref name="b" id="m{i + 1}"/></shape>'
    for i in range(40)
)
HOSTILE = {
    "deep": (b'<scene version="3.0.0">' + b'<shape type="sphere">' * 9999, "64 deep"),
    "chain": (scene(f'{CHAIN}<bsdf type="diffuse" id="b99"/><shape type="cube">'
                    '<ref id="b0"/></shape>'), "64 deep"),
    "copies without end": (scene(f'{GROWTH}<shape type="cube" id="m40"/>'), "memory"),
    "refers to itself": (scene('<bsdf type="twosided" id="a"><ref id="a"/></bsdf>'
                               '<shape type="cube"><ref id="a"/></shape>'), "circular"),
    "includes itself": (scene('<include filename="scene.xml"/>'), "includes itself"),
    "include outside": (scene('<include filename="/etc/hostname"/>'), "lies outside"),
    "include by a link": (scene('<include filename="outside/etc/hostname"/>'),
                          "lies outside"),
    "include of a pipe": (scene('<include filename="pipe"/>'), "device or a pipe"),
    "include by a parameter": (scene('<default name="x" value="/etc/hostname"/>'
                                     '<include filename="$x"/>'), "made of parameters"),
    "path outside": (scene('<path value="/etc"/>'), "lies outside"),
    "spectrum of a device": (scene('<bsdf type="diffuse"><spectrum name="reflectance"'
                                   ' filename="/dev/zero"/></bsdf>'), "lies outside"),
    "mesh of a device": (file_of("/dev/zero"), "lies outside"),
    "mesh of a pipe": (file_of("pipe"), "not a regular file"),
    "mesh on another machine": (file_of("https://a.b/c.ply"), "not on this machine"),
    "mesh that is a folder": (file_of("library"), "not a regular file"),
    "metal by a path": (scene('<shape type="cube"><bsdf type="conductor"><string '
                              'name="material" value="../../x"/></bsdf></shape>'),
                        "no metal"),
    "entities": (b'<!DOCTYPE a [<!ENTITY x "xx">]><scene version="3.0.0"/>',
                 "entities"),
    "another encoding": (b'<?xml version="1.0" encoding="utf-7"?><scene/>', "UTF-8"),
    "too bright": (lamp("1e308, 1, 1"), "emission is"),
    "not a number": (lamp("nan, 1, 1"), "nan"),
    "negative": (lamp("-1, 1, 1"), "-1"),
    "a radius beyond all": (scene('<shape type="sphere"><float name="radius" '
                                  'value="1e999"/></shape>'), "inf"),
    "a place beyond all": (scene('<shape type="cube"><transform name="to_world">'
                                 '<scale value="1e200"/></transform></shape>'),
                           "beyond 1e+50"),
    "a string for a number": (scene('<shape type="sphere"><string name="radius" '
                                    'value="wide"/></shape>'), "has to be a number"),
    "no index of refraction": (scene('<shape type="sphere"><bsdf type="dielectric">'
                                     '<float name="int_ior" value="1"/><float '
                                     'name="ext_ior" value="0"/></bsdf></shape>'),
                               "ior is inf"),
}  # fmt: skip


LONG = {"copies without end"}


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.slow if name in LONG else ())
        for name in HOSTILE
    ],
)
def test_hostile_scenes_are_refused_in_one_line(folder, name):
    contents, words = HOSTILE[name]
    message = outcome(folder, contents)
    assert words in message
    assert_plain(message)


def assert_plain(message):
    assert "\n" not in message
    assert not PYTHON.search(message.replace("Error parsing", "")), message


TOKENS = re.compile(rb'"[^"]*"|[\w.]+|[<>/="]')
VALUES = [b'"1e308"', b'"nan"', b'"-1"', b'""', b'"$x"', b'"0"', b'"99999999999999999"']
VALUES += [b'"../a.png"', b'"true"', b'"sphere"', b'"1 2 3"', b'"\xc3\xa9"', b'"\x00"']


def mutant(rng):
    """A form of a public scene with one to three of its pieces changed."""
    form = FORMS[str(rng.choice(list(FORMS)))]
    contents = bytearray(scene(f'<path value="library"/>{form}'))
    for _ in range(rng.integers(1, 4)):
        pieces = list(TOKENS.finditer(bytes(contents)))
        one, other = (pieces[i] for i in rng.integers(len(pieces), size=2))
        match rng.integers(5):
            case 0:
                contents[one.start() : one.end()] = b""
            case 1:
                contents[one.start() : one.end()] = other.group()
            case 2:
                values = [p for p in pieces if p.group().startswith(b'"')]
                value = values[rng.integers(len(values))]
                new = VALUES[rng.integers(len(VALUES))]
                contents[value.start() : value.end()] = new
            case 3:
                contents[one.start()] = int(rng.integers(256))
            case _:
                low, high = sorted((one.start(), other.start()))
                contents[low:high] = contents[low:high] * 2
    return bytes(contents)


def mutate(folder, seed, count):
    rng = np.random.default_rng(seed)
    messages = []
    for _ in range(count):
        contents = mutant(rng)
        messages.append(outcome(folder, contents))
        assert_plain(messages[-1])
    return messages


def test_mutants_load_or_are_refused_in_one_line(folder):
    messages = mutate(folder, 1, 120)
    assert len(set(messages)) > 20  # they die of many causes


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2, 5))
def test_many_mutants_load_or_are_refused_in_one_line(folder, seed):
    mutate(folder, seed, 700)


def test_large_meshes_are_weighed_against_their_own_bytes(folder, monkeypatch):
    """A file may take a multiple of its bytes, however often instances show it."""
    from restir_gi.reference.scene.loaders import ledger, mitsuba_shapes

    monkeypatch.setattr(ledger, "ROOM", 0)
    monkeypatch.setattr(mitsuba_shapes, "BYTES", 0)
    mesh = '<shape type="ply"><string name="filename" value="colored.ply"/></shape>'
    group = f'<shape type="shapegroup" id="g">{mesh}</shape>'
    instance = '<shape type="instance"><ref id="g"/></shape>'
    lamp = '<emitter type="constant"/>'
    assert outcome(folder, scene(lamp + group + instance)) == ""
    monkeypatch.setattr(ledger, "MOST_EXPANSION", 2)
    assert "memory" in outcome(folder, scene(lamp + group + 99 * instance))

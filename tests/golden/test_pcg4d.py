"""Known answers of the random streams, for everybody who writes a backend.

``pcg4d.csv`` has a line for each key: pixel, frame, seed, stream, dimension; the fourth
word of the key, 64 stream + dimension; four words of 32 bits; and four numbers in
[0, 1) as hexadecimal floats, which are exact in float32.  The answers are not made by
the code under test but by the plain integers below.  ``pytest -n0 tests/golden
--regenerate`` writes the file again.
"""

import csv
from pathlib import Path

import numpy as np
import pytest

from restir_gi.reference.numerics.rng import (
    DIMENSIONS,
    KeyedUniforms,
    Stream,
    pcg4d,
    to_unit_interval,
)

FILE = Path(__file__).with_name("pcg4d.csv")
KEY = ["pixel", "frame", "seed", "stream", "dimension"]
WORDS = ["word_x", "word_y", "word_z", "word_w"]
NUMBERS = ["u_x", "u_y", "u_z", "u_w"]

FIRST, LAST = 0, 2**32 - 1


def keys():
    """Corners of the key space, the start of a render, and places in between."""
    yield from (
        (p, f, s, 0, 0) for p in (FIRST, LAST) for f in (0, LAST) for s in (0, LAST)
    )
    for stream in Stream:
        yield from ((p, 0, 0, int(stream), d) for p in (0, 1) for d in (0, 1, 63))
    pixel, frame, seed = 262143, 7, 12345
    for bit in range(0, 32, 5):
        yield pixel ^ (1 << bit), frame, seed, int(Stream.SPATIAL), bit
        yield pixel, frame ^ (1 << bit), seed, int(Stream.TEMPORAL), bit
        yield pixel, frame, seed ^ (1 << bit), int(Stream.PATH), bit


def pcg4d_in_integers(x, y, z, w):
    """[Jarzynski20, Listing 5] in Python's integers, one word at a time."""
    mask = 2**32 - 1
    v = [(word * 1664525 + 1013904223) & mask for word in (x, y, z, w)]

    def mix():
        for target, a, b in ((0, 1, 3), (1, 2, 0), (2, 0, 1), (3, 1, 2)):
            v[target] = (v[target] + v[a] * v[b]) & mask

    mix()
    v = [word ^ (word >> 16) for word in v]
    mix()
    return v


def answers():
    """Rows of the file."""
    for pixel, frame, seed, stream, dimension in keys():
        fourth = 64 * stream + dimension
        words = pcg4d_in_integers(pixel, frame, seed, fourth)
        numbers = [(word // 256 / 2**24).hex() for word in words]
        yield [
            pixel, frame, seed, stream, dimension, fourth,
            *(f"0x{word:08x}" for word in words), *numbers,
        ]  # fmt: skip


@pytest.fixture(scope="module")
def golden(regenerate):
    """Rows of the file as dictionaries."""
    if regenerate:
        with FILE.open("w", newline="", encoding="ascii") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow([*KEY, "key_w", *WORDS, *NUMBERS])
            writer.writerows(answers())
    with FILE.open(newline="", encoding="ascii") as file:
        return list(csv.DictReader(file))


def test_the_file_is_what_plain_integers_say(golden):
    expected = [[str(value) for value in row] for row in answers()]
    assert [list(row.values()) for row in golden] == expected


def test_the_hash_gives_the_words(golden):
    names = ["pixel", "frame", "seed", "key_w"]
    key = (np.array([int(row[name]) for row in golden], np.uint32) for name in names)
    for name, found in zip(WORDS, pcg4d(*key), strict=True):
        assert found.dtype == np.uint32
        assert [f"0x{word:08x}" for word in found] == [row[name] for row in golden]


def test_the_words_give_the_numbers(golden):
    for word, number in zip(WORDS, NUMBERS, strict=True):
        bits = np.array([int(row[word], 16) for row in golden], np.uint32)
        found = to_unit_interval(bits)
        assert [u.hex() for u in found.tolist()] == [row[number] for row in golden]
        # Exact in float32.
        assert (found.astype(np.float32) == found).all()


def test_the_streams_give_the_numbers(golden):
    for row in golden:
        pixel, frame, seed, stream, dimension = (int(row[name]) for name in KEY)
        key = np.array([pixel], np.uint32), frame, seed, Stream(stream)
        found = KeyedUniforms(*key).draw(dimension)
        assert [u[0].hex() for u in found] == [row[name] for name in NUMBERS]


def test_every_stream_has_64_dimensions_of_its_own():
    assert DIMENSIONS == 64
    assert sorted(Stream) == list(range(len(Stream)))

"""Files that are no image for us: one line each, and nothing else on any stream."""

import os
import re
import struct
import sys

import numpy as np
import OpenEXR
import pytest

from restir_gi.reference.images.exr import read_exr, write_exr
from restir_gi.reference.images.image import Image
from restir_gi.reference.system.errors import UsageError

SCAN = {"type": OpenEXR.scanlineimage, "compression": OpenEXR.ZIP_COMPRESSION}
RNG = np.random.default_rng(0)
RGB = RNG.random((16, 20, 3), np.float32)
Y = RGB[..., 0].copy()


@pytest.fixture
def good(tmp_path):
    """Write a file of ours with an extra layer, and return its bytes."""
    image = Image({"color": RGB, "standard_error": RGB}, {"scene": "cornell-box"})
    write_exr(tmp_path / "good.exr", image)
    return (tmp_path / "good.exr").read_bytes()


@pytest.fixture
def refuse(tmp_path, capfd):
    """Read bytes that must be refused, and return the message without the path."""

    def read(contents):
        path = tmp_path / "bad.exr"
        path.write_bytes(contents)
        with pytest.raises(UsageError) as error:
            read_exr(path)
        message = str(error.value)
        assert len(message.splitlines()) == 1
        assert str(path) in message
        # The library's own C++ chatter would break --json and the one line.
        assert capfd.readouterr() == ("", "")
        return message.replace(str(path), "", 1)

    return read


@pytest.fixture
def foreign(tmp_path):
    """Write a file the library's own way, and return its bytes."""

    def write(channels, header=SCAN):
        OpenEXR.File(dict(header), channels).write(str(tmp_path / "foreign.exr"))
        return (tmp_path / "foreign.exr").read_bytes()

    return write


# ---------------------------------------------------------------- damaged


def test_empty(refuse):
    assert "is empty" in refuse(b"")


@pytest.mark.parametrize("contents", [b"\x89PNG\r\n\x1a\n", b"v/1", b"\n" * 2000])
def test_not_openexr(refuse, contents):
    assert "is not an OpenEXR file" in refuse(contents)


@pytest.mark.parametrize("share", [0.01, 0.05, 0.1, 0.2, 0.5, 0.9, 0.999])
def test_truncated(refuse, good, share):
    message = refuse(good[: int(share * len(good))])
    assert "makes no sense" in message or "truncated or corrupt" in message


def test_pixels_that_cannot_be_decompressed(refuse, good):
    middle = len(good) // 2
    damaged = good[:middle] + bytes(64) + good[middle + 64 :]
    assert "truncated or corrupt" in refuse(damaged)


def test_every_damage_of_a_few_bytes_is_an_image_or_one_line(tmp_path, good, capfd):
    path = tmp_path / "bad.exr"
    messages = set()
    for _ in range(300):
        damaged = bytearray(good)
        for at in RNG.integers(0, 700, 4):
            damaged[at] = RNG.integers(256)
        path.write_bytes(damaged)
        try:
            read_exr(path)
        except UsageError as error:
            messages.add(str(error))
    assert len(messages) > 3
    assert all(len(message.splitlines()) == 1 for message in messages)
    assert capfd.readouterr() == ("", "")


def claim(contents, width, height):
    """Write another size into both windows of a file."""
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    for name in (b"dataWindow", b"displayWindow"):
        at = contents.index(name) + len(name + b"\0box2i\0") + 4
        contents = contents[:at] + window + contents[at + 16 :]
    return contents


@pytest.mark.parametrize("size", [(10**6, 10**6), (30_000, 30_000), (4096, 2048)])
def test_a_header_that_claims_too_much(refuse, good, size):
    """No memory is taken for it: the first would need 24 TB."""
    assert f"claims {size[0]}x{size[1]} pixels" in refuse(claim(good, *size))


def test_more_pixels_than_we_take(refuse, good):
    """Nearly black, such a file could be as small as this one is padded to be."""
    assert "in at most 268435456 pixels" in refuse(
        claim(good, 2**14 + 1, 2**14) + bytes(7_000_000)
    )


def test_a_second_part_that_is_damaged(refuse, tmp_path):
    """The library would hand out the first alone, and say nothing."""
    parts = [
        OpenEXR.Part(dict(SCAN), {"RGB": RGB}, "beauty"),
        OpenEXR.Part(dict(SCAN), {"Z": Y}, "depth"),
    ]
    OpenEXR.File(parts).write(str(tmp_path / "parts.exr"))
    whole = (tmp_path / "parts.exr").read_bytes()
    assert "truncated or corrupt" in refuse(whole[:-20])


def test_the_streams_are_back_after_a_damaged_file(refuse, good, capfd):
    refuse(good[: len(good) // 2])
    sys.stdout.write("out\n")
    os.write(2, b"err\n")
    assert capfd.readouterr() == ("out\n", "err\n")


def test_text_that_is_not_utf8(refuse, good):
    assert "not UTF-8" in refuse(good.replace(b"cornell", b"corn\xe9ll"))


# ---------------------------------------------------------------- foreign


@pytest.mark.parametrize(
    "channels",
    [
        {"X": Y, "Y": Y, "Z": Y},
        {"Z": Y},
        {"r": Y, "g": Y, "b": Y},
        {"R": Y, "G": Y},
        {"left": RGB, "right": RGB},
    ],
    ids=lambda channels: "".join(channels),
)
def test_without_one_picture_the_channels_are_named(refuse, foreign, channels):
    message = refuse(foreign(channels))
    assert "no colour channels R, G, B" in message
    for name in channels:
        assert re.search(rf"[ ,]{name}[,;]", message)


def test_subsampled_channels(refuse, good):
    """As beside luminance: the entry of channel G, with every second pixel only."""
    entry = b"G\0" + struct.pack("<iBxxxii", 2, 0, 1, 1)
    halved = b"G\0" + struct.pack("<iBxxxii", 2, 0, 2, 2)
    assert entry in good
    assert "subsampled channels ['G']" in refuse(good.replace(entry, halved, 1))


def test_deep_samples(refuse, foreign):
    deep = np.empty((2, 3), object)
    for at in np.ndindex(deep.shape):
        deep[at] = np.ones(2, np.float32)
    header = {"type": OpenEXR.deepscanline, "compression": OpenEXR.ZIPS_COMPRESSION}
    assert "deep" in refuse(foreign({"Z": deep}, header))


def test_a_crop(refuse, foreign):
    header = SCAN | {
        "dataWindow": ((3, 2), (22, 17)),
        "displayWindow": ((0, 0), (99, 99)),
    }
    assert "crop" in refuse(foreign({"RGB": RGB}, header))


def test_other_primaries(refuse, foreign):
    aces = (0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, 0.32168, 0.33767)
    message = refuse(foreign({"RGB": RGB}, SCAN | {"chromaticities": aces}))
    assert "Rec. 709" in message


def test_control_the_right_primaries(tmp_path, foreign):
    rec709 = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.329)
    foreign({"RGB": RGB}, SCAN | {"chromaticities": rec709})
    np.testing.assert_array_equal(read_exr(tmp_path / "foreign.exr").color, RGB)

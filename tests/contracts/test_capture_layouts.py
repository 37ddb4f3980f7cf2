"""Reservoirs of known layouts: their bytes are those of the page of packing."""

import re
import struct
from pathlib import Path

import numpy as np
import pytest

from restir_gi.reference.numerics.arrays import normalize
from restir_gi.reference.oracle.capture.kinds import KINDS
from restir_gi.reference.oracle.capture.layouts import LAYOUTS
from restir_gi.reference.oracle.capture.record import Capture
from restir_gi.reference.resampling.packing import paper, restir_pt, rtxdi
from restir_gi.reference.resampling.reservoir import Reservoirs, Samples

PAGE = (Path(__file__).parents[2] / "docs/reference/packing.md").read_text("utf-8")

WORDS = {
    "visible point": "visible_position",
    "its normal": "normal",
    "sample point": "position",
    "radiance": "radiance",
    "confidence": "M",
    "weight": "W",
    "seed": "seed",
    "$M$": "M",
    "age": "age",
    "the application's own": "misc",
    "normal": "normal",
}
"""How the page begins to say what a field is."""

TYPES = {
    "3 × float32": ("float32", 3),
    "3 × float16": ("float16", 3),
    "2 × int16": ("octahedral-snorm16", 3),
    "uint32, [LogLuv]": ("logluv32", 3),
    "uint8": ("uint8", 1),
    "uint16": ("uint16", 1),
    "uint32": ("uint32", 1),
    "float32": ("float32", 1),
}


def rows_of_page(title):
    """Byte, name and type of each field, as the page has them."""
    section = PAGE.partition(f"## {title}\n")[2].partition("\n## ")[0]
    cells = re.findall(r"^\| (\d+) \| ([^|]*) \| ([^|]*) \|", section, re.MULTILINE)
    for byte, what, kind in cells:
        if what.startswith("not used"):
            continue
        name = next(WORDS[word] for word in WORDS if what.startswith(word))
        if "n_v" in what:
            name = "visible_normal"
        yield name, int(byte), *next(TYPES[t] for t in TYPES if kind.startswith(t))


@pytest.mark.parametrize(
    ("layout", "title"), [("paper", "The paper's reservoir"), ("rtxdi", "RTXDI")]
)
def test_fields_stand_where_the_page_says(layout, title):
    found = [
        (f["name"], f["offset"], f["kind"], 3 if KINDS[f["kind"]].columns > 1 else None)
        for f in LAYOUTS[layout].fields
    ]
    page = list(rows_of_page(title))
    assert len(page) == len(found) >= 7
    for (name, byte, kind, columns), mine in zip(page, found, strict=True):
        assert (name, byte, kind) == mine[:3]
        assert mine[3] in (None, columns)


def test_restir_pt_has_an_age_where_the_paper_has_a_seed():
    *same, last = LAYOUTS["restir_pt"].fields
    *others, seed = LAYOUTS["paper"].fields
    assert same == others
    assert (last["name"], seed["name"]) == ("age", "seed")
    assert last["offset"] == seed["offset"] == 44


# ---------------------------------------------------------------- by hand


def one_pixel(layout, data):
    manifest = {"buffers": {"temporal": {"layout": layout, "order": "rows"}}}
    capture = Capture.from_arrays(
        width=1, height=1, frames=[{"temporal": data}], manifest=manifest
    )
    return capture.frames[0]["temporal"]


def test_a_reservoir_of_48_bytes_by_hand():
    data = struct.pack(
        "<3f2h3f2h3eHfI",
        *(1.5, -2.0, 3.25, 0, 0, -4.0, 5.0, 6.5, 32767, 0),
        *(0.5, 1.0, 2.0, 300, 0.125, 7),
    )
    for layout in ("paper", "restir_pt"):
        found = one_pixel(layout, data)
        assert found["visible_position"].tolist() == [[1.5, -2.0, 3.25]]
        assert found["visible_normal"].tolist() == [[0, 0, 1]]
        assert found["position"].tolist() == [[-4.0, 5.0, 6.5]]
        assert found["normal"].tolist() == [[1, 0, 0]]
        assert found["radiance"].tolist() == [[0.5, 1.0, 2.0]]
        assert found["M"].tolist() == [300]
        assert found["W"].tolist() == [0.125]
        last = "seed" if layout == "paper" else "age"
        assert found[last].tolist() == [7]
        assert found.storage == layout
        assert found.words["temporal"].tobytes() == data


def test_a_reservoir_of_rtxdi_by_hand():
    counts = 9 | 4 << 8 | 0xABCD << 16
    data = struct.pack("<3fIIf2hI", 1, 2, 3, counts, 0, 0.5, 0, -32767, 0xFFFFFFFF)
    found = one_pixel("rtxdi", data)
    assert found["position"].tolist() == [[1, 2, 3]]
    assert found["M"].tolist() == [9]
    assert found["age"].tolist() == [4]
    assert found["misc"].tolist() == [0xABCD]
    assert found["radiance"].tolist() == [[0, 0, 0]]
    assert found["W"].tolist() == [0.5]
    assert found["normal"].tolist() == [[0, -1, 0]]
    assert found.formats["radiance"] == "logluv32"


# ---------------------------------------------------------------- whole buffers

WIDTH, HEIGHT = 21, 19  # no multiples of 16
ROWS = WIDTH * HEIGHT


def reservoirs(seed):
    rng = np.random.default_rng(seed)
    y = Samples(
        position=rng.normal(size=(ROWS, 3)),
        normal=normalize(rng.normal(size=(ROWS, 3))),
        radiance=rng.exponential(size=(ROWS, 3)),
    )
    M = rng.integers(0, 30, ROWS).astype(float)
    return Reservoirs(y=y, W=rng.exponential(size=ROWS), M=M)


def captured(table, data):
    capture = Capture.from_arrays(
        width=WIDTH,
        height=HEIGHT,
        frames=[{"spatial": data}],
        manifest={"buffers": {"spatial": table}},
    )
    return capture.frames[0]["spatial"]


def same_reservoirs(found, r):
    for name, expected in (
        ("position", r.y.position),
        ("normal", r.y.normal),
        ("radiance", r.y.radiance),
        ("W", r.W),
        ("M", r.M),
    ):
        assert np.array_equal(found[name], expected), name


@pytest.mark.parametrize("slot", [0, 1, 2])
def test_a_buffer_of_rtxdi_has_blocks(slot):
    """Two arrays of whole blocks and a third, of which one is meant."""
    packed = [
        rtxdi.pack(reservoirs(k), np.arange(ROWS), np.arange(ROWS)) for k in range(3)
    ]
    blocks = 256 * 2 * 2
    data = np.zeros(3 * blocks, rtxdi.RESERVOIR)
    for k, codes in enumerate(packed):
        data[rtxdi.buffer_index(WIDTH, HEIGHT) + k * blocks] = codes
    found = captured({"layout": "rtxdi", "slots": 3, "slot": slot}, data)
    r, age, misc = rtxdi.unpack(packed[slot])
    same_reservoirs(found, r)
    assert np.array_equal(found["age"], age)
    assert np.array_equal(found["misc"], misc)


def test_a_buffer_of_restir_pt_has_slots():
    packed = [
        restir_pt.pack(r.y.position, r.y.normal, r, np.arange(ROWS))
        for r in map(reservoirs, range(2))
    ]
    data = np.concatenate(packed)
    for slot in range(2):
        table = {"layout": "restir_pt", "slots": 2, "slot": slot}
        found = captured(table, data)
        x, n, r, age = restir_pt.unpack(packed[slot])
        same_reservoirs(found, r)
        assert np.array_equal(found["visible_position"], x)
        assert np.array_equal(found["visible_normal"], n)
        assert np.array_equal(found["age"], age)


def test_a_buffer_of_the_paper():
    r = reservoirs(4)
    codes = paper.pack(r.y.position, r.y.normal, r, np.arange(ROWS))
    x, _, stored, seed = paper.unpack(codes)
    found = captured({"layout": "paper"}, codes)
    same_reservoirs(found, stored)
    assert np.array_equal(found["visible_position"], x)
    assert np.array_equal(found["seed"], seed)


def test_control_the_order_matters():
    codes = rtxdi.pack(reservoirs(0), np.arange(ROWS), np.arange(ROWS))
    data = np.zeros(1024, rtxdi.RESERVOIR)
    data[:ROWS] = codes
    found = captured({"layout": "rtxdi"}, data)
    assert not np.array_equal(found["W"], rtxdi.unpack(codes)[0].W)

"""Packed reservoirs against their documented bit fields, and their rounding errors.

Words are made by shifting fields together, without the code that is tested.  They must
be read as those fields say, and written again bit for bit.  Reservoirs of any numbers
must come back within the errors that are stated for each field.
"""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from restir_gi.reference.numerics.arrays import length
from restir_gi.reference.resampling.packing import paper, restir_pt, rtxdi, rtxdi_path
from restir_gi.reference.resampling.packing.components import (
    WORST_ANGLE as WORST_OF_COMPONENTS,
)
from restir_gi.reference.resampling.packing.components import encode_components
from restir_gi.reference.resampling.packing.log_luv import RGB_TO_XYZ
from restir_gi.reference.resampling.packing.octahedral import WORST_ANGLE, encode_normal
from restir_gi.reference.resampling.packing.rounding import nearest_count, nearest_float
from restir_gi.reference.resampling.reservoir import Reservoirs, Samples
from restir_gi.reference.strategies import (
    colors,
    points,
    reservoirs,
    samples,
    scalars,
    unit_vectors,
)
from tests.words import (
    FIELDS,
    PATH_FIELDS,
    UNIT,
    Fields,
    PathFields,
    direction,
    half_value,
    nearest_steps,
    to_bytes,
    words_of_48_bytes,
    words_of_path,
    words_of_rtxdi,
)

EPS = np.finfo(np.float64).eps

EXAMPLE = Fields(
    x_v=(1.5, -2.0, 3.25),
    n_v=(-12345, 23456),
    x_s=(-0.0, 2.0**-140, 7.0),
    n_s=(4321, -321),
    halves=(0x3C01, 0x0001, 0x7BFF),
    log_luv=(9000, 170, 400),
    W=0.3125,
    M=300,
    age=77,
    misc=0xBEEF,
    seed=0xDEADBEEF,
)
"""All fields differ, some are negative: the input of the controls."""

PATH = PathFields(
    x_s=(1.5, -2.0, 3.25),
    W=0.3125,
    n_s=nearest_steps((-3, 5, -4)),
    M=0x5640,
    partial_jacobian=2.75,
    onward_pdf=0.625,
    L_o=(0.25, 7.5, 11.0),
    on_light=False,
    light=0x8000BEEF,
    light_place=0x1234CAFE,
    age=19,
    boosts=True,
    reconnection_vertex=3,
    path_length=7,
    random_index=201,
    target=(1.25, 17.0, 23.0),
    seed=0xDEADBEEF,
)
"""The same of a path."""

# ---------------------------------------------------------------- bit fields


def differ(found, expected, tolerance=0.0):
    """Names of the columns, of one row each, that are not what they should be."""
    return [
        name
        for name, value in expected.items()
        if not np.all(abs(found[name] - np.array(value)) <= tolerance)
    ]


def by_name(codes, dtype):
    """Fields under the same names in another layout."""
    other = np.zeros(len(codes), dtype)
    for name in dtype.names:
        other[name] = codes[name]
    return other


def normals_of(f):
    """Unit normals of the codes of a row."""
    names = ("n_v", "n_s")
    return {name: direction(*np.array(getattr(f, name)) / UNIT) for name in names}


def faults_of_48_bytes(f, layout, last, dtype=None, pack=None):
    """What is wrong in reading and writing one row of the paper or of ReSTIR_PT."""
    dtype, pack = dtype or layout.RESERVOIR, pack or layout.pack
    before = to_bytes(words_of_48_bytes(f, last))
    codes = by_name(np.frombuffer(before, dtype), layout.RESERVOIR)
    x_v, n_v, r, word = layout.unpack(codes)
    found = {"x_v": x_v, "x_s": r.y.position, "L_o": r.y.radiance, "W": r.W, "M": r.M}
    radiance = [half_value(code) for code in f.halves]
    expected = {"x_v": f.x_v, "x_s": f.x_s, "L_o": radiance, "W": f.W, "M": f.M}
    wrong = differ(found | {"last": word}, expected | {"last": last})
    # Both sides round a unit vector: 8 roundings.
    wrong += differ({"n_v": n_v, "n_s": r.y.normal}, normals_of(f), 8 * EPS)
    after = pack(x_v, n_v, r, word)
    return wrong + ["bits"] * (after.tobytes() != before)


def color_of(L, u, v):
    """Luminance and chromaticities x, y of the middle of a cell, or black."""
    Y = 2 ** ((L + 0.5) / 409.6 - 20) if L else 0.0
    u, v = (u + 0.5) / 820, (v + 0.5) / 820
    divisor = 6 * u - 16 * v + 12
    return Y, 9 * u / divisor, 4 * v / divisor


def faults_of_rtxdi(f, dtype=rtxdi.RESERVOIR, pack=rtxdi.pack):
    """What is wrong in reading and writing one row of RTXDI."""
    before = to_bytes(words_of_rtxdi(f))
    codes = by_name(np.frombuffer(before, dtype), rtxdi.RESERVOIR)
    r, age, misc = rtxdi.unpack(codes)
    found = {"x_s": r.y.position, "W": r.W, "M": r.M, "age": age, "misc": misc}
    expected = {"x_s": f.x_s, "W": f.W, "M": f.M & 255, "age": f.age & 255}
    wrong = differ(found, expected | {"misc": f.misc})
    wrong += differ({"n_s": r.y.normal}, {"n_s": normals_of(f)["n_s"]}, 8 * EPS)
    X, Y, Z = RGB_TO_XYZ @ r.y.radiance[0]
    luminance, x, y = color_of(*f.log_luv)
    # Channels of up to 14 times the luminance, in sums of 8 roundings: 128 eps; the
    # exponent, up to 20, is off by a few eps in either formula.
    if not abs(Y - luminance) <= 256 * EPS * luminance:
        wrong.append("luminance")
    total = X + Y + Z
    if luminance and not abs(X - x * total) + abs(Y - y * total) <= 512 * EPS * total:
        wrong.append("chromaticity")
    return wrong + ["bits"] * (pack(r, age, misc).tobytes() != before)


RECORDED = (
    "age",
    "boosts",
    "reconnection_vertex",
    "path_length",
    "random_index",
    "seed",
    "partial_jacobian",
    "onward_pdf",
    "target",
    "on_light",
)


def faults_of_path(f, dtype=rtxdi_path.RESERVOIR, pack=rtxdi_path.pack):
    """What is wrong in reading and writing one row of RTXDI's paths."""
    before = to_bytes(words_of_path(f))
    codes = by_name(np.frombuffer(before, dtype), rtxdi_path.RESERVOIR)
    r, path = rtxdi_path.unpack(codes)
    found = {"x_s": r.y.position, "L_o": r.y.radiance, "W": r.W, "M": r.M}
    radiance = (0, 0, 0) if f.on_light else f.L_o
    expected = {"x_s": f.x_s, "L_o": radiance, "W": f.W, "M": half_value(f.M)}
    found |= {name: getattr(path, name) for name in (*RECORDED, "light", "light_place")}
    expected |= {name: getattr(f, name) for name in RECORDED}
    expected["light"] = f.light * f.on_light
    expected["light_place"] = f.light_place * f.on_light
    found = {name: np.asarray(column, float) for name, column in found.items()}
    wrong = differ(found, expected)
    # A quotient of two numbers that are rounded less than 8 times together.
    normal = np.array(f.n_s) / np.sqrt(np.sum(np.square(f.n_s)))
    wrong += differ({"n_s": r.y.normal}, {"n_s": normal}, 8 * EPS)
    return wrong + ["bits"] * (pack(r, path).tobytes() != before)


@given(FIELDS)
def test_words_of_the_paper(f):
    assert faults_of_48_bytes(f, paper, f.seed) == []


@given(FIELDS)
def test_words_of_restir_pt(f):
    assert faults_of_48_bytes(f, restir_pt, f.age) == []


@given(FIELDS)
def test_words_of_rtxdi(f):
    assert faults_of_rtxdi(f) == []


@given(PATH_FIELDS)
def test_words_of_paths(f):
    assert faults_of_path(f) == []


def reordered(dtype, *names):
    """The fields of a layout in another order."""
    return np.dtype([(name, dtype[name]) for name in names])


@pytest.mark.parametrize(
    "order",
    [
        ("x_s", "n_s", "x_v", "n_v", "L_o", "M", "W", "seed"),
        ("x_v", "n_v", "x_s", "n_s", "M", "L_o", "W", "seed"),
        ("x_v", "n_v", "x_s", "n_s", "L_o", "W", "M", "seed"),
        ("x_v", "n_v", "x_s", "n_s", "L_o", "M", "seed", "W"),
        ("n_v", "x_v", "x_s", "n_s", "L_o", "M", "W", "seed"),
    ],
)
def test_control_another_order_of_the_48_bytes_is_found(order):
    dtype = reordered(paper.RESERVOIR, *order)
    assert faults_of_48_bytes(EXAMPLE, paper, EXAMPLE.seed, dtype) != []


@pytest.mark.parametrize(
    "order",
    [
        ("x_s", "age", "M", "misc", "L_o", "W", "n_s", "unused"),
        ("x_s", "misc", "M", "age", "L_o", "W", "n_s", "unused"),
        ("x_s", "M", "age", "misc", "W", "L_o", "n_s", "unused"),
        ("x_s", "M", "age", "misc", "L_o", "W", "unused", "n_s"),
    ],
)
def test_control_another_order_of_rtxdi_is_found(order):
    assert faults_of_rtxdi(EXAMPLE, reordered(rtxdi.RESERVOIR, *order)) != []


def exchanged(dtype, one, other):
    """A layout with two of its fields in each other's place."""
    names = {one: other, other: one}
    return reordered(dtype, *(names.get(name, name) for name in dtype.names))


@pytest.mark.parametrize("f", [PATH, replace(PATH, on_light=True)])
@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("x_s", "target"),
        ("L_o", "target"),
        ("W", "partial_jacobian"),
        ("partial_jacobian", "onward_pdf"),
        ("n_s", "M"),
        ("age", "reconnection_vertex"),
        ("reconnection_vertex", "path_length"),
        ("path_length", "random_index"),
        ("onward_pdf", "seed"),
    ],
)
def test_control_another_order_of_paths_is_found(f, one, other):
    assert faults_of_path(f) == []
    assert faults_of_path(f, exchanged(rtxdi_path.RESERVOIR, one, other)) != []


def with_path_field(name, change):
    """A writer of paths that changes what it writes into a field."""

    def pack(*row):
        codes = rtxdi_path.pack(*row)
        codes[name] = change(codes[name])
        return codes

    return pack


@pytest.mark.parametrize(
    "pack",
    [
        # Two's complement in place of an offset.
        with_path_field("n_s", lambda n: n - UNIT),
        with_path_field("n_s", lambda n: n + 1),
        with_path_field("M", lambda M: M.astype("u2").view("f2")),
        with_path_field("age", lambda age: age & 31),
        with_path_field("L_o", lambda L: L[:, ::-1]),
        with_path_field("seed", lambda seed: seed.byteswap()),
    ],
)
def test_control_a_wrong_writer_of_paths_is_found(pack):
    assert faults_of_path(PATH, pack=pack) == ["bits"]


def with_field(name, change):
    """A writer of the paper's layout that changes what it writes into a field."""

    def pack(*row):
        codes = paper.pack(*row)
        codes[name] = change(codes[name])
        return codes

    return pack


@pytest.mark.parametrize(
    "pack",
    [
        # The sign of the first component runs over the second.
        with_field("n_v", lambda n: n | np.where(n[:, :1] < 0, [[0, -1]], 0)),
        with_field("n_s", lambda n: n[:, ::-1]),
        with_field("L_o", lambda L: L[:, ::-1]),
        with_field("M", lambda M: np.minimum(M, 255)),
        with_field("W", lambda W: W.astype(np.float16)),
        with_field("seed", lambda seed: seed.byteswap()),
    ],
)
def test_control_a_wrong_writer_is_found(pack):
    f = replace(EXAMPLE, W=float(np.float32(0.1)))
    assert faults_of_48_bytes(f, paper, f.seed) == []
    assert faults_of_48_bytes(f, paper, f.seed, pack=pack) == ["bits"]


# ---------------------------------------------------------------- rounding


def angle(a, b):
    """Angle between unit vectors; twice the arc sine of half the chord."""
    return 2 * np.arcsin(length(a - b) / 2)


def excess(x_v, n_v, r, found):
    """Fields of the paper that came back with more than their stated error.

    Float64 holds the products with 2⁻¹¹ and 2⁻²⁴ and the differences of a number and
    its neighbour of fewer bits: no tolerance.  Only the angle is rounded, as said in
    tests/extremes/test_packing.py.
    """
    found_x_v, found_n_v, found_r, _ = found
    y, found_y = r.y, found_r.y
    off = {
        "x_v": abs(found_x_v - x_v) - np.maximum(2.0**-24 * abs(x_v), 2.0**-150),
        "x_s": abs(found_y.position - y.position)
        - np.maximum(2.0**-24 * abs(y.position), 2.0**-150),
        "L_o": abs(found_y.radiance - y.radiance)
        - np.maximum(2.0**-11 * y.radiance, 2.0**-25),
        "W": abs(found_r.W - r.W) - 2.0**-24 * r.W,
        "M": abs(found_r.M - r.M) - 0.5,
        "n_v": angle(found_n_v, n_v) - WORST_ANGLE * (1 + 1e-10),
        "n_s": angle(found_y.normal, y.normal) - WORST_ANGLE * (1 + 1e-10),
    }
    return [name for name, error in off.items() if (error > 0).any()]


@st.composite
def stored(draw):
    """Visible points, their normals, and reservoirs with confidences of any kind."""
    y = samples(brightest=65504.0)
    r = draw(reservoirs(y=y))
    r = replace(r, M=draw(scalars(1.0, 65535.0)))
    return draw(points()), draw(unit_vectors()), r


SEEDS = np.arange(5, dtype=np.uint32)


@given(stored())
def test_errors_of_the_paper_are_within_their_bounds(row):
    found = paper.unpack(paper.pack(*row, SEEDS))
    assert excess(*row, found) == []
    assert (found[3] == SEEDS).all()


def record_of(r, n):
    """What is stored of paths whose numbers are those of a reservoir."""
    return rtxdi_path.PathRecord(
        *(n, n > 2, n, n, n, n, r.W, r.W, r.y.radiance),
        on_light=n == 1,
        light=n,
        light_place=n,
    )


def excess_of_path(r, path, found, found_path):
    """Fields of a path that came back with more than their stated error.

    Float64 is exact here, but for angles: the bound on them is a sine, which is off by
    1.2e-10 of itself, and unit vectors are by as much as in the tests of the others.
    """
    floats = {"x_s": (r.y.position, found.y.position), "W": (r.W, found.W)}
    radiance = np.where(path.on_light[:, None], 0, r.y.radiance)
    floats["L_o"] = (radiance, found.y.radiance)
    for name in ("partial_jacobian", "onward_pdf", "target"):
        floats[name] = (getattr(path, name), getattr(found_path, name))
    off = {
        name: abs(b - a) - np.maximum(2.0**-24 * abs(a), 2.0**-150)
        for name, (a, b) in floats.items()
    }
    M = np.minimum(r.M, 65504)
    exact = (np.rint(M) == M) & (M <= 2048)
    off["M"] = abs(found.M - M) - np.where(exact, 0, 2.0**-11 * M)
    off["n_s"] = angle(found.y.normal, r.y.normal) - WORST_OF_COMPONENTS * (1 + 1e-9)
    return [name for name, error in off.items() if (error > 0).any()]


@given(stored())
def test_errors_of_paths_are_within_their_bounds(row):
    r, path = row[2], record_of(row[2], SEEDS)
    found = rtxdi_path.unpack(rtxdi_path.pack(r, path))
    assert excess_of_path(r, path, *found) == []


def test_control_paths_with_errors_exceed_the_bounds():
    # Whatever a hair below a number of 24 bits, or half a step, can show.
    below = np.full((1, 3), 1 + 2.0**-22 - 2.0**-40)
    normal = np.array([[0.6, 0.0, 0.8]])
    y = Samples(position=below, normal=normal, radiance=below)
    r, n = Reservoirs(y, W=below[:, 0], M=np.array([2.75])), np.zeros(1, np.uint32)
    path = record_of(r, n)
    codes = rtxdi_path.pack(r, path)
    assert excess_of_path(r, path, *rtxdi_path.unpack(codes)) == []
    for name in ("x_s", "W", "partial_jacobian", "onward_pdf", "target"):
        wrong = codes.copy()
        wrong[name] = toward_0(wrong[name].astype(float) - 2.0**-23, np.float32)
        assert excess_of_path(r, path, *rtxdi_path.unpack(wrong)) == [name]
    wrong = codes.copy()
    wrong["n_s"] = encode_components(normal * [1, 1, -1])
    wrong["M"] = 2
    assert excess_of_path(r, path, *rtxdi_path.unpack(wrong)) == ["M", "n_s"]


@given(stored())
def test_restir_pt_rounds_as_the_paper(row):
    codes = restir_pt.pack(*row, SEEDS)
    assert codes.tobytes() == paper.pack(*row, SEEDS).tobytes()


@given(stored())
def test_nulls_stay_nulls_and_others_stay_others(row):
    """W = 0 with its M; and from 2⁻²⁰ on no weight becomes 0."""
    *_, r = row
    for found in (
        paper.unpack(paper.pack(*row, SEEDS))[2],
        rtxdi.unpack(rtxdi.pack(r, SEEDS, SEEDS))[0],
        rtxdi_path.unpack(rtxdi_path.pack(r, record_of(r, SEEDS)))[0],
    ):
        assert ((found.W == 0) == (r.W == 0)).all()
        assert (found.M > 0).all()


@given(stored())
def test_twice_is_once(row):
    """What was rounded is not rounded again."""
    once = paper.pack(*row, SEEDS)
    assert paper.pack(*paper.unpack(once)).tobytes() == once.tobytes()
    codes = rtxdi.pack(row[2], SEEDS, SEEDS)
    again = rtxdi.pack(*rtxdi.unpack(codes))
    for name in ("x_s", "M", "age", "misc", "W", "n_s"):
        assert again[name].tobytes() == codes[name].tobytes()


def toward_0(x, dtype):
    """Truncate to a narrower type."""
    nearest = nearest_float(x, dtype)
    return np.where(abs(nearest) > abs(x), np.nextafter(nearest, dtype(0)), nearest)


def rewritten(name, values):
    """A writer of the paper's layout with other values in one field."""

    def pack(x_v, n_v, r, seed):
        codes = paper.pack(x_v, n_v, r, seed)
        codes[name] = values(x_v, n_v, r)
        return codes

    return pack


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("x_v", lambda x_v, n_v, r: toward_0(x_v, np.float32)),
        ("L_o", lambda x_v, n_v, r: toward_0(r.y.radiance, np.float16)),
        ("W", lambda x_v, n_v, r: toward_0(r.W, np.float32)),
        ("M", lambda x_v, n_v, r: np.floor(r.M)),
        ("n_v", lambda x_v, n_v, r: encode_normal(n_v * [1, 1, -1])),
        ("n_s", lambda x_v, n_v, r: encode_normal(r.y.normal)[:, ::-1]),
    ],
)
def test_control_truncation_and_exchange_exceed_the_bounds(name, values):
    # A hair below a number of 11 bits: truncated, it loses nearly a whole step.
    below = np.full((1, 3), 1 + 2.0**-10 - 2.0**-40)
    normal = np.array([[0.6, 0.0, 0.8]])
    y = Samples(position=below, normal=normal, radiance=below)
    row = below, normal, Reservoirs(y=y, W=below[:, 0], M=np.array([2.75]))
    pack = rewritten(name, values)
    assert excess(*row, paper.unpack(paper.pack(*row, SEEDS[:1]))) == []
    assert excess(*row, paper.unpack(pack(*row, SEEDS[:1]))) == [name]


@given(colors(), scalars(2.0**-9, 2.0**9))
def test_errors_of_log_luv_are_within_their_bounds(color, scale):
    """Luminance from -8.465e-4 to 1.14e-2 of itself, a channel 0.09 of luminance.

    Beside these bounds, rounded up in the third digit, rounding is nothing.
    """
    color = color * scale[:, None]
    luminance = color @ RGB_TO_XYZ[1]
    y = Samples(color, color, color)
    r = Reservoirs(y, luminance, luminance)
    found = rtxdi.unpack(rtxdi.pack(r, SEEDS, SEEDS))[0].y.radiance
    seen = luminance >= 9.56e-7
    off = (found @ RGB_TO_XYZ[1] - luminance)[seen]
    assert (off >= -8.465e-4 * luminance[seen]).all()
    assert (off <= 1.14e-2 * luminance[seen]).all()
    assert (abs(found - color)[seen] <= 0.09 * luminance[seen, None]).all()
    assert (found[luminance < 9.55e-7] == 0).all()


@given(scalars(0.0, 70000.0))
def test_counts_are_the_nearest_and_never_lose_a_sample(M):
    found = nearest_count(M, 65535)
    exact = [min(max(round(x), 1), 65535) if x > 0 else 0 for x in M.tolist()]
    assert found.tolist() == exact

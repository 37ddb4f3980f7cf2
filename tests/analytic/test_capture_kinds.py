"""Every kind of number of a capture against its definition, code by code.

The definitions are written once more here, with `struct`, whole numbers and fractions.
"""

import math
import struct
from fractions import Fraction

import numpy as np
import pytest

from restir_gi.reference.oracle.capture.kinds import KINDS
from restir_gi.reference.oracle.capture.record import Capture


def read(kind, codes, name="radiance", **keys):
    """What a capture of one row of pixels reads: (N,) or (N, 3)."""
    data = b"".join(codes)
    size = len(codes[0])
    field = {"name": name, "kind": kind, **keys}
    manifest = {
        "buffers": {"it": {"role": "initial", "stride": size, "fields": [field]}}
    }
    height = 64 if len(codes) > 16384 else 1  # a row has no more pixels
    assert len(codes) % height == 0
    capture = Capture.from_arrays(
        width=len(codes) // height,
        height=height,
        frames=[{"it": data}],
        manifest=manifest,
    )
    return capture.frames[0]["initial"][name]


PLAIN = {
    "float32": ("f", [0.0, -0.0, 1.5, -3e38, 1e-45, 0.1]),
    "float64": ("d", [0.0, 0.1, -1e300, 5e-324]),
    "uint8": ("B", range(256)),
    "uint16": ("H", range(65536)),
    "uint32": ("I", [0, 1, 2**31, 2**32 - 1]),
    "int8": ("b", range(-128, 128)),
    "int16": ("h", range(-32768, 32768)),
    "int32": ("i", [-(2**31), -1, 0, 2**31 - 1]),
}


@pytest.mark.parametrize("kind", PLAIN)
def test_plain_numbers_are_what_struct_says(kind):
    letter, values = PLAIN[kind]
    codes = [struct.pack("<" + letter, value) for value in values]
    expected = [struct.unpack("<" + letter, code)[0] for code in codes]
    # M takes all of them, none of which is looked at twice.
    assert read(kind, codes, "M").tolist() == [float(value) for value in expected]


@pytest.mark.parametrize("kind", PLAIN)
def test_big_numbers_come_first_where_that_is_said(kind):
    letter, values = PLAIN[kind]
    values = list(values)[:256]
    data = b"".join(struct.pack(">" + letter, value) for value in values)
    table = {"role": "initial", "byte_order": "big"}
    table["fields"] = [{"name": "M", "kind": kind}]
    capture = Capture.from_arrays(
        width=len(values),
        height=1,
        frames=[{"it": data}],
        manifest={"buffers": {"it": table}},
    )
    expected = [x for (x,) in struct.iter_unpack(">" + letter, data)]
    assert capture.frames[0]["initial"]["M"].tolist() == [float(x) for x in expected]


def test_all_finite_halves():
    codes = [struct.pack("<H", code) for code in range(65536)]
    values = [struct.unpack("<e", code)[0] for code in codes]
    finite = [k for k, value in enumerate(values) if math.isfinite(value)]
    assert len(finite) == 65536 - 2 * 1024
    found = read("float16", [codes[k] for k in finite], "M")
    assert found.tolist() == [values[k] for k in finite]


@pytest.mark.parametrize("bits", [8, 16, 32])
def test_unorm_is_a_fraction_of_the_largest_code(bits):
    codes = range(2**bits) if bits < 32 else [0, 1, 2**31, 2**32 - 2, 2**32 - 1]
    letter = {8: "B", 16: "H", 32: "I"}[bits]
    found = read(f"unorm{bits}", [struct.pack("<" + letter, c) for c in codes], "M")
    # A quotient is rounded once: it is the float64 that is nearest to the fraction.
    assert found.tolist() == [float(Fraction(c, 2**bits - 1)) for c in codes]


@pytest.mark.parametrize("bits", [8, 16])
def test_snorm_is_symmetric_and_has_minus_one_twice(bits):
    most = 2 ** (bits - 1) - 1
    codes = range(-most - 1, most + 1)
    letter = {8: "b", 16: "h"}[bits]
    found = read(f"snorm{bits}", [struct.pack("<" + letter, c) for c in codes], "M")
    assert found.tolist() == [
        float(max(Fraction(c, most), Fraction(-1))) for c in codes
    ]
    assert found[0] == found[1] == -1


# ---------------------------------------------------------------- packed radiance


def of_small_float(code, mantissa_bits):
    """A float without a sign, with five bits of exponent, as a fraction."""
    exponent, mantissa = divmod(code, 2**mantissa_bits)
    share = Fraction(mantissa, 2**mantissa_bits)
    if exponent == 0:
        return share * Fraction(1, 2**14)
    return (1 + share) * Fraction(2) ** (exponent - 15)


def test_r11g11b10f_for_every_finite_code_of_each_channel():
    words, expected = [], []
    for code in range(31 * 64):
        blue = code % (31 * 32)
        green = 31 * 64 - 1 - code
        words.append(struct.pack("<I", code | green << 11 | blue << 22))
        expected.append(
            [float(of_small_float(c, m)) for c, m in ((code, 6), (green, 6), (blue, 5))]
        )
    assert read("r11g11b10f", words).tolist() == expected


def test_rgb9e5_is_mantissas_times_a_power_of_two():
    rng = np.random.default_rng(5)
    cases = [(0, 0, 0, 0), (511, 511, 511, 31), (1, 256, 511, 0), (256, 1, 0, 15)]
    cases += [tuple(map(int, rng.integers(0, (512, 512, 512, 32)))) for _ in range(500)]
    words = [struct.pack("<I", r | g << 9 | b << 18 | e << 27) for r, g, b, e in cases]
    found = read("rgb9e5", words)
    for row, (*channels, e) in zip(found.tolist(), cases, strict=True):
        assert row == [float(c * Fraction(2) ** (e - 15 - 9)) for c in channels]
    assert found.max() == 65408


def solved(columns, right):
    """Solution of three linear equations, by Cramer's rule in fractions."""

    def determinant(a, b, c):
        return (
            a[0] * (b[1] * c[2] - b[2] * c[1])
            - b[0] * (a[1] * c[2] - a[2] * c[1])
            + c[0] * (a[1] * b[2] - a[2] * b[1])
        )

    whole = determinant(*columns)
    replaced = ([*columns[:k], right, *columns[k + 1 :]] for k in range(3))
    return [determinant(*one) / whole for one in replaced]


def of_chromaticity(x, y):
    """X, Y and Z of a colour with Y = 1."""
    x, y = Fraction(x), Fraction(y)
    return [x / y, Fraction(1), (1 - x - y) / y]


def linear_rec709(XYZ):
    """Red, green and blue: how much of each primary makes the colour."""
    primaries = [("0.64", "0.33"), ("0.30", "0.60"), ("0.15", "0.06")]
    columns = [of_chromaticity(*xy) for xy in primaries]
    white = solved(columns, of_chromaticity("0.3127", "0.3290"))
    return [a / b for a, b in zip(solved(columns, XYZ), white, strict=True)]


def test_logluv_is_the_middle_of_its_cell():
    cases = [(8192, 162, 384), (9000, 180, 400), (1, 160, 380), (16383, 160, 385)]
    words = [struct.pack("<I", L << 18 | u << 9 | v) for L, u, v in cases]
    found = read("logluv32", words)
    for row, (L, *uv) in zip(found, cases, strict=True):
        Y = 2.0 ** ((L + 0.5) / 409.6 - 20)
        u, v = ((Fraction(c) + Fraction(1, 2)) / 820 for c in uv)
        X, Z = 9 * u / (4 * v), (12 - 3 * u - 20 * v) / (4 * v)
        expected = [Y * float(c) for c in linear_rec709([X, Fraction(1), Z])]
        # Some dozen operations on numbers of the size of 4 Y, each within 2⁻⁵³.
        np.testing.assert_allclose(row, expected, rtol=0, atol=1e-14 * Y)
    assert not read("logluv32", [struct.pack("<I", 5 << 9)]).any()


# ---------------------------------------------------------------- normals

HALF = math.sqrt(0.5)
KNOWN = {
    (0, 0): (0, 0, 1),
    (1, 0): (1, 0, 0),
    (0, 1): (0, 1, 0),
    (-1, 0): (-1, 0, 0),
    (0, -1): (0, -1, 0),
    (1, 1): (0, 0, -1),
    (-1, -1): (0, 0, -1),
    (0.5, 0): (HALF, 0, HALF),
    (0, -0.5): (0, -HALF, HALF),
    (0.5, 0.5): (HALF, HALF, 0),
    (1, 0.5): (HALF, 0, -HALF),
    (-0.5, 1): (0, HALF, -HALF),
}
"""Places on the square, and where they are on the sphere, by drawing it."""

OCTAHEDRAL = {
    "octahedral-snorm8": ("b", 127, "signed"),
    "octahedral-snorm16": ("h", 32767, "signed"),
    "octahedral-unorm8": ("B", 255, "unsigned"),
    "octahedral-unorm16": ("H", 65535, "unsigned"),
    "octahedral-float16": ("e", None, "signed"),
    "octahedral-float32": ("f", None, "signed"),
    "octahedral-unsigned-float16": ("e", None, "unsigned"),
    "octahedral-unsigned-float32": ("f", None, "unsigned"),
}


def octahedral_codes(kind, places, unit=None):
    letter, own, mapping = OCTAHEDRAL[kind]
    unit = unit or own
    for place in places:
        place = [(x + 1) / 2 for x in place] if mapping == "unsigned" else place
        numbers = [round(x * unit) for x in place] if unit else place
        yield struct.pack("<2" + letter, *numbers)


def test_every_octahedral_kind_is_tried():
    assert set(OCTAHEDRAL) == {name for name in KINDS if name.startswith("octahedral")}
    packed = {"logluv32", "rgb9e5", "r11g11b10f", "float16", "uint64"}
    norms = {f"{sign}norm{bits}" for sign in "us" for bits in (8, 16)} | {"unorm32"}
    assert set(KINDS) == set(OCTAHEDRAL) | set(PLAIN) | packed | norms


@pytest.mark.parametrize("kind", OCTAHEDRAL)
def test_octahedral_normals(kind):
    found = read(kind, list(octahedral_codes(kind, KNOWN)), "normal")
    unit = OCTAHEDRAL[kind][1] or 2.0**11
    # Half a step of each coordinate, 3 / √2 of which turn a normal (octahedral.py); of
    # unsigned ones a step is twice as long.
    steps = 2 if OCTAHEDRAL[kind][2] == "unsigned" else 1
    angle = steps * 3 / (math.sqrt(2) * unit)
    np.testing.assert_allclose(found, list(KNOWN.values()), rtol=0, atol=angle)
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1, rtol=0, atol=1e-15)


def test_a_unit_of_its_own():
    """RTXDI's sample application has 65534 for 1, so that the middle is a code."""
    codes = list(octahedral_codes("octahedral-unorm16", KNOWN, unit=65534))
    found = read("octahedral-unorm16", codes, "normal", unit=65534)
    np.testing.assert_allclose(found[0], (0, 0, 1), rtol=0, atol=0)
    angle = 2 * 3 / (math.sqrt(2) * 65534)
    np.testing.assert_allclose(found, list(KNOWN.values()), rtol=0, atol=angle)


def test_control_another_unit_turns_the_middle():
    codes = list(octahedral_codes("octahedral-unorm16", [(0, 0)], unit=65534))
    assert abs(read("octahedral-unorm16", codes, "normal")[0, 0]) > 1e-6


# ---------------------------------------------------------------- what fields add


@pytest.mark.parametrize("size", [8, 16, 32, 64])
def test_bits_of_words(size):
    letter = {8: "B", 16: "H", 32: "I", 64: "Q"}[size]
    rng = np.random.default_rng(size)
    words = [int.from_bytes(rng.bytes(size // 8)) for _ in range(64)]
    for first, last in ((0, 0), (0, size - 1), (3, 6), (size - 1, size - 1)):
        if last - first >= 32:
            continue
        codes = [struct.pack("<" + letter, word) for word in words]
        found = read(f"uint{size}", codes, "seed", bits=[first, last])
        expected = [(word >> first) % 2 ** (last - first + 1) for word in words]
        assert found.tolist() == expected


def test_scale_and_bias_one_or_many():
    codes = [struct.pack("<3B", *rgb) for rgb in ((0, 128, 255), (1, 2, 3))]
    found = read("unorm8", codes, "normal", scale=2, bias=-1)
    assert found.tolist() == [[2 * (c / 255) - 1 for c in code] for code in codes]
    found = read("uint8", codes, "radiance", scale=[1, 2, 4], bias=[0, 0, 0.5])
    assert found.tolist() == [[r, 2 * g, 4 * b + 0.5] for r, g, b in codes]


def test_vectors_are_normalized_where_that_is_said():
    codes = [struct.pack("<3B", 255, 255, 128), struct.pack("<3B", 128, 200, 128)]
    keys = {"scale": 2 / 255, "bias": -1}
    raw = read("uint8", codes, "normal", **keys)
    found = read("uint8", codes, "normal", normalize=True, **keys)
    assert abs(np.linalg.norm(raw, axis=1) - 1).min() > 0.1
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1, rtol=0, atol=1e-15)
    np.testing.assert_allclose(np.cross(raw, found), 0, rtol=0, atol=1e-15)

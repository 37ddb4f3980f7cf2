"""Packed reservoirs at the ends of each field, and the worst angle of a normal.

What is too large becomes the largest number that fits, what is too small becomes 0,
and nothing becomes infinite or NaN.  The bounds on errors are met, not only kept.
"""

import itertools
import struct

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from restir_gi.reference.numerics.arrays import length, normalize
from restir_gi.reference.resampling.packing import paper, rtxdi, rtxdi_path
from restir_gi.reference.resampling.packing.components import (
    WORST_ANGLE as WORST_OF_COMPONENTS,
)
from restir_gi.reference.resampling.packing.components import (
    decode_components,
    encode_components,
)
from restir_gi.reference.resampling.packing.log_luv import (
    decode_log_luv,
    encode_log_luv,
)
from restir_gi.reference.resampling.packing.octahedral import (
    UNIT,
    WORST_ANGLE,
    decode_normal,
    encode_normal,
)
from restir_gi.reference.resampling.packing.rounding import nearest_count, nearest_float
from restir_gi.reference.resampling.reservoir import Reservoirs, Samples
from tests.words import direction

F32 = np.finfo(np.float32)

# ---------------------------------------------------------------- halves and floats

HALVES = [
    (0.0, 0.0),
    (-0.0, -0.0),
    (2.0**-25, 0.0),  # half of the smallest: a tie, to even
    (2.0**-25 * (1 + 2.0**-50), 2.0**-24),
    (3 * 2.0**-25, 2.0**-23),  # a tie, to even
    (1023 * 2.0**-24, 1023 * 2.0**-24),  # the largest subnormal
    (2.0**-14, 2.0**-14),
    (1 + 2.0**-11, 1.0),  # a tie, to even
    (1 + 3 * 2.0**-11, 1 + 2.0**-9),  # a tie, to even
    (65504.0, 65504.0),
    (65505.0, 65504.0),
    (65519.999, 65504.0),
    (65520.0, 65504.0),  # IEEE 754 rounds this to infinity
    (1e30, 65504.0),
    (1e308, 65504.0),
    (np.inf, 65504.0),
    (-1e30, -65504.0),
    (np.nan, 0.0),
]


def same(a, b):
    """To the bit, signs of 0 included."""
    return a.tobytes() == b.tobytes()


def test_halves_at_their_ends():
    x, expected = np.array(HALVES).T
    found = nearest_float(x, np.float16)
    assert found.dtype == np.float16
    assert same(found.astype(np.float64), expected)


@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.float64])
def test_halves_of_any_floats(dtype):
    """As the standard library packs them, which overflows where these saturate."""
    with np.errstate(over="ignore"):
        x = np.array([0, 2.0**-24, 1e-7, 0.1, 1 / 3, 5.0, 2049, 65504], dtype)
    exact = [struct.unpack("<e", struct.pack("<e", v))[0] for v in x.tolist()]
    assert_array_equal(nearest_float(x, np.float16).astype(np.float64), exact)


def test_floats_at_their_ends():
    largest = float(F32.max)
    x = [largest, largest * (1 + 2.0**-26), 3.5e38, 1e308, np.inf, -1e39, np.nan]
    expected = [largest] * 5 + [-largest, 0.0]
    assert_array_equal(nearest_float(np.array(x), np.float32), np.float32(expected))
    tiny = np.array([2.0**-150, 2.0**-150 * 1.1, 2.0**-149, 1e-320, -0.0])
    found = nearest_float(tiny, np.float32).astype(np.float64)
    assert same(found, np.array([0.0, 2.0**-149, 2.0**-149, 0.0, -0.0]))


HAIR = 2.0**-50
HALF = np.arange(0x7C00, dtype=np.uint16).view(np.float16).astype(np.float64)
MIDDLES = (HALF[1:] + HALF[:-1]) / 2
HARD = np.concatenate([MIDDLES * (1 - HAIR), MIDDLES, MIDDLES * (1 + HAIR)])
HARD = np.concatenate([HARD, HALF[1:] * (1 - HAIR)])
"""Numbers about half-way between neighbouring halves, and a hair below each half."""


def share_of_bound(narrow, x):
    """Largest error over 2⁻¹¹ |x|, or over 2⁻²⁵ below 2⁻¹⁴.  Float64 is exact here."""
    error = abs(narrow(x, np.float16).astype(np.float64) - x)
    return (error / np.maximum(2.0**-11 * x, 2.0**-25)).max()


@pytest.mark.parametrize("x", [HARD[HARD >= 2.0**-14], HARD[HARD < 2.0**-14]])
def test_the_worst_halves_meet_their_bound(x):
    """Relative 2⁻¹¹ is met just above each power of two, absolute 2⁻²⁵ below 2⁻¹⁴."""
    assert 0.999 < share_of_bound(nearest_float, x) <= 1


def truncated(x, dtype):
    narrow = x.astype(dtype)
    return np.where(narrow > x, np.nextafter(narrow, dtype(0)), narrow)


def flushed(x, dtype):
    """Subnormal halves become 0, as some hardware has it."""
    narrow = x.astype(dtype)
    return np.where(x < 2.0**-14, dtype(0), narrow)


@pytest.mark.parametrize("wrong", [truncated, flushed])
def test_control_wrong_halves_exceed_the_bound(wrong):
    assert share_of_bound(wrong, HARD) > 1.5


def test_control_without_saturation_there_is_an_infinity():
    with np.errstate(over="ignore"):
        assert np.isinf(np.array([65520.0, 1e30]).astype(np.float16)).all()


# ---------------------------------------------------------------- counts

COUNTS = [
    (0.0, 0),
    (-3.0, 0),
    (np.nan, 0),
    (1e-300, 1),  # else its sample would be lost
    (0.5, 1),
    (1.5, 2),  # ties to even
    (2.5, 2),
    (30.0, 30),
    (65534.5, 65534),
    (65535.4, 65535),
    (65536.0, 65535),
    (1e30, 65535),
    (np.inf, 65535),
]


def test_counts_at_their_ends():
    M, expected = zip(*COUNTS, strict=True)
    assert nearest_count(np.array(M), 65535).tolist() == list(expected)
    ages = np.array([0, 254, 255, 256, 2**31])
    assert nearest_count(ages, 255).tolist() == [0, 254, 255, 255, 255]


# ---------------------------------------------------------------- whole reservoirs


def reservoirs(radiance, W, M):
    """Rows with given radiance, W and M, at one place."""
    rows = len(W)
    position = np.full((rows, 3), 2.0)
    normal = np.tile([0.0, 0.0, 1.0], (rows, 1))
    y = Samples(position, normal, np.repeat(np.array(radiance)[:, None], 3, axis=1))
    return Reservoirs(y, np.array(W), np.array(M))


def arrays_of(r):
    return r.W, r.M, r.y.position, r.y.normal, r.y.radiance


def record_of(r, n):
    """What is stored of paths whose numbers are those of a reservoir."""
    bright, none = r.y.radiance, np.zeros(len(n), bool)
    return rtxdi_path.PathRecord(
        n, none, n, n, n, n, r.W, r.W, bright, on_light=none, light=n, light_place=n
    )


ENDS = [0.0, 1e-320, 1e-40, 1e-8, 1.0, 65504.0, 65505.0, 1e30, 1e38, 1e39, 1e308]


def test_extreme_reservoirs_stay_finite():
    rows = np.array(list(itertools.product(ENDS, ENDS, ENDS)))
    r = reservoirs(*rows.T)
    x, n, none = r.y.position * 1e300, r.y.normal, np.zeros(len(rows), np.uint32)
    _, _, found, _ = paper.unpack(paper.pack(x, n, r, none))
    paths, record = rtxdi_path.unpack(rtxdi_path.pack(r, record_of(r, none)))
    for array in (
        *arrays_of(found),
        *arrays_of(rtxdi.unpack(rtxdi.pack(r, none, none))[0]),
        *arrays_of(paths),
        *(record.partial_jacobian, record.onward_pdf, record.target),
    ):
        assert np.isfinite(array).all()
    assert not record.on_light.any()
    assert_array_equal(found.W[r.W == 0], 0)
    assert_array_equal(found.M > 0, r.M > 0)


def test_each_field_saturates_at_its_own_end():
    """Radiance is rounded once: by way of float32 two of these would differ."""
    radiance, expected = np.array(HALVES).T
    rows, W, M = (
        len(radiance),
        np.full(len(radiance), 1e39),
        np.full(len(radiance), 1e6),
    )
    r, count = reservoirs(radiance, W, M), np.full(rows, 70000)
    codes = paper.pack(r.y.position, r.y.normal, r, count)
    assert same(codes["L_o"][:, 2].astype(np.float64), expected)
    assert_array_equal(codes["M"], 65535)
    assert_array_equal(codes["W"], F32.max)
    r = reservoirs(radiance, W, np.full(rows, 300.0))
    codes = rtxdi.pack(r, count, np.full(rows, 65535))
    for name, largest in (("M", 255), ("age", 255), ("misc", 65535), ("W", F32.max)):
        assert_array_equal(codes[name], largest)


def test_paths_saturate_and_mask_at_their_ends():
    """Floats and halves become their largest numbers; ages and counts lose bits."""
    radiance, rows = [1e39, np.inf, -np.inf, np.nan], 4
    M = np.array([65505.0, 65520.0, 1e30, 2049.0])
    r = reservoirs(radiance, np.full(rows, 1e39), M)
    record = record_of(r, np.array([31, 32, 256 + 77, 2**32 - 1]))
    codes = rtxdi_path.pack(r, record)
    assert codes["M"].tolist() == [65504, 65504, 65504, 2048]
    assert_array_equal(codes["W"], F32.max)
    largest = [F32.max, F32.max, -F32.max, 0]
    assert_array_equal(codes["L_o"].view("f4"), np.repeat([largest], 3, axis=0).T)
    assert codes["age"].tolist() == [31, 0, 13, 31]
    for name in ("reconnection_vertex", "path_length", "random_index"):
        assert codes[name].tolist() == [31, 32, 77, 255]


def test_an_infinite_red_stands_for_a_light():
    """Of either sign, whatever the other two words are; NaN is none."""
    codes = np.zeros(3, rtxdi_path.RESERVOIR)
    codes["L_o"] = [[0x7F800000, 1, 2], [0xFF800000, 3, 0x7F800000], [0x7FC00000, 4, 5]]
    r, path = rtxdi_path.unpack(codes)
    assert path.on_light.tolist() == [True, True, False]
    assert path.light.tolist() == [1, 3, 0]
    assert path.light_place.tolist() == [2, 0x7F800000, 0]
    assert_array_equal(r.y.radiance[:2], 0)
    assert (rtxdi_path.pack(r, path)["L_o"][:2, 0] == 0x7F800000).all()


def test_a_null_without_a_normal_is_stored_and_stays_a_null():
    """A miss may leave zeros everywhere; its normal is then read as +z."""
    nothing = np.zeros((1, 3))
    r = Reservoirs(Samples(nothing, nothing, nothing), np.zeros(1), np.array([7.0]))
    zero = np.zeros(1, np.uint32)
    _, n_v, found, _ = paper.unpack(paper.pack(nothing, nothing, r, zero))
    assert (found.W[0], found.M[0]) == (0, 7)
    assert_array_equal(n_v, [[0, 0, 1]])
    assert_array_equal(found.y.normal, [[0, 0, 1]])


# ---------------------------------------------------------------- normals

Z, T = np.float64(0.0), 1 / np.sqrt(2)

AXES = [
    # Normal, code.
    ((0, 0, 1), (0, 0)),
    ((0, 0, -1), (UNIT, UNIT)),
    ((1, 0, 0), (UNIT, 0)),
    ((-1, 0, 0), (-UNIT, 0)),
    ((0, 1, 0), (0, UNIT)),
    ((0, -1, 0), (0, -UNIT)),
    # Negative zeros are zeros: the same normals, the same codes.
    ((-Z, -Z, 1), (0, 0)),
    ((-Z, -Z, -1), (UNIT, UNIT)),
    ((1, -Z, -Z), (UNIT, 0)),
    ((-Z, 1, -Z), (0, UNIT)),
    # The lower half of the planes x = 0 and y = 0 is on the rim: sign 0 = +1.
    ((T, 0, -T), (UNIT, 16384)),
    ((T, -Z, -T), (UNIT, 16384)),
    ((-T, -Z, -T), (-UNIT, 16384)),
    ((-Z, T, -T), (16384, UNIT)),
    ((0, -T, -T), (16384, -UNIT)),
    # A hair to the other side of such a plane is the other end, but the same code.
    ((T, -1e-300, -T), (UNIT, 16384)),
    ((-1e-300, T, -T), (16384, UNIT)),
    ((-1e-300, -1e-300, -1), (UNIT, UNIT)),
    # The equator, and a hair below it.
    ((T, T, 0), (16384, 16384)),
    ((T, T, -1e-300), (16384, 16384)),
    ((-T, T, -Z), (-16384, 16384)),
]


@pytest.mark.parametrize(("normal", "code"), AXES)
def test_normals_on_axes_planes_and_folds(normal, code):
    """16383.5 is a tie, and goes to 16384."""
    assert encode_normal(np.array([normal], np.float64)).tolist() == [list(code)]


def test_axes_are_read_exactly():
    axes = np.array([normal for normal, _ in AXES[:6]], np.float64)
    assert_array_equal(decode_normal(encode_normal(axes)), axes)


@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.float64])
def test_normals_of_any_floats(dtype):
    n = normalize(np.array([[1.0, 2, -3], [-5, 0.1, 2], [1, 1, 1]])).astype(dtype)
    assert_array_equal(encode_normal(n), encode_normal(n.astype(np.float64)))


def test_what_is_no_direction_is_z():
    odd = np.array([[0.0, 0, 0], [np.nan, 0, 0], [np.inf, np.nan, 0]])
    assert_array_equal(encode_normal(odd), 0)


def test_the_lowest_code_is_read_as_its_neighbor():
    low = np.array([[-32768, 0], [0, -32768], [-32768, 32767]], np.int16)
    assert_array_equal(decode_normal(low), decode_normal(np.maximum(low, -UNIT)))


def spiral(rows):
    """Directions that cover the sphere evenly."""
    k = np.arange(rows) + 0.5
    z, phi = 1 - 2 * k / rows, np.pi * (1 + 5**0.5) * k
    s = np.sqrt(1 - z * z)
    return np.stack([s * np.cos(phi), s * np.sin(phi), z], axis=-1)


def corners_of_cells():
    """Directions half-way between four codes: about all middles, edges and corners.

    The middles of the eight faces are nearest to the centre: there the bound is met.
    """
    places = [0, UNIT / 3, UNIT / 2, 2 * UNIT / 3, UNIT]
    places = [sign * place for place in places for sign in (1, -1)]
    near = np.arange(-8, 9) + 0.5
    each = np.concatenate([np.floor(place) + near for place in places])
    each = np.unique(each[abs(each) < UNIT])
    u, v = np.meshgrid(each, each)
    return direction(u.ravel() / UNIT, v.ravel() / UNIT)


def planes():
    """Directions of the planes x = 0, y = 0 and z = 0, where the folds are."""
    phi = np.linspace(0, 2 * np.pi, 4001)
    c, s, o = np.cos(phi), np.sin(phi), np.zeros(4001)
    return np.concatenate([np.stack(p, -1) for p in ((o, c, s), (c, o, s), (c, s, o))])


def worst_angle(encode):
    """Largest angle between a normal and its decoded code, over a dense set."""
    n = normalize(np.concatenate([spiral(200_000), corners_of_cells(), planes()]))
    chord = length(n - decode_normal(encode(n)))
    return (2 * np.arcsin(chord / 2)).max()


def test_the_worst_angle_meets_its_bound():
    """3 / (√2 · 32767) = 6.474e-5 radians.

    A coordinate, up to 32767, takes five roundings: it is rounded as if it were off by
    32767 · 5 eps/2 < 2e-11 steps, 4e-11 of half a step.  The unit vectors and their
    chord are off by less than 4 eps, 2e-11 of the bound.  Together less than 1e-10.
    """
    assert_allclose(WORST_ANGLE, 6.474e-5, rtol=1e-4)
    assert 0.999 * WORST_ANGLE < worst_angle(encode_normal) <= WORST_ANGLE * (1 + 1e-10)


def planted(fold, round_off):
    """An encoder with a fold and a rounding of its own."""

    def encode(n):
        p = n[:, :2] / abs(n).sum(axis=1, keepdims=True)
        p = np.where(n[:, 2:] < 0, fold(p), p)
        return round_off(UNIT * p).astype(np.int16)

    return encode


def fold(p):
    return (1 - abs(p[:, ::-1])) * np.where(p < 0, -1, 1)


def test_the_planted_encoder_without_a_mistake_is_right():
    assert worst_angle(planted(fold, np.rint)) <= WORST_ANGLE * (1 + 1e-10)


@pytest.mark.parametrize(
    "wrong",
    [
        planted(fold, np.trunc),
        planted(fold, np.floor),
        planted(lambda p: p, np.rint),
        planted(lambda p: (1 - abs(p)) * np.where(p < 0, -1, 1), np.rint),
        planted(lambda p: (1 - abs(p[:, ::-1])) * np.sign(p), np.rint),
        planted(lambda p: 1 - abs(p[:, ::-1]), np.rint),
        lambda n: np.rint(planted(fold, np.rint)(n) * (32766 / UNIT)).astype(np.int16),
    ],
    ids=["truncated", "floor", "no fold", "u for v", "sign 0", "no sign", "scale"],
)
def test_control_wrong_encoders_exceed_the_angle(wrong):
    assert worst_angle(wrong) > 1.2 * WORST_ANGLE


# ---------------------------------------------------------------- components


def worst_of_components(encode):
    """Largest angle of normals in three components, over a dense set."""
    rng = np.random.default_rng(64)
    # All three components half-way between codes, and nearly perpendicular to what that
    # leaves: (x, y, z) with x + y + z = 0, where all are rounded to the same side.
    x, y = rng.uniform(-0.7, 0.7, (2, 400_000))
    across = np.rint(UNIT * normalize(np.stack([x, y, -x - y], axis=-1))) + 0.5
    n = normalize(np.concatenate([spiral(200_000), across, across - 1e-6]))
    chord = length(n - decode_components(encode(n)))
    return (2 * np.arcsin(chord / 2)).max()


def test_the_worst_angle_of_components_meets_its_bound():
    """√3 / (2 · 32767); the sine of it, and roundings, are 1e-9 of the bound at most.

    To be near it all three components have to be half-way at once, and so they are in
    some of many directions.
    """
    assert_allclose(WORST_OF_COMPONENTS, 2.643e-5, rtol=1e-4)
    worst = worst_of_components(encode_components)
    assert 0.98 * WORST_OF_COMPONENTS < worst <= WORST_OF_COMPONENTS * (1 + 1e-9)


def test_control_truncated_components_exceed_the_angle():
    def truncated(n):
        return np.floor(UNIT * n + UNIT).astype(np.uint16)

    assert worst_of_components(truncated) > 1.5 * WORST_OF_COMPONENTS


def test_what_is_no_direction_has_no_components():
    odd = np.array([[0.0, 0, 0], [np.nan, 0, 0], [-0.0, np.nan, 0]])
    assert_array_equal(encode_components(odd), UNIT)
    assert_array_equal(decode_components(encode_components(odd)), 0)
    beyond = np.array([[2.0, -2, 0], [np.inf, -np.inf, 1]])
    assert_array_equal(encode_components(beyond)[:, :2], [[2 * UNIT, 0]] * 2)


# ---------------------------------------------------------------- LogLuv


def levels(luminance):
    """Level that is written for greys."""
    return encode_log_luv(np.repeat(np.array(luminance)[:, None], 3, axis=1)) >> 18


def test_the_darkest_and_the_brightest_level():
    """A grey's luminance is a sum of three terms: off by a few eps, a hair of 1e-12."""
    darkest, top = 2 ** (1 / 409.6 - 20), 2 ** (16383 / 409.6 - 20)
    assert_allclose([darkest, top], [9.553e-7, 1.0468e6], rtol=1e-4)
    x = [0.0, 1e-320, 2.0**-20, darkest * (1 - 1e-12), darkest * (1 + 1e-12)]
    assert levels(x).tolist() == [0, 0, 0, 0, 1]
    x = [top * (1 - 1e-12), top * (1 + 1e-12), 2.0**20, 1e30, 1e300, np.inf]
    assert levels(x).tolist() == [16382, *[16383] * 5]


def test_what_is_too_dark_has_no_chromaticity():
    """The whole word is 0, as it is said, not only its level."""
    dim = 9.5e-7 * np.vstack([np.eye(3), np.ones(3)])
    assert_array_equal(encode_log_luv(dim), 0)


def test_what_is_no_color_is_black():
    odd = np.array([[np.nan] * 3, [-1.0] * 3, [-np.inf, 0, 0]])
    assert_array_equal(encode_log_luv(odd), 0)


def test_negative_channels_count_as_0():
    odd, clean = np.array([[1.0, -5.0, np.nan]]), np.array([[1.0, 0.0, 0.0]])
    assert_array_equal(encode_log_luv(odd), encode_log_luv(clean))


def grey_error(encode):
    """Largest relative error of greys over all levels, at both ends of each."""
    level = np.arange(1, 16384)[:, None] + [1e-9, 0.5, 1 - 1e-9]
    grey = np.repeat(2 ** (level.ravel() / 409.6 - 20)[:, None], 3, axis=1)
    Y = np.array([0.2126390058715104, 0.7151686787677559, 0.0721923153607337])
    return abs(decode_log_luv(encode(grey)) @ Y / grey[:, 0] - 1).max()


def test_greys_meet_the_bound_on_luminance():
    """2^(1/819.2) - 1, where the middle of the cell is inside the triangle: it is."""
    bound = 2 ** (1 / 819.2) - 1
    # 1e-9 of a level is 1.7e-12 of the luminance, 2e-9 of the bound.
    assert 0.999 * bound < grey_error(encode_log_luv) <= bound * (1 + 1e-8)


@pytest.mark.parametrize("off", [-1, 1])
def test_control_a_level_too_low_or_too_high_exceeds_the_bound(off):
    def wrong(color):
        return encode_log_luv(color * 2 ** (off / 819.2))

    assert grey_error(wrong) > 1.5 * (2 ** (1 / 819.2) - 1)

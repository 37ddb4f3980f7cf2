"""Packed reservoirs: all codes of each field, and where the fields stand.

Reading and writing again must give the same bits: for all 65,536 codes of each field of
16 bits, for all levels and all chromaticities of LogLuv, and for each normal that an
encoder writes.  There is nothing to round, so there is no tolerance.
"""

import ctypes
import struct

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from restir_gi.reference.resampling.packing import paper, restir_pt, rtxdi, rtxdi_path
from restir_gi.reference.resampling.packing.components import (
    decode_components,
    encode_components,
)
from restir_gi.reference.resampling.packing.log_luv import (
    RGB_TO_XYZ,
    XYZ_TO_RGB,
    decode_log_luv,
    encode_log_luv,
)
from restir_gi.reference.resampling.packing.octahedral import (
    decode_normal,
    encode_normal,
)
from restir_gi.reference.resampling.packing.rounding import widened
from restir_gi.reference.resampling.reservoir import Reservoirs
from tests.words import (
    IN_GAMUT,
    PRIMARIES,
    UNIT,
    WHITE,
    chroma,
    chroma_cells,
    direction,
    distances_to_sides,
    is_canonical,
)

CODES = np.arange(65536, dtype=np.uint16)
SNORM = CODES.view(np.int16)
EPS = np.finfo(np.float64).eps

# ---------------------------------------------------------------- layouts

FLOAT3, SNORM2 = ctypes.c_float * 3, ctypes.c_int16 * 2


class PaperInC(ctypes.LittleEndianStructure):
    """As a C compiler lays it out: nothing said of packing or alignment."""

    _fields_ = (
        ("x_v", FLOAT3),
        ("n_v", SNORM2),
        ("x_s", FLOAT3),
        ("n_s", SNORM2),
        ("L_o", ctypes.c_uint16 * 3),
        ("M", ctypes.c_uint16),
        ("W", ctypes.c_float),
        ("seed", ctypes.c_uint32),
    )


class RtxdiInC(ctypes.LittleEndianStructure):
    """The same for RTXDI, its word of M, age and misc as bytes."""

    _fields_ = (
        ("x_s", FLOAT3),
        ("M", ctypes.c_uint8),
        ("age", ctypes.c_uint8),
        ("misc", ctypes.c_uint16),
        ("L_o", ctypes.c_uint32),
        ("W", ctypes.c_float),
        ("n_s", SNORM2),
        ("unused", ctypes.c_uint32),
    )


class PathInC(ctypes.LittleEndianStructure):
    """The same for RTXDI's paths, their word of counts as bytes."""

    _fields_ = (
        ("x_s", FLOAT3),
        ("W", ctypes.c_float),
        ("n_s", ctypes.c_uint16 * 3),
        ("M", ctypes.c_uint16),
        ("partial_jacobian", ctypes.c_float),
        ("onward_pdf", ctypes.c_float),
        ("L_o", ctypes.c_uint32 * 3),
        ("age", ctypes.c_uint8),
        ("reconnection_vertex", ctypes.c_uint8),
        ("path_length", ctypes.c_uint8),
        ("random_index", ctypes.c_uint8),
        ("target", FLOAT3),
        ("seed", ctypes.c_uint32),
    )


def places(dtype):
    """Byte where each field begins."""
    return [dtype.fields[name][1] for name in dtype.names]


@pytest.mark.parametrize(
    ("dtype", "in_c", "size"),
    [
        (paper.RESERVOIR, PaperInC, 48),
        (restir_pt.RESERVOIR, PaperInC, 48),
        (rtxdi.RESERVOIR, RtxdiInC, 32),
        (rtxdi_path.RESERVOIR, PathInC, 64),
    ],
)
def test_the_layout_is_that_of_a_struct_in_c_without_gaps(dtype, in_c, size):
    names = [name for name, _ in in_c._fields_]
    sizes = [dtype[name].itemsize for name in dtype.names]
    assert dtype.itemsize == ctypes.sizeof(in_c) == size
    assert places(dtype) == [getattr(in_c, name).offset for name in names]
    assert places(dtype) == [sum(sizes[:i]) for i in range(len(sizes))]


def test_the_fields_of_the_paper_take_the_bytes_that_it_says():
    """Positions 12 each, normals 4 each, three halves, W, M and a seed: 48 in all."""
    sizes = {name: paper.RESERVOIR[name].itemsize for name in paper.RESERVOIR.names}
    assert sizes == {
        "x_v": 12,
        "n_v": 4,
        "x_s": 12,
        "n_s": 4,
        "L_o": 6,
        "M": 2,
        "W": 4,
        "seed": 4,
    }


def test_control_w_before_m_would_leave_gaps_in_c():
    class InC(ctypes.LittleEndianStructure):
        _fields_ = (
            ("L_o", ctypes.c_uint16 * 3),
            ("W", ctypes.c_float),
            ("M", ctypes.c_uint16),
            ("seed", ctypes.c_uint32),
        )

    assert ctypes.sizeof(InC) > 6 + 4 + 2 + 4


def test_memory_of_all_buffers_is_that_of_the_paper():
    """475 MB are MiB; and the 570 and 285 MB that a frame reads and writes are too."""
    assert paper.buffer_bytes(1920, 1080) == 497_664_000
    buffer = paper.buffer_bytes(1920, 1080) / 5 / 2**20
    assert round(5 * buffer, 1) == 474.6
    assert (round(6 * buffer, 0), round(3 * buffer, 0)) == (570, 285)


@pytest.mark.parametrize(("width", "height"), [(1, 1), (16, 16), (17, 33), (40, 5)])
def test_a_buffer_of_rtxdi_is_made_of_blocks(width, height):
    """Written pixel by pixel, in the order of the memory."""
    across, down = (width + 15) // 16, (height + 15) // 16
    memory = [
        (16 * by + y) * width + 16 * bx + x if 16 * bx + x < width else None
        for by in range(down)
        for bx in range(across)
        for y in range(16)
        for x in range(16)
    ]
    memory = [row if row is not None and row < width * height else -1 for row in memory]
    index = rtxdi.buffer_index(width, height)
    assert_array_equal(np.array(memory)[index], np.arange(width * height))
    assert len(memory) == 256 * across * down > index.max()


# ---------------------------------------------------------------- 16-bit fields


def stored(**fields):
    """Reservoirs of the paper that are 0 but for some fields."""
    codes = np.zeros(len(next(iter(fields.values()))), paper.RESERVOIR)
    for name, values in fields.items():
        codes[name] = values
    return codes


def again(codes):
    """Read and written."""
    x_v, n_v, r, seed = paper.unpack(codes)
    return paper.pack(x_v, n_v, r, seed)


def test_all_halves_are_read_as_the_standard_library_reads_them():
    """Infinity becomes 65504 and NaN 0; so it is said."""
    exact = np.array([struct.unpack("<e", struct.pack("<H", c))[0] for c in CODES])
    expected = np.nan_to_num(exact, nan=0.0, posinf=65504.0, neginf=-65504.0)
    halves = CODES.view(np.float16)
    assert widened(halves).tobytes() == expected.tobytes()


def test_all_halves_are_written_as_they_were_read():
    """63,488 finite codes are kept to the bit; the 2048 others become finite ones."""
    halves = np.repeat(CODES.view(np.float16)[:, None], 3, axis=1)
    before = stored(L_o=halves)
    kept = before["L_o"].tobytes()
    after = again(before)["L_o"]
    finite = np.isfinite(halves[:, 0])
    assert finite.sum() == 63_488
    assert after[finite].tobytes() == halves[finite].tobytes()
    assert np.isfinite(after).all()
    assert_array_equal(abs(after[np.isinf(halves)]), 65504)
    assert_array_equal(after[np.isnan(halves)], 0)
    assert before["L_o"].tobytes() == kept


def test_all_m_are_written_as_they_were_read():
    before = stored(M=CODES)
    assert_array_equal(paper.unpack(before)[2].M, np.arange(65536.0))
    assert again(before).tobytes() == before.tobytes()


def test_floats_are_written_as_they_were_read():
    """All signs, exponents and leading 7 bits, with four endings: 262,144 floats."""
    endings = np.array([0x0000, 0x0001, 0x8000, 0xFFFF], np.uint32)
    words = (CODES.astype(np.uint32)[:, None] << 16 | endings).ravel()
    floats = words.view(np.float32)
    after = again(stored(W=floats, x_v=floats[:, None], x_s=floats[:, None]))
    finite = np.isfinite(floats)
    for column in (after["W"], *after["x_v"].T, *after["x_s"].T):
        assert column[finite].tobytes() == floats[finite].tobytes()
        assert_array_equal(abs(column[np.isinf(floats)]), np.finfo(np.float32).max)
        assert_array_equal(column[np.isnan(floats)], 0)


# ---------------------------------------------------------------- normals

PARTNERS = [0, 1, 10922, 16383, 16384, 32766, 32767]
PARTNERS += [-partner for partner in PARTNERS] + [-32768]


def pairs_of_codes():
    """Each code of a component with some of the other, and all codes on the edges."""
    each, some = np.meshgrid(SNORM, np.array(PARTNERS, np.int16))
    one, other = each.ravel(), some.ravel()
    side = np.arange(UNIT + 1)
    signs = np.array([(1, 1), (1, -1), (-1, 1), (-1, -1)])
    # |u| + |v| = 32767, the edge between the halves, and its neighbours on either side.
    edges = [
        (np.stack([side, UNIT - side + step], -1) * sign).clip(-UNIT, UNIT)
        for sign in signs
        for step in (-1, 0, 1)
    ]
    pairs = [np.stack([one, other], -1), np.stack([other, one], -1), *edges]
    return np.concatenate(pairs).astype(np.int16)


PAIRS = pairs_of_codes()
CANONICAL = is_canonical(*PAIRS.astype(np.int64).T)


def twin(codes):
    """Code that is written for the normal of any code."""
    u, v = np.maximum(codes.astype(np.int64), -UNIT).T
    v = np.where(abs(u) == UNIT, abs(v), v)
    u = np.where(abs(v) == UNIT, abs(u), u)
    return np.stack([u, v], axis=-1)


def changed(encode):
    """Pairs that are not written as their twins."""
    return (encode(decode_normal(PAIRS)) != twin(PAIRS)).any(axis=1)


def test_normals_are_written_as_they_were_read():
    """The canonical codes as they are; of the others the one that is the same normal.

    Not canonical are -32768, and on the rim, where codes meet in pairs, those with a
    negative coordinate along the side; so that of the corners only (1, 1) is, for -z.
    """
    assert not changed(encode_normal).any()
    assert_array_equal(twin(PAIRS)[CANONICAL], PAIRS[CANONICAL])
    assert (twin(PAIRS)[~CANONICAL] != PAIRS[~CANONICAL]).any(axis=1).all()
    # All 65,536 codes of either component, canonical but for -32768, were among them.
    for component in range(2):
        found = np.unique(PAIRS[CANONICAL][:, component])
        assert_array_equal(found, np.arange(-UNIT, UNIT + 1))


def test_doubles_of_a_normal_are_read_as_one():
    assert_array_equal(decode_normal(PAIRS), decode_normal(twin(PAIRS)))


def test_normals_are_read_face_by_face():
    """Against the octahedron's triangles; 8 roundings of numbers up to 1."""
    u, v = np.maximum(PAIRS.astype(np.int64), -UNIT).T / UNIT
    error = abs(decode_normal(PAIRS) - direction(u, v))
    assert error.max() <= 8 * EPS


def test_the_lowest_code_is_never_written():
    assert encode_normal(decode_normal(PAIRS)).min() == -UNIT


def without_fold(n):
    total = abs(n).sum(axis=1, keepdims=True)
    return np.rint(UNIT * n[:, :2] / total).astype(np.int16)


def with_sign_0(n):
    """The fold with sign 0 = 0 loses the lower half of the planes x = 0 and y = 0."""
    p = n[:, :2] / abs(n).sum(axis=1, keepdims=True)
    folded = (1 - abs(p[:, ::-1])) * np.sign(p)
    return np.rint(UNIT * np.where(n[:, 2:] < 0, folded, p)).astype(np.int16)


def truncating(n):
    p = n[:, :2] / abs(n).sum(axis=1, keepdims=True)
    folded = (1 - abs(p[:, ::-1])) * np.where(p < 0, -1, 1)
    return (UNIT * np.where(n[:, 2:] < 0, folded, p)).astype(np.int16)


@pytest.mark.parametrize("wrong", [without_fold, with_sign_0, truncating])
def test_control_wrong_encoders_change_codes(wrong):
    assert changed(wrong).any()


# ---------------------------------------------------------------- components


def test_all_codes_of_a_component_are_read_as_steps_from_the_middle():
    """Beside a component of one step, or none: 8 roundings of numbers up to 1."""
    for beside in (0, 1):
        codes = np.full((65536, 3), 32767, np.uint16)
        codes[:, 1], codes[:, 2] = CODES, 32767 + beside
        steps = np.minimum(np.arange(65536.0), 65534) - 32767
        length = np.sqrt(steps**2 + beside)
        length[length == 0] = 1
        expected = np.stack([0 * steps, steps / length, beside / length], axis=-1)
        assert abs(decode_components(codes) - expected).max() <= 8 * EPS


def test_all_codes_of_a_component_are_written():
    """Of unit vectors with that component, the rest of them along x."""
    z = (np.arange(65535) - 32767) / 32767
    n = np.stack([np.sqrt(1 - z * z), 0 * z, z], axis=-1)
    assert_array_equal(encode_components(n)[:, 2], np.arange(65535))
    assert_array_equal(encode_components(-n)[:, 2], np.arange(65535)[::-1])


def test_control_components_in_twos_complement_are_seen():
    codes = np.array([[32767, 32767, 65534]], np.uint16)
    assert_array_equal(decode_components(codes), [[0, 0, 1]])
    assert (decode_components(codes + np.uint16(32769)) != [[0, 0, 1]]).any()


# ---------------------------------------------------------------- LogLuv


def log_luv(L, u, v):
    return (np.asarray(L) << 18 | np.asarray(u) << 9 | np.asarray(v)).astype(np.uint32)


def xyz_of(uv):
    """X, Y, Z of luminance 1 and chromaticities u′, v′, by way of x, y."""
    u, v = np.moveaxis(uv, -1, 0)
    x, y = 9 * u / (6 * u - 16 * v + 12), 4 * v / (6 * u - 16 * v + 12)
    return np.stack([x / y, np.ones_like(y), (1 - x - y) / y], axis=-1)


def test_the_matrix_has_the_primaries_and_the_white_of_rec_709():
    """That defines it, with white of luminance 1.  The sums are of 8 roundings."""
    colors = np.vstack([np.eye(3), np.ones(3)])
    xyz = colors @ RGB_TO_XYZ.T
    xy = xyz[:, :2] / xyz.sum(axis=1, keepdims=True)
    assert_allclose(xy, [*PRIMARIES, WHITE], atol=8 * EPS)
    assert_allclose(xyz[3, 1], 1, atol=8 * EPS)
    assert_allclose(XYZ_TO_RGB @ RGB_TO_XYZ, np.eye(3), atol=64 * EPS)
    assert_array_equal(np.round(RGB_TO_XYZ[1], 4), [0.2126, 0.7152, 0.0722])


@pytest.mark.parametrize("level", [1, 8192, 16383])
def test_all_chromaticities_in_gamut_are_written_as_they_were_read(level):
    words = log_luv(level, *IN_GAMUT.T)
    assert_array_equal(encode_log_luv(decode_log_luv(words)), words)


def test_all_levels_are_written_as_they_were_read():
    L, cell = np.meshgrid(np.arange(1, 16384), np.arange(0, len(IN_GAMUT), 4001))
    words = log_luv(L.ravel(), *IN_GAMUT[cell.ravel()].T)
    assert_array_equal(encode_log_luv(decode_log_luv(words)), words)


def test_level_0_is_black_and_black_is_0():
    words = log_luv(0, *chroma_cells()[0].T)
    assert_array_equal(decode_log_luv(words), 0)
    assert_array_equal(encode_log_luv(np.zeros((1, 3))), 0)


def rounding(color):
    """Writes the nearest chroma code where the reader takes it for truncated."""
    L, xyz = encode_log_luv(color) >> 18, color @ RGB_TO_XYZ.T
    u, v = np.rint(820 * chroma(xyz[:, :2] / xyz.sum(axis=1, keepdims=True))).T
    return log_luv(L, u.astype(np.int64), v.astype(np.int64))


def exchanged(color):
    """Writes v′ where u′ belongs."""
    words = encode_log_luv(color)
    return log_luv(words >> 18, words & 511, words >> 9 & 511)


@pytest.mark.parametrize("wrong", [rounding, exchanged])
def test_control_wrong_writers_of_log_luv_change_words(wrong):
    words = log_luv(8192, *IN_GAMUT.T)
    assert (wrong(decode_log_luv(words)) != words).mean() > 0.1


def cells_that_hold_colors():
    """Cells that overlap the triangle of Rec. 709: no side of either separates them.

    Red-green runs through corners of cells; rounding may not decide for those.
    """
    codes, middle = chroma_cells()
    half = np.array([(1, 1), (1, -1), (-1, 1), (-1, -1)]) / 1640
    corners = middle + half[:, None]
    low, high = corners.min(axis=0), corners.max(axis=0)
    triangle = chroma(PRIMARIES)
    touches = (low <= triangle.max(axis=0)) & (high >= triangle.min(axis=0))
    nearest = distances_to_sides(corners).min(axis=1)
    held = touches.all(axis=1) & (nearest < -EPS).all(axis=0)
    return codes[held], middle[held], corners[:, held]


def test_errors_of_all_colors_of_rec_709():
    """The bounds that the reader states, over each cell that holds a colour.

    In a cell a channel over luminance is a quotient of two linear functions of u′ and
    v′, so that it is furthest from that of the middle at a corner.  Cutting off what is
    negative brings it nearer to any colour.  The level is off by half a step, which
    counts once for the luminance, and for a channel as often as it is the luminance.
    """
    codes, middle, corners = cells_that_hold_colors()
    inside = (distances_to_sides(middle) < 0).all(axis=0)
    assert inside.sum() == len(IN_GAMUT)
    assert round((~inside).mean(), 3) == 0.014
    half_step = 2 ** (1 / 819.2) - 1
    color = decode_log_luv(log_luv(8192, *codes.T)) / 2 ** (8192.5 / 409.6 - 20)
    luminance = color @ RGB_TO_XYZ[1]
    # A channel sums three terms below 16 of 8 roundings; luminance is a mean of them.
    assert_allclose(luminance[inside], 1, atol=128 * EPS)
    assert luminance.min() >= 1 - 128 * EPS
    brightest = luminance.max() * (1 + half_step) - 1
    assert 0.01 < brightest <= 1.14e-2
    channels = xyz_of(middle) @ XYZ_TO_RGB.T
    off = abs(xyz_of(corners) @ XYZ_TO_RGB.T - channels).max()
    bluest = (xyz_of(corners) @ XYZ_TO_RGB.T).max()
    assert 0.08 < off * (1 + half_step) + bluest * half_step <= 0.09


# ---------------------------------------------------------------- any bits


@pytest.mark.parametrize("layout", [paper, restir_pt, rtxdi, rtxdi_path])
def test_any_bits_are_read_as_finite_numbers(layout):
    """And may be written again: reading is total."""
    bits = np.random.default_rng(48).integers(0, 256, (9999, 64), dtype=np.uint8)
    bits = np.vstack([bits, np.full((1, 64), 255, np.uint8)])
    codes = bits[:, : layout.RESERVOIR.itemsize].copy().view(layout.RESERVOIR)[:, 0]
    found = layout.unpack(codes)
    (r,) = [part for part in found if isinstance(part, Reservoirs)]
    vectors = [part for part in found if isinstance(part, np.ndarray)]
    for array in (*vectors, r.W, r.M, r.y.position, r.y.normal, r.y.radiance):
        assert len(array) == len(codes)
        assert np.isfinite(array).all()
    layout.pack(*found)

"""Packed reservoirs as 32-bit words, made by shifting bit fields.

The judges of :mod:`restir_gi.reference.resampling.packing`, without a line of the
project: the words are plain numbers, and floats are made by the standard library's
``struct``.
"""

import struct
from dataclasses import dataclass
from math import hypot

import numpy as np
from hypothesis import strategies as st

UNIT = 32767
LARGEST_FLOAT = struct.unpack("<f", b"\xff\xff\x7f\x7f")[0]

# ---------------------------------------------------------------- bits


def float_bits(x):
    """Word of a number that float32 holds."""
    return struct.unpack("<I", struct.pack("<f", x))[0]


def half_value(code):
    """Number of a 16-bit code."""
    return struct.unpack("<e", code.to_bytes(2, "little"))[0]


def normal_word(code):
    """Two 16-bit integers in two's complement, the first in the low bits."""
    u, v = code
    return (u & 0xFFFF) | (v & 0xFFFF) << 16


def to_bytes(words):
    """Words as they lie in memory, low byte first."""
    return b"".join(word.to_bytes(4, "little") for word in words)


# ---------------------------------------------------------------- codes


def is_canonical(u, v):
    """Which codes an encoder writes: on the rim of the square, half of them."""
    inside = (abs(u) <= UNIT) & (abs(v) <= UNIT)
    return inside & ((abs(u) < UNIT) | (v >= 0)) & ((abs(v) < UNIT) | (u >= 0))


def direction(u, v):
    """Unit vectors of octahedral coordinates in [-1, 1], face by face.

    The upper half is the square |u| + |v| <= 1 seen from +z.  The lower half of each
    quadrant is the same triangle turned over its long side: (u, v) goes to
    (1 - v, 1 - u).
    """
    u, v = np.asarray(u, np.float64), np.asarray(v, np.float64)
    a, b = abs(u), abs(v)
    lower = a + b > 1
    x, y = np.where(lower, 1 - b, a), np.where(lower, 1 - a, b)
    n = np.stack([np.copysign(x, u), np.copysign(y, v), 1 - a - b], axis=-1)
    return n / np.sqrt(np.sum(n * n, axis=-1, keepdims=True))


PRIMARIES = np.array([(0.64, 0.33), (0.30, 0.60), (0.15, 0.06)])
"""Chromaticities x, y of red, green and blue of Rec. 709."""

WHITE = (0.3127, 0.3290)


def chroma(xy):
    """CIE 1976 u′, v′ of chromaticities x, y."""
    x, y = np.moveaxis(np.asarray(xy), -1, 0)
    divisor = -2 * x + 12 * y + 3
    return np.stack([4 * x / divisor, 9 * y / divisor], axis=-1)


def distances_to_sides(uv):
    """How far points are outside of each side of the triangle of Rec. 709."""
    corners = chroma(PRIMARIES)
    result = []
    for i in range(3):
        (ax, ay), (bx, by) = corners[i - 1], corners[i]
        across = np.array([by - ay, ax - bx]) / np.hypot(bx - ax, by - ay)
        third = (corners[i - 2] - corners[i]) @ across
        result.append(-np.sign(third) * ((uv - corners[i]) @ across))
    return np.stack(result)


def chroma_cells():
    """All 2¹⁸ pairs of chroma codes, and their middles."""
    codes = np.stack(np.meshgrid(np.arange(512), np.arange(512), indexing="ij"), -1)
    codes = codes.reshape(-1, 2)
    return codes, (codes + 0.5) / 820


def cells_in_gamut():
    """Chroma codes whose middle is a colour of Rec. 709."""
    codes, middle = chroma_cells()
    return codes[(distances_to_sides(middle) < 0).all(axis=0)]


IN_GAMUT = cells_in_gamut()

# ---------------------------------------------------------------- reservoirs


@dataclass(frozen=True)
class Fields:
    """What one stored reservoir holds, as codes where there are codes.

    Attributes
    ----------
    x_v, x_s : three floats
        Positions that float32 holds.
    n_v, n_s : two ints
        Octahedral codes, canonical.
    halves : three ints
        Codes of radiance in halves.
    log_luv : three ints
        Codes of radiance in LogLuv.
    W : float
        Non-negative, of float32.
    M, age, misc, seed : int
        Whole numbers.
    """

    x_v: tuple
    n_v: tuple
    x_s: tuple
    n_s: tuple
    halves: tuple
    log_luv: tuple
    W: float
    M: int
    age: int
    misc: int
    seed: int


def words_of_48_bytes(f, last):
    """Three times four words: as ReSTIR_PT has them, with the word that comes last."""
    red, green, blue = f.halves
    return [
        *(float_bits(x) for x in f.x_v),
        normal_word(f.n_v),
        *(float_bits(x) for x in f.x_s),
        normal_word(f.n_s),
        red | green << 16,
        blue | f.M << 16,
        float_bits(f.W),
        last,
    ]


def words_of_rtxdi(f):
    """Eight words; M and age have 8 bits."""
    L, u, v = f.log_luv
    return [
        *(float_bits(x) for x in f.x_s),
        f.M & 255 | (f.age & 255) << 8 | f.misc << 16,
        L << 18 | u << 9 | v,
        float_bits(f.W),
        normal_word(f.n_s),
        0,
    ]


INFINITY = 0x7F800000
"""Bits of an infinite float32."""


@dataclass(frozen=True)
class PathFields:
    """What one stored path of RTXDI holds, as codes where there are codes.

    Attributes
    ----------
    x_s, L_o, target : three floats
        That float32 holds.
    W, partial_jacobian, onward_pdf : float
        Non-negative, of float32.
    n_s : three ints
        Steps of 1/32767, from -32767 to 32767, of a unit vector.
    M : int
        Code of a half.
    on_light, boosts : bool
    light, light_place, seed : int
        Of 32 bits.
    age, reconnection_vertex, path_length, random_index : int
        Whole numbers, of which the age has 5 bits, the others 8.
    """

    x_s: tuple
    W: float
    n_s: tuple
    M: int
    partial_jacobian: float
    onward_pdf: float
    L_o: tuple
    on_light: bool
    light: int
    light_place: int
    age: int
    boosts: bool
    reconnection_vertex: int
    path_length: int
    random_index: int
    target: tuple
    seed: int


def words_of_path(f):
    """Sixteen words: four times four."""
    x, y, z = (step + UNIT for step in f.n_s)
    light = (INFINITY, f.light, f.light_place)
    return [
        *(float_bits(c) for c in f.x_s),
        float_bits(f.W),
        x | y << 16,
        z | f.M << 16,
        float_bits(f.partial_jacobian),
        float_bits(f.onward_pdf),
        *(light if f.on_light else (float_bits(c) for c in f.L_o)),
        f.age
        | f.boosts << 7
        | f.reconnection_vertex << 8
        | f.path_length << 16
        | f.random_index << 24,
        *(float_bits(c) for c in f.target),
        f.seed,
    ]


def nearest_steps(v):
    """Steps of 1/32767 that are nearest to the unit vector along v."""
    return tuple(round(UNIT * c / hypot(*v)) for c in v)


@st.composite
def steps_of_directions(draw):
    """Steps that are those of their own direction: its length may move them."""
    steps = nearest_steps(draw(triples(st.integers(-UNIT, UNIT)).filter(any)))
    while nearest_steps(steps) != steps:
        steps = nearest_steps(steps)
    return steps


@st.composite
def canonical_normals(draw):
    """Codes that an encoder writes."""
    u, v = draw(st.integers(-UNIT, UNIT)), draw(st.integers(-UNIT, UNIT))
    v = abs(v) if abs(u) == UNIT else v
    u = abs(u) if abs(v) == UNIT else u
    return u, v


def triples(numbers):
    return st.tuples(numbers, numbers, numbers)


@st.composite
def log_luv_codes(draw):
    """Black, or a colour of Rec. 709."""
    L = draw(st.integers(0, 16383))
    u, v = IN_GAMUT[draw(st.integers(0, len(IN_GAMUT) - 1))].tolist()
    return (L, u, v) if L else (0, 0, 0)


FLOATS = st.floats(-LARGEST_FLOAT, LARGEST_FLOAT, width=32)
HALVES = st.builds(int.__or__, st.integers(0, 0x7BFF), st.sampled_from([0, 0x8000]))
COUNTS = st.integers(0, 65535)
UINT32 = st.integers(0, 2**32 - 1)

FIELDS = st.builds(
    Fields,
    x_v=triples(FLOATS),
    n_v=canonical_normals(),
    x_s=triples(FLOATS),
    n_s=canonical_normals(),
    halves=triples(HALVES),
    log_luv=log_luv_codes(),
    W=st.floats(0, LARGEST_FLOAT, width=32),
    M=COUNTS,
    age=UINT32,
    misc=COUNTS,
    seed=UINT32,
)
"""Reservoirs that any writer may have written: finite, and in canonical codes."""

BYTE, POSITIVE = st.integers(0, 255), st.floats(0, LARGEST_FLOAT, width=32)

PATH_FIELDS = st.builds(
    PathFields,
    x_s=triples(FLOATS),
    W=POSITIVE,
    n_s=steps_of_directions(),
    M=st.integers(0, 0x7BFF),
    partial_jacobian=POSITIVE,
    onward_pdf=POSITIVE,
    L_o=triples(FLOATS),
    on_light=st.booleans(),
    light=UINT32,
    light_place=UINT32,
    age=st.integers(0, 31),
    boosts=st.booleans(),
    reconnection_vertex=BYTE,
    path_length=BYTE,
    random_index=BYTE,
    target=triples(FLOATS),
    seed=UINT32,
)
"""The same for paths."""

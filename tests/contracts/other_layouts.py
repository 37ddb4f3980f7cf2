"""Layouts that have to be declared, in a backend's own type, with shifts and masks.

In the order of operations that a shader has: the matrix of Rec. 709 in sums, by way of
X + Y + Z and of x, y, a reciprocal in place of a quotient.  With mistakes, by name.
"""

import numpy as np

from tests.contracts.other_packing import (
    pack,
    packed_normal,
    units,
    unpack,
    unpacked_normal,
)
from tests.words import PRIMARIES, WHITE

U = np.uint32
LARGEST = np.finfo(np.float32).max


def primaries_to_xyz():
    """Columns are the colours of the primaries, as bright as white needs them."""
    x, y = PRIMARIES.T
    columns = np.stack([x / y, np.ones(3), (1 - x - y) / y])
    white = np.array([WHITE[0], WHITE[1], 1 - sum(WHITE)]) / WHITE[1]
    return columns * np.linalg.solve(columns, white)


TO_XYZ = primaries_to_xyz()
TO_RGB = np.linalg.inv(TO_XYZ)


def through(real, matrix, v):
    """A matrix times the rows of an array, summed backwards."""
    m = matrix.astype(real)
    return [m[i, 2] * v[2] + m[i, 1] * v[1] + m[i, 0] * v[0] for i in range(3)]


def log_luv_words(real, mistake, color):
    """Level and chromaticities, with a reciprocal of the divisor."""
    X, Y, Z = through(real, TO_XYZ, color.T)
    with np.errstate(divide="ignore"):
        log = np.log(Y) if mistake == "natural logarithm" else np.log2(Y)
    level = real(409.6) * (log + real(20))
    half = real(0.5 if mistake == "cells rounded" else 0)
    if mistake == "level of 410 steps":
        level = real(410) * (log + real(20))
    L = np.clip(level + half, 0, 16383).astype(U)
    divisor = real(-2) * X + real(12) * Y + real(3) * (X + Y + Z)
    with np.errstate(divide="ignore"):
        inverse = np.where(divisor > 0, 1 / divisor, 0).astype(real)
    u, v = (
        np.clip(real(820) * (factor * c * inverse) + half, 0, 511).astype(U)
        for factor, c in ((real(4), X), (real(9), Y))
    )
    if mistake == "v′ above u′":
        u, v = v, u
    return np.where(L == 0, U(0), L << U(18) | u << U(9) | v)


def colors_of(real, mistake, words):
    """By way of chromaticities x, y."""
    L, u, v = words >> U(18), words >> U(9) & U(511), words & U(511)
    if mistake == "v′ above u′":
        u, v = v, u
    half = real(0 if mistake == "no half" else 0.5)
    log = (L.astype(real) + half) / real(409.6) - real(20)
    Y = np.exp(log) if mistake == "natural logarithm" else np.power(real(2), log)
    u, v = ((c.astype(real) + half) / real(820) for c in (u, v))
    inverse = 1 / (real(6) * u - real(16) * v + real(12))
    x, y = real(9) * u * inverse, real(4) * v * inverse
    s = Y / y
    rgb = np.stack(through(real, TO_RGB, [s * x, Y, s * (1 - x - y)]), axis=1)
    if mistake != "channels below 0":
        rgb = np.maximum(rgb, 0)
    return np.where((L == 0)[:, None], 0, rgb)


def bits_of(x):
    """Words of numbers that become float32."""
    return np.ascontiguousarray(x).astype(np.float32).view(U)


def with_columns(words, columns):
    """Words of which some are exchanged."""
    found = words.copy()
    for one, other in columns:
        found[:, [one, other]] = words[:, [other, one]]
    return found


def exchanged_bytes(words, pairs):
    """Bytes of each row of which some are exchanged."""
    found = np.ascontiguousarray(words).view(np.uint8).copy()
    before = found.copy()
    for one, other in pairs:
        found[:, one], found[:, other] = before[:, other], before[:, one]
    return found.view(U)


# ------------------------------------------------ ReSTIR_PT


def pack_restir_pt(real, mistake, f):
    """The paper's words, with an age."""
    words = pack(real, mistake, **f, seed=f["age"])["words"]
    return with_columns(words, [(10, 11)] if mistake == "age before W" else [])


def unpack_restir_pt(real, mistake, words):
    """The same, read."""
    words = with_columns(words, [(10, 11)] if mistake == "age before W" else [])
    found = unpack(real, mistake, words)
    return {n: a for n, a in found.items() if n != "seed"} | {"age": found["seed"]}


# ------------------------------------------------ 32 bytes


def count_word(mistake, f):
    """M, age and the application's bits."""
    M, age, misc = f["M"].astype(U), f["age"], f["misc"]
    if mistake == "M wraps":
        M = M & U(255)
    if mistake != "M runs over":
        M = np.minimum(M, U(255))
    if mistake == "age wraps":
        age = age & U(255)
    if mistake != "age runs over":
        age = np.minimum(age, U(255))
    if mistake == "no misc":
        misc = misc & U(0)
    return M | age << U(8) | misc << U(16)


BYTES_OF_RTXDI = {
    "age below M": [(12, 13)],
    "misc below": [(12, 14), (13, 15)],
    "W before radiance": [(16 + k, 20 + k) for k in range(4)],
    "normal last": [(24 + k, 28 + k) for k in range(4)],
}


def pack_rtxdi(real, mistake, f):
    """Eight words."""
    words = np.zeros((len(f["W"]), 8), U)
    words[:, 0:3], words[:, 5] = bits_of(f["position"]), bits_of(f["W"])
    words[:, 3] = count_word(mistake, f)
    words[:, 4] = log_luv_words(real, mistake, f["radiance"])
    words[:, 6] = packed_normal(real, mistake, f["normal"])
    return exchanged_bytes(words, BYTES_OF_RTXDI.get(mistake, []))


def unpack_rtxdi(real, mistake, words):
    """The same, read."""
    words = exchanged_bytes(words, BYTES_OF_RTXDI.get(mistake, []))
    floats = np.nan_to_num(words.view(np.float32), nan=0, posinf=LARGEST)
    counts = words[:, 3]
    return {
        "position": floats[:, 0:3],
        "normal": unpacked_normal(real, mistake, words[:, 6].copy()),
        "radiance": colors_of(real, mistake, words[:, 4]),
        "W": floats[:, 5],
        "M": counts & U(255),
        "age": counts >> U(8) & U(255),
        "misc": counts >> U(16),
    }


# ------------------------------------------------ 64 bytes


BYTES_OF_PATH = {
    "M below z": [(20, 22), (21, 23)],
    "density first": [(24 + k, 28 + k) for k in range(4)],
    "target before radiance": [(32 + k, 48 + k) for k in range(12)],
    "lengths exchanged": [(45, 46)],
    "age above": [(44, 47), (45, 46)],
}
COUNTS = ("reconnection_vertex", "path_length", "random_index")


def components(real, mistake, n):
    """Codes with 32767 for 0, or numbers with a sign."""
    steps = np.clip(n, -1, 1) * real(32767)
    if mistake == "components cut":
        return np.floor(steps + real(32767)).astype(U)
    whole = np.rint(steps).astype(np.int32)
    if mistake == "components with a sign":
        return whole.astype(np.int16).view(np.uint16).astype(U)
    return (whole + 32767).astype(U)


def half_bits(mistake, M):
    """M as a half, cut off as some platforms do, or as a whole number."""
    if mistake == "M is a count":
        return np.rint(np.minimum(M, 65535)).astype(U)
    most = np.inf if mistake == "M overflows" else 65504
    with np.errstate(over="ignore"):
        near = np.minimum(M, most).astype(np.float16)
    cut = np.nextafter(near, np.float16(0))
    near = np.where(np.isfinite(near) & (near.astype(float) > M), cut, near)
    return near.view(np.uint16).astype(U)


def flag_word(mistake, f):
    """Age, flag and counts."""
    age, bit = f["age"], 5 if mistake == "flag above the age" else 7
    if mistake == "age stops":
        age = np.minimum(age, U(31))
    if mistake != "age runs over":
        age = age & U(31)
    word = age | f["boosts"] << U(bit)
    for place, name in enumerate(COUNTS, 1):
        word = word | f[name] << U(8 * place)
    return word


def pack_path(real, mistake, f):
    """Sixteen words."""
    words = np.zeros((len(f["W"]), 16), U)
    words[:, 0:3], words[:, 3] = bits_of(f["position"]), bits_of(f["W"])
    x, y, z = components(real, mistake, f["normal"]).T
    words[:, 4] = x | y << U(16)
    words[:, 5] = z | half_bits(mistake, f["M"]) << U(16)
    words[:, 6] = bits_of(f["partial_jacobian"])
    words[:, 7] = bits_of(f["onward_pdf"])
    words[:, 8:11] = bits_of(f["radiance"])
    if mistake != "no light":
        on_light = f["on_light"] == 1
        infinity = np.full(len(words), np.inf, np.float32).view(U)
        for column, light in ((8, infinity), (9, f["light"]), (10, f["light_place"])):
            words[on_light, column] = light[on_light]
    words[:, 11] = flag_word(mistake, f)
    words[:, 12:15] = bits_of(f["target_function"])
    words[:, 15] = f["seed"]
    return exchanged_bytes(words, BYTES_OF_PATH.get(mistake, []))


def vectors_of(real, mistake, words):
    """Normals of three codes."""
    codes = np.stack([words[:, 4] & U(0xFFFF), words[:, 4] >> U(16)], axis=1)
    codes = np.column_stack([codes, words[:, 5] & U(0xFFFF)]).astype(np.int32)
    if mistake == "components with a sign":
        steps = codes.astype(np.uint16).view(np.int16)
    else:
        steps = codes - 32767
    n = np.clip(steps.astype(real) * real(1 / 32767), -1, 1)
    return n if mistake == "not normalized" else units(n)


def halves_of(codes):
    """Numbers of the codes of halves, which are finite."""
    found = codes.view(np.float16).astype(np.float64)
    return np.nan_to_num(found, nan=0, posinf=65504, neginf=-65504)


def unpack_path(real, mistake, words):
    """The same, read."""
    words = exchanged_bytes(words, BYTES_OF_PATH.get(mistake, []))
    floats = words.view(np.float32)
    finite = np.nan_to_num(floats, nan=0, posinf=LARGEST, neginf=-LARGEST)
    on_light = np.isinf(floats[:, 8]) & (mistake != "no light")
    M = (words[:, 5] >> U(16)).astype(np.uint16)
    flags = words[:, 11]
    bit = U(5 if mistake == "flag above the age" else 7)
    mask = U(255 if mistake == "age not masked" else 31)
    return {
        "position": finite[:, 0:3],
        "normal": vectors_of(real, mistake, words),
        "radiance": np.where(on_light[:, None], 0, finite[:, 8:11]),
        "W": finite[:, 3],
        "M": M if mistake == "M is a count" else halves_of(M),
        "partial_jacobian": finite[:, 6],
        "onward_pdf": finite[:, 7],
        "target_function": finite[:, 12:15],
        "on_light": on_light,
        "light": np.where(on_light, words[:, 9], 0),
        "light_place": np.where(on_light, words[:, 10], 0),
        "age": flags & mask,
        "boosts": flags >> bit & U(1),
        **{n: flags >> U(8 * k) & U(255) for k, n in enumerate(COUNTS, 1)},
        "seed": words[:, 15],
    }


WRITERS = {"restir_pt": pack_restir_pt, "rtxdi": pack_rtxdi, "rtxdi_path": pack_path}
READERS = {
    "restir_pt": unpack_restir_pt,
    "rtxdi": unpack_rtxdi,
    "rtxdi_path": unpack_path,
}


def pack_layout(real, mistake, layout="paper", **f):
    """Pass ``pack`` of any layout."""
    if layout == "paper":
        return pack(real, mistake, **f)
    return {"words": WRITERS[layout](real, mistake, f)}


def unpack_layout(real, mistake, words, layout="paper"):
    """Pass ``unpack`` of any layout."""
    if layout == "paper":
        return unpack(real, mistake, words)
    return READERS[layout](real, mistake, words)

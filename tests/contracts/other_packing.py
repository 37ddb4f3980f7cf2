"""Passes ``pack`` and ``unpack`` in a backend's own type, with shifts and masks.

As another project would write them, and with mistakes that it may make, by name.
"""

import numpy as np


def units(v):
    """Normalized with a reciprocal."""
    return v * (1 / np.sqrt((v * v).sum(axis=-1, keepdims=True)))


def signs(x, mistake):
    """1 for 0, or 0 as shaders have it."""
    return np.sign(x) if mistake == "sign of 0 is 0" else np.where(x < 0, -1, 1)


def folded(u, v, below, mistake, real):
    """The lower half of the octahedron."""
    outside = [
        (1 - abs(b)) * signs(a, mistake).astype(real) for a, b in ((u, v), (v, u))
    ]
    if mistake == "not folded":
        return u, v
    return [np.where(below, o, a) for o, a in zip(outside, (u, v), strict=True)]


def packed_normal(real, mistake, n):
    """Two integers in a word, ties away from 0."""
    s = abs(n[:, 2]) + abs(n[:, 1]) + abs(n[:, 0])
    if mistake == "not divided":
        s = (s > 0).astype(real)
    u, v = (n[:, i] / np.where(s > 0, s, 1) for i in range(2))
    one = real(32768 if mistake == "by 32768" else 32767)
    u, v = (c * one for c in folded(u, v, n[:, 2] < 0, mistake, real))
    if mistake == "normals truncated":
        u, v = np.trunc(u), np.trunc(v)
    u, v = (
        np.clip(np.trunc(c + np.copysign(real(0.5), c)), -32767, 32767).astype(np.int32)
        for c in (u, v)
    )
    if mistake == "v first":
        u, v = v, u
    low = u if mistake == "sign extended" else u & 0xFFFF
    return (low | (v << 16)).astype(np.int32).view(np.uint32)


def halves(mistake, x):
    """Rounded in whole numbers: 11 bits, ties upwards."""
    most = np.inf if mistake == "infinite halves" else 65504
    if mistake != "halves truncated":
        with np.errstate(over="ignore"):
            near = np.minimum(x, most).astype(np.float16)
        small = (mistake == "small halves are 0") & (near < 2.0**-14)
        return np.where(small, np.float16(0), near).view(np.uint16)
    near = np.minimum(x, 65504).astype(np.float16)
    down = np.nextafter(near, np.float16(-1))
    return np.where(near.astype(float) > x, down, near).view(np.uint16)


def pack(real, mistake, **f):
    """Shifts and masks."""
    words = np.zeros((len(f["W"]), 12), np.uint32)
    f32 = {n: f[n].astype(np.float32) for n in ("visible_position", "position", "W")}
    words[:, 0:3] = f32["visible_position"].view(np.uint32)
    words[:, 4:7] = f32["position"].view(np.uint32)
    words[:, 3] = packed_normal(real, mistake, f["visible_normal"])
    words[:, 7] = packed_normal(real, mistake, f["normal"])
    red, green, blue = (
        halves(mistake, f["radiance"][:, i]).astype(np.uint32) for i in range(3)
    )
    M = np.rint(f["M"]).clip(0, 2**31)
    if mistake != "M wraps around":
        M = M.clip(0, 65535)
    if mistake != "M below 1":
        M = np.where(f["M"] > 0, np.maximum(M, 1), 0)
    M = M.astype(np.uint32) & np.uint32(0xFFFF)
    if mistake == "red above":
        red, green = green, red
    words[:, 8] = red | green << np.uint32(16)
    words[:, 9] = blue | M << np.uint32(16)
    if mistake == "M below blue":
        words[:, 9] = M | blue << np.uint32(16)
    words[:, 10] = f32["W"].view(np.uint32)
    words[:, 11] = f["seed"]
    return {"words": words}


def unpacked_normal(real, mistake, word):
    """Sign extension by shifts."""
    signed = word.view(np.int32)
    u, v = signed << 16 >> 16, signed >> 16
    if mistake == "not sign extended":
        u = signed & 0xFFFF
    if mistake != "−32768 as it is":
        u, v = np.maximum(u, -32767), np.maximum(v, -32767)
    scale = real(1 / (32768 if mistake == "by 32768" else 32767))
    u, v = u.astype(real) * scale, v.astype(real) * scale
    z = 1 - abs(u) - abs(v)
    n = np.stack([*folded(u, v, z < 0, mistake, real), z], axis=1)
    return n if mistake == "not normalized" else units(n)


def unpack(real, mistake, words):
    """Each word on its own; what is not finite is made so."""

    def finite(x, most):
        if mistake == "NaN goes on":
            return x
        return np.where(np.isnan(x), 0, np.clip(x, -most, most))

    largest = np.finfo(np.float32).max
    words = np.ascontiguousarray(words)
    floats = finite(words.view(np.float32), largest)
    shorts = words.view(np.uint16)[:, 16:20]
    L = finite(np.ascontiguousarray(shorts[:, :3]).view(np.float16).astype(real), 65504)
    if mistake == "small halves are 0":
        L = np.where(abs(L) < 2.0**-14, 0, L)
    first, second = (3, 7) if mistake != "normals exchanged" else (7, 3)
    return {
        "visible_position": floats[:, 0:3],
        "visible_normal": unpacked_normal(real, mistake, words[:, first].copy()),
        "position": floats[:, 4:7],
        "normal": unpacked_normal(real, mistake, words[:, second].copy()),
        "radiance": L[:, ::-1] if mistake == "blue first" else L,
        "W": floats[:, 10],
        "M": shorts[:, 3].view(np.int16) if mistake == "M has a sign" else shorts[:, 3],
        "seed": words[:, 11],
    }

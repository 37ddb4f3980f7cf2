"""Reservoirs in the 32 bytes of RTXDI, in single precision, as an engine packs them."""

import numpy as np

F = np.float32

RESERVOIR = np.dtype(
    [
        ("position", "<f4", 3),
        ("counts", "<u4"),
        ("radiance", "<u4"),
        ("W", "<f4"),
        ("normal", "<u4"),
        ("unused", "<u4"),
    ]
)

TO_XYZ = np.array(
    [
        [0.4123908, 0.35758434, 0.1804808],
        [0.21263901, 0.71516868, 0.07219232],
        [0.01933082, 0.11919478, 0.95053215],
    ],
    F,
)
FROM_XYZ = np.linalg.inv(TO_XYZ.astype(np.float64)).astype(F)


def log_luv(color):
    """Radiance in 32 bits: 14 of the logarithm of Y, and 9 for each of u and v."""
    X, Y, Z = (color @ TO_XYZ.T).T
    with np.errstate(divide="ignore", invalid="ignore"):
        level = np.clip(np.floor(409.6 * (np.log2(Y) + 20)), 0, 16383)
        whole = X + 15 * Y + 3 * Z
        u, v = np.floor(820 * 4 * X / whole), np.floor(820 * 9 * Y / whole)
    lit = (Y > 0) & (level > 0)
    parts = [np.where(lit, part, 0).astype(np.uint32) for part in (level, u, v)]
    return (
        (parts[0] << 18) | (np.minimum(parts[1], 511) << 9) | np.minimum(parts[2], 511)
    )


def from_log_luv(words):
    """The middle of the cell."""
    level, u, v = words >> 18, (words >> 9) & 511, words & 511
    u, v = (u.astype(F) + F(0.5)) / F(820), (v.astype(F) + F(0.5)) / F(820)
    Y = np.exp2((level.astype(F) + F(0.5)) / F(409.6) - F(20))
    X, Z = Y * 9 * u / (4 * v), Y * (12 - 3 * u - 20 * v) / (4 * v)
    color = np.stack([X, Y, Z], axis=1).astype(F) @ FROM_XYZ.T
    return np.where((level > 0)[:, None], np.maximum(color, 0), 0).astype(F)


def octahedral(n):
    """A unit vector in two signed 16-bit numbers."""
    n = n / np.abs(n).sum(axis=1, keepdims=True)
    x, y = n[:, 0], n[:, 1]
    sign = np.where(n[:, :2] >= 0, 1, -1)
    folded = (1 - np.abs(n[:, 1::-1])) * sign
    xy = np.where((n[:, 2] < 0)[:, None], folded, np.stack([x, y], axis=1))
    bits = np.rint(np.clip(xy, -1, 1) * 32767).astype(np.int16).view(np.uint16)
    return bits[:, 0].astype(np.uint32) | (bits[:, 1].astype(np.uint32) << 16)


def from_octahedral(words):
    """The unit vector."""
    bits = np.stack([words & 0xFFFF, words >> 16], axis=1).astype(np.uint16)
    xy = np.maximum(bits.view(np.int16).astype(F) / F(32767), F(-1))
    z = 1 - np.abs(xy).sum(axis=1)
    sign = np.where(xy >= 0, F(1), F(-1))
    folded = (1 - np.abs(xy[:, ::-1])) * sign
    xy = np.where((z < 0)[:, None], folded, xy)
    n = np.column_stack([xy, z]).astype(F)
    return n / np.sqrt((n * n).sum(axis=1, keepdims=True))


def pack(r, age=0):
    """Reservoirs as bytes, (N,) `RESERVOIR`."""
    out = np.zeros(len(r["W"]), RESERVOIR)
    out["position"] = r["position"]
    out["counts"] = np.minimum(r["M"], 255).astype(np.uint32) | (np.uint32(age) << 8)
    out["radiance"] = log_luv(r["radiance"])
    out["W"], out["normal"] = r["W"], octahedral(r["normal"])
    return out


def unpack(packed):
    """Reservoirs, a dict of float32 arrays."""
    return {
        "position": packed["position"].copy(),
        "normal": from_octahedral(packed["normal"]),
        "radiance": from_log_luv(packed["radiance"]),
        "W": packed["W"].copy(),
        "M": (packed["counts"] & 255).astype(F),
    }

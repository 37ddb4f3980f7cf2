"""Packed path reservoirs of RTXDI: 64 bytes, for paths that are joined at any vertex.

::

    word     x                 y                     z                  w
    0        position of the sample point                               W, float32
    1        normal, x and y   normal z, M           partial Jacobian   onward density
    2        radiance, three float32; or infinity, light, place on it   see below
    3        target function, three float32                             seed

    word 1   bits 31:16                  bits 15:0
    x        y of the normal             x of the normal
    y        M, float16                  z of the normal

    word 2, w
    31:24    random numbers that were drawn before the path began
    23:16    vertices from the visible point to the light
    15:8     vertex at which the path is joined
    7        whether the next spatial reuse takes more samples
    4:0      age

Facts, not code, of RTXDI: the words from PT/ReSTIRPTParameters.h, their fields from
PT/Reservoir.hlsli, and what stands for a light from Utils/SampledLightData.hlsli.  The
order of a buffer is that of :func:`.rtxdi.buffer_index`.  The visible point is not
stored: it is taken from the G-buffer.

Its writer differs from this one at the ends: an M beyond 65504 may become infinite, how
a half is rounded is the platform's affair, and it runs in float32, so that a code of a
normal may be the neighbour of ours.  Its empty reservoir has a normal of 0, which it
reads as NaN.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Masks, Scalars, Vec3s
from restir_gi.reference.resampling.packing.components import (
    decode_components,
    encode_components,
)
from restir_gi.reference.resampling.packing.rounding import (
    UInts,
    nearest_float,
    widened,
)
from restir_gi.reference.resampling.reservoir import Reservoirs, Samples

RESERVOIR = np.dtype(
    [
        ("x_s", "<f4", 3),  # byte 0
        ("W", "<f4"),  # 12
        ("n_s", "<u2", 3),  # 16
        ("M", "<f2"),  # 22
        ("partial_jacobian", "<f4"),  # 24
        ("onward_pdf", "<f4"),  # 28
        ("L_o", "<u4", 3),  # 32: bits of float32, or infinity, light, place on it
        ("age", "u1"),  # 44: bits 4:0 of a word, and bit 7
        ("reconnection_vertex", "u1"),  # 45: bits 15:8
        ("path_length", "u1"),  # 46: bits 23:16
        ("random_index", "u1"),  # 47: bits 31:24
        ("target", "<f4", 3),  # 48
        ("seed", "<u4"),  # 60
    ]
)
"""64 bytes, little-endian, no padding, each field aligned as C aligns it."""

OLDEST, BOOST = 31, 0x80
"""Largest age, and the bit above it."""

INFINITY = np.uint32(0x7F800000)
"""Bits of a float32 that stands for a light that was sampled, in place of red."""


@dataclass(frozen=True, slots=True, eq=False)
class PathRecord:
    """What is stored of a path beside its sample point, N rows.

    Attributes
    ----------
    age : (N,) unsigned int; frames that the sample has survived
    boosts : (N,) bool; the next spatial reuse takes more samples
    reconnection_vertex : (N,) unsigned int; number of the vertex where it is joined
    path_length : (N,) unsigned int; vertices from the visible point to the light
    random_index : (N,) unsigned int; random numbers that were drawn before it began
    seed : (N,) uint32; what it is drawn again with
    partial_jacobian : (N,) float
        Of the base path: its part of the Jacobian, as the renderer defines it.
    onward_pdf : (N,) float, 1/sr; of the direction onward from that vertex
    target : (N, 3) float; target function, of which p̂ is the luminance
    on_light : (N,) bool; it ends where a light was sampled, at that very vertex
    light, light_place : (N,) uint32
        Which light, and where on it, in the renderer's own bits; 0 without one.
    """

    age: UInts
    boosts: Masks
    reconnection_vertex: UInts
    path_length: UInts
    random_index: UInts
    seed: UInts
    partial_jacobian: Scalars
    onward_pdf: Scalars
    target: Vec3s
    on_light: Masks
    light: UInts
    light_place: UInts


def pack(r: Reservoirs, path: PathRecord) -> NDArray[np.void]:
    """Reservoirs of paths as RTXDI stores them.

    Parameters
    ----------
    r : Reservoirs
        N rows, whose samples are `Samples`; the radiance of rows on a light is not
        stored.
    path : PathRecord; N rows

    Returns
    -------
    (N,) `RESERVOIR`
        Rounded to nearest.  Errors: all float32 relative 2⁻²⁴, normals 2.643e-5
        radians, M relative 2⁻¹¹ and none where it is whole and at most 2048.  Beyond
        65504 M becomes 65504, what is beyond float32 its largest number, NaN 0.  Of an
        age the low five bits are kept, of the three counts the low eight.

    Raises
    ------
    ValueError
        A column that does not have N rows; one row serves all.
    """
    codes = np.zeros(len(r.W), RESERVOIR)
    codes["x_s"] = nearest_float(r.y.position, np.float32)
    codes["W"] = nearest_float(r.W, np.float32)
    codes["n_s"] = encode_components(r.y.normal)
    codes["M"] = nearest_float(r.M, np.float16)
    codes["partial_jacobian"] = nearest_float(path.partial_jacobian, np.float32)
    codes["onward_pdf"] = nearest_float(path.onward_pdf, np.float32)
    radiance = nearest_float(r.y.radiance, np.dtype("<f4"))
    codes["L_o"] = np.ascontiguousarray(radiance).view("<u4")
    on_light = np.broadcast_to(path.on_light, len(codes))
    codes["L_o"][on_light, 0] = INFINITY
    for column, word in ((1, path.light), (2, path.light_place)):
        held = codes["L_o"][:, column]
        codes["L_o"][:, column] = np.where(on_light, word, held)
    codes["age"] = path.age & OLDEST | np.where(path.boosts, BOOST, 0)
    codes["reconnection_vertex"] = path.reconnection_vertex & 255
    codes["path_length"] = path.path_length & 255
    codes["random_index"] = path.random_index & 255
    codes["target"] = nearest_float(path.target, np.float32)
    codes["seed"] = path.seed
    return codes


def unpack(codes: NDArray[np.void]) -> tuple[Reservoirs, PathRecord]:
    """Reservoirs of paths as RTXDI stored them.

    Any bits give finite numbers: an infinite half is read as ±65504, an infinite float
    as the largest one, NaN as 0; but an infinite red, of either sign, stands for a
    light.  `pack` gives back the same bits, unless there was one of these, a normal
    whose codes it does not write, or something in bits 5 and 6 beside the age.

    Parameters
    ----------
    codes : (N,) `RESERVOIR`
        As from ``np.fromfile(dump, RESERVOIR)[rtxdi.buffer_index(width, height)]``.

    Returns
    -------
    r : Reservoirs
        N rows of float64 and `Samples`; radiance 0 on a light, which knows its own.
    path : PathRecord; N rows
    """
    words = np.ascontiguousarray(codes["L_o"])
    on_light: Masks = words[:, 0] & np.uint32(0x7FFFFFFF) == INFINITY
    radiance = np.where(on_light[:, None], 0.0, widened(words.view("<f4")))
    y = Samples(
        position=widened(codes["x_s"]),
        normal=decode_components(codes["n_s"]),
        radiance=radiance,
    )
    path = PathRecord(
        age=codes["age"] & np.uint8(OLDEST),
        boosts=codes["age"] & np.uint8(BOOST) != 0,
        reconnection_vertex=codes["reconnection_vertex"].copy(),
        path_length=codes["path_length"].copy(),
        random_index=codes["random_index"].copy(),
        seed=codes["seed"].copy(),
        partial_jacobian=widened(codes["partial_jacobian"]),
        onward_pdf=widened(codes["onward_pdf"]),
        target=widened(codes["target"]),
        on_light=on_light,
        light=np.where(on_light, words[:, 1], np.uint32(0)),
        light_place=np.where(on_light, words[:, 2], np.uint32(0)),
    )
    return Reservoirs(y=y, W=widened(codes["W"]), M=widened(codes["M"])), path

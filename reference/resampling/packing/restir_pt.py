"""Reservoirs of ReSTIR_PT's screen-space ReSTIR GI: three words of four times 32 bits.

::

    word     x, y, z                      w
    0        position of visible point    normal of visible point
    1        position of sample point     normal of sample point
    2        see below                    age

    word 2   bits 31:16                   bits 15:0
    x        radiance, green              radiance, red
    y        M                            radiance, blue
    z        W, float32

In memory x comes first, and low bits come first, so that all bytes but those of the age
are those of :mod:`restir_gi.reference.resampling.packing.paper`.  A buffer holds the
pixels in rows, all of them once for each slot: even slots are the temporal reservoirs,
odd ones the spatial.

Facts, not code, of DQLin/ReSTIR_PT, Source/Falcor/Experimental/ScreenSpaceReSTIR/
GIReservoir.slang and GIResampling.cs.slang, and Source/Falcor/Utils/Math/
FormatConversion.slang.  Left open by these: how a float is rounded to a half, which is
the platform's affair; and the octahedral map, for which Falcor's own is taken.

Its writer differs from this one at the ends: radiance beyond the halves may become
infinite, of M the low 16 bits are kept, and ties of normals go away from 0.  Its empty
reservoir has M = 0 and W = 1: a null there is known by its M or its radiance.
"""

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Vec3s
from restir_gi.reference.resampling.packing import paper
from restir_gi.reference.resampling.packing.rounding import UInts
from restir_gi.reference.resampling.reservoir import Reservoirs

RESERVOIR = np.dtype([*paper.RESERVOIR.descr[:-1], ("age", "<u4")])
"""48 bytes, little-endian, no padding."""


def pack(x_v: Vec3s, n_v: Vec3s, r: Reservoirs, age: UInts) -> NDArray[np.void]:
    """Reservoirs as ReSTIR_PT stores them.

    Parameters
    ----------
    x_v, n_v : (N, 3) float, m and 1
        Visible points that own the reservoirs, and their unit normals.
    r : Reservoirs; N rows, whose samples are `Samples`
    age : (N,) uint32; frames since the sample was drawn

    Returns
    -------
    (N,) `RESERVOIR`; rounded and saturated, with the errors of :func:`.paper.pack`

    Raises
    ------
    ValueError
        A column that does not have N rows; one row serves all.
    """
    return paper.pack(x_v, n_v, r, age).view(RESERVOIR)


def unpack(codes: NDArray[np.void]) -> tuple[Vec3s, Vec3s, Reservoirs, UInts]:
    """Reservoirs as ReSTIR_PT stored them.

    Any bits give finite numbers, as for :func:`.paper.unpack`.

    Parameters
    ----------
    codes : (N,) `RESERVOIR`; as from ``np.fromfile(dump, RESERVOIR)``

    Returns
    -------
    x_v, n_v : (N, 3) float64, m and 1; visible points and their unit normals
    r : Reservoirs; N rows of float64 and `Samples`
    age : (N,) uint32; frames since the sample was drawn
    """
    return paper.unpack(codes.view(paper.RESERVOIR))

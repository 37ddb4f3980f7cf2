"""Values at which kernels break: the ends of number types, and degenerate geometry."""

from typing import Any

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import DTypeLike

from restir_gi.reference.numerics.arrays import Scalars, Vec3s
from restir_gi.reference.numerics.frames import normal_frames
from restir_gi.reference.strategies.numbers import ROWS


def extreme_weights(
    rows: int = ROWS, dtype: DTypeLike = np.float64
) -> st.SearchStrategy[Scalars]:
    """Weights that are 0, tiny, huge, subnormal, or neighbours of a power of two.

    Parameters
    ----------
    dtype : type; float16, float32 or float64

    Returns
    -------
    strategy of (rows,) dtype; finite and not negative; what is simple stands first
    """
    info = np.finfo(np.dtype(dtype))
    one = info.dtype.type(1)
    ends: list[Any] = [
        info.dtype.type(0),
        one,
        one - info.epsneg,
        one + info.eps,
        info.tiny,
        info.smallest_subnormal,
        info.max,
        np.sqrt(info.max),
        np.sqrt(info.tiny),
    ]
    return arrays(info.dtype, rows, elements=st.sampled_from(ends))


def extreme_uniforms(rows: int = ROWS) -> st.SearchStrategy[Scalars]:
    """Random numbers at the ends of [0, 1), and on both sides of a half.

    Returns
    -------
    strategy of (rows,) float64
        0, 2⁻²⁴, 1/2 ∓ 2⁻²⁴, 1 − 2⁻²⁴: a generator makes each of them.
    """
    step = 2.0**-24
    ends = [0.0, step, 0.5 - step, 0.5, 0.5 + step, 1 - step]
    return arrays(np.float64, rows, elements=st.sampled_from(ends))


@st.composite
def extreme_offsets(draw: st.DrawFn, rows: int = ROWS) -> Vec3s:
    """Offsets between points: none, along an axis, and of any size that has a square.

    Returns strategy of (rows, 3) float64; m.
    """
    corner = st.sampled_from([0.0, 1.0, -1.0])
    direction: Vec3s = draw(arrays(np.float64, (rows, 3), elements=corner))
    power = draw(arrays(np.int64, rows, elements=st.integers(-60, 60)))
    offsets: Vec3s = direction * 2.0 ** power[:, None]
    return offsets


@st.composite
def grazing_directions(draw: st.DrawFn, normals: Vec3s) -> Vec3s:
    """Unit vectors that are nearly in the planes of given normals, or in them.

    Parameters
    ----------
    normals : (N, 3) float64; unit vectors

    Returns
    -------
    strategy of (N, 3) float64; cosines from −2⁻²⁰ to 2⁻²⁰ with the normals
    """
    rows = len(normals)
    ends = [0.0, 2.0**-52, -(2.0**-52), 2.0**-24, -(2.0**-24), 2.0**-20, -(2.0**-20)]
    cosine = draw(arrays(np.float64, rows, elements=st.sampled_from(ends)))
    tangent, _ = normal_frames(normals)
    sine = np.sqrt(1.0 - cosine * cosine)
    found: Vec3s = sine[:, None] * tangent + cosine[:, None] * normals
    return found

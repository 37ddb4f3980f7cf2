"""Random numbers of path vertices: each has streams of its own."""

import numpy as np

from reference.arrays import Indices, Scalars
from reference.rng import KeyedUniforms, Stream, Uniforms

VERTICES = 32
"""More than any path has: step of the keys from frame to frame."""

DECISIONS = 16
"""Dimension of the first decisions, four to a dimension; look-ups are before them."""


def of_vertices(
    pixel: Indices, frame: int, vertex: int | Indices, seed: int, stream: Stream
) -> KeyedUniforms:
    """Random numbers of vertices x_v; K rows, of the key 32 · frame + v.

    Parameters
    ----------
    pixel : (K,) int64; whose paths
    frame : int; of them; below 2²²
    vertex : int or (K,) int64; v, of all of them or of each
    """
    key = frame * VERTICES + vertex
    return KeyedUniforms(pixel.astype(np.uint32), key, seed, stream)


def decisions(uniforms: Uniforms, count: int) -> list[Scalars]:
    """Numbers by which a stream of reservoirs is resampled.

    Parameters
    ----------
    uniforms : Uniforms; K rows, of the stream of cells
    count : int; how many reservoirs there are, at most 160

    Returns
    -------
    list of (K,) float64; one for each
    """
    return [uniforms.draw(DECISIONS + k // 4)[k % 4] for k in range(count)]

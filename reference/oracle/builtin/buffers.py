"""Buffers of the contract as records of the passes."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Masks, Scalars
from restir_gi.reference.oracle.builtin.surfaces import surface_pixels
from restir_gi.reference.oracle.builtin.world import Known, surface_of, world_of
from restir_gi.reference.oracle.contract.fields import Precision, dtype_of
from restir_gi.reference.oracle.contract.surfaces import LAMBERTIAN
from restir_gi.reference.passes.pixels import Pixels
from restir_gi.reference.resampling.reservoir import Reservoirs, Samples
from restir_gi.reference.settings import UNBIASED

Array = NDArray[Any]
Arrays = Mapping[str, Array]


def as_real(precision: Precision, values: Array) -> Array:
    """Reals of the backend's precision.

    Parameters
    ----------
    values : array; reals

    Returns
    -------
    array; in C order
    """
    return np.ascontiguousarray(values.astype(dtype_of("real", precision)))


def bit(words: Array, place: int) -> Masks:
    """One bit of each word, (N,) bool; whether it is set.

    Parameters
    ----------
    words : (N,) uint32; words
    place : int; from 0
    """
    found: Masks = (words >> np.uint32(place)) & np.uint32(1) != 0
    return found


def samples_of(buffers: Arrays, prefix: str = "") -> Samples:
    """Sample points among buffers.

    Parameters
    ----------
    buffers : mapping of str to array; with ``position``, ``normal`` and ``radiance``
    """
    return Samples(
        buffers[f"{prefix}position"],
        buffers[f"{prefix}normal"],
        buffers[f"{prefix}radiance"],
    )


def reservoirs_of(buffers: Arrays, prefix: str = "") -> Reservoirs:
    """Reservoirs among buffers, N rows, whose names begin with the prefix."""
    W, M = buffers[f"{prefix}W"], buffers[f"{prefix}M"]
    return Reservoirs(samples_of(buffers, prefix), W, M)


def pixels_of(
    buffers: Arrays,
    kind: Any,
    known: Sequence[Known] = (),
    surface: str = LAMBERTIAN,
) -> Pixels:
    """Pixels among buffers."""
    if surface != LAMBERTIAN:
        return surface_pixels(buffers, kind, surface, known)
    points = surface_of(
        buffers["visible_position"], buffers["visible_normal"], buffers["albedo"]
    )
    return Pixels(world_of(known), points, replace(UNBIASED, target=kind))


def target_of(kind: Any, buffers: Arrays, surface: str = LAMBERTIAN) -> Scalars:
    """Target of sample points at visible points.

    Returns (N,); in the precision of the buffers.
    """
    return pixels_of(buffers, kind, surface=surface).target(samples_of(buffers))


def reservoirs_out(precision: Precision, r: Reservoirs) -> dict[str, Array]:
    """Reservoirs as the buffers of an output."""
    found = {
        "position": r.y.position,
        "normal": r.y.normal,
        "radiance": r.y.radiance,
        "W": r.W,
        "M": r.M,
    }
    return {name: as_real(precision, values) for name, values in found.items()}

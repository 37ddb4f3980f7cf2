"""Cases of the further passes: made here, without a scene, the same for a seed."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from restir_gi.reference.numerics.rng import KeyedUniforms, Stream
from restir_gi.reference.oracle.buffers import given
from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.contract.fields import Precision, Value
from restir_gi.reference.oracle.levels.further_views import (
    ROWS,
    WIDTH,
    Parts,
    gbuffer_cases,
    reproject_cases,
)
from restir_gi.reference.oracle.levels.layouts import layout_cases
from restir_gi.reference.oracle.levels.packing import packing_cases
from restir_gi.reference.oracle.parts import SEED


def further_cases(precision: Precision, seed: int = SEED) -> list[Case]:
    """Cases of all further passes, with the extremes, in the order of the contract.

    Parameters
    ----------
    precision : 'float32' or 'float64'
        In which the inputs are given; most are numbers that float32 holds.
    seed : int; of all rows that are random
    """
    rng = np.random.default_rng([2027, seed])
    makers = (
        gbuffer_cases,
        reproject_cases,
        _validation,
        _boiling,
        _checkerboard,
        _roulette,
        packing_cases,
    )
    return [
        _case(name, settings, inputs, precision)
        for maker in makers
        for name, settings, inputs in maker(rng)
    ]


def declared_cases(precision: Precision, seed: int = SEED) -> list[Case]:
    """Cases with values of settings that have to be declared.

    Parameters
    ----------
    precision : 'float32' or 'float64'; as for `further_cases`
    seed : int; of all rows that are random
    """
    rng = np.random.default_rng([2029, seed])
    return [
        _case(name, settings, inputs, precision)
        for name, settings, inputs in layout_cases(rng)
    ]


RANDOM = {
    "reproject",
    "reproject-aslant",
    "reproject-line",
    "reproject-beside",
    "roulette",
}
"""Whose decisions hang on numbers that were drawn."""

WHOLE_FRAMES = {
    "gbuffer",
    "reproject",
    "boiling",
    "boiling-edge",
    "boiling-line",
    "checkerboard-even",
}


def _case(
    name: str, settings: dict[str, Value], inputs: dict[str, Any], precision: Precision
) -> Case:
    pass_name = name.partition("-")[0]
    held = {
        n: v.astype(np.float32) if v.dtype.kind == "f" else v for n, v in inputs.items()
    }
    width = int(settings["width"]) if name in WHOLE_FRAMES else None
    return Case(
        f"further-{name}",
        pass_name,
        settings,
        given(held, precision),
        name in RANDOM,
        width,
    )


def _validation(rng: np.random.Generator) -> Iterator[Parts]:
    then = 10.0 ** rng.uniform(-4, 3, (ROWS, 3)) * (rng.random((ROWS, 1)) < 0.9)
    factor = rng.choice([1.0, 1.0, 0.0, rng.uniform()], ROWS)
    factor = np.where(factor > 0, rng.uniform(0.8, 1.25, ROWS), factor)
    # Brighter, and darker, by more than a tenth of then, or of now, but not of both.
    factor[1::8] = rng.uniform(1.1, 1 / 0.9, len(factor[1::8]))
    factor[2::8] = rng.uniform(0.9, 1 / 1.1, len(factor[2::8]))
    factor[3::8] = 1.0
    now = then * factor[:, None]
    now[::4] = then[::4] * rng.uniform(0.6, 1.6, now[::4].shape)
    now[::31] += 1e-3  # light where there was none
    inputs = {
        "W": 10.0 ** rng.uniform(-3, 3, ROWS) * (rng.random(ROWS) < 0.9),
        "M": rng.integers(0, 500, ROWS).astype(float),
        "radiance_then": then,
        "radiance_now": now,
        "met": (rng.random(ROWS) < 0.85).astype(np.uint32),
        "null": (rng.random(ROWS) < 0.1).astype(np.uint32),
    }
    yield "validation", {"tolerance": 0.1}, inputs
    colours = then * rng.uniform(0.6, 1.6, then.shape)
    changed = inputs | {"radiance_now": colours}
    yield "validation-colours", {"tolerance": 0.2}, changed
    # Nothing may change; and a change that is just as large as it may be.
    scale = 10.0 ** rng.uniform(-3, 3, (ROWS, 1))
    even = np.arange(ROWS)[:, None] % 2 == 0
    extremes = inputs | {"radiance_then": then * scale, "radiance_now": then * scale}
    yield "validation-none", {"tolerance": 0.0}, extremes
    edge = np.float32(then) * np.where(even, 0.75, 0.7)
    # And changes that are smaller than most tolerances, down to a tenth of this one.
    small = 10.0 ** rng.uniform(np.log10(0.025), np.log10(0.25), (ROWS, 1))
    edge[::4] = (np.float32(then) * (1 - small))[::4]
    yield "validation-edge", {"tolerance": 0.25}, inputs | {"radiance_now": edge}


def _boiling(rng: np.random.Generator) -> Iterator[Parts]:
    width, height = 52, 20  # tiles that are cut off on both sides
    rows = width * height
    y, x = np.divmod(np.arange(rows), width)
    inputs = {
        "radiance": 10.0 ** rng.normal(0, 0.7, (rows, 3)),
        "W": 10.0 ** (rng.normal(0, 0.5, rows) + y / 8) * (rng.random(rows) < 0.8),
        "M": rng.integers(0, 30, rows).astype(float),
    }
    # In other tiles, before some of them have little light, and some none at all.
    bright = {name: array.copy() for name, array in inputs.items()}
    yield "boiling-narrow", {"width": width // 2, "strength": 0.95}, bright
    inputs["radiance"][x < 16] *= 0.01
    inputs["W"][x >= 48] = 0.0
    yield "boiling", {"width": width, "strength": 0.5}, inputs
    # One line of pixels, of an odd number.
    line = {
        "radiance": 10.0 ** rng.normal(0, 0.7, (331, 3)),
        "W": 10.0 ** rng.normal(0, 1.0, 331) * (rng.random(331) < 0.8),
        "M": rng.integers(0, 30, 331).astype(float),
    }
    yield "boiling-line", {"width": 331, "strength": 0.8}, line
    # All alike but for one pixel of each tile, a hundredth below or above the limit of
    # r times the mean: k of n has that where k n / (n - 1 + k) = r.
    strength = 0.6
    tile = y // 16 * 4 + x // 16
    count = np.bincount(tile)
    r = (10 / strength - 9) * np.where(np.arange(8) % 2 == 0, 0.99, 1.01)
    first = np.array([np.flatnonzero(tile == t)[2] for t in range(8)])
    W = np.ones(rows)
    W[first] = r * (count - 1) / (count - r)
    edge = {"radiance": np.full((rows, 3), 0.3), "W": W}
    yield "boiling-edge", {"width": width, "strength": strength}, inputs | edge
    # Alone in its tile nobody is above the mean.
    alone = {"W": np.where(np.isin(np.arange(rows), first), 1e6, 0.0)}
    yield "boiling-alone", {"width": width, "strength": 0.95}, inputs | alone


def _checkerboard(rng: np.random.Generator) -> Iterator[Parts]:
    history = (rng.random(ROWS) < 0.7).astype(np.uint32)
    inputs = {"pixel": np.arange(ROWS), "has_history": history}
    yield "checkerboard-even", {"width": WIDTH, "frame": 6}, inputs
    # Of an odd width, where row and pixel have not the same parity.
    inputs = {"pixel": rng.integers(0, 7681 * 4321, ROWS), "has_history": history}
    yield "checkerboard-odd", {"width": 7681, "frame": 2**27 - 1}, inputs


def _roulette(rng: np.random.Generator) -> Iterator[Parts]:
    inputs = {"pixel": rng.integers(0, 7681 * 4321, ROWS)}
    base: dict[str, Value] = {"width": 7681, "frame": 2**27 - 1, "seed": 17}
    yield "roulette", base | {"probability": 0.3}, inputs
    yield "roulette-always", base | {"probability": 1.0}, inputs
    # The very number of a tile: it does not go on.
    tiles = KeyedUniforms(np.arange(40, dtype=np.uint32), 3, 1, Stream.ROULETTE)
    p = float(np.median(np.delete(tiles.draw(0)[0], 0)))
    inputs = {"pixel": np.arange(0, 300 * 200, 59)}
    base = {"width": 300, "frame": 3, "seed": 1, "probability": p}
    yield "roulette-equal", base, inputs

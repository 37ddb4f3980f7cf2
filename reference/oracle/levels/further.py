"""Cases of the further passes: made here, without a scene, always the same."""

from collections.abc import Iterator
from itertools import product
from typing import Any

import numpy as np

from restir_gi.reference.numerics.arrays import normalize
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
    unit_vectors,
)
from restir_gi.reference.resampling.packing import paper
from restir_gi.reference.resampling.reservoir import Reservoirs, Samples


def further_cases(precision: Precision) -> list[Case]:
    """Cases of all further passes, with the extremes, in the order of the contract.

    Parameters
    ----------
    precision : 'float32' or 'float64'
        In which the inputs are given; most are numbers that float32 holds.
    """
    rng = np.random.default_rng(2027)
    makers = (
        gbuffer_cases,
        reproject_cases,
        _validation,
        _boiling,
        _checkerboard,
        _roulette,
        _packing,
    )
    return [
        _case(name, settings, inputs, precision)
        for maker in makers
        for name, settings, inputs in maker(rng)
    ]


RANDOM = {"reproject", "reproject-beside", "roulette"}
"""Whose decisions hang on numbers that were drawn."""

WHOLE_FRAMES = {"gbuffer", "reproject", "boiling", "boiling-edge", "checkerboard-even"}


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
    now = then * np.where(rng.random(ROWS) < 0.3, 1.0, factor)[:, None]
    now[::7] *= rng.uniform(0.8, 1.25, now[::7].shape)
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
    # Nothing may change; and a change that is just as large as it may be.
    scale = 10.0 ** rng.uniform(-30, 30, (ROWS, 1))
    even = np.arange(ROWS)[:, None] % 2 == 0
    extremes = inputs | {"radiance_then": then * scale, "radiance_now": then * scale}
    yield "validation-none", {"tolerance": 0.0}, extremes
    edge = np.float32(then) * np.where(even, 0.75, 0.7)
    yield "validation-edge", {"tolerance": 0.25}, inputs | {"radiance_now": edge}


def _boiling(rng: np.random.Generator) -> Iterator[Parts]:
    width, height = 52, 20  # tiles that are cut off on both sides
    rows = width * height
    y, x = np.divmod(np.arange(rows), width)
    inputs = {
        "radiance": 10.0 ** rng.normal(0, 0.5, (rows, 3)),
        "W": 10.0 ** (rng.normal(0, 0.5, rows) + y / 8) * (rng.random(rows) < 0.8),
        "M": rng.integers(0, 30, rows).astype(float),
    }
    inputs["radiance"][x < 16] *= 0.01
    inputs["W"][x >= 48] = 0.0  # no light at all
    yield "boiling", {"width": width, "strength": 0.5}, inputs
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


def _packing(rng: np.random.Generator) -> Iterator[Parts]:
    inputs = {
        "visible_position": rng.normal(size=(ROWS, 3)) * 100,
        "visible_normal": unit_vectors(rng, ROWS),
        "position": rng.normal(size=(ROWS, 3)) * 100,
        "normal": unit_vectors(rng, ROWS),
        "radiance": 10.0 ** rng.uniform(-4, 4, (ROWS, 3)),
        "W": 10.0 ** rng.uniform(-9, 9, ROWS) * (rng.random(ROWS) < 0.9),
        "M": rng.integers(0, 500, ROWS).astype(float),
        "seed": rng.integers(0, 2**32, ROWS, np.uint32),
    }
    yield "pack", {}, inputs
    axes = np.array(list(product((-1.0, 0.0, 1.0), repeat=3)))  # also 0: a null
    some = axes[np.arange(ROWS) % len(axes)]
    ends = [0.0, 2.0**-25, 6e-8, 6.2e-5, 1.0, 65504.0, 65519.0, 65520.0, 1e6, 1e30]
    counts = [0.0, 0.25, 1.0, 1.5, 499.7, 65534.7, 65535.0, 65536.0, 1e9]
    extremes = inputs | {
        "visible_normal": normalize(some),
        "normal": normalize(some + 1e-5 * rng.normal(size=some.shape)),
        "radiance": rng.choice(ends, (ROWS, 3)),
        "W": rng.choice([0.0, 1e-37, 1.0, 3.4e38], ROWS),
        "M": rng.choice(counts, ROWS),
    }
    yield "pack-extremes", {}, extremes

    r = Reservoirs(
        Samples(inputs["position"], inputs["normal"], inputs["radiance"]),
        inputs["W"],
        inputs["M"],
    )
    at = (inputs["visible_position"], inputs["visible_normal"])
    codes = paper.pack(*at, r, inputs["seed"])
    yield "unpack", {}, {"words": codes.view("<u4").reshape(-1, 12)}
    # All codes of normals and of halves; no infinite numbers.
    wild = codes.copy()
    ends16 = [-32768, -32767, -20000, -1, 0, 1, 12767, 32767]
    wild["n_v"], wild["n_s"] = rng.choice(ends16, (2, ROWS, 2))
    wild["M"] = rng.integers(0, 2**16, ROWS)
    halves = rng.integers(0, 2**16, (ROWS, 3), np.uint16).view(np.float16)
    wild["L_o"] = np.where(np.isfinite(halves), halves, 0)
    yield "unpack-extremes", {}, {"words": wild.view("<u4").reshape(-1, 12)}
    # Infinity and NaN, which `pack` does not write and others do.
    wild["L_o"] = rng.choice(np.array([np.inf, -np.inf, np.nan, 1], "f2"), (ROWS, 3))
    wild["W"] = rng.choice(np.array([np.inf, np.nan, 1], "f4"), ROWS)
    yield "unpack-infinite", {}, {"words": wild.view("<u4").reshape(-1, 12)}

"""Ordinary numbers, and the ends to which extremes drive them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars

Generator = np.random.Generator
Sampler = Callable[[Generator, int, Any], Scalars]
"""From a generator, a number of rows and the `finfo` of a type to a value a row."""


def _powers(low: float, high: float) -> Sampler:
    """Powers of two, as likely in each octave."""
    return lambda rng, rows, info: 2.0 ** rng.uniform(low, high, rows)


def _in_type(low: float, high: float) -> Sampler:
    """Powers of two, from shares of the type's lowest and highest exponents."""

    def sampled(rng: Generator, rows: int, info: Any) -> Scalars:
        ends = low * float(-info.minexp), high * float(info.maxexp)
        return _powers(*ends)(rng, rows, info)

    return sampled


def _among(*values: float) -> Sampler:
    return lambda rng, rows, info: rng.choice(np.array(values), rows)


def _signed(sampler: Sampler) -> Sampler:
    return lambda *of: sampler(*of) * of[0].choice([-1.0, 1.0], of[1])


def _mixed(*samplers: Sampler) -> Sampler:
    """Any of several, row by row."""

    def sampled(rng: Generator, rows: int, info: Any) -> Scalars:
        drawn = np.stack([sampler(rng, rows, info) for sampler in samplers])
        return drawn[rng.integers(0, len(samplers), rows), np.arange(rows)]

    return sampled


def _uniform(rng: Generator, rows: int, info: Any) -> Scalars:
    """Numbers in [0, 1) as a backend makes them, on a grid of the type, or of 2⁻²⁴."""
    step = max(float(info.eps) / 2, 2.0**-24)
    return np.floor(rng.random(rows) / step) * step


def _ends_of_u(rng: Generator, rows: int, info: Any) -> Scalars:
    step = max(float(info.eps) / 2, 2.0**-24)
    return rng.choice([0.0, step, 0.5, 1 - step], rows)


def _limits(rng: Generator, rows: int, info: Any) -> Scalars:
    """The ends of half, single and this type, denormals among them."""
    ends = [float(np.finfo(t).max) for t in (np.float16, np.float32)]
    ends += [float(np.finfo(t).tiny) for t in (np.float16, np.float32)]
    ends += [float(np.finfo(t).smallest_subnormal) for t in (np.float16, np.float32)]
    ends += [float(info.max), float(info.tiny), float(info.smallest_subnormal), 0.0]
    limits: Scalars = rng.choice(np.array(ends), rows)
    return limits


def _counts(rng: Generator, rows: int, info: Any) -> Scalars:
    ends = [0, 1, 2**11 - 1, 2**11, 2**24 - 1, 2**24, 2**53 - 1, 2**53]
    return rng.choice(np.array(ends, float), rows)


def _next_to_1(rng: Generator, rows: int, info: Any) -> Scalars:
    return 1.0 + float(info.eps) * rng.integers(-4, 5, rows)


PLAIN: Mapping[str, Sampler] = {
    "distance": _powers(-3, 3),
    "cosine": _signed(lambda rng, rows, info: rng.uniform(0.1, 1.0, rows)),
    "scale": _among(1.0),
    "offset": _among(0.0),
    "shape": _powers(-2, 2),
    "radiance": _powers(-6, 6),
    "albedo": lambda rng, rows, info: rng.uniform(0.05, 0.95, rows),
    "roughness": lambda rng, rows, info: rng.uniform(0.2, 1.0, rows),
    "index": _powers(-1, 1),
    "weight": _powers(-5, 5),
    "confidence": lambda rng, rows, info: rng.integers(1, 31, rows).astype(float),
    "u": _uniform,
}
"""By name, values that every scene has."""


@dataclass(frozen=True, slots=True, eq=False)
class Extreme:
    """An end of what kernels may be given.

    Attributes
    ----------
    drives : mapping of str to callable
        The values that go there, by their names in `PLAIN`.
    """

    name: str
    drives: Mapping[str, Sampler]


_NEAR = _mixed(_powers(-10, 0), _in_type(-0.5, 0), _in_type(-1, 0), _among(0.0))
_FAR = _mixed(_powers(0, 10), _in_type(0, 0.45), _in_type(0, 0.99))
_GRAZING = _mixed(_signed(_powers(-10, 0)), _signed(_in_type(-1, 0)), _among(0.0))
_THIN = _mixed(_powers(-10, 0), _in_type(-1, 0))
_ENDS = _mixed(_in_type(-1, 0.99), _limits)
_INDEX = _mixed(_among(1.0), _next_to_1, _powers(-4, 3))

EXTREMES: tuple[Extreme, ...] = (
    Extreme("plain", {}),
    Extreme("points that touch", {"distance": _NEAR}),
    Extreme("points far away", {"distance": _FAR}),
    Extreme("edge-on", {"cosine": _GRAZING}),
    Extreme("in a corner", {"distance": _NEAR, "cosine": _GRAZING}),
    Extreme("scale of the scene", {"scale": _powers(-20, 20)}),
    Extreme("far from the origin", {"offset": _signed(_powers(0, 20))}),
    Extreme("slivers", {"shape": _THIN}),
    Extreme("no area", {"shape": _among(0.0)}),
    Extreme("radiance at its limits", {"radiance": _ENDS}),
    Extreme("no light", {"radiance": _among(0.0)}),
    Extreme("black and white", {"albedo": _among(0.0, 1.0)}),
    Extreme("smooth", {"roughness": _mixed(_powers(-24, 0), _in_type(-1, 0))}),
    Extreme("index of refraction", {"index": _INDEX}),
    Extreme("weights at their limits", {"weight": _ENDS}),
    Extreme("confidence", {"confidence": _counts}),
    Extreme("random numbers", {"u": _ends_of_u}),
)
"""The columns of the matrix; the first is none."""

"""Replay of reservoirs in bits: any code passes that is read as it should be."""

import numpy as np
from numpy.typing import NDArray

from reference.arrays import Scalars, Vec3s, length, normalize
from reference.oracle.cases import Buffers, Case
from reference.oracle.contract.fields import Precision
from reference.oracle.replay.bounded import (
    Bounded,
    Rounding,
    constant,
    exact,
    rounding_of,
)
from reference.oracle.replay.further.numbers import unit
from reference.oracle.replay.judgement import Compared, Judgement, beside, exactly
from reference.oracle.replay.rules import Rules
from reference.oracle.replay.verbs import choose
from reference.resampling.packing import paper
from reference.resampling.packing.octahedral import UNIT, WORST_ANGLE

SINGLE, SMALL_SINGLE = 2.0**-24, float(np.finfo(np.float32).tiny)
"""Relative error of a float32; smaller ones may be flushed to 0."""

HALF, SMALL_HALF = 2.0**-11, 2.0**-25
"""Relative error of a float16, and absolute error of one below 2⁻¹⁴."""

MOST_HALF, MOST_SINGLE, MOST_M = 65504.0, float(np.finfo(np.float32).max), 65535.0


def judge_pack(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``pack``.

    Parameters
    ----------
    case : Case
        The call.
    outputs : mapping of str to array
        By the backend.
    rules : Rules
        What is calculated with.
    precision : 'float32' or 'float64'
        Of the backend.

    Returns
    -------
    Judgement
        N rows.  The words are read by the production code, and what they say is held
        against the errors that the layout has.  So a normal may have the code beside
        ours, where both are near enough.
    """
    given, rounding = case.inputs, rounding_of(precision)
    codes = _records(outputs["words"])
    x_v, n_v, r, seed = paper.unpack(codes)
    singles = (
        ("visible_position", codes["x_v"], x_v),
        ("position", codes["x_s"], r.y.position),
        ("W", codes["W"], r.W),
    )
    return Judgement(
        (
            *(
                _rounded(
                    name, raw, read, given[name], MOST_SINGLE, SINGLE, SMALL_SINGLE
                )
                for name, raw, read in singles
            ),
            _rounded(
                "radiance",
                codes["L_o"],
                r.y.radiance,
                given["radiance"],
                MOST_HALF,
                HALF,
                SMALL_HALF,
            ),
            _turned("visible_normal", n_v, given["visible_normal"], rounding),
            _turned("normal", r.y.normal, given["normal"], rounding),
            _counted(r.M, given["M"]),
            exactly("seed", seed, given["seed"]),
        )
    )


def judge_unpack(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``unpack``.

    Parameters
    ----------
    case : Case
        The call.
    outputs : mapping of str to array
        By the backend.
    rules : Rules
        What is calculated with.
    precision : 'float32' or 'float64'
        Of the backend.

    Returns
    -------
    Judgement
        N rows.  All but the normals is exact; a float32 below the smallest normal
        number may be flushed to 0.
    """
    rounding = rounding_of(precision)
    codes = _records(case.inputs["words"])
    x_v, _, r, seed = paper.unpack(codes)
    return Judgement(
        (
            _copied("visible_position", outputs, x_v),
            beside(
                "visible_normal",
                outputs["visible_normal"],
                _decoded(codes["n_v"], rounding),
            ),
            _copied("position", outputs, r.y.position),
            beside("normal", outputs["normal"], _decoded(codes["n_s"], rounding)),
            exactly("radiance", outputs["radiance"], r.y.radiance),
            _copied("W", outputs, r.W),
            exactly("M", outputs["M"], r.M),
            exactly("seed", outputs["seed"], seed),
        )
    )


def _records(words: NDArray[np.uint32]) -> NDArray[np.void]:
    whole = np.ascontiguousarray(words, "<u4")
    return whole.view(paper.RESERVOIR)[:, 0]


def _rounded(
    name: str,
    raw: Scalars,
    read: Scalars,
    given: Scalars,
    most: float,
    relative: float,
    absolute: float,
) -> Compared:
    """Numbers of a narrower type, which is never infinite nor NaN."""
    wide = given.astype(np.float64)
    held = np.clip(wide, -most, most)
    allowed = np.maximum(np.abs(held) * relative, absolute)
    found = np.where(np.isfinite(raw), read, np.inf)
    saturated = np.abs(wide) > most
    return Compared(f"words: {name}", found, held, np.where(saturated, 0.0, allowed))


def _turned(name: str, read: Vec3s, given: Vec3s, rounding: Rounding) -> Compared:
    """How far normals are from what they were.

    The layout's own error is that of half a step of the grid in each of the two
    coordinates.  To it come roundings: two of the sum of three, one of the quotient,
    two of the fold, and the scaling's, together eight half units, or two of `unit`, of
    a number up to 1, which is 32767 steps.
    """
    wide = given.astype(np.float64)
    away = normalize(wide)
    away[~wide.any(axis=1), 2] = 1.0  # the zero vector is written as +z
    steps = 0.5 + 2 * rounding.unit * UNIT
    chord = length(read - away)
    most = np.full(len(chord), WORST_ANGLE * steps / 0.5)
    return Compared(f"words: angle of {name}", chord, np.zeros_like(chord), most)


def _counted(read: Scalars, given: Scalars) -> Compared:
    wide = given.astype(np.float64)
    held = np.where(wide > 0, np.clip(wide, 1.0, MOST_M), 0.0)
    allowed = np.where(held == np.rint(held), 0.0, 0.5)
    return Compared("words: M", read, held, allowed)


def _copied(name: str, outputs: Buffers, expected: Scalars) -> Compared:
    small = np.abs(expected) < SMALL_SINGLE
    return Compared(name, outputs[name], expected, np.where(small, SMALL_SINGLE, 0.0))


def _decoded(codes: NDArray[np.int16], rounding: Rounding) -> Bounded:
    """Normals of octahedral codes, as a backend calculates them in its own type.

    Where z is near 0 it may be taken for the other side of the fold.  There the two
    sides meet, and differ by z: that error is added to both coordinates.
    """
    u, v = (
        exact(np.maximum(codes[:, i].astype(np.int32), -UNIT), rounding)
        / exact(np.full(len(codes), UNIT), rounding)
        for i in range(2)
    )
    one = constant(1.0, u)
    z = one - abs(u) - abs(v)
    whole = UNIT - np.abs(codes.clip(-UNIT).astype(np.int32)).sum(axis=1)
    below = whole < 0
    folded = [choose(below, _fold(a, b), a) for a, b in ((u, v), (v, u))]
    coordinates = [*folded, z]
    value = np.stack([c.value for c in coordinates], axis=1)
    error = np.stack([folded[0].error + z.error, folded[1].error + z.error, z.error], 1)
    return unit(Bounded(value, error, rounding))


def _fold(a: Bounded, b: Bounded) -> Bounded:
    """(1 − |b|) sign a, with sign 0 = +1."""
    size = constant(1.0, b) - abs(b)
    return Bounded(
        np.where(a.value < 0, -size.value, size.value), size.error, a.rounding
    )

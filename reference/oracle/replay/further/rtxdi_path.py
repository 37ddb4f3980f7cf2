"""Replay of reservoirs of paths in the 64 bytes of RTXDI."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Masks, Scalars, Vec3s
from restir_gi.reference.oracle.cases import Buffers
from restir_gi.reference.oracle.replay.bounded import Bounded, Rounding, exact
from restir_gi.reference.oracle.replay.further.formulas import MOST_M
from restir_gi.reference.oracle.replay.further.layout_rules import PathRules
from restir_gi.reference.oracle.replay.further.numbers import unit
from restir_gi.reference.oracle.replay.further.records import copied, records, single
from restir_gi.reference.oracle.replay.further.rules import FurtherRules
from restir_gi.reference.oracle.replay.judgement import (
    Compared,
    beside,
    between,
    exactly,
    in_rows,
)
from restir_gi.reference.resampling.packing import rtxdi_path
from restir_gi.reference.resampling.packing.components import UNIT
from restir_gi.reference.resampling.packing.rounding import widened

STEP_OF_HALF = 2.0**-10
"""Between two float16, at most, of the smaller one: how they are rounded is the
platform's affair."""

MOST_HALF, FIRST_BEYOND = 65504.0, 65520.0
"""The largest float16, and the least number whose nearest one is infinite."""

COUNTS = ("reconnection_vertex", "path_length", "random_index")
NUMBERS = ("partial_jacobian", "onward_pdf")


def packed(
    given: Buffers, outputs: Buffers, part: FurtherRules, rounding: Rounding
) -> tuple[Compared, ...]:
    """Words beside what was given; N rows."""
    rules = part.rtxdi_path
    codes = records(outputs["words"], "u1", rules.bytes, rtxdi_path.RESERVOIR)
    r, path = rtxdi_path.unpack(codes)
    on_light = (given["on_light"] == 1) & rules.marked
    found_light = _is_infinite(codes)
    return (
        single("position", codes["x_s"], r.y.position, given["position"]),
        single("W", codes["W"], r.W, given["W"]),
        *(single(n, codes[n], getattr(path, n), given[n]) for n in NUMBERS),
        single(
            "target_function", codes["target"], path.target, given["target_function"]
        ),
        exactly("words: on_light", found_light, on_light),
        in_rows(~on_light, _radiance(codes, given["radiance"])),
        *(
            in_rows(
                on_light, exactly(f"words: {name}", codes["L_o"][:, k], given[name])
            )
            for k, name in ((1, "light"), (2, "light_place"))
        ),
        _components(codes["n_s"], given["normal"], rules, rounding),
        _confidence(codes["M"], given["M"].astype(np.float64), rules),
        *_flags(codes, given, rules),
        exactly("words: seed", path.seed, given["seed"]),
    )


def unpacked(
    given: Buffers, outputs: Buffers, part: FurtherRules, rounding: Rounding
) -> tuple[Compared, ...]:
    """Reservoirs beside what the words hold; N rows."""
    rules = part.rtxdi_path
    codes = records(given["words"], "u1", rules.bytes, rtxdi_path.RESERVOIR)
    r, path = rtxdi_path.unpack(codes)
    reals = {"position": r.y.position, "W": r.W, "target_function": path.target}
    reals |= {name: getattr(path, name) for name in NUMBERS}
    on_light = path.on_light & rules.marked
    words = codes["L_o"]
    radiance = np.where(on_light[:, None], 0.0, _as_floats(words))
    lights = {"on_light": on_light}
    lights["light"], lights["light_place"] = (
        np.where(on_light, words[:, k], 0) for k in (1, 2)
    )
    M = r.M if rules.half else codes["M"].view("<u2").astype(np.float64)
    age, boosts = rules.flags_read(codes["age"].astype(np.uint32))
    whole = {"M": M, "age": age, "boosts": boosts, "seed": path.seed, **lights}
    whole |= {name: getattr(path, name) for name in COUNTS}
    return (
        *(copied(name, outputs, expected) for name, expected in reals.items()),
        copied("radiance", outputs, radiance),
        beside("normal", outputs["normal"], _normals(codes["n_s"], rules, rounding)),
        *(exactly(name, outputs[name], held) for name, held in whole.items()),
    )


def _is_infinite(codes: NDArray[np.void]) -> Masks:
    """Rows with an infinite red, which stands for a light, (N,) bool."""
    red = codes["L_o"][:, 0] & np.uint32(0x7FFFFFFF)
    found: Masks = red == rtxdi_path.INFINITY
    return found


def _as_floats(words: NDArray[Any]) -> Scalars:
    """Words as the floats whose bits they are."""
    return widened(np.ascontiguousarray(words).view("<f4"))


def _radiance(codes: NDArray[np.void], given: Vec3s) -> Compared:
    raw = np.ascontiguousarray(codes["L_o"]).view("<f4")
    return single("radiance", raw, widened(raw), given)


def _steps(codes: NDArray[np.unsignedinteger[Any]], rules: PathRules) -> Scalars:
    """Components of normals in steps, as they are read; none beyond the last."""
    if rules.offset:
        return np.minimum(codes.astype(np.float64) - UNIT, UNIT)
    return np.maximum(codes.astype(np.uint16).view(np.int16).astype(np.float64), -UNIT)


def _components(
    codes: NDArray[np.unsignedinteger[Any]],
    given: Vec3s,
    rules: PathRules,
    rounding: Rounding,
) -> Compared:
    """Components in steps, beside the nearest; or those below.

    A component times 32767, and 32767 added to it, are rounded twice each.
    """
    found, exactly_so = _steps(codes, rules), UNIT * given.astype(np.float64)
    room = np.full(found.shape, 2 * rounding.unit * UNIT)
    name = "words: normal in steps"
    if not rules.cut:
        held = np.clip(exactly_so, -UNIT, UNIT)
        return Compared(name, found, held, 0.5 + room)
    ends = (np.clip(np.floor(exactly_so + s * room), -UNIT, UNIT) for s in (-1, 1))
    return between(name, found, *ends)


def _normals(
    codes: NDArray[np.unsignedinteger[Any]], rules: PathRules, rounding: Rounding
) -> Bounded:
    steps = exact(_steps(codes, rules), rounding)
    found = steps / exact(np.full(codes.shape, UNIT), rounding)
    return unit(found) if rules.normalized else found


def _confidence(raw: Scalars, given: Scalars, rules: PathRules) -> Compared:
    """M as a float16; or as a uint16, or infinite where it is too large."""
    if not rules.half:
        found = np.ascontiguousarray(raw).view("<u2").astype(np.float64)
        held = np.clip(given, 0.0, MOST_M)
        return Compared("words: M", found, held, np.where(held % 1 > 0, 1.0, 0.0))
    held, beyond = np.clip(given, 0.0, MOST_HALF), np.inf
    is_half = held.astype(np.float16).astype(np.float64) == held
    allowed = np.where(is_half, 0.0, STEP_OF_HALF * held)
    if rules.overflows:
        beyond = 2 * FIRST_BEYOND
        held = np.where(given >= FIRST_BEYOND, beyond, held)
    found = np.where(np.isfinite(raw), raw.astype(np.float64), beyond)
    return Compared("words: M", found, held, allowed)


def _flags(
    codes: NDArray[np.void], given: Buffers, rules: PathRules
) -> tuple[Compared, ...]:
    """The word of age, boosts and counts, as it is read."""
    word = rules.flags(given["age"], given["boosts"])
    for place, name in enumerate(COUNTS, 1):
        word = word | given[name] << np.uint32(8 * place)
    expected = {"age": word & np.uint32(31), "boosts": word >> np.uint32(7) & 1}
    found = {"age": codes["age"] & 31, "boosts": codes["age"] >> 7}
    for place, name in enumerate(COUNTS, 1):
        expected[name] = word >> np.uint32(8 * place) & np.uint32(255)
        found[name] = codes[name]
    return tuple(exactly(f"words: {n}", found[n], held) for n, held in expected.items())

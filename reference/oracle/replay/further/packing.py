"""Replay of reservoirs in bits: any code passes that is read as it should be."""

from collections.abc import Callable, Mapping

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.contract.packing import (
    PAPER,
    RESTIR_PT,
    RTXDI,
    RTXDI_PATH,
)
from restir_gi.reference.oracle.replay.bounded import Rounding, rounding_of
from restir_gi.reference.oracle.replay.further import rtxdi, rtxdi_path
from restir_gi.reference.oracle.replay.further.normals import as_read, as_written
from restir_gi.reference.oracle.replay.further.records import copied, records, single
from restir_gi.reference.oracle.replay.further.rules import FurtherRules, further
from restir_gi.reference.oracle.replay.judgement import (
    Compared,
    Judgement,
    beside,
    exactly,
)
from restir_gi.reference.oracle.replay.rules import Rules
from restir_gi.reference.resampling.packing import paper

HALF, SMALL_HALF = 2.0**-11, 2.0**-25
"""Relative error of a float16, and absolute error of one below 2⁻¹⁴."""

NORMAL_HALF, FIRST_BEYOND = 2.0**-14, 65520.0
"""Smallest normal float16, and what the nearest one of is infinity."""

MOST_HALF = 65504.0

LAST = {PAPER: "seed", RESTIR_PT: "age"}
"""What stands in the last word of 48 bytes."""

Compare = Callable[[Buffers, Buffers, FurtherRules, Rounding], tuple[Compared, ...]]

PACKED: Mapping[str, Compare] = {RTXDI: rtxdi.packed, RTXDI_PATH: rtxdi_path.packed}
UNPACKED: Mapping[str, Compare] = {
    RTXDI: rtxdi.unpacked,
    RTXDI_PATH: rtxdi_path.unpacked,
}
"""Comparisons of the layouts that do not have the paper's 48 bytes."""


def judge_pack(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``pack``.

    N rows.  The words are read by the production code, and what they say is held
    against the errors that the layout has.  So a normal may have the code beside ours,
    where both are near enough.
    """
    part, given, rounding = further(rules), case.inputs, rounding_of(precision)
    layout = str(case.settings.get("layout", PAPER))
    if layout in PACKED:
        return Judgement(PACKED[layout](given, outputs, part, rounding))
    codes = records(outputs["words"], "<u2", part.halves, paper.RESERVOIR)
    x_v, _, r, last = paper.unpack(codes)
    singles = (
        ("visible_position", codes["x_v"], x_v),
        ("position", codes["x_s"], r.y.position),
        ("W", codes["W"], r.W),
    )
    octahedron = part.octahedron
    return Judgement(
        (
            *(single(name, raw, read, given[name]) for name, raw, read in singles),
            _halved(codes["L_o"], r.y.radiance, given["radiance"], part),
            *as_written(
                "visible_normal",
                codes["n_v"],
                given["visible_normal"],
                octahedron,
                rounding,
            ),
            *as_written("normal", codes["n_s"], given["normal"], octahedron, rounding),
            _counted(r.M, part.packed_confidence(given["M"].astype(np.float64))),
            exactly(LAST[layout], last, given[LAST[layout]]),
        )
    )


def judge_unpack(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``unpack``.

    All but the normals is exact, and LogLuv; a float32 below the smallest normal number
    may be flushed to 0.
    """
    part, rounding = further(rules), rounding_of(precision)
    layout = str(case.settings.get("layout", PAPER))
    if layout in UNPACKED:
        return Judgement(UNPACKED[layout](case.inputs, outputs, part, rounding))
    codes = records(case.inputs["words"], "<u2", part.halves, paper.RESERVOIR)
    x_v, _, r, last = paper.unpack(codes)
    n_v, n_s = (as_read(codes[n], part.octahedron, rounding) for n in ("n_v", "n_s"))
    radiance, M = r.y.radiance, r.M
    if not part.small_halves_kept:
        radiance = _without_small(radiance)
    if part.confidence_signed:
        M = codes["M"].astype(np.int16).astype(np.float64)
    return Judgement(
        (
            copied("visible_position", outputs, x_v),
            beside("visible_normal", outputs["visible_normal"], n_v),
            copied("position", outputs, r.y.position),
            beside("normal", outputs["normal"], n_s),
            exactly("radiance", outputs["radiance"], radiance),
            copied("W", outputs, r.W),
            exactly("M", outputs["M"], M),
            exactly(LAST[layout], outputs[LAST[layout]], last),
        )
    )


def _halved(
    raw: Scalars, read: Scalars, given: Scalars, part: FurtherRules
) -> Compared:
    """Channels as float16."""
    wide = given.astype(np.float64)
    held = np.clip(wide, -MOST_HALF, MOST_HALF)
    allowed = np.maximum(np.abs(held) * HALF, SMALL_HALF)
    allowed = np.where(np.abs(wide) > MOST_HALF, 0.0, allowed)
    if part.half_toward_zero:
        held, allowed = _toward_zero(held), np.zeros_like(held)
    beyond = np.inf
    if part.half_overflows:
        beyond = 2 * FIRST_BEYOND
        held = np.where(np.abs(wide) >= FIRST_BEYOND, np.copysign(beyond, wide), held)
    if not part.small_halves_kept:
        held = _without_small(held)
        allowed = np.where(held == 0, 0.0, allowed)
    found = np.where(np.isfinite(raw), read, np.copysign(beyond, raw.astype(float)))
    return Compared("words: radiance", found, held, allowed)


def _toward_zero(x: Scalars) -> Scalars:
    near = x.astype(np.float16)
    down = np.nextafter(near, np.float16(0))
    return np.where(np.abs(near) > np.abs(x), down, near).astype(np.float64)


def _without_small(x: Scalars) -> Scalars:
    return np.where(np.abs(x) < NORMAL_HALF, 0.0, x)


def _counted(read: Scalars, held: Scalars) -> Compared:
    allowed = np.where(held == np.rint(held), 0.0, 0.5)
    return Compared("words: M", read, held, allowed)

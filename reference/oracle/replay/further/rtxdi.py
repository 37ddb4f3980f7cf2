"""Replay of reservoirs in the 32 bytes of RTXDI."""

import numpy as np

from restir_gi.reference.oracle.cases import Buffers
from restir_gi.reference.oracle.replay.bounded import Rounding
from restir_gi.reference.oracle.replay.further.normals import as_read, as_written
from restir_gi.reference.oracle.replay.further.records import copied, records, single
from restir_gi.reference.oracle.replay.further.rules import FurtherRules
from restir_gi.reference.oracle.replay.judgement import Compared, beside, exactly
from restir_gi.reference.oracle.replay.log_luv import as_log_luv, read_log_luv
from restir_gi.reference.resampling.packing import rtxdi


def packed(
    given: Buffers, outputs: Buffers, part: FurtherRules, rounding: Rounding
) -> tuple[Compared, ...]:
    """Words beside what was given; N rows."""
    rules = part.rtxdi
    codes = records(outputs["words"], "u1", rules.bytes, rtxdi.RESERVOIR)
    M = np.minimum(given["M"].astype(np.float64), 2.0**32 - 1).astype(np.uint32)
    counts = rules.counts(M, given["age"], given["misc"])
    r, age, misc = rtxdi.unpack(codes)
    return (
        single("position", codes["x_s"], r.y.position, given["position"]),
        single("W", codes["W"], r.W, given["W"]),
        *as_log_luv(codes["L_o"], given["radiance"], rules.log_luv, rounding),
        *as_written("normal", codes["n_s"], given["normal"], part.octahedron, rounding),
        exactly("words: M", r.M, counts & np.uint32(255)),
        exactly("words: age", age, counts >> np.uint32(8) & np.uint32(255)),
        exactly("words: misc", misc, counts >> np.uint32(16)),
    )


def unpacked(
    given: Buffers, outputs: Buffers, part: FurtherRules, rounding: Rounding
) -> tuple[Compared, ...]:
    """Reservoirs beside what the words hold; N rows."""
    rules = part.rtxdi
    codes = records(given["words"], "u1", rules.bytes, rtxdi.RESERVOIR)
    r, age, misc = rtxdi.unpack(codes)
    radiance = read_log_luv(codes["L_o"], rules.log_luv, rounding)
    normal = as_read(codes["n_s"], part.octahedron, rounding)
    return (
        copied("position", outputs, r.y.position),
        beside("normal", outputs["normal"], normal),
        beside("radiance", outputs["radiance"], radiance),
        copied("W", outputs, r.W),
        exactly("M", outputs["M"], r.M),
        exactly("age", outputs["age"], age),
        exactly("misc", outputs["misc"], misc),
    )

"""L2: inside a sphere nothing is left to chance.

Every chord of a sphere meets it at both ends under the cosine d / 2R.  With directions
in proportion to the cosine and the full target, a reservoir's weight is then the same
for whoever looks: the pixel's value is ρ L in a furnace, at once, whatever is reused;
and where only one cap shines, M times the value over ρ L is a whole number, the count
of samples that met it.  Both hold to rounding, in every frame.
"""

from typing import Any

import numpy as np

from restir_gi.reference.numerics.arrays import Masks
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.levels.probe import Finding
from restir_gi.reference.oracle.levels.sphere import (
    ALBEDO,
    InsideSphere,
    points_inside,
    ring,
)
from restir_gi.reference.oracle.loop import Ask, Run, run_frames

ROUNDINGS = 512
"""Of one estimate, in units of half an eps, times the largest 1 / cos: two merges of
four and a shade, some 60 operations, of which each J and p̂ divide by a cosine that a
difference of positions has rounded."""

LEAST_COSINE = 1 / 8
"""Chords that are shorter are not looked at: their cosine is all rounding."""


def furnace(ask: Ask, precision: Precision, rows: int = 512) -> Finding:
    """The sphere shines everywhere: every pixel is ρ, in every frame.

    A right backend cannot fail.
    """
    sphere = InsideSphere(points_inside(rows, 1), 2.0)
    frames = run_frames(ask, sphere, lambda f: ring(rows, 3, f), Run(), precision)
    for number, shown in enumerate(frames):
        clear = _clear(sphere, shown.spatial)
        off = np.abs(shown.color / ALBEDO - 1).max(axis=1)
        bad = clear & (off > room(precision))
        if bad.any():
            row = int(np.flatnonzero(bad)[0])
            return Finding(
                False,
                f"sphere furnace, frame {number}: pixel {row} is"
                f" {shown.color[row, 0]:.6g} instead of {ALBEDO[0]:.6g}"
                f" ({int(bad.sum())} of {rows} pixels are wrong)",
            )
    return Finding(True)


def half_lit(ask: Ask, precision: Precision, rows: int = 512) -> Finding:
    """Half of the sphere shines: M times a pixel over ρ is a whole number.

    A right backend cannot fail; M here is no larger than the caps.
    """
    sphere = InsideSphere(points_inside(rows, 2), 0.0)
    run = Run(temporal_cap=1e4, spatial_cap=1e4)
    frames = run_frames(ask, sphere, lambda f: ring(rows, 2, f), run, precision)
    confidence, before = 0.0, 0.0
    for number, shown in enumerate(frames):
        before += 1.0  # temporal
        confidence = confidence + 3 * before  # spatial past, own and two neighbours
        count = confidence * shown.color[:, 0].astype(float) / ALBEDO[0]
        clear = _clear(sphere, shown.spatial)
        bad = clear & (np.abs(count - np.rint(count)) > confidence * room(precision))
        wrong_M = shown.spatial["M"] != confidence
        if wrong_M.any():
            M = shown.spatial["M"][wrong_M][0]
            return Finding(
                False,
                f"half-lit sphere, frame {number}: M is {M:g} instead of"
                f" {confidence:g}: misses count",
            )
        if bad.any():
            row = int(np.flatnonzero(bad)[0])
            return Finding(
                False,
                f"half-lit sphere, frame {number}: pixel {row} counts {count[row]:.6g}"
                f" lit samples of {confidence:g}, which is not a whole number"
                f" ({int(bad.sum())} of {rows} pixels)",
            )
    return Finding(True)


def room(precision: Precision) -> float:
    """Relative error that rounding may have in the estimate of a clear pixel.

    Returns float; `ROUNDINGS` half units, times the largest 1 / cos.
    """
    return ROUNDINGS * float(np.finfo(precision).eps) / 2 / LEAST_COSINE


def _clear(sphere: InsideSphere, kept: Any) -> Masks:
    """Rows whose sample is not so near that rounding hides its cosine."""
    d = np.linalg.norm(kept["position"] - sphere.position, axis=1)
    far: Masks = (d / 2 > LEAST_COSINE) | (kept["W"] == 0)
    return far

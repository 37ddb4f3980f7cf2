"""L2: inside a sphere nothing is left to chance.

Every chord of a sphere meets it at both ends under the cosine d / 2R.  With directions
in proportion to the cosine and the full target, a reservoir's weight is then the same
for whoever looks, and what a pixel shows over ρ is the mean of the radiances that were
met, each weighted with its confidence: 1 in a furnace, whatever is reused; and where
half of the sphere shines, M times it is the count of samples that met it.  Both hold to
rounding, in every frame, for weights that divide by sums of M: 1/M and 1/Z, and balance
and pairwise, too, as p̂ / J is the same whoever looks; by the defensive weight a furnace
is 1, and M counts nothing.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.levels.probe import Finding
from restir_gi.reference.oracle.levels.sphere import (
    ALBEDO,
    InsideSphere,
    points_inside,
    ring,
)
from restir_gi.reference.oracle.loop import Ask, LoopFrame, Run, run_frames

ROUNDINGS = 512
"""Of one estimate, in units of half an eps, times the largest 1 / cos: two merges of
four and a shade, some 60 operations, of which each J and p̂ divide by a cosine that a
difference of positions has rounded."""

LEAST_COSINE = 1 / 8
"""Chords that are shorter are not looked at: their cosine is all rounding."""

LONG = Run(frames=40, temporal_cap=8.0, spatial_cap=20.0)
"""Long enough for both caps to be reached, and for what they leave out to add up."""

PLAIN = Run()

AROUND = 2
"""Neighbours of a pixel in the long run."""

KEPT_ROUNDINGS = 12
"""Estimates whose roundings a long run adds up: of what it had a pixel keeps 8 of 9
parts in the temporal pass and 20 of 44 in the spatial one, and each merge rounds once
more: at most 1 / (1 - 8/9) + 1 / (1 - 20/44) < 12 times one estimate's."""

ROWS = 64
"""Pixels of either sphere in the long run."""


def furnace(
    ask: Ask, precision: Precision, run: Run = PLAIN, rows: int = 512
) -> Finding:
    """The sphere shines everywhere: every pixel is ρ, in every frame.

    A right backend cannot fail.
    """
    sphere = InsideSphere(points_inside(rows, 1), 2.0)
    K = run.around(3)
    frames = run_frames(ask, sphere, lambda f: ring(rows, K, f), run, precision)
    return _all_shine(frames, sphere, slice(rows), "sphere furnace", room(precision))


def half_lit(
    ask: Ask, precision: Precision, run: Run = PLAIN, rows: int = 512
) -> Finding:
    """Half of the sphere shines: M times a pixel over ρ counts what met light.

    A right backend cannot fail; M here is no larger than the caps.
    """
    sphere = InsideSphere(points_inside(rows, 2), 0.0)
    run = replace(run, temporal_cap=1e4, spatial_cap=1e4)
    K = run.around(2)
    frames = run_frames(ask, sphere, lambda f: ring(rows, K, f), run, precision)
    around = [ring(rows, K, f) for f in range(run.frames)]
    words, most = "half-lit sphere", room(precision)
    return _counts(frames, sphere, slice(rows), words, most, around, run)


def long_run(ask: Ask, precision: Precision, run: Run = PLAIN) -> list[LoopFrame]:
    """Frames of a furnace, and behind it of a half-lit sphere, with small caps."""
    return run_frames(ask, _both(), partial(_rings, run), long_form(run), precision)


def long_form(run: Run) -> Run:
    """A long run of the same weights and neighbours."""
    limits = LONG.temporal_cap, LONG.spatial_cap
    return replace(
        run, frames=LONG.frames, temporal_cap=limits[0], spatial_cap=limits[1]
    )


def long_furnace(frames: list[LoopFrame], precision: Precision) -> Finding:
    """Every pixel of the furnace is ρ, wherever M is capped.

    A right backend cannot fail.
    """
    words = f"sphere furnace of {LONG.frames} frames"
    most = KEPT_ROUNDINGS * room(precision)
    return _all_shine(frames, _both(), slice(ROWS), words, most)


def long_half_lit(
    frames: list[LoopFrame], precision: Precision, run: Run = PLAIN
) -> Finding:
    """Every pixel is what the contract's confidences make of the samples that it met.

    A right backend cannot fail.
    """
    around = [ring(ROWS, run.around(AROUND), f) for f in range(LONG.frames)]
    words = f"half-lit sphere of {LONG.frames} frames"
    most = KEPT_ROUNDINGS * room(precision)
    about = words, most, around, long_form(run)
    return _counts(frames, _both(), slice(ROWS, None), *about)


def _both() -> InsideSphere:
    lit = np.concatenate([np.full(ROWS, 2.0), np.zeros(ROWS)])
    return InsideSphere(points_inside(2 * ROWS, 3), lit)


def _rings(run: Run, frame: int) -> Indices:
    within = ring(ROWS, run.around(AROUND), frame)
    return np.concatenate([within, within + ROWS])


def _all_shine(
    frames: list[LoopFrame], sphere: InsideSphere, rows: slice, words: str, most: float
) -> Finding:
    for number, shown in enumerate(frames):
        off = np.abs(shown.color[rows] / ALBEDO - 1).max(axis=1)
        bad = _clear(sphere, shown.spatial)[rows] & (off > most)
        if bad.any():
            row = int(np.flatnonzero(bad)[0])
            return Finding(
                False,
                f"{words}, frame {number}: pixel {row} is"
                f" {shown.color[rows][row, 0]:.6g} instead of {ALBEDO[0]:.6g}"
                f" ({int(bad.sum())} of {len(bad)} pixels are wrong)",
            )
    return Finding(True)


def _counts(
    frames: list[LoopFrame],
    sphere: InsideSphere,
    rows: slice,
    words: str,
    most: float,
    around: list[Indices],
    run: Run,
) -> Finding:
    wanted = _shares(frames, rows, around, run)
    for number, (shown, (confidence, share)) in enumerate(
        zip(frames, wanted, strict=True)
    ):
        where = f"{words}, frame {number}"
        M = shown.spatial["M"][rows].astype(float)
        if np.any(confidence != M):
            return Finding(False, f"{where}: {_other_M(M, confidence, share)}")
        found = shown.color[rows, 0].astype(float) / ALBEDO[0]
        bad = _clear(sphere, shown.spatial)[rows] & (np.abs(found - share) > most)
        if bad.any():
            row = int(np.flatnonzero(bad)[0])
            return Finding(
                False,
                f"{where}: pixel {row} shows {found[row]:.6g} of the light instead of"
                f" {share[row]:.6g}, the share of lit samples among those that it has"
                f" met ({int(bad.sum())} of {len(bad)} pixels are wrong)",
            )
    return Finding(True)


def _shares(
    frames: list[LoopFrame], rows: slice, around: list[Indices], run: Run
) -> Iterator[tuple[float, Scalars]]:
    """M of all pixels, and the weighted share of lit samples of each, by frame."""
    M_t = M_s = 0.0
    v_t = v_s = np.zeros(len(around[0]))
    for shown, near in zip(frames, around, strict=True):
        lit = (shown.radiance[rows, 0] > 0).astype(float)
        v_t = (M_t * v_t + lit) / (M_t + 1)
        M_t = min(M_t + 1, run.temporal_cap)
        M_s = M_s if run.history else 0.0
        total = M_s + M_t * (1 + near.shape[1])
        v_s = (M_s * v_s + M_t * (v_t + v_t[near].sum(axis=1))) / total
        M_s = min(total, run.spatial_cap)
        yield M_s, v_s


def _other_M(M: Scalars, wanted: float, share: Scalars) -> str:
    """What was seen of confidences that are wrong."""
    wrong = np.not_equal(M, wanted)
    text = (
        f"M is {M[wrong][0]:.6g} instead of {wanted:g} in {int(wrong.sum())} of"
        f" {len(M)} pixels"
    )
    # Sums of ones, which are exact but for the quotient of the share.
    if np.abs(M - share * wanted).max() < 1e-6:
        return f"{text}, everywhere the number of samples that met light: misses count"
    return text


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

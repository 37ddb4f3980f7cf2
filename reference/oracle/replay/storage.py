"""Reservoirs that are stored in fewer bits between passes.

What a pass reads may have been stored, and what it gives is.  So sample and W carry the
error of their format on the way in, and on the way out they have to be numbers that the
format has: a mistake whose size is that of a rounding is not taken for one.

A format has a range of its own.  Beyond its largest number a renderer may hold that or
infinity, and nothing is known; below its least normal number it may hold 0.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from restir_gi.reference.numerics.arrays import Masks, Scalars
from restir_gi.reference.oracle.cases import Buffers
from restir_gi.reference.oracle.replay.bounded import Bounded
from restir_gi.reference.oracle.replay.judgement import Compared
from restir_gi.reference.oracle.replay.log_luv import beside_log_luv, stored_in_log_luv
from restir_gi.reference.oracle.replay.points import SamplePoint, same_points

HALF_LEAST, HALF_MOST = 2.0**-14, 65504.0
"""Of float16: the least normal number, and the largest."""


@dataclass(frozen=True, slots=True)
class SharedExponent:
    """Channels of so many bits each, beside an exponent that they share.

    Attributes
    ----------
    least_step : float; between two numbers that have the least exponent
    most : float; the largest number that all three channels can have
    """

    bits: int
    least_step: float
    most: float


RGB9E5 = SharedExponent(9, 2.0**-24, 65408.0)
RGBE = SharedExponent(8, 2.0**-136, 255 * 2.0**119)


@dataclass(frozen=True, slots=True)
class Storage:
    """A format of reservoirs.

    Attributes
    ----------
    half_radiance, half_weight : bool; float16
    shared : SharedExponent or None
        How the channels of the radiance are stored; ``None``: in bits of their own.
    log_luv : bool; the radiance is a logarithm and chromaticities
    normal_error : float; of a component of the normal
    normals_alone : bool; nothing but the normals tells the format
    """

    half_radiance: bool = False
    half_weight: bool = False
    shared: SharedExponent | None = None
    log_luv: bool = False
    normal_error: float = 0.0
    normals_alone: bool = False


OCTAHEDRAL_16 = 6.474e-5
"""Angle in radians by which two int16 on an octahedron miss a normal, at most."""

STORAGES: Mapping[str, Storage] = {
    "half": Storage(half_radiance=True, half_weight=True),
    "half-radiance": Storage(half_radiance=True),
    "half-weight": Storage(half_weight=True),
    "packed": Storage(half_radiance=True, normal_error=OCTAHEDRAL_16),
    "packed-half": Storage(
        half_radiance=True, half_weight=True, normal_error=OCTAHEDRAL_16
    ),
    "rgb9e5": Storage(shared=RGB9E5, half_weight=True, normal_error=OCTAHEDRAL_16),
    "rgb9e5-float-weight": Storage(shared=RGB9E5, normal_error=OCTAHEDRAL_16),
    "rgbe": Storage(shared=RGBE, half_weight=True, normal_error=OCTAHEDRAL_16),
    "rgbe-float-weight": Storage(shared=RGBE, normal_error=OCTAHEDRAL_16),
    "rtxdi": Storage(log_luv=True, normal_error=OCTAHEDRAL_16),
    "octahedral": Storage(normal_error=OCTAHEDRAL_16, normals_alone=True),
}


def _half(x: Bounded) -> Bounded:
    """Numbers as float16, to nearest or cut: one step, and 0 for subnormal numbers."""
    size = np.abs(x.value)
    step = np.where(size < HALF_LEAST, size, 2.0**-10 * size)
    return _up_to(HALF_MOST, Bounded(x.value, x.error + step, x.rounding))


def _in_shared(x: Bounded, form: SharedExponent) -> Bounded:
    """Channels beside one exponent, to nearest or cut: one step of the largest."""
    largest = np.abs(x.value).max(axis=1, keepdims=True)
    step = np.maximum(2.0 ** (1 - form.bits) * largest, form.least_step)
    error = x.error + np.where(x.value > 0, step, 0.0)
    return _up_to(form.most, Bounded(x.value, error, x.rounding))


def _up_to(most: float, x: Bounded) -> Bounded:
    """Numbers of a format, of which nothing is known beyond its largest."""
    out = np.abs(x.value) + x.error > most
    return Bounded(x.value, np.where(out, np.inf, x.error), x.rounding)


def stored_sample(y: SamplePoint, name: str) -> SamplePoint:
    """Sample points as they come out of storage."""
    if name == "exact":
        return y
    form, radiance, normal = STORAGES[name], y.radiance, y.normal
    if form.half_radiance:
        radiance = _half(radiance)
    if form.shared is not None:
        radiance = _in_shared(radiance, form.shared)
    if form.log_luv:
        radiance = stored_in_log_luv(radiance)
    if form.normal_error:
        error = normal.error + form.normal_error
        normal = Bounded(normal.value, error, normal.rounding)
    return replace(y, radiance=radiance, normal=normal)


def stored_W(W: Bounded, name: str) -> Bounded:
    """W as it comes out of storage, (N,)."""
    return _half(W) if name != "exact" and STORAGES[name].half_weight else W


def held_as_stored(outputs: Buffers, y: SamplePoint, name: str) -> Masks:
    """Whether outputs hold sample points, as far as their storage can tell, (N,)."""
    if name == "exact":
        return same_points(outputs, y)
    y = stored_sample(y, name)
    same: Masks = (outputs["position"] == y.position.value).all(axis=1)
    for buffer, x in (("normal", y.normal), ("radiance", y.radiance)):
        found = outputs[buffer].astype(np.float64)
        same &= (np.abs(found - x.value) <= x.error).all(axis=1)
    return same


def in_format(outputs: Buffers, name: str) -> list[Compared]:
    """Outputs beside the nearest numbers that the format has.

    Nothing is allowed, but for the rounding of decoders that calculate.
    """
    if name == "exact":
        return []
    form, found = STORAGES[name], []
    if form.half_radiance:
        found.append(_beside_half("radiance", outputs))
    if form.half_weight:
        found.append(_beside_half("W", outputs))
    if form.normals_alone:
        found.append(_beside_octahedral(outputs["normal"]))
    if form.shared is not None:
        found.append(_beside_shared(outputs["radiance"], form.shared))
    if form.log_luv:
        found.append(beside_log_luv(outputs["radiance"]))
    return found


def _beside_half(buffer: str, outputs: Buffers) -> Compared:
    given = outputs[buffer]
    with np.errstate(over="ignore"):
        stored = given.astype(np.float16).astype(np.float64)
    return _beside_stored(buffer, given, stored, HALF_MOST)


def _beside_shared(radiance: Scalars, form: SharedExponent) -> Compared:
    wide = radiance.astype(np.float64)
    most = np.maximum(np.abs(wide).max(axis=1, keepdims=True), 2.0**-120)
    # A largest channel that was rounded up to a power of 2 had the exponent below.
    below = most * (1 - 2.0 ** -(form.bits + 1))
    step = 2.0 ** (np.floor(np.log2(below)) + 1 - form.bits)
    step = np.maximum(step, form.least_step)
    stored = np.round(wide / step) * step
    return _beside_stored("radiance", radiance, stored, form.most)


STEPS = 2**15 - 1
"""Of an int16 from 0 to 1."""


def _beside_octahedral(normal: Scalars) -> Compared:
    """Places on an octahedron beside the nearest ones that two int16 have.

    What came out of them was rounded by a decoder: half a dozen operations, each of
    which moves a place by 2⁻²⁴ of its size of 1 at most, and so do as many of ours.
    """
    wide = normal.astype(np.float64)
    size = np.abs(wide).sum(axis=1, keepdims=True)
    x, y, z = np.divide(wide, size, out=np.zeros_like(wide), where=size > 0).T
    folded = np.stack([np.copysign(1 - abs(y), x), np.copysign(1 - abs(x), y)])
    place = STEPS * np.where(z < 0, folded, np.stack([x, y])).T
    room = np.full(place.shape, 2 * 6 * 2.0**-24 * STEPS)
    return Compared("normal as stored", place, np.round(place), room)


def _beside_stored(
    buffer: str, given: Scalars, stored: Scalars, most: float
) -> Compared:
    """Numbers beside the nearest of a format, but for those beyond its largest."""
    beyond = np.abs(given) > most
    room = np.where(beyond, np.inf, 0.0)
    stored = np.where(beyond, most, stored)
    return Compared(f"{buffer} as stored", given, stored, room)

"""Replay of normals as two integers of 16 bits."""

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Masks, Scalars, Vec3s, length, normalize
from restir_gi.reference.oracle.replay.bounded import Bounded, Rounding, constant, exact
from restir_gi.reference.oracle.replay.further.layout_rules import Octahedron
from restir_gi.reference.oracle.replay.further.numbers import unit
from restir_gi.reference.oracle.replay.judgement import Compared
from restir_gi.reference.oracle.replay.verbs import choose
from restir_gi.reference.resampling.packing.octahedral import (
    UNIT,
    WORST_ANGLE,
    decode_normal,
)

Codes = NDArray[np.int16]


def as_written(
    name: str, codes: Codes, given: Vec3s, octahedron: Octahedron, rounding: Rounding
) -> tuple[Compared, ...]:
    """How far normals are from what they were.

    Parameters
    ----------
    codes : (N, 2) int16; by the backend
    given : (N, 3) float; unit normals, or 0

    Returns
    -------
    tuple of Compared
        By the contract, angles: so a normal may have the code beside ours, where both
        are near enough.  A mistake is held against the codes that it writes.
    """
    if octahedron == Octahedron():
        return (_turned(name, decode_normal(codes), given, rounding),)
    codes = codes[:, ::-1] if octahedron.v_first else codes
    return _coded(name, codes, given.astype(np.float64), octahedron, rounding)


def _turned(name: str, read: Vec3s, given: Vec3s, rounding: Rounding) -> Compared:
    """The angle, from the chord.

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


def _coded(
    name: str, codes: Codes, given: Vec3s, octahedron: Octahedron, rounding: Rounding
) -> tuple[Compared, ...]:
    total = np.abs(given).sum(axis=1) if octahedron.divided else np.ones(len(given))
    u, v = (given[:, i] / np.where(total > 0, total, 1.0) for i in range(2))
    if octahedron.folds:
        below, signs = given[:, 2] < 0, (_sign(u, octahedron), _sign(v, octahedron))
        folded = (1 - np.abs(v)) * signs[0], (1 - np.abs(u)) * signs[1]
        u, v = np.where(below, folded[0], u), np.where(below, folded[1], v)
    room = 2 * rounding.unit * octahedron.steps
    found = [codes[:, i].astype(np.float64) for i in range(2)]
    # The sides of the square are folded onto themselves, and either half may stand.
    edge = [np.abs(f) >= UNIT for f in found]
    one, other = (
        _code(f"words: {axis} of {name}", f, c * octahedron.steps, e, octahedron, room)
        for axis, f, c, e in zip("uv", found, (u, v), edge[::-1], strict=True)
    )
    if octahedron.runs_over:
        expected = np.where(found[0] < 0, -1.0, other.expected)
        other = Compared(other.name, found[1], expected, other.allowed)
    return one, other


def _sign(x: Scalars, octahedron: Octahedron) -> Scalars:
    zero: Scalars = np.where(x == 0, octahedron.sign_of_zero, np.sign(x))
    return zero


def _code(
    name: str,
    found: Scalars,
    exactly: Scalars,
    on_edge: Masks,
    octahedron: Octahedron,
    room: float,
) -> Compared:
    """A coordinate in steps, within the 16 bits."""
    exactly = np.where(on_edge, np.abs(exactly) * np.sign(found), exactly)
    most = np.clip(exactly, -UNIT, UNIT)
    if not octahedron.toward_zero:
        return Compared(name, found, most, np.full(len(found), 0.5 + room))
    whole = np.trunc(most)
    near = np.abs(most - np.rint(most)) <= room
    return Compared(name, found, whole, np.where(near, 1.0, 0.0))


def as_read(codes: Codes, octahedron: Octahedron, rounding: Rounding) -> Bounded:
    """Normals of octahedral codes, as a backend calculates them in its own type.

    Parameters
    ----------
    codes : (N, 2) int16

    Returns
    -------
    Bounded
        (N, 3).  Where z is near 0 it may be taken for the other side of the fold.
        There the two sides meet, and differ by z: that error is added to both
        coordinates.
    """
    kind = np.int16 if octahedron.signed else np.uint16
    codes = codes[:, ::-1] if octahedron.v_first else codes
    whole = np.maximum(codes.astype(kind).astype(np.int32), -UNIT)
    steps = exact(np.full(len(codes), octahedron.steps), rounding)
    u, v = (exact(whole[:, i], rounding) / steps for i in range(2))
    z = constant(1.0, u) - abs(u) - abs(v)
    below = (octahedron.steps < np.abs(whole).sum(axis=1)) & octahedron.folds
    folded = [choose(below, _folded(a, b, octahedron), a) for a, b in ((u, v), (v, u))]
    value = np.stack([c.value for c in (*folded, z)], axis=1)
    either = [c.error + z.error * octahedron.folds for c in folded]
    found = Bounded(value, np.stack([*either, z.error], axis=1), rounding)
    return unit(found) if octahedron.normalized else found


def _folded(a: Bounded, b: Bounded, octahedron: Octahedron) -> Bounded:
    """(1 − |b|) sign a."""
    size = constant(1.0, b) - abs(b)
    sign = _sign(a.value, octahedron)
    return Bounded(sign * size.value, size.error, a.rounding)

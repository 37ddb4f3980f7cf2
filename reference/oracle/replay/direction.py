"""Replay of drawn directions, in whatever frame a backend has about its normals."""

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars, Vec3s
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.replay.bounded import Bounded, exact, rounding_of
from restir_gi.reference.oracle.replay.judgement import Compared, Judgement, beside
from restir_gi.reference.oracle.replay.rules import Rules

SINE = 8
"""Roundings of a sine or cosine: the argument's, magnified by up to 2π, and its own."""


def judge_direction(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``direction``.

    The cosine with the normal, the length, and the density follow from the numbers.
    The azimuth does up to a turn, or a reflection, that is the same for all rows with
    one normal: so it is judged against the first such row.
    """
    rounding = rounding_of(precision)
    source = case.settings["source"]
    u = exact(case.inputs["u"], rounding)
    cosine = rules.drawn_cosine(source, u[:, 0])
    normal = case.inputs["visible_normal"].astype(np.float64)
    direction = outputs["direction"].astype(np.float64)
    # Each component of the direction has a few roundings of a number up to 1, and the
    # normal may itself be off unit length by some.
    room = 8 * rounding.unit
    outward = -1.0 if rules.inward else 1.0
    found = outward * (normal * direction).sum(axis=1)
    length = np.sqrt((direction * direction).sum(axis=1))
    p = rules.density(source, _at(cosine, room))
    angle = rules.turn * case.inputs["u"][:, rules.azimuth_number].astype(float)
    turned, wanted, loose = _azimuths(direction, normal, angle, room)
    ones = np.ones(case.rows)
    return Judgement(
        (
            Compared("cos θ", found, cosine.value, cosine.error + room),
            Compared("length", length, ones, np.full(case.rows, room)),
            Compared("azimuth", turned, wanted, loose),
            beside("pdf", outputs["pdf"], p),
        ),
        {"cos θ": found, "azimuth from the first of its normal": turned},
    )


def _at(cosine: Bounded, room: float) -> Bounded:
    return Bounded(cosine.value, cosine.error + room, cosine.rounding)


def _azimuths(
    direction: Vec3s, normal: Vec3s, phi: Scalars, room: float
) -> tuple[Scalars, Scalars, Scalars]:
    """Cosine of the azimuth from the first row of the same normal; wanted; allowed."""
    # By their bits: a frame may turn where a component is −0.
    bits = np.ascontiguousarray(normal).view(np.int64)
    _, first, group = np.unique(bits, axis=0, return_index=True, return_inverse=True)
    along = direction - (normal * direction).sum(axis=1)[:, None] * normal
    sine = np.sqrt((along * along).sum(axis=1))
    base = first[group.ravel()]
    both = sine * sine[base]
    turned = np.divide(
        (along * along[base]).sum(axis=1), both, out=np.ones_like(both), where=both > 0
    )
    angle = phi - phi[base]
    least = np.minimum(sine, sine[base])
    loose = np.where(least > 4 * room, (SINE + 4) * room / np.maximum(least, room), 2.0)
    return turned, np.where(both > 0, np.cos(angle), 1.0), loose

"""Paths from the end: what begins at x_v is a sample of its own.

Light that reaches x_v by way of further points is an integral over all that follows; a
reservoir of x_v estimates it.  Behind the way to x_v its sample is one of x_(v-1).
"""

from dataclasses import dataclass, replace

import numpy as np

from extensions.ends import density_at
from extensions.paths import Paths
from extensions.walking import Step
from reference.arrays import Masks, Scalars, Vec3s, divide_or_zero
from reference.records import where


@dataclass(frozen=True, slots=True)
class Onset:
    """How N paths leave their first point.

    Attributes
    ----------
    wi : (N, 3) float64; unit directions
    weight : (N, 3) float64; f cos θ / p
    pdf : (N,) float64, 1/sr; p
    delta : (N,) bool; by a delta lobe
    """

    wi: Vec3s
    weight: Vec3s
    pdf: Scalars
    delta: Masks


def behind(step: Step, tail: Paths, onset: Onset) -> Paths:
    """Paths that go from x_(v-1) to x_v, and then as the paths of x_v do.

    Parameters
    ----------
    step : Step; N paths at x_v; ``weight`` is that of the way to it
    tail : Paths; N paths from x_v on, which is the first point of theirs

    Returns
    -------
    Paths
        N paths from x_(v-1) on.  The random numbers of the tail are taken for the next
        ones of the path itself: where they are others, the tail is joined, and not
        replayed.
    """
    size = len(tail)
    there = tail.there
    later = np.where(tail.joint > 0, tail.joint + 1, 0).astype(np.int8)
    grown = replace(
        tail,
        end=np.where(there, tail.end + 1, 0).astype(np.int8),
        joint=np.where(there, later, 0).astype(np.int8),
        value=step.weight * tail.value,
    )
    # The first point that may be joined is the one that is.
    joins = there & step.joinable & ~onset.delta
    if not joins.any():
        return grown
    here = replace(
        grown,
        joint=np.full(size, 2, np.int8),
        surface=step.points,
        wi=onset.wi,
        incoming=divide_or_zero(tail.value, onset.weight),
        density=density_at(step, onset.pdf),
    )
    return where(joins, here, grown)

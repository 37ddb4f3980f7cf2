"""Formulas of shifts of paths, on numbers with error bounds."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Masks
from restir_gi.reference.oracle.replay.bounded import Bounded, Rounding, constant
from restir_gi.reference.oracle.replay.further.numbers import Choice
from restir_gi.reference.oracle.replay.verbs import choose, inner, square_root


def told(array: NDArray[Any], rounding: Rounding) -> Bounded:
    """Numbers of a walk, which were rounded once to be told.

    Parameters
    ----------
    array : (N, ...) array; reals of the case

    Returns
    -------
    Bounded
        Within one `unit`: a backend that walks itself has them unrounded, and is as
        right.
    """
    wide = np.asarray(array).astype(np.float64)
    return Bounded(wide, rounding.unit * np.abs(wide), rounding)


def perceptual(alpha: Bounded) -> Bounded:
    """Perceptual roughness √alpha, (N,).

    Parameters
    ----------
    alpha : Bounded; (N,): GGX width
    """
    return square_root(alpha)


def spread(cosine_times_d: Bounded, squared: Bounded) -> Bounded:
    """Solid angle over area, |cos| / d², (N,).

    Parameters
    ----------
    cosine_times_d, squared : Bounded; (N,): |n · D|, and D · D
    """
    return cosine_times_d / square_root(squared) / squared


def spread_between(
    position: Bounded, joint: Bounded, normal: Bounded
) -> tuple[Bounded, Bounded]:
    """What a spread is calculated from, (N,) each: n · D, D · D.

    Parameters
    ----------
    position, joint, normal : Bounded; (N, 3): x_(c-1), x_c and the normal there
    """
    way = joint - position
    return inner(normal, way), inner(way, way)


def share(mine: Bounded, other: Bounded) -> Bounded:
    """Balance heuristic (N,), 1 where one's own density is 0.

    Parameters
    ----------
    mine, other : Bounded; (N,): densities of both techniques
    """
    none = mine.value == 0
    return choose(none, constant(1.0, mine), mine / (mine + other))


def certainly(mask: Masks) -> Choice:
    """A choice that no rounding touches.

    Parameters
    ----------
    mask : (N,) bool; of flags
    """
    return Choice(mask, np.ones(mask.shape, bool))


def negated(choice: Choice) -> Choice:
    """The opposite."""
    return Choice(~choice.own, choice.certain)


def all_of(*choices: Choice) -> Choice:
    """Yes where all say yes; one certain no is enough."""
    own = np.all([c.own for c in choices], axis=0)
    certain = np.all([c.certain for c in choices], axis=0)
    no = np.any([c.certain & ~c.own for c in choices], axis=0)
    return Choice(own, certain | no)


def where_positive(number: Bounded) -> Choice:
    """Yes where a number is above 0.  An exact 0 is a certain no."""
    return Choice(number.value > 0, number.surely_positive | number.surely_not_positive)

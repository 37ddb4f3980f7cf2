"""Verbs for numbers with error bounds."""

import numpy as np

from restir_gi.reference.numerics.arrays import Masks
from restir_gi.reference.oracle.replay.bounded import Bounded


def square_root(x: Bounded) -> Bounded:
    """Square root of each number; at 0 the error is the root of the error.

    Parameters
    ----------
    x : Bounded; not negative
    """
    value = np.sqrt(np.maximum(x.value, 0.0))
    above = np.sqrt(np.maximum(x.value, 0.0) + x.error)
    below = np.sqrt(np.maximum(x.value - x.error, 0.0))
    error = np.maximum(above - value, value - below)
    return Bounded(value, error + x.rounding.unit * value, x.rounding)


def inner(a: Bounded, b: Bounded) -> Bounded:
    """Inner product of the rows of two arrays of vectors, (N,).

    Parameters
    ----------
    a, b : Bounded; (N, 3) each
    """
    product = a * b
    return product[:, 0] + product[:, 1] + product[:, 2]


def times(a: Bounded, factor: Bounded) -> Bounded:
    """Vectors scaled row by row, (N, 3).

    Parameters
    ----------
    a : Bounded; (N, 3)
    factor : Bounded; (N,)
    """
    return a * factor[:, None]


def choose(mask: Masks, yes: Bounded, no: Bounded) -> Bounded:
    """Choose between two arrays where both sides of the choice are certain.

    Parameters
    ----------
    mask : (N,) bool; take ``yes`` where true
    """
    m = mask.reshape(mask.shape + (1,) * (yes.value.ndim - mask.ndim))
    return Bounded(
        np.where(m, yes.value, no.value),
        np.where(m, yes.error, no.error),
        yes.rounding,
    )


def where_positive(test: Bounded, x: Bounded) -> Bounded:
    """A number where a test is above 0, else 0; both where the test is uncertain.

    Parameters
    ----------
    test : Bounded; (N,)
    x : Bounded; (N,) or (N, 3)

    Returns
    -------
    Bounded; in the uncertain rows the bound covers 0 and x
    """
    shape = test.value.shape + (1,) * (x.value.ndim - test.value.ndim)
    yes = test.surely_positive.reshape(shape)
    no = test.surely_not_positive.reshape(shape)
    positive = (test.value > 0).reshape(shape)
    value = np.where(positive, x.value, 0.0)
    open_error = np.abs(x.value) + x.error
    error = np.where(yes, x.error, np.where(no, 0.0, open_error))
    return Bounded(value, error, x.rounding)

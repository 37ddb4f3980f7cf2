"""Limits on the Jacobian of a shift, which production renderers set."""

import numpy as np

from restir_gi.reference.numerics.arrays import Masks, Scalars


def clamp_jacobian(jacobian: Scalars, limit: float) -> Scalars:
    """Jacobian forced into [1/limit, limit], (N,), sr/sr; 0 stays 0: there is no shift.

    Biased: the weight is then not that of the change of variables.  Bright where J is
    small, dark where it is large.

    Parameters
    ----------
    jacobian : (N,), sr/sr; not negative
    limit : float; at least 1; inf for none, a ``Fraction`` among rationals
    """
    clamped = np.minimum(np.maximum(jacobian, 1 / limit), limit)
    return np.where(jacobian > 0, clamped, jacobian)


def within_limit(jacobian: Scalars, limit: float) -> Masks:
    """Whether max(J, 1/J) is at most the limit.

    It looks at the sample: refusing a shift is biased unless the weights of others
    count its neighbour only where it would not have been refused.

    Parameters
    ----------
    jacobian : (N,), sr/sr; not negative
    limit : float; at least 1; inf for none, a ``Fraction`` among rationals

    Returns
    -------
    (N,) bool
        The same for a shift and for the way back, whose Jacobian is 1/J; false for 0.
    """
    allowed: Masks = (jacobian > 0) & (jacobian <= limit) & (jacobian >= 1 / limit)
    return allowed.astype(bool, copy=False)

"""Equation 11 as the settings would have it: exact, or in one of its wrong forms."""

from dataclasses import dataclass
from math import isfinite

from reference.arrays import Masks, Scalars, Vec3s, divide_or_zero
from reference.resampling.jacobian_limits import clamp_jacobian, within_limit
from reference.resampling.reservoir import Samples
from reference.resampling.shift import reconnection_jacobian
from reference.settings import Settings


@dataclass(frozen=True, slots=True)
class Shift:
    """Reconnection of N samples to other visible points.

    Attributes
    ----------
    factor : (N,) float64 or None, sr/sr
        On their W; ``None`` for 1.
    possible : (N,) bool or None
        Whether the shift is not refused; ``None`` for all.
    """

    factor: Scalars | None
    possible: Masks | None


def shift(settings: Settings, x_from: Vec3s, x_to: Vec3s, y: Samples) -> Shift:
    """Reconnect samples to other visible points.

    Parameters
    ----------
    settings : Settings
        Use of the Jacobian, and its limit.
    x_from, x_to : (N, 3) float64, m
        Visible points that made the samples, and those that reuse them.
    y : Samples
        N samples.

    Returns
    -------
    Shift
        Exact by default.

    Notes
    -----
    [Ouyang21, Eq. 11].  ``jacobian``, ``beyond_limit='clamp'`` and
    ``beyond_limit='reject'`` bias what follows; a rejection that the weights mirror
    (:func:`mirrored`) does not.
    """
    if settings.jacobian == "left-out":
        return Shift(None, None)
    J = reconnection_jacobian(x_from, x_to, y.position, y.normal)
    possible = None
    if isfinite(settings.jacobian_limit):
        if settings.beyond_limit == "clamp":
            J = clamp_jacobian(J, settings.jacobian_limit)
        else:
            possible = within_limit(J, settings.jacobian_limit)
    if settings.jacobian == "divided":
        J = divide_or_zero(J * 0 + 1, J)
    return Shift(J, possible)


def mirrored(
    settings: Settings, x_from: Vec3s, x_to: Vec3s, y: Samples
) -> Masks | None:
    """Whether a donor's shift of a sample would not have been refused.

    Parameters
    ----------
    settings : Settings
        Limit of the Jacobian.
    x_from, x_to : (N, 3) float64, m
        The donor's visible point, and the receiver's.
    y : Samples
        N samples, whoever made them.

    Returns
    -------
    (N,) bool or None
        ``None`` for all.
    """
    if settings.beyond_limit != "reject-mirrored" or not isfinite(
        settings.jacobian_limit
    ):
        return None
    return shift(settings, x_from, x_to, y).possible

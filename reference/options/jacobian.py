"""The Jacobian as some renderers have it: left out, divided by, or limited."""

from collections.abc import Callable
from dataclasses import replace
from math import isfinite

from restir_gi.reference.numerics.arrays import Masks, Scalars, Vec3s, divide_or_zero
from restir_gi.reference.passes.pixels import Pixels, reconnection
from restir_gi.reference.resampling.jacobian_limits import clamp_jacobian, within_limit
from restir_gi.reference.resampling.reservoir import Samples
from restir_gi.reference.settings import Settings


def with_jacobian(q: Pixels) -> Pixels:
    """Pixels q that use the Jacobian as their settings say.

    ``jacobian``, ``beyond_limit='clamp'`` and ``'reject'`` bias what follows; a
    rejection that the weights mirror does not.
    """
    s = q.settings
    mirrors = s.beyond_limit == "reject-mirrored" and s.jacobian != "left-out"
    limited = mirrors and isfinite(s.jacobian_limit)
    return replace(q, shift=shift_of(s), refuses=refusal_of(s) if limited else None)


def shift_of(settings: Settings) -> Callable[[Vec3s, Vec3s, Samples], Scalars]:
    """Jacobian of reconnections, 0 where they are refused, as the settings have it.

    Parameters
    ----------
    settings : Settings; use of the Jacobian, and its limit

    Returns
    -------
    callable
        From x_from, x_to, (K, 3) in m, and samples to (K,) sr/sr; [Ouyang21, Eq. 11].
    """
    use, limit, beyond = (
        settings.jacobian,
        settings.jacobian_limit,
        settings.beyond_limit,
    )

    def shift(x_from: Vec3s, x_to: Vec3s, y: Samples) -> Scalars:
        J = reconnection(x_from, x_to, y)
        if use == "left-out":
            return J * 0 + 1
        if isfinite(limit) and beyond == "clamp":
            J = clamp_jacobian(J, limit)
        factor = divide_or_zero(J * 0 + 1, J) if use == "divided" else J
        if isfinite(limit) and beyond != "clamp":
            factor = factor * within_limit(J, limit)
        return factor

    return shift


def refusal_of(settings: Settings) -> Callable[[Vec3s, Vec3s, Samples], Masks]:
    """Whether reconnections are refused for their Jacobian; arguments as `shift_of`."""

    def refuses(x_from: Vec3s, x_to: Vec3s, y: Samples) -> Masks:
        J = reconnection(x_from, x_to, y)
        return ~within_limit(J, settings.jacobian_limit)

    return refuses

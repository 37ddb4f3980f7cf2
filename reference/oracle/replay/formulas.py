"""The contract's formulas, on numbers with error bounds."""

from dataclasses import dataclass
from math import pi

import numpy as np

from restir_gi.reference.oracle.replay.bounded import Bounded, constant
from restir_gi.reference.oracle.replay.geometry import (
    cosine_at,
    on_both_sides,
)
from restir_gi.reference.oracle.replay.points import ReceiverPoint, SamplePoint
from restir_gi.reference.oracle.replay.surface_rules import (
    CONTRACT_SURFACES,
    SurfaceRules,
)
from restir_gi.reference.oracle.replay.target_rules import TargetRules
from restir_gi.reference.oracle.replay.verbs import (
    choose,
    inner,
    square_root,
    times,
)

target = TargetRules()
"""Target p̂, Equation 9 or 10."""


@dataclass(frozen=True, slots=True)
class Integrand:
    """Integrand f cos θ L_o.

    Attributes
    ----------
    surface : SurfaceRules; f cos θ of declared surfaces
    """

    surface: SurfaceRules = CONTRACT_SURFACES

    def __call__(self, x: ReceiverPoint, y: SamplePoint) -> Bounded:
        """Of Lambertian points albedo / π · cos θ · L_o, (N, 3)."""
        if x.material is not None:
            color = self.surface(x, x.material, y) * y.radiance
        else:
            cosine = cosine_at(x, y)
            color = times(x.albedo * y.radiance, cosine / constant(pi, cosine))
        return on_both_sides(x, y, color)


reflected = Integrand()
"""The contract's."""


def jacobian(x_from: ReceiverPoint, x_to: ReceiverPoint, y: SamplePoint) -> Bounded:
    """Ratio |∂ω_to / ∂ω_from|, Equation 11, (N,).

    Parameters
    ----------
    x_from, x_to : ReceiverPoint; N visible points each; their normals are not used
    """
    v_from, v_to = x_from.position - y.position, x_to.position - y.position
    d_from, d_to = inner(v_from, v_from), inner(v_to, v_to)
    cosine_from = abs(inner(y.normal, v_from)) / square_root(d_from)
    cosine_to = abs(inner(y.normal, v_to)) / square_root(d_to)
    return cosine_to / cosine_from * (d_from / d_to)


def weight(p_hat: Bounded, W: Bounded, M: Bounded, J: Bounded) -> Bounded:
    """Resampling weight w = p̂ W M J of a reservoir, (N,)."""
    return p_hat * W * M * J


def preference(u: Bounded, w_before: Bounded, w: Bounded) -> Bounded:
    """Positive where a candidate is kept: w − u (w_before + w).

    Parameters
    ----------
    u : Bounded; (N,), in [0, 1)
    w_before, w : Bounded; (N,): sum so far, and the candidate's weight

    Returns
    -------
    Bounded
        (N,); w itself where nothing came before.  A share of the sum below the smallest
        number of the type may be lost, as it is where u is held against w / S.
    """
    alone = (w_before.value == 0) & (w_before.error == 0)
    S = w_before + w
    slack = w - u * S
    # What has no weight has nothing to lose.
    some = (w.value > 0) | (w.error > 0)
    lost = np.where(some, slack.rounding.tiny * np.abs(S.value), 0.0)
    return choose(alone, w, Bounded(slack.value, slack.error + lost, slack.rounding))


def fresh_confidence(w: Bounded) -> Bounded:
    """Confidence of a new sample: 1, for nulls too.

    Parameters
    ----------
    w : Bounded; (N,), its weight

    Returns
    -------
    Bounded; (N,)
    """
    return constant(1.0, w)


def capped(M: Bounded, cap: float) -> Bounded:
    """Confidence at most the cap, (N,)."""
    return Bounded(np.minimum(M.value, cap), M.error, M.rounding)


def finalized(w: Bounded, p_hat: Bounded, Z: Bounded) -> Bounded:
    """Contribution weight W = w / (Z p̂), (N,)."""
    return w / p_hat / Z


def merged(a: Bounded, b: Bounded) -> Bounded:
    """Weight, or confidence, of two reservoirs together: the sum.

    Parameters
    ----------
    a, b : Bounded; (N,) each: what came before, and the next

    Returns
    -------
    Bounded; (N,)
    """
    return a + b


def fresh_weight(p_hat: Bounded, pdf: Bounded) -> Bounded:
    """Resampling weight w = p̂ / p of a new sample, (N,)."""
    return p_hat / pdf


def shaded(f: Bounded, W: Bounded) -> Bounded:
    """Estimate f W of the pixel, (N, 3).

    Parameters
    ----------
    f : Bounded; (N, 3)
    W : Bounded; (N,)
    """
    return f * W[:, None]

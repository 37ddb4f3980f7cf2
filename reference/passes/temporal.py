"""Algorithm 3: the new sample meets what the pixel kept from earlier frames."""

from reference.passes.history import History
from reference.passes.initial import InitialSamples
from reference.resampling.mis import one_over_m
from reference.resampling.reservoir import (
    Reservoirs,
    cap_confidence,
    finalize,
    initial_candidates,
    merge,
    reused_candidates,
)
from reference.resampling.target import Target, target
from reference.rng import Uniforms
from reference.scene.surface import SurfacePoints
from reference.world import World


def temporal_pass(
    world: World,
    points: SurfacePoints,
    initial: InitialSamples,
    history: History | None,
    kind: Target,
    cap: float,
    uniforms: Uniforms,
) -> Reservoirs:
    """Resample the new sample together with the temporal reservoir of the last frame.

    Parameters
    ----------
    world : World
        The scene.
    points : SurfacePoints
        N visible points.
    initial : InitialSamples
        One new sample each.
    history : History or None
        Temporal reservoirs of the last frame at the same visible points; ``None``
        after a reset.
    kind : 'scattered' or 'outgoing'
        Target, Equation 9 or 10.
    cap : float
        Limit of M.
    uniforms : Uniforms
        N rows; dimension 0, lane 0 decides.

    Returns
    -------
    Reservoirs
        M at most ``cap``.

    Notes
    -----
    [Ouyang21, Alg. 3].  Both samples come from the same domain, so that 1/M is exact
    here.  The running w of the paper is rebuilt from W and the capped M: kept as it
    is, it would grow without bound.
    """
    # Lines 2 and 4: the new sample with w = p̂ / p.
    p_hat = target(kind, world.materials, points, initial.y)
    new = initial_candidates(initial.y, p_hat, initial.pdf)
    if history is None:
        return cap_confidence(finalize(new, new.M), cap)
    # Line 3: the reservoir of the last frame competes with w = p̂ W M.
    past = history.reservoirs
    old = reused_candidates(past, target(kind, world.materials, points, past.y))
    # Lines 5 and 6.
    both = merge(old, new, uniforms.draw(0)[0])
    return cap_confidence(finalize(both, one_over_m([old.M, new.M])), cap)

"""Algorithm 3: temporal resampling."""

from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.passes.initial import InitialSamples
from restir_gi.reference.resampling.reservoir import (
    Reservoirs,
    cap_confidence,
    finalize,
    initial_candidates,
)
from restir_gi.reference.resampling.reuse import (
    Neighbor,
    PaperMis,
    Receiver,
    begin,
    normalization,
    reused,
)


def temporal_resampling(
    q: Receiver,
    initial: InitialSamples,
    past: Reservoirs | Neighbor,
    u: Scalars,
    *,
    cap: float,
    mis: PaperMis = "1/Z",
) -> Reservoirs:
    """Each pixel's new sample meets the temporal reservoir of the last frame.

    [Ouyang21, Alg. 3].  Line 1 is the loop over rows.  The running sum w of the paper
    is rebuilt from W and the capped M: kept as it is, it would grow without bound.

    Parameters
    ----------
    past : Reservoirs or Neighbor
        Temporal reservoirs of the last frame: q's own, M = 0 after a reset; or, where
        something has moved, those of the pixels that q was then.
    u : (K,); one number in [0, 1) each
    cap : float; limit of M
    mis : '1/M' or '1/Z'
        The same while nothing moves: both samples come from one domain, and M is exact.
    """
    S = initial.y  # line 2
    R = begin(reused(q, past))  # line 3
    new = initial_candidates(S, q.target(S), initial.pdf, initial.M)  # line 4: w = p̂/p
    R = R.then(new, u)  # line 5
    Z = normalization(mis, R, [past, new])  # line 6 has R.M: all, while nothing moves
    return cap_confidence(finalize(R.kept, Z), cap)  # lines 6 and 7

"""Algorithm 4: spatial resampling."""

from collections.abc import Sequence

from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.resampling.reservoir import (
    Reservoirs,
    cap_confidence,
    finalize,
)
from restir_gi.reference.resampling.reuse import (
    Neighbor,
    PaperMis,
    Receiver,
    begin,
    normalization,
    reused,
    shifted,
)


def spatial_resampling(
    q: Receiver,
    past: Reservoirs | Neighbor,
    own: Reservoirs,
    neighbors: Sequence[tuple[Neighbor, Scalars]],
    u_own: Scalars,
    *,
    cap: float,
    mis: PaperMis = "1/Z",
) -> Reservoirs:
    """Each pixel q resamples the temporal reservoirs of pixels near it, K rows.

    [Ouyang21, Alg. 4].  Line 1 is the loop over rows.  Lines 5 to 8, the search for
    neighbours, are :func:`restir_gi.reference.passes.neighbors.find_neighbors`.  The
    printed algorithm leaves out q's own temporal reservoir; without it nobody need
    cover the domain of q.

    Parameters
    ----------
    q : Receiver; K pixels
    past : Reservoirs or Neighbor
        Spatial reservoirs of the last frame: q's own, M = 0 after a reset; or, where
        something has moved, those of the pixels that q was then.
    neighbors : sequence of (Neighbor, (K,))
        Similar pixels near q, and a number in [0, 1) for each, which decides on it.
    u_own : (K,); the number that decides on q's own temporal reservoir
    cap : float; limit of M
    mis : '1/M' or '1/Z'; biased or unbiased
    """
    R_s = begin(reused(q, past))  # line 2
    R_s = R_s.then(reused(q, own), u_own)
    Q: list[Reservoirs | Neighbor] = [past, own]  # line 3
    for q_n, u_n in neighbors:  # lines 4 to 8
        R_s = R_s.then(shifted(q, q_n), u_n)  # lines 9 to 14
        Q.append(q_n)  # line 15
    Z = normalization(mis, R_s, Q)  # lines 16 to 19
    return cap_confidence(finalize(R_s.kept, Z), cap)  # lines 20 and 21

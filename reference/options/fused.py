"""One pass for all reuse: of the pixel's past, and of its neighbours' a frame ago."""

from collections.abc import Sequence

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
    shifted,
)


def fused_resampling(
    q: Receiver,
    initial: InitialSamples,
    past: Reservoirs | Neighbor,
    neighbors: Sequence[tuple[Neighbor, Scalars]],
    u: Scalars,
    *,
    cap: float,
    mis: PaperMis = "1/Z",
) -> Reservoirs:
    """New samples, the pixels' history, and their neighbours' of the last frame.

    Production renderers save a pass, a barrier and a buffer that way.  Neighbours are a
    frame old, but the estimate is not biased for it: each is asked in its own frame
    what it could have made.

    Parameters
    ----------
    q : Receiver; K pixels
    neighbors : sequence of (Neighbor, (K,))
        Pixels of the last frame, and a number in [0, 1) for each.
    u : (K,); the number that decides on the new sample
    cap : float; limit of M
    mis : '1/M' or '1/Z'; biased or unbiased

    Returns
    -------
    Reservoirs; K rows
    """
    S = initial.y
    new = initial_candidates(S, q.target(S), initial.pdf, initial.M)
    R = begin(reused(q, past)).then(new, u)
    for q_n, u_n in neighbors:
        R = R.then(shifted(q, q_n), u_n)
    Z = normalization(mis, R, [past, new, *(q_n for q_n, _ in neighbors)])
    return cap_confidence(finalize(R.kept, Z), cap)


def spatiotemporal_resampling(
    q: Receiver,
    own: Reservoirs,
    sources: Sequence[tuple[Neighbor, Scalars]],
    *,
    cap: float,
    mis: PaperMis = "1/Z",
) -> Reservoirs:
    """The pixels' own reservoirs of this frame, then sources of the last one.

    As RTXDI has it: the history of the pixel is a source like any other.

    Parameters
    ----------
    q : Receiver; K pixels
    sources : sequence of (Neighbor, (K,))
        Pixels of the last frame, and a number in [0, 1) for each.
    cap : float; limit of M
    mis : '1/M' or '1/Z'; biased or unbiased

    Returns
    -------
    Reservoirs; K rows
    """
    R = begin(reused(q, own))
    for q_n, u_n in sources:
        R = R.then(shifted(q, q_n), u_n)
    Z = normalization(mis, R, [own, *(q_n for q_n, _ in sources)])
    return cap_confidence(finalize(R.kept, Z), cap)

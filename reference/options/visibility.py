"""Other uses of visibility: asked of the kept sample alone, of none, or when shown."""

from dataclasses import dataclass, replace

import numpy as np

from restir_gi.reference.frame import FrameContext
from restir_gi.reference.numerics.arrays import Masks
from restir_gi.reference.numerics.records import indices
from restir_gi.reference.options.masks import goes_on
from restir_gi.reference.passes.pixels import History, Pixels, sees
from restir_gi.reference.resampling.reservoir import Reservoirs, Samples
from restir_gi.reference.settings import Settings


@dataclass(frozen=True, slots=True, eq=False)
class TrustingPixels(Pixels):
    """Pixels q that take samples over without looking at them."""

    def sees(self, y: Samples, asked: Masks) -> Masks:
        """All that are asked, (K,): no ray."""
        return asked


def trusting(q: Pixels) -> TrustingPixels:
    """The same pixels, which do not look at samples that they take over."""
    return TrustingPixels(q.world, q.points, q.settings, q.shift, q.refuses)


def without_hidden(q: Pixels, r: Reservoirs) -> Reservoirs:
    """Empty the reservoirs whose sample q does not see: W = 0; M still counts."""
    seen = sees(q.world, q.points, r.y, r.W > 0)
    return replace(r, W=np.where(seen, r.W, r.W * 0))


def finally_seen(
    frame: FrameContext[Settings],
    q: Pixels,
    shown: Reservoirs,
    history: History | None,
    rows: slice,
) -> Masks:
    """Whether K pixels see the samples that they show, (K,) bool.

    With ``final_visibility='reused'`` a sample that the pixel has kept from the last
    frame was looked at then, which is biased while things move.
    """
    full = shown.W > 0
    seen = np.zeros(len(full), bool)
    known = seen
    reuses = frame.settings.final_visibility == "reused"
    if reuses and history is not None and history.seen is not None:
        last = history.of(history.spatial, q, rows)
        past = last if isinstance(last, Reservoirs) else last.reservoirs
        same = (shown.y.position == past.y.position).all(axis=1)
        known = goes_on(history, rows) & same & (past.W > 0)
        then = np.maximum(indices(history.rows(rows)), 0)
        seen = known & history.seen[then]
    return seen | sees(q.world, q.points, shown.y, full & ~known)

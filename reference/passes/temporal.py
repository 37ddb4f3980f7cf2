"""Algorithm 3: the new sample meets what the pixel kept from earlier frames."""

from dataclasses import replace

import numpy as np

from reference.arrays import Masks
from reference.passes.entries import Entry
from reference.passes.history import History, past_entry
from reference.passes.initial import InitialSamples
from reference.passes.receivers import Receivers
from reference.passes.resample import Competition
from reference.resampling.reservoir import initial_candidates
from reference.rng import Uniforms


def temporal_competition(
    receivers: Receivers,
    initial: InitialSamples,
    history: History | None,
    uniforms: Uniforms,
    drawn: Masks | None = None,
) -> Competition:
    """Who takes part in temporal resampling.

    Parameters
    ----------
    receivers : Receivers
        N pixels.
    initial : InitialSamples
        One new sample each.
    history : History or None
        Temporal reservoirs of the last frame; ``None`` after a reset.
    uniforms : Uniforms
        N rows; dimension 0, lane 0 decides.
    drawn : (N,) bool or None
        Whether the pixel has drawn a sample at all; ``None`` for all.

    Returns
    -------
    Competition
        The past, where there is one, and then the new sample; M of what
        :func:`reference.passes.resample.resample` makes of it is at most
        ``settings.temporal_cap``.

    Notes
    -----
    [Ouyang21, Alg. 3].  While nothing moves both samples come from the same domain, so
    that 1/M is exact.  The running w of the paper is rebuilt from W and the capped M:
    kept as it is, it would grow without bound.
    """
    # Line 3: the reservoir of the last frame competes with w = p̂ W M.
    entries = [past_entry(receivers, history, 0)] if history else []
    # Lines 2 and 4: the new sample with w = p̂ / p.
    canonical = len(entries)
    entries.append(new_entry(receivers, initial, canonical, drawn))
    # Lines 5 and 6.
    decisions = [uniforms.draw(0)[0]] * len(entries)
    cap = receivers.settings.temporal_cap
    return Competition(receivers, entries, decisions, canonical, cap)


def new_entry(
    receivers: Receivers, initial: InitialSamples, place: int, drawn: Masks | None
) -> Entry:
    """Entry of the samples that the initial pass has drawn.

    Parameters
    ----------
    receivers : Receivers
        N pixels.
    initial : InitialSamples
        One new sample each.
    place : int
        In the stream.
    drawn : (N,) bool or None
        Whether the pixel has drawn a sample at all; ``None`` for all.

    Returns
    -------
    Entry
        w = p̂ / p, and M = 1 for nulls too; both 0 where nothing was drawn.
    """
    p_hat = receivers.target(initial.y)
    places = np.full(len(p_hat), place, np.uint8)
    new = initial_candidates(places, p_hat, initial.pdf)
    if drawn is not None:
        w, M = np.where(drawn, new.w, 0.0), np.where(drawn, new.M, 0.0)
        new = replace(new, w=w, M=M)
    return Entry(new, initial.y)

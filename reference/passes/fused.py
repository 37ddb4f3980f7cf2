"""One pass for all reuse: the pixel's past, and its neighbours' of the last frame."""

from reference.arrays import Masks
from reference.passes.history import History, past_entry
from reference.passes.initial import InitialSamples
from reference.passes.receivers import Receivers
from reference.passes.resample import Competition
from reference.passes.spatial import OWN, Neighborhood, neighbors
from reference.passes.temporal import new_entry
from reference.rng import Uniforms


def fused_competition(
    receivers: Receivers,
    initial: InitialSamples,
    around: Neighborhood | None,
    history: History | None,
    uniforms: Uniforms,
    drawn: Masks | None = None,
) -> Competition:
    """Who takes part: the new sample, the pixel's history, and its neighbours'.

    Parameters
    ----------
    receivers : Receivers
        K pixels.
    initial : InitialSamples
        One new sample each.
    around : Neighborhood or None
        Neighbours in the last frame; ``None`` for nobody.
    history : History or None
        Reservoirs of the last frame; ``None`` after a reset.
    uniforms : Uniforms
        K rows, as for :func:`reference.passes.spatial.spatial_competitions`; dimension
        63 decides on the new sample.
    drawn : (K,) bool or None
        Whether the pixel has drawn a sample at all; ``None`` for all.

    Returns
    -------
    Competition
        The past, where there is one; the new sample; the neighbours.

    Notes
    -----
    Production renderers save a pass, a barrier and a buffer that way.  Neighbours are a
    frame old, but the estimate is not biased for it: each is asked in its own frame
    what it could have made.
    """
    settings = receivers.settings
    entries = [past_entry(receivers, history, 0)] if history else []
    canonical = len(entries)
    entries.append(new_entry(receivers, initial, canonical, drawn))
    decisions = [uniforms.draw(OWN)[0]] * len(entries)
    if settings.spatial:
        tries, place = settings.iterations_few, len(entries)
        for entry, u in neighbors(receivers, around, uniforms, tries, place):
            entries.append(entry)
            decisions.append(u)
    cap = settings.temporal_cap
    return Competition(receivers, entries, decisions, canonical, cap)

"""Who draws a new sample, and who keeps a reservoir: decided without any sample."""

import numpy as np

from restir_gi.reference.frame import FrameContext
from restir_gi.reference.numerics.arrays import Masks
from restir_gi.reference.numerics.records import NONE, indices
from restir_gi.reference.options.checkerboard import draws_new_sample
from restir_gi.reference.options.reduced_resolution import keeps_reservoir
from restir_gi.reference.options.validation import validates
from restir_gi.reference.passes.pixels import History
from restir_gi.reference.settings import Settings


def goes_on(history: History, rows: slice) -> Masks:
    """Whether K pixels go on from the last frame, (K,) bool."""
    found: Masks = indices(history.rows(rows)) != NONE
    return found


def who_keeps(frame: FrameContext[Settings], rows: slice) -> Masks | None:
    """Who keeps reservoirs, (K,) bool; ``None`` for everyone."""
    side, width = frame.settings.lattice, frame.world.camera.width
    if side == 1:
        return None
    return keeps_reservoir(np.arange(rows.start, rows.stop), width, side)


def who_draws(
    frame: FrameContext[Settings], history: History | None, rows: slice
) -> Masks | None:
    """Who draws a new sample, (K,) bool; ``None`` for everyone."""
    able, drawn = who_keeps(frame, rows), None
    if history and validates(frame):
        # The rays of this frame go into old samples, where there are.
        drawn = ~goes_on(history, rows)
    elif history and frame.settings.checkerboard:
        pixel, width = np.arange(rows.start, rows.stop), frame.world.camera.width
        past = goes_on(history, rows)
        drawn = draws_new_sample(pixel, width, frame.number, past)
    if able is None or drawn is None:
        return able if drawn is None else drawn
    return drawn & able

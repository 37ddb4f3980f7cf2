"""What Figures 6, 9 and 10 of [Wang25] measure, and the method does not do.

Reservoirs that reuse samples of the other sign as well, and neighbours that are any
pairs around.  Reservoirs of both signs in one are Equation 19.
"""

from dataclasses import replace

import numpy as np

from restir_gi.extensions.area_restir import Window
from restir_gi.gradient_domain.pairs import Pairs, draw_around
from restir_gi.gradient_domain.settings import GradientSettings, Signs
from restir_gi.reference.frame import FrameContext
from restir_gi.reference.numerics.arrays import Indices
from restir_gi.reference.numerics.rng import Stream


def reused_signs(signs: Signs, sign: int) -> tuple[int, ...]:
    """Signs of the other pairs' reservoirs that one of a sign reuses, its own first."""
    return (sign, -sign) if signs == "across" else (sign,)


def reused_windows(
    signs: Signs, sign: int, windows: list[Window], same_domain: bool
) -> list[tuple[int, Window]]:
    """Signs and windows of the last frame's reservoirs that one of a sign reuses."""
    found = [(sign, window) for window in windows]
    # Where nothing has moved, samples of the other sign have that sign here as well.
    if signs == "across" and not same_domain:
        # It is one past, however many reservoirs know of it.
        found += [(-sign, replace(w, share=0.0 * w.share)) for w in windows]
    return found


def random_neighbors(frame: FrameContext[GradientSettings], pairs: Pairs) -> Indices:
    """For each pair any other around, or ``NONE``, (P,) int."""
    every = slice(0, len(pairs))
    u = frame.uniforms(Stream.SEARCH, every).draw(0)[0]
    return draw_around(frame, pairs, np.arange(len(pairs)), u)

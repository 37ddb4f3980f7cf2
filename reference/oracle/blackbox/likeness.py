"""Which other convention a renderer's pictures agree with, where they are wrong.

Either the pictures are changed as a renderer may have changed them, and held against
the same truth; or they are held against the truth of another convention.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtr

from restir_gi.reference.images.image import luminance
from restir_gi.reference.oracle.blackbox.convention import Convention
from restir_gi.reference.oracle.blackbox.evidence import ROUNDING
from restir_gi.reference.oracle.blackbox.tiles import TILES
from restir_gi.reference.oracle.blackbox.truth import Truth

# (n, PLACES, 3) float64; of each picture and its tiles, in each channel.
Means = NDArray[np.float64]

DOUBTFUL = 0.01
"""Probability that the convention a renderer follows is not named."""

NEAR = 0.25
"""Share of the means that disagree with the truth that was asked for: where no more of
them disagree with another one, it is named as near."""

FACTORS = {
    "pi": np.pi,
    "1/pi": 1 / np.pi,
    "2": 2.0,
    "1/2": 0.5,
    "4": 4.0,
    "1/4": 0.25,
    "2 pi": 2 * np.pi,
    "4 pi": 4 * np.pi,
}


@dataclass(frozen=True, slots=True)
class Likeness:
    """A convention with which pictures agree.

    Attributes
    ----------
    text : str; what the pictures are, in words
    agree, means : int; means of tiles and channels that agree, of how many
    deviation : float; of the worst of them, in standard errors
    """

    text: str
    agree: int
    means: int
    deviation: float

    @property
    def sentence(self) -> str:
        """What is said of it."""
        if self.agree == self.means:
            return f"they agree with {self.text}"
        share = f"{self.agree} of {self.means} means of tiles and channels"
        return f"they nearly agree with {self.text}: in {share}"


def likenesses(
    linear: Means, decoded: Means, truth: Truth, others: Iterable[tuple[str, Truth]]
) -> list[Likeness]:
    """Conventions with which pictures agree, the likeliest first.

    Parameters
    ----------
    linear : (n, PLACES, 3) float64; means of the pictures as they are
    decoded : (n, PLACES, 3) float64; of the pictures decoded from sRGB
    truth : Truth; of the convention that was asked for
    others : iterable of (str, Truth); of other conventions, in words

    Returns
    -------
    list of Likeness
        Those that agree in all means, or else the nearest, if it is near; none where
        the errors are so large that the truth asked for agrees as well.
    """
    found = [_likeness(*one) for one in _changed(linear, decoded, truth)]
    found += [_likeness(text, linear, *other.channels) for text, other in others]
    asked = _likeness("", linear, *truth.channels)
    if asked.agree == asked.means:  # these means accuse nothing, and so explain nothing
        return []
    whole = [one for one in found if one.agree == one.means]
    most = NEAR * (asked.means - asked.agree)
    near = [one for one in found if one.means - one.agree <= most]
    whole.sort(key=lambda one: one.deviation)
    return whole or sorted(near, key=lambda one: -one.agree)[:1]


def _likeness(text: str, means: Means, mean: Means, error: Means) -> Likeness:
    n = len(means)
    own = means.std(axis=0, ddof=1) / np.sqrt(n)
    beyond = np.abs(means.mean(axis=0) - mean) - ROUNDING * mean
    both = np.hypot(own, error)
    never = np.where(beyond > 0, np.inf, 0.0)
    z = np.divide(np.maximum(beyond, 0.0), both, out=never, where=both > 0)
    agree = 2 * stdtr(n - 1, -z) >= DOUBTFUL / z.size
    return Likeness(text, int(agree.sum()), z.size, float(z.max()))


Compared = tuple[str, NDArray[Any], NDArray[Any], NDArray[Any]]


def _changed(linear: Means, decoded: Means, truth: Truth) -> Iterator[Compared]:
    """Pictures from which a change was taken back; of luminance, the truth changed."""
    mean, error = truth.channels
    yield "the truth encoded as sRGB", decoded, mean, error
    for name, factor in FACTORS.items():
        yield f"the truth times {name}", linear / factor, mean, error
    factor = float(linear[:, 0].mean() / mean[0].mean()) if mean[0].any() else 0.0
    if factor > 0 and not any(abs(factor / f - 1) < 0.02 for f in FACTORS.values()):
        yield f"the truth times {factor:.3g}, throughout", linear / factor, mean, error
    for name, flipped in _FLIPS.items():
        places = np.concatenate([[0], 1 + flipped(_TILES).ravel()])
        yield f"the truth {name}", linear[:, places], mean, error
    yield "the truth with red and blue exchanged", linear[..., ::-1], mean, error
    # Errors of channels that share their paths add up at most.
    shape = mean.shape
    grey, most = (np.broadcast_to(luminance(a)[:, None], shape) for a in (mean, error))
    yield "the truth's luminance in all channels", linear, grey, most


_TILES = np.arange(TILES**2).reshape(TILES, TILES)

_FLIPS: dict[str, Callable[[NDArray[np.int64]], NDArray[np.int64]]] = {
    "upside down": lambda tiles: tiles[::-1],
    "with left and right exchanged": lambda tiles: tiles[:, ::-1],
    "turned by half": lambda tiles: tiles[::-1, ::-1],
}


def conventions(asked: Convention) -> dict[str, Convention]:
    """Other conventions, by what is said of them."""
    return {f"{one.words} ({one.options})": one for one in asked.others()}

"""Numbers that stand in for luminance."""

import numpy as np

from restir_gi.reference.oracle.replay.bounded import Bounded
from restir_gi.reference.oracle.replay.geometry import sum_of_shares


def rec_601(color: Bounded) -> Bounded:
    """0.299 R + 0.587 G + 0.114 B, of another standard, (N,).

    Parameters
    ----------
    color : Bounded; (N, 3)
    """
    return sum_of_shares(color, (0.299, 0.587, 0.114))


def mean_of_channels(color: Bounded) -> Bounded:
    """(R + G + B) / 3, (N,).

    Parameters
    ----------
    color : Bounded; (N, 3)
    """
    return sum_of_shares(color, (1 / 3, 1 / 3, 1 / 3))


def sum_of_channels(color: Bounded) -> Bounded:
    """R + G + B, (N,).

    Parameters
    ----------
    color : Bounded; (N, 3)
    """
    return color[:, 0] + color[:, 1] + color[:, 2]


def red_channel(color: Bounded) -> Bounded:
    """R, (N,).

    Parameters
    ----------
    color : Bounded; (N, 3)
    """
    return color[:, 0]


def largest_channel(color: Bounded) -> Bounded:
    """max(R, G, B).

    Parameters
    ----------
    color : Bounded; (N, 3)

    Returns
    -------
    Bounded; (N,)
    """
    most = color.value.argmax(axis=1)
    return color[np.arange(len(most)), most]

"""The contract's source densities, on numbers with error bounds."""

from math import pi

from restir_gi.reference.oracle.contract.fields import Value
from restir_gi.reference.oracle.replay.bounded import Bounded, constant
from restir_gi.reference.oracle.replay.verbs import square_root


def drawn_cosine(source: Value, u: Bounded) -> Bounded:
    """Cosine with the normal of a direction that is drawn, (N,).

    Parameters
    ----------
    u : Bounded; (N,), the first random number
    """
    return u if source == "uniform" else square_root(constant(1.0, u) - u)


def density(source: Value, cosine: Bounded) -> Bounded:
    """Source density of a direction, (N,).

    Parameters
    ----------
    cosine : Bounded; (N,), with the normal
    """
    if source == "uniform":
        return constant(1 / (2 * pi), cosine)
    return cosine / constant(pi, cosine)

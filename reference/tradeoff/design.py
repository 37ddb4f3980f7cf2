"""Which operating points are measured."""

from collections.abc import Iterable, Sequence

from scipy.stats.qmc import LatinHypercube

from reference.methods import method_named, method_names
from reference.tradeoff.knobs import Knob
from reference.tradeoff.points import Point

SEVERAL = "several"
"""Name of all knobs together."""


def one_at_a_time(base: Point, knobs: Iterable[Knob]) -> list[Point]:
    """Points that differ from the base in one knob.

    Parameters
    ----------
    base : Point
        Where all begins.
    knobs : iterable of Knob
        Turned one after the other.

    Returns
    -------
    list of Point
        All levels of all knobs; one of a knob may be as the base is.
    """
    return [
        Point(base.method, (*base.values, *values), knob.name, label)
        for knob in knobs
        for label, values in knob.levels
    ]


def at_random(base: Point, knobs: Sequence[Knob], count: int, seed: int) -> list[Point]:
    """Points that differ from the base in all knobs.

    Parameters
    ----------
    base : Point
        Where all begins.
    knobs : sequence of Knob
        Each turned to one of its levels, over all points evenly.
    count : int
        Points.
    seed : int
        Decides which levels meet.

    Returns
    -------
    list of Point
        A Latin hypercube: [McKay79].
    """
    if not knobs:
        return []
    cube = LatinHypercube(len(knobs), rng=seed).random(count)
    places = (cube * [len(knob.levels) for knob in knobs]).astype(int)
    turned = [
        tuple(v for knob, i in zip(knobs, row, strict=True) for v in knob.levels[i][1])
        for row in places
    ]
    return [
        Point(base.method, (*base.values, *values), SEVERAL, f"no. {number}")
        for number, values in enumerate(turned, 1)
    ]


def methods_beside(base: Point) -> list[Point]:
    """Other methods, as they are by default.

    Parameters
    ----------
    base : Point
        Whose method is left out.

    Returns
    -------
    list of Point
        All that make frames one by one.
    """
    return [
        Point(name, (), "method", name)
        for name in method_names()
        if name != base.method and method_named(name).frames is not None
    ]

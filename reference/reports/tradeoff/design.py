"""Which operating points are measured."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import chain

from scipy.stats.qmc import LatinHypercube

from restir_gi.reference.methods import method_named, method_names
from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.reports.tradeoff.knobs import Knob
from restir_gi.reference.reports.tradeoff.points import Design, can_run
from restir_gi.reference.system.errors import UsageError

SEVERAL = "several"
"""Name of all knobs together."""

MOST_DRAWS = 1000
"""Of cubes: levels of which one row in a hundred can run fill a design of 16."""


def one_at_a_time(base: Design, knobs: Iterable[Knob]) -> list[Design]:
    """Points that differ from the base in one knob.

    All levels of all knobs; one of a knob may be as the base is.

    Parameters
    ----------
    knobs : iterable of Knob; turned one after the other
    """
    return [
        Design(base.method, (*base.values, *values), knob.name, label)
        for knob in knobs
        for label, values in knob.levels
    ]


def at_random(
    base: Design, knobs: Sequence[Knob], count: int, seed: int
) -> list[Design]:
    """Points that differ from the base in all knobs.

    A Latin hypercube: [McKay79].  Levels that cannot go together, such as a coarse
    lattice without spatial reuse, are drawn again.

    Raises UsageError: hardly any go together.

    Parameters
    ----------
    knobs : sequence of Knob; each turned to one of its levels, over all points evenly
    """
    if not knobs:
        return []
    cube = LatinHypercube(len(knobs), rng=seed)
    found: list[Design] = []
    for _ in range(MOST_DRAWS):
        for values in _turned(knobs, cube.random(count - len(found))):
            label = f"no. {len(found) + 1}"
            point = Design(base.method, (*base.values, *values), SEVERAL, label)
            if can_run(point):
                found.append(point)
        if len(found) == count:
            return found
    names = ", ".join(knob.name for knob in knobs)
    raise UsageError(
        f"few levels of {names} can be combined; leave some out, or use --design 0"
    )


def _turned(knobs: Sequence[Knob], cube: Scalars) -> Iterator[tuple[str, ...]]:
    """Settings of each row of a cube of numbers from 0 to 1."""
    places = (cube * [len(knob.levels) for knob in knobs]).astype(int)
    for row in places:
        levels = [knob.levels[i][1] for knob, i in zip(knobs, row, strict=True)]
        yield tuple(chain.from_iterable(levels))


def methods_beside(base: Design) -> list[Design]:
    """Other methods, as they are by default.  All that make frames one by one."""
    return [
        Design(name, (), "method", name)
        for name in method_names()
        if name != base.method and method_named(name).frames is not None
    ]

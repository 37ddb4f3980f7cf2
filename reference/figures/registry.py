"""The figures by name."""

from collections.abc import Callable
from dataclasses import dataclass
from difflib import get_close_matches

from reference.errors import UsageError
from reference.figures import (
    bias,
    bounces,
    equal_time,
    jacobian,
    source,
    validation,
)
from reference.figures.record import PaperFigure, Plan


@dataclass(frozen=True, slots=True)
class Entry:
    """A figure that can be asked for.

    Attributes
    ----------
    name : str
        As on the command line.
    make : callable
        Runs and draws it.
    runs : int
        By default.
    numbers : tuple of str
        In the paper; each is as good as the name.
    least_runs : int
        With which its errors can be told.
    """

    name: str
    make: Callable[[Plan], PaperFigure]
    runs: int
    numbers: tuple[str, ...]
    least_runs: int = 2


_ENTRIES = (
    Entry(equal_time.NAME, equal_time.equal_time, 32, ("1", "13")),
    Entry(jacobian.NAME, jacobian.jacobian, 16, ("7",)),
    Entry(bounces.NAME, bounces.bounces, 8, ("8",)),
    Entry(bias.NAME, bias.bias, 16, ("9",), 4),
    Entry(validation.NAME, validation.validation, 8, ("11",)),
    Entry(source.NAME, source.source, 32, ("14",)),
)

FIGURES: dict[str, Entry] = {entry.name: entry for entry in _ENTRIES}
"""All figures, by name, in the order in which they are made."""


def find_figure(name: str) -> Entry:
    """Figure of a name.

    Parameters
    ----------
    name : str
        As in the registry, or its number in the paper.

    Returns
    -------
    Entry
        Not made yet.

    Raises
    ------
    UsageError
        No figure has that name; the message says which do, the closest one first.
    """
    if name in FIGURES:
        return FIGURES[name]
    for entry in _ENTRIES:
        if name in entry.numbers:
            return entry
    close = get_close_matches(name, FIGURES, n=1)
    hint = f"did you mean {close[0]}? " if close else ""
    every = ", ".join(f"{e.name} ({', '.join(e.numbers)})" for e in _ENTRIES)
    raise UsageError(f"there is no figure {name!r}; {hint}the figures are {every}")

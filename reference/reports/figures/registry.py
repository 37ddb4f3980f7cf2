"""The figures by name: those of the ReSTIR GI paper, and those of plug-ins."""

from collections.abc import Callable
from dataclasses import dataclass

from docs.figures import (
    bias,
    bounces,
    equal_time,
    extremes,
    jacobian,
    kernels,
    source,
    validation,
)
from reference.reports.figures.record import PaperFigure, Work
from reference.system.errors import UsageError
from reference.system.plugins import find_plugin, plugin_names
from reference.system.suggestions import unknown


@dataclass(frozen=True, slots=True)
class FigureEntry:
    """A figure that can be asked for.

    Attributes
    ----------
    make : callable; runs and draws it
    numbers : tuple of str; in the paper; each is as good as the name
    least_runs : int; with which its errors can be told
    """

    name: str
    make: Callable[[Work], PaperFigure]
    runs: int
    numbers: tuple[str, ...]
    least_runs: int = 2


_ENTRIES = (
    FigureEntry(equal_time.NAME, equal_time.equal_time, 32, ("1", "13")),
    FigureEntry(jacobian.NAME, jacobian.jacobian, 16, ("7",)),
    FigureEntry(bounces.NAME, bounces.bounces, 8, ("8",)),
    FigureEntry(bias.NAME, bias.bias, 16, ("9",), 4),
    FigureEntry(validation.NAME, validation.validation, 8, ("11",)),
    FigureEntry(source.NAME, source.source, 32, ("14",)),
    FigureEntry(extremes.NAME, extremes.extremes, 32, ()),
    FigureEntry(kernels.NAME, kernels.kernels_at_extremes, 64, ()),
)

GROUP = "restir.figures"

FIGURES: dict[str, FigureEntry] = {entry.name: entry for entry in _ENTRIES}
"""The paper's, by name, in the order in which they are made."""


def figure_names() -> list[str]:
    """Names of all figures.  The paper's first.  Nothing is imported."""
    theirs = [name for name in plugin_names(GROUP) if name not in FIGURES]
    return [*FIGURES, *theirs]


def find_figure(name: str) -> FigureEntry:
    """Figure of a name.  Not made yet.

    Raises UsageError: no figure has that name; the message says which do, the closest
    one first.  Or the package that brings it is broken.

    Parameters
    ----------
    name : str; as `figure_names` lists it, or its number in the paper
    """
    if name in FIGURES:
        return FIGURES[name]
    for entry in _ENTRIES:
        if name in entry.numbers:
            return entry
    found = find_plugin(GROUP, name, FigureEntry, "figure")
    if found is not None:
        return found
    names = figure_names()
    numbers = {e.name: f" ({', '.join(e.numbers)})" for e in _ENTRIES}
    every = ", ".join(each + numbers.get(each, "") for each in names)
    raise UsageError(unknown("figure", name, names, every))

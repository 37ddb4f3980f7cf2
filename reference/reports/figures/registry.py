"""The figures by name, as packages register them, and by their numbers in the paper."""

from collections.abc import Callable
from dataclasses import dataclass

from restir_gi.reference.reports.figures.record import PaperFigure, Work
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.plugins import find_plugin, plugin_names
from restir_gi.reference.system.suggestions import unknown

GROUP = "restir.figures"

NUMBERS = {
    "1": "equal-time",
    "7": "jacobian",
    "8": "bounces",
    "9": "bias",
    "11": "validation",
    "13": "equal-time",
    "14": "source",
}
"""Figures of the ReSTIR GI paper: each number is as good as the name."""


@dataclass(frozen=True, slots=True)
class FigureEntry:
    """A figure that can be asked for.

    Attributes
    ----------
    make : callable; runs and draws it
    least_runs : int; with which its errors can be told
    """

    name: str
    make: Callable[[Work], PaperFigure]
    runs: int
    least_runs: int = 2


def figure_names() -> list[str]:
    """Names of all figures: the paper's first, in its order.  Nothing is imported."""
    names = plugin_names(GROUP)
    paper = [name for name in dict.fromkeys(NUMBERS.values()) if name in names]
    return paper + [name for name in names if name not in paper]


def find_figure(name: str) -> FigureEntry:
    """Figure of a name.  Not made yet.

    Raises UsageError: no figure has that name; the message says which do, the closest
    one first.  Or the package that brings it is broken.

    Parameters
    ----------
    name : str; as `figure_names` lists it, or its number in the paper
    """
    found = find_plugin(GROUP, NUMBERS.get(name, name), FigureEntry, "figure")
    if found is not None:
        return found
    names = figure_names()
    every = ", ".join(each + _numbers(each) for each in names)
    raise UsageError(unknown("figure", name, names, every))


def _numbers(name: str) -> str:
    numbers = [number for number, each in NUMBERS.items() if each == name]
    return f" ({', '.join(numbers)})" if numbers else ""

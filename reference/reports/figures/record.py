"""What makes a figure, and what a figure is: a picture and the numbers beside it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from io import BytesIO
from typing import TYPE_CHECKING

import numpy as np

from restir_gi.reference.images.display import Bytes
from restir_gi.reference.numerics.intervals import Interval
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.reports.figures.canvas import png_of

if TYPE_CHECKING:  # matplotlib takes half a second to load
    from matplotlib.figure import Figure


@dataclass(frozen=True, slots=True)
class Work:
    """How much is spent on a figure.

    Attributes
    ----------
    size : int, pixels; width and height of each picture, at least 16
    runs : int; runs of each method, with different seeds; at least 2
    tick : callable; told how much is done, of how much, and its unit
    """

    size: int
    runs: int
    schedule: Schedule
    tick: Callable[[int, int, str], None] = lambda done, total, unit: None


@dataclass(frozen=True, slots=True)
class Deviation:
    """A relative deviation from the truth, with its standard error.

    Attributes
    ----------
    value : float; share of the truth, 0 for none
    error : float; standard error of it
    """

    value: float
    error: float


Cell = str | int | float | Interval | Deviation
Row = Mapping[str, Cell]


@dataclass(frozen=True, slots=True, eq=False)
class PaperFigure:
    """A figure of the paper, made again.

    Attributes
    ----------
    title : str; what it shows, and its number in the paper
    picture : matplotlib.figure.Figure; known to no window and to no global state
    rows : tuple of mapping of str to Cell; the numbers; all rows have the same columns
    remarks : tuple of str; how the numbers came about, and the paper's own
    """

    name: str
    title: str
    picture: "Figure"
    rows: tuple[Row, ...]
    remarks: tuple[str, ...]

    def pixels(self) -> Bytes:
        """Drawn (H, W, 3) uint8, for notebooks and galleries."""
        from PIL import Image

        return np.asarray(Image.open(BytesIO(self.png())).convert("RGB"))

    def png(self) -> bytes:
        """Contents of a PNG file."""
        return png_of(self.picture)

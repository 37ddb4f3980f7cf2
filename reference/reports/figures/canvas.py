"""How figures look: pictures in a grid, each with its caption, and plain axes."""

from collections.abc import Sequence
from dataclasses import dataclass
from io import BytesIO
from typing import TYPE_CHECKING

from restir_gi.reference.images.display import Bytes, auto_exposure, to_display
from restir_gi.reference.images.image import Floats, to_image

if TYPE_CHECKING:  # matplotlib takes half a second to load
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

INK, QUIET = "#1c1f23", "#6b7178"
COLORS = ("#0b6e99", "#c8553d", "#5a8a3a", "#8d6cab", "#b58900")
"""Of lines; the first is the unbiased form throughout."""

SIDE, BIG = 2.3, 3.0  # inches of a picture among many, and among few
PAD = 0.06  # inches around each
DPI = 144


@dataclass(frozen=True, slots=True, eq=False)
class Tile:
    """A picture of a grid.

    Attributes
    ----------
    pixels : (H, W, 3) uint8; as a screen takes them
    title, caption : str; above and below
    """

    pixels: Bytes
    title: str = ""
    caption: str = ""


def shown(rows: Floats, size: int, exposure: float) -> Bytes:
    """Frame as a screen takes it.

    Parameters
    ----------
    rows : (size · size, 3) float; linear radiance

    Returns
    -------
    (size, size, 3) uint8; see :func:`restir_gi.reference.images.display.to_display`
    """
    return to_display(to_image(rows, size, size), exposure)


def exposure_of(rows: Floats, size: int) -> float:
    """Exposure that suits a frame.

    Parameters
    ----------
    rows : (size · size, 3) float; linear radiance
    """
    return auto_exposure(to_image(rows, size, size))


def blank(width: float, height: float) -> "Figure":
    """Empty figure that no window and no global state knows.

    Its parts find room for their labels by themselves.
    """
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    engine = ConstrainedLayoutEngine(w_pad=PAD, h_pad=PAD)
    return Figure(figsize=(width, height), dpi=DPI, layout=engine)


def png_of(picture: "Figure") -> bytes:
    """Contents of a PNG file."""
    buffer = BytesIO()
    picture.savefig(buffer, format="png")
    return buffer.getvalue()


def split(
    picture: "Figure", rows: int, columns: int, shares: Sequence[float]
) -> list["SubFigure"]:
    """Parts of a figure, from left to right or from top to bottom.

    Parameters
    ----------
    rows, columns : int; of parts; one of the two is 1
    shares : sequence of float; of the height or the width, one a part
    """
    heights, widths = (shares, None) if columns == 1 else (None, shares)
    parts = picture.subfigures(
        rows, columns, squeeze=False, height_ratios=heights, width_ratios=widths
    )
    return list(parts.flat)


def draw_tiles(
    area: "Figure | SubFigure",
    grid: Sequence[Sequence[Tile]],
    names: Sequence[str] = (),
) -> None:
    """Draw pictures in rows and columns.

    Parameters
    ----------
    names : sequence of str; of the rows, at their left; may be left out
    """
    axes = area.subplots(len(grid), len(grid[0]), squeeze=False)
    for places, tiles in zip(axes, grid, strict=True):
        for place, tile in zip(places, tiles, strict=True):
            place.imshow(tile.pixels, interpolation="nearest")
            place.set(xticks=[], yticks=[])
            place.set_title(tile.title, fontsize=9, color=INK)
            place.set_xlabel(tile.caption, fontsize=8, color=QUIET)
            for spine in place.spines.values():
                spine.set_visible(False)
    for places, name in zip(axes, names, strict=False):
        places[0].set_ylabel(name, fontsize=9, color=INK)


def tidy(axes: "Axes", title: str, x: str, y: str) -> None:
    """Label axes, and take away what says nothing.

    Parameters
    ----------
    title, x, y : str; above, below and at the left
    """
    axes.set_title(title, fontsize=9, color=INK)
    axes.set_xlabel(x, fontsize=8, color=INK)
    axes.set_ylabel(y, fontsize=8, color=INK)
    axes.tick_params(labelsize=8, colors=INK)
    axes.grid(True, color="#d9dcdf", linewidth=0.6)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)

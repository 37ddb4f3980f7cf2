"""Mean luminance of the texels around rectangles of a texture."""

from dataclasses import dataclass

import numpy as np

from restir_gi.reference.images.image import luminance_weights
from restir_gi.reference.numerics.arrays import Indices, Scalars, Vec3s
from restir_gi.reference.scene.textures import Bitmap, Pattern, Wrap

LEAST_SHARE = 1e-3
"""Least weight of a cell that emits, in means of its texture.

Rounding in the sums over texels, 2⁻⁵³ of their total, then never hides a cell.
"""

SLACK = 2.0**-10
"""Texels by which rectangles are widened, against rounding of texture coordinates."""


def texels(texture: Pattern) -> Vec3s:
    """Texels of a pattern.

    Returns (h, w, 3) float64; row 0 is the top; a checker has two rows of two.
    """
    if isinstance(texture, Bitmap):
        return texture.pixels
    a, b = texture.color0, texture.color1
    return np.array([[b, a], [a, b]])


@dataclass(frozen=True, slots=True, eq=False)
class TexelSums:
    """A texture made ready for means over rectangles.

    Attributes
    ----------
    sums : (h + 1, w + 1) float64
        Sums of the luminance of texels over all rows and columns before.
    lit : (h + 1, w + 1) int64; as many of these texels are above 0 in any channel
    scale : (float, float); repetitions along u and v
    wrap : (Wrap, Wrap); how the texture goes on beyond the unit square along u and v
    reach : float; texels by which a rectangle is widened: what interpolation blends in
    least : float; least mean around a rectangle that any light reaches into
    """

    sums: Scalars
    lit: Indices
    scale: tuple[float, float]
    wrap: tuple[Wrap, Wrap]
    reach: float
    least: float

    @staticmethod
    def of(texture: Pattern) -> "TexelSums":
        """Sum up a texture."""
        pixels = texels(texture)
        luminance = pixels @ np.array(luminance_weights())
        lit = (pixels > 0).any(axis=2).astype(np.int64)
        smooth = isinstance(texture, Bitmap) and texture.filter == "bilinear"
        return TexelSums(
            sums=np.pad(luminance, ((1, 0), (1, 0))).cumsum(axis=0).cumsum(axis=1),
            lit=np.pad(lit, ((1, 0), (1, 0))).cumsum(axis=0).cumsum(axis=1),
            scale=texture.scale,
            wrap=getattr(texture, "wrap", ("repeat", "repeat")),
            reach=(0.5 if smooth else 0.0) + SLACK,
            least=LEAST_SHARE * float(luminance.mean()),
        )

    def around(self, low: Scalars, high: Scalars) -> Scalars:
        """Mean luminance of the texels that reach into rectangles.

        Parameters
        ----------
        low, high : (N, 2) float64; corners in (u, v)

        Returns
        -------
        (N,) float64; positive wherever the texture is above 0 anywhere in the rectangle
        """
        height, width = self.sums.shape[0] - 1, self.sums.shape[1] - 1
        (u0, v0), (u1, v1) = low.T, high.T
        across, up = self.scale
        left, right = u0 * across * width, u1 * across * width
        top, bottom = (1.0 - v1 * up) * height, (1.0 - v0 * up) * height
        columns = _texels(left, right, self.reach, width, self.wrap[0])
        rows = _texels(top, bottom, self.reach, height, self.wrap[1])
        lit = _box_sums(self.lit, rows, columns)
        mean = _box_sums(self.sums, rows, columns) / (rows[1] * columns[1])
        return np.where(lit > 0, np.maximum(mean, self.least), 0.0)


def _texels(
    a: Scalars, b: Scalars, reach: float, count: int, wrap: Wrap
) -> tuple[Indices, Indices]:
    """First texel of those that an interval shows, and how many follow, going round."""
    first, last = np.floor(np.minimum(a, b) - reach), np.floor(np.maximum(a, b) + reach)
    many = np.minimum(last - first + 1.0, count)
    if wrap == "clamp":
        first, last = np.clip(first, 0, count - 1), np.clip(last, 0, count - 1)
        many = last - first + 1.0
    elif wrap == "repeat":
        first = np.mod(first, count)
    else:
        # There and back: an interval with a turn in it shows all of them, at most.
        turns = np.floor(first / count) != np.floor(last / count)
        ends = [np.mod(end, 2 * count) for end in (first, last)]
        ends = [np.minimum(end, 2 * count - 1 - end) for end in ends]
        first = np.where(turns, 0, np.minimum(*ends))
        many = np.where(turns, count, np.maximum(*ends) - first + 1.0)
    return first.astype(np.int64), many.astype(np.int64)


def _box_sums(
    sums: Scalars,
    rows: tuple[Indices, Indices],
    columns: tuple[Indices, Indices],
) -> Scalars:
    """Sums over boxes of a texture that repeats, from its running sums."""
    total = np.zeros(len(rows[0]))
    for top, bottom in _unwrapped(*rows, sums.shape[0] - 1):
        for left, right in _unwrapped(*columns, sums.shape[1] - 1):
            total = total + (sums[bottom, right] - sums[top, right])
            total = total - (sums[bottom, left] - sums[top, left])
    return total


def _unwrapped(
    first: Indices, count: Indices, period: int
) -> tuple[tuple[Indices, Indices], tuple[Indices, Indices]]:
    """The part up to the edge of the texture, and the part that starts over."""
    end = first + count
    beyond = np.maximum(end - period, 0)
    return (first, np.minimum(end, period)), (np.zeros_like(beyond), beyond)

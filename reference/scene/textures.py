"""Colours that vary over a surface: a bitmap, a checker, or one colour."""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from reference.arrays import Scalars, Vec3s

Color = tuple[float, float, float]


@dataclass(frozen=True, slots=True, eq=False)
class Bitmap:
    """Colours on a grid, repeated beyond the unit square.

    Attributes
    ----------
    pixels : (h, w, 3) float64
        Linear Rec. 709, of reflectance or of radiance; row 0 is the top, v = 1.
    filter : 'bilinear' or 'nearest'
        How it is read between the texel centres.
    scale : (float, float)
        Repetitions along u and v.
    """

    pixels: Vec3s
    filter: Literal["bilinear", "nearest"] = "bilinear"
    scale: tuple[float, float] = (1.0, 1.0)


@dataclass(frozen=True, slots=True)
class Checker:
    """Two colours on a chess board, each square half a unit of scaled (u, v).

    Attributes
    ----------
    color0, color1 : Color
        ``color0`` where both coordinates fall into the same half of their unit.
    scale : (float, float)
        Repetitions along u and v.
    """

    color0: Color
    color1: Color
    scale: tuple[float, float] = (1.0, 1.0)


Pattern = Bitmap | Checker
Texture = Color | Pattern


def mean_color(texture: Texture) -> Vec3s:
    """Average colour of a texture.

    Parameters
    ----------
    texture : Texture
        Any kind.

    Returns
    -------
    (3,) float64
        Over one repetition.
    """
    mean: Vec3s
    if isinstance(texture, Bitmap):
        mean = texture.pixels.mean(axis=(0, 1))
        return mean
    if isinstance(texture, Checker):
        colors: Vec3s = np.array([texture.color0, texture.color1])
        mean = colors.mean(axis=0)
        return mean
    return np.asarray(texture, float)


def color_range(texture: Texture) -> tuple[float, float]:
    """Smallest and largest value that a texture takes in any channel.

    Parameters
    ----------
    texture : Texture
        Any kind.

    Returns
    -------
    float, float
        NaN if any value is.
    """
    if isinstance(texture, Bitmap):
        values = texture.pixels
    elif isinstance(texture, Checker):
        values = np.array([texture.color0, texture.color1])
    else:
        values = np.array(texture, float)
    return float(values.min()), float(values.max())


def shines(texture: Texture) -> bool:
    """Whether a texture of radiance is above 0 anywhere.

    Parameters
    ----------
    texture : Texture
        Any kind.

    Returns
    -------
    bool
        False if a value is NaN.
    """
    return color_range(texture)[1] > 0


def scaled_color(color: Color, factor: float) -> Color:
    """A colour, brighter or darker.

    Parameters
    ----------
    color : Color
        Any.
    factor : float
        On each channel.

    Returns
    -------
    Color
        The product.
    """
    r, g, b = color
    return factor * r, factor * g, factor * b


def scaled(texture: Texture, factor: float) -> Texture:
    """The same texture, brighter or darker.

    Parameters
    ----------
    texture : Texture
        Any kind.
    factor : float
        On each channel.

    Returns
    -------
    Texture
        Of the same kind.
    """
    if isinstance(texture, Bitmap):
        return replace(texture, pixels=factor * texture.pixels)
    if isinstance(texture, Checker):
        color0 = scaled_color(texture.color0, factor)
        color1 = scaled_color(texture.color1, factor)
        return replace(texture, color0=color0, color1=color1)
    return scaled_color(texture, factor)


def read(texture: Texture, uv: Scalars) -> Vec3s:
    """Colour at texture coordinates.

    Parameters
    ----------
    texture : Texture
        Any kind.
    uv : (N, 2) float
        Any real numbers; the texture repeats.

    Returns
    -------
    (N, 3) float64
        Interpolated between texel centres where the bitmap asks for it.
    """
    if isinstance(texture, Bitmap):
        nearest = texture.filter == "nearest"
        return (_nearest if nearest else _bilinear)(texture.pixels, uv * texture.scale)
    if isinstance(texture, Checker):
        scaled = uv * texture.scale
        same_half = np.equal(*((scaled - np.floor(scaled) > 0.5).T))
        return np.where(same_half[:, None], texture.color0, texture.color1)
    return np.broadcast_to(np.asarray(texture, float), (len(uv), 3))


def _nearest(pixels: Vec3s, uv: Scalars) -> Vec3s:
    height, width, _ = pixels.shape
    column = np.floor(uv[:, 0] * width).astype(np.int64) % width
    row = np.floor((1.0 - uv[:, 1]) * height).astype(np.int64) % height
    nearest: Vec3s = pixels[row, column]
    return nearest


def _bilinear(pixels: Vec3s, uv: Scalars) -> Vec3s:
    return _blend(pixels, uv[:, 0], 1.0 - uv[:, 1], wrap_rows=True)


def read_latitudes(pixels: Vec3s, u: Scalars, v: Scalars) -> Vec3s:
    """Bilinear look-up that repeats along a row and stops at the poles.

    Parameters
    ----------
    pixels : (h, w, 3) float64
        A latitude-longitude map.
    u, v : (N,) float64
        In [0, 1]; v runs downwards from row 0.

    Returns
    -------
    (N, 3) float64
        Interpolated between texel centres.
    """
    return _blend(pixels, u, v, wrap_rows=False)


def _blend(pixels: Vec3s, u: Scalars, v: Scalars, wrap_rows: bool) -> Vec3s:
    height, width, _ = pixels.shape
    x, y = u * width - 0.5, v * height - 0.5
    left, top = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    right_share, bottom_share = (x - left)[:, None], (y - top)[:, None]
    columns = (left % width, (left + 1) % width)
    if wrap_rows:
        rows = (top % height, (top + 1) % height)
    else:
        rows = (np.clip(top, 0, height - 1), np.clip(top + 1, 0, height - 1))
    upper = (1 - right_share) * pixels[rows[0], columns[0]]
    upper += right_share * pixels[rows[0], columns[1]]
    lower = (1 - right_share) * pixels[rows[1], columns[0]]
    lower += right_share * pixels[rows[1], columns[1]]
    blended: Vec3s = (1 - bottom_share) * upper + bottom_share * lower
    return blended

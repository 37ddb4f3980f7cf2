"""Colours that vary over a surface: a bitmap, a checker, or one colour."""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Scalars, Vec3s

Color = tuple[float, float, float]

Wrap = Literal["repeat", "mirror", "clamp"]
"""What stands beyond the edges of a picture: itself, itself mirrored, its edge."""


@dataclass(frozen=True, slots=True, eq=False)
class Bitmap:
    """Colours on a grid over the unit square.

    Attributes
    ----------
    pixels : (h, w, 3) float64
        Linear Rec. 709, of reflectance or of radiance; row 0 is the top, v = 1.
    filter : 'bilinear' or 'nearest'; how it is read between the texel centres
    scale : (float, float); repetitions along u and v
    wrap : (Wrap, Wrap); how it goes on beyond the unit square along u and v
    """

    pixels: Vec3s
    filter: Literal["bilinear", "nearest"] = "bilinear"
    scale: tuple[float, float] = (1.0, 1.0)
    wrap: tuple[Wrap, Wrap] = ("repeat", "repeat")


@dataclass(frozen=True, slots=True)
class Checker:
    """Two colours on a chess board, each square half a unit of scaled (u, v).

    Attributes
    ----------
    color0, color1 : Color
        ``color0`` where both coordinates fall into the same half of their unit.
    scale : (float, float); repetitions along u and v
    """

    color0: Color
    color1: Color
    scale: tuple[float, float] = (1.0, 1.0)


Pattern = Bitmap | Checker
Texture = Color | Pattern


def mean_color(texture: Texture) -> Vec3s:
    """Average colour of a texture, (3,) float64; over one repetition."""
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
    """Whether a texture of radiance is above 0 anywhere; False if a value is NaN."""
    return color_range(texture)[1] > 0


def scaled_color(color: Color, factor: float) -> Color:
    """A colour, brighter or darker."""
    r, g, b = color
    return factor * r, factor * g, factor * b


def scaled(texture: Texture, factor: float) -> Texture:
    """The same texture, brighter or darker."""
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
    uv : (N, 2) float
        Up to 1e50 in magnitude; where float64 does not resolve texels any more, some
        colour of the texture.

    Returns
    -------
    (N, 3) float64; interpolated between texel centres where the bitmap asks for it
    """
    if isinstance(texture, Bitmap):
        u, v = (uv * texture.scale).T
        look_up = _nearest if texture.filter == "nearest" else _blend
        return look_up(texture.pixels, u, 1.0 - v, texture.wrap)
    if isinstance(texture, Checker):
        scaled = uv * texture.scale
        same_half = np.equal(*((scaled - np.floor(scaled) > 0.5).T))
        return np.where(same_half[:, None], texture.color0, texture.color1)
    return np.broadcast_to(np.asarray(texture, float), (len(uv), 3))


def read_latitudes(pixels: Vec3s, u: Scalars, v: Scalars) -> Vec3s:
    """Bilinear look-up that repeats along a row and stops at the poles.

    Parameters
    ----------
    pixels : (h, w, 3) float64; a latitude-longitude map
    u, v : (N,) float64; in [0, 1]; v runs downwards from row 0

    Returns
    -------
    (N, 3) float64; interpolated between texel centres
    """
    return _blend(pixels, u, v, ("repeat", "clamp"))


def _nearest(pixels: Vec3s, u: Scalars, v: Scalars, wrap: tuple[Wrap, Wrap]) -> Vec3s:
    height, width, _ = pixels.shape
    column = _texel(np.floor(u * width), width, wrap[0])
    row = _texel(np.floor(v * height), height, wrap[1])
    nearest: Vec3s = pixels[row, column]
    return nearest


def _blend(pixels: Vec3s, u: Scalars, v: Scalars, wrap: tuple[Wrap, Wrap]) -> Vec3s:
    height, width, _ = pixels.shape
    x, y = u * width - 0.5, v * height - 0.5
    left, top = np.floor(x), np.floor(y)
    right_share, bottom_share = (x - left)[:, None], (y - top)[:, None]
    columns = [_texel(place, width, wrap[0]) for place in (left, left + 1)]
    rows = [_texel(place, height, wrap[1]) for place in (top, top + 1)]
    upper = (1 - right_share) * pixels[rows[0], columns[0]]
    upper += right_share * pixels[rows[0], columns[1]]
    lower = (1 - right_share) * pixels[rows[1], columns[0]]
    lower += right_share * pixels[rows[1], columns[1]]
    blended: Vec3s = (1 - bottom_share) * upper + bottom_share * lower
    return blended


def _texel(place: Scalars, count: int, wrap: Wrap) -> Indices:
    """Index of whole places on an endless row of texels; places stay floats till then.

    Beyond 2⁶³ they are no int64, but their remainder still is exact.
    """
    if wrap == "clamp":
        return np.clip(place, 0, count - 1).astype(np.int64)
    if wrap == "repeat":
        return np.mod(place, count).astype(np.int64)
    there = np.mod(place, 2 * count).astype(np.int64)
    return np.minimum(there, 2 * count - 1 - there)

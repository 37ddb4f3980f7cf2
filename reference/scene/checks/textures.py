"""Textures: colours within bounds, wherever they are read."""

import numpy as np

from restir_gi.reference.scene.checks.values import need_numbers, refuse
from restir_gi.reference.scene.textures import Bitmap, Checker, Texture


def check_texture(where: str, what: str, texture: Texture, high: float) -> None:
    """Require a texture of finite colours from 0 to a bound.

    Raises UsageError, which names the texture's kind and the value.

    Parameters
    ----------
    where, what : str; the shape that has it, and what it tells of it: "reflectance"
    texture : Texture; a colour, a bitmap or a checker
    high : float; bound, inclusive
    """
    if isinstance(texture, Bitmap):
        pixels = texture.pixels
        if pixels.ndim != 3 or pixels.shape[2] != 3 or pixels.size == 0:
            size = "x".join(map(str, pixels.shape))
            wrong = f"the bitmap of its {what} is {size}"
            refuse(where, wrong, "it must be (h, w, 3), not empty")
        need_numbers(where, f"{what} in the bitmap", pixels, 0, high)
        need_numbers(where, "scale of the bitmap", texture.scale, count=2)
    elif isinstance(texture, Checker):
        for color in (texture.color0, texture.color1):
            need_numbers(where, f"{what} of the checker", color, 0, high, count=3)
        need_numbers(where, "scale of the checker", texture.scale, count=2)
    else:
        need_numbers(where, what, np.asarray(texture, float), 0, high, count=3)

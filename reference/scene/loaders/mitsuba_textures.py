"""Mitsuba's textures as ours."""

from typing import Any

import numpy as np

from reference.errors import UsageError
from reference.scene.loaders.framing import color
from reference.scene.loaders.ledger import Ledger
from reference.scene.loaders.mitsuba_nodes import Node
from reference.scene.loaders.pictures import read_picture
from reference.scene.textures import Bitmap, Checker, Color, Texture, mean_color

MID_GREY = (0.5, 0.5, 0.5)
CONSTANT = {"uniform": "value", "srgb": "color"}


def read_texture(
    mi: Any, node: Node, key: str, default: float, ledger: Ledger
) -> Texture:
    """Reflectance that a plugin takes from a parameter.

    Parameters
    ----------
    mi : module
        ``mitsuba``.
    node : Node
        The plugin.
    key : str
        Name of the parameter.
    default : float
        What Mitsuba takes if the file does not say.
    ledger : Ledger
        Of the file.

    Returns
    -------
    Texture
        A colour, a bitmap or a checker.
    """
    texture = node.child(key)
    if texture is None:
        return _constant(mi, node.get(key, default), False, ledger)
    if texture.kind in CONSTANT:
        value = texture.get(CONSTANT[texture.kind], default)
        return _constant(mi, value, False, ledger)
    if texture.kind == "bitmap":
        return _bitmap(texture, ledger)
    if texture.kind == "checkerboard":
        checker = Checker(
            color0=_plain(mi, texture, "color0", 0.4, ledger),
            color1=_plain(mi, texture, "color1", 0.2, ledger),
            scale=_scale(texture, ledger),
        )
        texture.refuse_unread(ledger)
        return checker
    ledger.replace(
        f"{node.name}: the texture {texture.name} is not modelled (bitmap,"
        " checkerboard, uniform and srgb are)",
        "taken as mid grey",
    )
    return MID_GREY


def read_color(
    mi: Any, node: Node, key: str, default: float, emission: bool, ledger: Ledger
) -> Color:
    """Colour that a plugin takes from a parameter, where a texture is not modelled.

    Parameters
    ----------
    mi : module
        ``mitsuba``.
    node : Node
        The plugin.
    key : str
        Name of the parameter.
    default : float
        What Mitsuba takes if the file does not say.
    emission : bool
        It is one of emitted light.
    ledger : Ledger
        Of the file.

    Returns
    -------
    Color
        Linear Rec. 709; the mean of a texture, if lenient.
    """
    if node.child(key) is None:
        return _constant(mi, node.get(key, default), emission, ledger)
    texture = read_texture(mi, node, key, default, ledger)
    if isinstance(texture, Bitmap | Checker):
        ledger.replace(
            f'{node.name}: a texture as "{key}" is not modelled, a colour is',
            "taken as the mean colour of the texture",
        )
    return color(mean_color(texture))


def _plain(mi: Any, node: Node, key: str, default: float, ledger: Ledger) -> Color:
    return read_color(mi, node, key, default, False, ledger)


def _bitmap(node: Node, ledger: Ledger) -> Texture:
    raw = bool(node.get("raw", False))
    wrap = node.get("wrap_mode", "repeat")
    if wrap != "repeat":
        ledger.replace(
            f'{node.name}: the wrap mode "{wrap}" is not modelled, "repeat" is',
            "taken as repeat",
        )
    nearest = node.get("filter_type", "bilinear") == "nearest"
    scale = _scale(node, ledger)
    filename = node.get("filename")
    node.refuse_unread(ledger, harmless="format accel")
    if filename is None:
        ledger.stop(f"{node.name} has no filename; it needs one")
    try:
        pixels = read_picture(filename, ledger, raw)
    except UsageError as error:
        ledger.replace(f"{node.name}: {error}", "taken as mid grey")
        return MID_GREY
    # Mitsuba counts v from the top of a picture, we from its bottom.
    upright = np.ascontiguousarray(pixels[::-1])
    return Bitmap(upright, "nearest" if nearest else "bilinear", scale)


def _scale(node: Node, ledger: Ledger) -> tuple[float, float]:
    matrix = node.matrix("to_uv")
    linear, shift = matrix[:2, :2], matrix[:2, -1]
    if len(matrix) == 4 and np.array_equal(matrix, np.eye(4)):
        return 1.0, 1.0
    if linear[0, 1] or linear[1, 0] or shift.any():
        ledger.replace(
            f"{node.name}: to_uv turns or shifts, which is not modelled; a scale is",
            "taken as its scale alone",
        )
    u, v = np.linalg.norm(linear, axis=0)
    return float(u), float(v)


def _constant(mi: Any, value: Any, emission: bool, ledger: Ledger) -> Color:
    """Linear Rec. 709, by Mitsuba's own conversion of numbers, colours and spectra."""
    if isinstance(value, int | float):
        return (float(value),) * 3
    if type(value).__name__.startswith("Color3"):
        return color(value)
    with ledger.reading("spectrum"):
        props = mi.Properties()
        props["value"] = value
        texture = (
            props.get_emissive_texture("value")
            if emission
            else props.get_unbounded_texture("value")
        )
        return color(texture.eval(mi.SurfaceInteraction3f()))

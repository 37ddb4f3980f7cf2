"""Mitsuba's textures as ours."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, TypeVar

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.scene.loaders.framing import color
from restir_gi.reference.scene.loaders.ledger import Ledger
from restir_gi.reference.scene.loaders.mitsuba_nodes import Node, reading
from restir_gi.reference.scene.loaders.pictures import read_picture
from restir_gi.reference.scene.textures import (
    Bitmap,
    Checker,
    Color,
    Pattern,
    Texture,
    Wrap,
    mean_color,
)
from restir_gi.reference.system.errors import UsageError

MID_GREY = (0.5, 0.5, 0.5)
CONSTANT = {"uniform": "value", "srgb": "color", "d65": "scale", "rawconstant": "value"}
WRAPS: dict[str, Wrap] = {"repeat": "repeat", "mirror": "mirror", "clamp": "clamp"}
FILTERS: dict[str, Literal["bilinear", "nearest"]] = {
    "bilinear": "bilinear",
    "nearest": "nearest",
}
Choice = TypeVar("Choice")


@dataclass(slots=True)
class Textures:
    """The textures of one file; one that several plugins refer to is one object.

    Attributes
    ----------
    mi : module; ``mitsuba``
    made : dict; what was converted already
    turned : dict of int to (2, 3) float64
        By identity of a texture: what becomes of texture coordinates before they are
        looked up in it, where that is more than a scale.
    """

    mi: Any
    ledger: Ledger
    made: dict[tuple[int, bool], Texture] = field(default_factory=dict)
    turned: dict[int, Scalars] = field(default_factory=dict)

    def read(
        self,
        node: Node,
        key: str,
        default: float,
        emission: bool = False,
        diffuse: bool = False,
    ) -> Texture:
        """Colour, bitmap or checker that a plugin takes from a parameter.

        Linear Rec. 709; a factor on the colours of the mesh.

        Parameters
        ----------
        default : float; what Mitsuba takes if the file does not say
        diffuse : bool; colours of the mesh may stand for it, see `attribute`
        """
        texture = node.children.get(key)
        if texture is None:
            return self._constant(node, node.get(key, default), emission)
        if texture.kind == "mesh_attribute" and not diffuse:
            self.ledger.replace(
                f'{node.name}: a mesh_attribute as "{key}" is not modelled',
                "taken as mid grey",
            )
            return MID_GREY
        way = id(texture), emission
        if way not in self.made:
            self.made[way] = self._convert(texture, emission)
        return self.made[way]

    def color(
        self, node: Node, key: str, default: float, emission: bool = False
    ) -> Color:
        """Colour that a plugin takes from a parameter, where a texture is not modelled.

        Linear Rec. 709; the mean of a texture, if lenient.

        Parameters
        ----------
        default : float; what Mitsuba takes if the file does not say
        """
        texture = self.read(node, key, default, emission)
        if isinstance(texture, Pattern):
            self.ledger.replace(
                f'{node.name}: a texture as "{key}" is not modelled, a colour is',
                "taken as the mean colour of the texture",
            )
        return color(mean_color(texture))

    def number(self, node: Node, key: str, default: float) -> float:
        """Number that a plugin takes from a parameter: the mean of a colour.

        Of a texture it is the mean too, if lenient.
        """
        shades = self.color(node, key, default)
        # The mean of three equal numbers is rounded.
        return shades[0] if len(set(shades)) == 1 else float(np.mean(shades))

    def attribute(self, node: Node, key: str) -> str:
        """Name of the colours of the mesh that a parameter takes, "" for none."""
        texture = node.children.get(key)
        if texture is None or texture.kind != "mesh_attribute":
            return ""
        return texture.text("name", "", self.ledger)

    def placement(self, textures: Sequence[Pattern], where: str) -> Scalars | None:
        """What becomes of the texture coordinates of a shape.

        Parameters
        ----------
        textures : sequence of Pattern; all those of the shape
        where : str; the shape, for messages

        Returns
        -------
        (2, 3) float64 or None; ``None`` where they stay as they are
        """
        turns = [self.turned.get(id(texture)) for texture in textures]
        first = turns[0] if turns else None
        if any(turn is not first and not _same(turn, first) for turn in turns):
            self.ledger.replace(
                f"{where}: its textures lie differently (to_uv), which is not modelled",
                "all placed as the first",
            )
        return first

    def _convert(self, node: Node, emission: bool) -> Texture:
        if not node.is_modelled(self.ledger):
            return MID_GREY
        node.check_words(self.ledger)
        if node.kind == "mesh_attribute":
            return (node.number("scale", 1.0, self.ledger),) * 3
        if node.kind == "bitmap":
            return self._bitmap(node)
        if node.kind == "checkerboard":
            scale, turn = self._placed(node)
            checker = Checker(
                self.color(node, "color0", 0.4), self.color(node, "color1", 0.2), scale
            )
            self._remember(checker, turn)
            return checker
        default = 1.0 if node.kind == "d65" else 0.5
        value = node.get(CONSTANT[node.kind], default)
        return self._constant(node, value, emission)

    def _bitmap(self, node: Node) -> Texture:
        raw = node.flag("raw", False, self.ledger)
        wrap = self._choice(node, "wrap_mode", WRAPS)
        filtered = self._choice(node, "filter_type", FILTERS)
        scale, turn = self._placed(node)
        try:
            path = node.file(self.ledger)
            pixels = read_picture(str(path), self.ledger, raw)
        except UsageError as error:
            self.ledger.replace(f"{node.name}: {error}", "taken as mid grey")
            return MID_GREY
        # Mitsuba counts v from the top of a picture, we from its bottom.
        upright = np.ascontiguousarray(pixels[::-1])
        bitmap = Bitmap(upright, filtered, scale, (wrap, wrap))
        self._remember(bitmap, turn)
        return bitmap

    def _choice(self, node: Node, key: str, known: dict[str, Choice]) -> Choice:
        given = node.text(key, next(iter(known)), self.ledger)
        if given not in known:
            can = " or ".join(known)
            self.ledger.stop(f'{node.name}: "{key}" is "{given}"; it can be {can}')
        return known[given]

    def _placed(self, node: Node) -> tuple[tuple[float, float], Scalars | None]:
        """Scale of texture coordinates, or, where to_uv does more, all of it."""
        matrix = node.matrix(self.ledger, "to_uv")
        columns = [0, 1, -1]
        affine = matrix[:2, columns]
        (u, tilt, right), (slant, v, up) = affine
        if tilt == slant == right == up == 0:
            return (float(u), float(v)), None
        return (1.0, 1.0), affine

    def _remember(self, texture: Texture, turn: Scalars | None) -> None:
        if turn is not None:
            self.turned[id(texture)] = turn

    def _constant(self, node: Node, value: Any, emission: bool) -> Color:
        """Linear Rec. 709, by Mitsuba's own conversion of colours and spectra."""
        if isinstance(value, int | float):
            return (float(value),) * 3
        if type(value).__name__.startswith("Color3"):
            return color(value)
        with reading(f"spectrum of {node.name}", self.ledger):
            props = self.mi.Properties()
            props["value"] = value
            texture = (
                props.get_emissive_texture("value")
                if emission
                else props.get_unbounded_texture("value")
            )
            return color(texture.eval(self.mi.SurfaceInteraction3f()))


def _same(a: Scalars | None, b: Scalars | None) -> bool:
    return a is not None and b is not None and np.array_equal(a, b)


def as_bitmap(checker: Checker) -> Bitmap:
    """The same checker as a picture of two by two, read without interpolation."""
    one, other = checker.color0, checker.color1
    return Bitmap(np.array([[other, one], [one, other]]), "nearest", checker.scale)

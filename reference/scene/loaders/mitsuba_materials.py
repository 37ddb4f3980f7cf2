"""Mitsuba's BSDFs as our materials."""

import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from restir_gi.reference.scene.loaders.framing import color
from restir_gi.reference.scene.loaders.ledger import Ledger, roughness
from restir_gi.reference.scene.loaders.mitsuba_nodes import Node, reading
from restir_gi.reference.scene.loaders.mitsuba_textures import (
    MID_GREY,
    Textures,
    as_bitmap,
)
from restir_gi.reference.scene.loaders.mitsuba_words import find
from restir_gi.reference.scene.materials.kinds import (
    Coated,
    Conductor,
    Dielectric,
    Distribution,
    Lambertian,
    Material,
)
from restir_gi.reference.scene.textures import Bitmap, Checker, Color, Texture

WHITE = (1.0, 1.0, 1.0)
FACTORS = ("specular_reflectance", "specular_transmittance")  # of glass
REFLECTANCE = {
    "diffuse": "reflectance",
    "conductor": "specular_reflectance",
    "roughconductor": "specular_reflectance",
    "plastic": "diffuse_reflectance",
    "roughplastic": "diffuse_reflectance",
    "pplastic": "diffuse_reflectance",
}
"""Which parameter our materials call their reflectance."""
METAL = re.compile(r"[\w-]+")  # Mitsuba looks it up as the name of a file
DISTRIBUTIONS: dict[str, Distribution] = {"beckmann": "beckmann", "ggx": "ggx"}
INVISIBLE = ("null", "thindielectric", "polarizer", "retarder", "circular")


@dataclass(frozen=True, slots=True, eq=False)
class MitsubaAppearance:
    """What a BSDF makes of a shape.

    Attributes
    ----------
    material : Material; how it scatters
    opacity : Bitmap or None; where there is a surface
    attribute : str
        Colours of the shape's vertices or faces, by Mitsuba's name; "" for none.
    """

    material: Material
    opacity: Bitmap | None = None
    attribute: str = ""


@dataclass(slots=True)
class Materials:
    """The materials of one file; a BSDF that several shapes refer to is one object.

    Attributes
    ----------
    mi : module; ``mitsuba``
    made : dict; what was converted already
    weighed : set of Path; files of triangles whose bytes were counted already
    """

    mi: Any
    ledger: Ledger
    textures: Textures
    made: dict[tuple[int, bool], MitsubaAppearance | None] = field(default_factory=dict)
    weighed: set[Path] = field(default_factory=set)

    def of(self, node: Node, two_sided: bool = False) -> MitsubaAppearance | None:
        """Look of a BSDF; ``None`` if the shape is to be left out.

        Parameters
        ----------
        two_sided : bool; it stands inside a ``twosided``
        """
        key = id(node), two_sided
        if key not in self.made:
            self.made[key] = self._convert(node, two_sided)
        return self.made[key]

    def _convert(self, node: Node, two_sided: bool) -> MitsubaAppearance | None:
        known = node.is_modelled(self.ledger)
        if node.kind in INVISIBLE:
            return None
        if node.kind in ("principled", "principledthin"):
            return MitsubaAppearance(self._principled(node, two_sided))
        inner = node.inside("bsdf")
        if not known and inner:
            return self.of(inner[0], two_sided)
        if known:
            node.check_words(self.ledger, apart=FACTORS)
        if node.kind in ("twosided", "mask"):
            if not inner:
                self.ledger.stop(f"{node.name} holds no BSDF; it needs one")
            if node.kind == "mask":
                return self._mask(node, self.of(inner[0], two_sided))
            if len(inner) > 1:
                self.ledger.replace(
                    f"{node.name} has two different sides, which is not modelled",
                    "taken as its first side on both",
                )
            return self.of(inner[0], two_sided=True)
        convert: dict[str, Callable[[Node, bool], Material]] = {
            "diffuse": self._diffuse,
            "conductor": self._conductor,
            "roughconductor": self._conductor,
            "plastic": self._coated,
            "roughplastic": self._coated,
            "pplastic": self._coated,
            "dielectric": self._dielectric,
            "roughdielectric": self._dielectric,
        }
        if node.kind not in convert:
            return MitsubaAppearance(Lambertian(MID_GREY, two_sided))
        material = convert[node.kind](node, two_sided)
        attribute = self.textures.attribute(node, REFLECTANCE.get(node.kind, ""))
        return MitsubaAppearance(material, attribute=attribute)

    def _reflectance(self, node: Node, default: float) -> Texture:
        return self.textures.read(node, REFLECTANCE[node.kind], default, diffuse=True)

    def _mask(
        self, node: Node, look: MitsubaAppearance | None
    ) -> MitsubaAppearance | None:
        opacity = self.textures.read(node, "opacity", 0.5)
        if isinstance(opacity, Checker):
            opacity = as_bitmap(opacity)
        values = opacity.pixels if isinstance(opacity, Bitmap) else np.array(opacity)
        hard = isinstance(opacity, Bitmap) and opacity.filter == "nearest"
        if np.all(values == 1):
            return look
        if np.all(values == 0):
            return None
        if look is None or look.opacity is not None:
            self.ledger.replace(
                f"{node.name} is a mask of what is itself one, or invisible, which is"
                " not modelled",
                "taken as the BSDF inside",
            )
            return look
        if not (hard and np.isin(values, (0, 1)).all()):
            self.ledger.replace(
                f"{node.name}: an opacity between 0 and 1 is not modelled",
                "taken as opaque from 0.5 on",
            )
        if isinstance(opacity, Bitmap):
            return replace(look, opacity=opacity)
        return look if np.mean(values) >= 0.5 else None

    def _diffuse(self, node: Node, two_sided: bool) -> Material:
        return Lambertian(self._reflectance(node, 0.5), two_sided)

    def _conductor(self, node: Node, two_sided: bool) -> Material:
        eta, k = self._complex_ior(node)
        return Conductor(
            self._reflectance(node, 1.0),
            alpha=self._alpha(node) if node.kind == "roughconductor" else 0.0,
            eta=eta,
            k=k,
            two_sided=two_sided,
            distribution=self._distribution(node),
        )

    def _coated(self, node: Node, two_sided: bool) -> Material:
        return Coated(
            self._reflectance(node, 0.5),
            alpha=0.0 if node.kind == "plastic" else self._alpha(node),
            ior=self._ior(node, "polypropylene"),
            nonlinear=node.flag("nonlinear", False, self.ledger),
            specular=self.textures.color(node, "specular_reflectance", 1.0),
            two_sided=two_sided,
            distribution=self._distribution(node),
        )

    def _dielectric(self, node: Node, _two_sided: bool) -> Material:
        for key in FACTORS:
            if self.textures.read(node, key, 1.0) != WHITE:
                node.refuse_word(key, find(node.kind, key), self.ledger)
        return Dielectric(
            self._ior(node, "bk7"),
            alpha=self._alpha(node) if node.kind == "roughdielectric" else 0.0,
            distribution=self._distribution(node),
        )

    def _principled(self, node: Node, two_sided: bool) -> Material:
        base = self.textures.read(node, "base_color", 0.5)
        metallic = self.textures.number(node, "metallic", 0.0)
        rough = self.textures.number(node, "roughness", 0.5)
        alpha = roughness(rough**2, node.name, self.ledger)
        if metallic >= 0.5:
            self.ledger.note(
                f"{node.name} is taken as rough metal by Schlick, alpha = roughness² ="
                f" {alpha:g}, for its metallic is {metallic:g}"
            )
            return Conductor(base, alpha=alpha, schlick=True, two_sided=two_sided)
        self.ledger.note(
            f"{node.name} is taken as a diffuse base under a coat of ior 1.5, alpha ="
            f" roughness² = {alpha:g}, for its metallic is {metallic:g}"
        )
        return Coated(base, alpha=alpha, ior=1.5, two_sided=two_sided)

    def _distribution(self, node: Node) -> Distribution:
        if not node.kind.startswith("rough"):
            return "ggx"  # of a smooth one it does not matter
        given = node.text("distribution", "beckmann", self.ledger)
        if given not in DISTRIBUTIONS:
            self.ledger.stop(
                f'{node.name}: "distribution" is "{given}"; it can be beckmann or ggx'
            )
        return DISTRIBUTIONS[given]

    def _alpha(self, node: Node) -> float:
        alpha = self.textures.number(node, "alpha", 0.1)
        across, along = (
            self.textures.number(node, f"alpha_{axis}", alpha) for axis in "uv"
        )
        if across != along:
            alpha = float(np.sqrt(across * along))
            self.ledger.replace(
                f"{node.name} is anisotropic, which is not modelled",
                f"taken as isotropic with alpha {alpha:.4g}",
            )
        else:
            alpha = across
        return roughness(alpha, node.name, self.ledger)

    def _ior(self, node: Node, default: str) -> float:
        """Relative index of refraction, by Mitsuba's table of names."""
        given = {"int_ior": default, "ext_ior": "air"}
        given = {key: node.get(key, name) for key, name in given.items()}
        if not any(isinstance(value, str) for value in given.values()):
            inside, outside = (node.number(key, 1.0, self.ledger) for key in given)
            return inside / outside if outside else float("inf")
        with reading(f"index of refraction of {node.name}", self.ledger):
            glass = self.mi.load_dict({"type": "dielectric", **given})
            return float(self.mi.traverse(glass)["eta"])

    def _complex_ior(self, node: Node) -> tuple[Color, Color] | tuple[None, None]:
        """Index of refraction of a metal, ``None`` for a perfect mirror."""
        material = node.text("material", "none", self.ledger)
        if {"eta", "k"} & (node.values.keys() | node.children.keys()):
            eta = self.textures.color(node, "eta", 0.0)
            return eta, self.textures.color(node, "k", 1.0)
        if material == "none":
            return None, None
        if not METAL.fullmatch(material):
            self.ledger.stop(f'{node.name}: there is no metal "{material}"')
        with reading(f"metal of {node.name}", self.ledger):
            metal = self.mi.load_dict({"type": "conductor", "material": material})
            table = self.mi.traverse(metal)
            return color(table["eta.value"]), color(table["k.value"])

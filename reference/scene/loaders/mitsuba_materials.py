"""Mitsuba's BSDFs as our materials."""

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from reference.scene.loaders.framing import color
from reference.scene.loaders.ledger import Ledger, roughness
from reference.scene.loaders.mitsuba_nodes import Node
from reference.scene.loaders.mitsuba_textures import MID_GREY, Textures
from reference.scene.loaders.mitsuba_words import find
from reference.scene.materials.kinds import (
    Coated,
    Conductor,
    Dielectric,
    Distribution,
    Lambertian,
    Material,
)
from reference.scene.textures import Color

WHITE = (1.0, 1.0, 1.0)
FACTORS = ("specular_reflectance", "specular_transmittance")  # of glass
METAL = re.compile(r"[\w-]+")  # Mitsuba looks it up as the name of a file
DISTRIBUTIONS: dict[str, Distribution] = {"beckmann": "beckmann", "ggx": "ggx"}
INVISIBLE = ("null", "thindielectric", "polarizer", "retarder", "circular")


@dataclass(slots=True)
class Materials:
    """The materials of one file; a BSDF that several shapes refer to is one object.

    Attributes
    ----------
    mi : module
        ``mitsuba``.
    ledger : Ledger
        Of the file.
    textures : Textures
        Of the file.
    made : dict
        What was converted already.
    """

    mi: Any
    ledger: Ledger
    textures: Textures
    made: dict[tuple[int, bool], Material | None] = field(default_factory=dict)

    def of(self, node: Node, two_sided: bool = False) -> Material | None:
        """Material for a BSDF.

        Parameters
        ----------
        node : Node
            The BSDF.
        two_sided : bool
            It stands inside a ``twosided``.

        Returns
        -------
        Material or None
            ``None`` if the shape is to be left out.
        """
        key = id(node), two_sided
        if key not in self.made:
            self.made[key] = self._convert(node, two_sided)
        return self.made[key]

    def _convert(self, node: Node, two_sided: bool) -> Material | None:
        known = node.is_modelled(self.ledger)
        if node.kind in INVISIBLE:
            return None
        if node.kind in ("principled", "principledthin"):
            return self._principled(node, two_sided)
        inner = node.inside("bsdf")
        if not known and inner:
            return self.of(inner[0], two_sided)
        if node.kind == "twosided":
            return self._both_sides(node)
        if known:
            node.check_words(self.ledger, apart=FACTORS)
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
        if node.kind in convert:
            return convert[node.kind](node, two_sided)
        return Lambertian(MID_GREY, two_sided)

    def _both_sides(self, node: Node) -> Material | None:
        sides = node.inside("bsdf")
        if not sides:
            self.ledger.stop(f"{node.name} holds no BSDF; it needs one")
        if len(sides) > 1:
            self.ledger.replace(
                f"{node.name} has two different sides, which is not modelled",
                "taken as its first side on both",
            )
        node.check_words(self.ledger)
        return self.of(sides[0], two_sided=True)

    def _diffuse(self, node: Node, two_sided: bool) -> Material:
        return Lambertian(self.textures.read(node, "reflectance", 0.5), two_sided)

    def _conductor(self, node: Node, two_sided: bool) -> Material:
        eta, k = self._complex_ior(node)
        return Conductor(
            self.textures.read(node, "specular_reflectance", 1.0),
            alpha=self._alpha(node) if node.kind == "roughconductor" else 0.0,
            eta=eta,
            k=k,
            two_sided=two_sided,
            distribution=self._distribution(node),
        )

    def _coated(self, node: Node, two_sided: bool) -> Material:
        return Coated(
            self.textures.read(node, "diffuse_reflectance", 0.5),
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
        with self.ledger.reading(f"index of refraction of {node.name}"):
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
        with self.ledger.reading(f"metal of {node.name}"):
            metal = self.mi.load_dict({"type": "conductor", "material": material})
            table = self.mi.traverse(metal)
            return color(table["eta.value"]), color(table["k.value"])

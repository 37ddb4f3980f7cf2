"""Mitsuba's BSDFs as our materials."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from reference.scene.loaders.framing import color
from reference.scene.loaders.ledger import Ledger, roughness
from reference.scene.loaders.mitsuba_nodes import Node
from reference.scene.loaders.mitsuba_textures import MID_GREY, read_color, read_texture
from reference.scene.materials.kinds import (
    Coated,
    Conductor,
    Dielectric,
    Lambertian,
    Material,
)
from reference.scene.textures import Color, Texture

WHITE = (1.0, 1.0, 1.0)
INVISIBLE = {
    "null": "left out: it is invisible",
    "thindielectric": "its shape left out: a thin pane hides almost nothing",
}


@dataclass(slots=True)
class Materials:
    """The materials of one file; a BSDF that several shapes refer to is one object.

    Attributes
    ----------
    mi : module
        ``mitsuba``.
    ledger : Ledger
        Of the file.
    made : dict
        What was converted already.
    """

    mi: Any
    ledger: Ledger
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
        modelled: dict[str, Callable[[Node, bool], Material]] = {
            "diffuse": self._diffuse,
            "conductor": self._conductor,
            "roughconductor": self._conductor,
            "plastic": self._coated,
            "roughplastic": self._coated,
            "dielectric": self._dielectric,
        }
        if node.kind == "twosided":
            return self._both_sides(node)
        if node.kind in modelled:
            material = modelled[node.kind](node, two_sided)
            node.refuse_unread(self.ledger, harmless="sample_visible")
            return material
        known = ", ".join(["twosided", *modelled])
        problem = f"{node.name} is not modelled ({known} are)"
        if node.kind in INVISIBLE:
            self.ledger.replace(problem, INVISIBLE[node.kind])
            return None
        if node.kind == "principled":
            return self._principled(node, two_sided, problem)
        if inner := node.inside("BSDF"):
            self.ledger.replace(problem, f"taken as its inner {inner[0].name}")
            return self.of(inner[0], two_sided)
        if node.kind == "roughdielectric":
            self.ledger.replace(problem, "taken as smooth")
            return Dielectric(self._ior(node, "bk7"))
        self.ledger.replace(problem, "taken as diffuse with reflectance 0.5")
        return Lambertian(MID_GREY, two_sided)

    def _both_sides(self, node: Node) -> Material | None:
        sides = node.inside("BSDF")
        if not sides:
            self.ledger.stop(f"{node.name} holds no BSDF; it needs one")
        if len(sides) > 1:
            self.ledger.replace(
                f"{node.name} has two different sides, which is not modelled",
                "taken as its first side on both",
            )
        node.refuse_unread(self.ledger)
        return self.of(sides[0], two_sided=True)

    def _diffuse(self, node: Node, two_sided: bool) -> Material:
        return Lambertian(self._texture(node, "reflectance", 0.5), two_sided)

    def _conductor(self, node: Node, two_sided: bool) -> Material:
        alpha = self._alpha(node) if node.kind == "roughconductor" else 0.0
        eta, k = self._complex_ior(node)
        return Conductor(
            self._texture(node, "specular_reflectance", 1.0),
            alpha=alpha,
            eta=eta,
            k=k,
            two_sided=two_sided,
        )

    def _coated(self, node: Node, two_sided: bool) -> Material:
        rough = node.kind == "roughplastic"
        return Coated(
            self._texture(node, "diffuse_reflectance", 0.5),
            alpha=self._alpha(node) if rough else 0.0,
            ior=self._ior(node, "polypropylene"),
            nonlinear=bool(node.get("nonlinear", False)),
            specular=read_color(
                self.mi, node, "specular_reflectance", 1.0, False, self.ledger
            ),
            two_sided=two_sided,
        )

    def _dielectric(self, node: Node, _two_sided: bool) -> Material:
        for key in ("specular_reflectance", "specular_transmittance"):
            if read_color(self.mi, node, key, 1.0, False, self.ledger) != WHITE:
                self.ledger.replace(
                    f"{node.name}: {key} other than 1 is not modelled", "taken as 1"
                )
        return Dielectric(self._ior(node, "bk7"))

    def _principled(self, node: Node, two_sided: bool, problem: str) -> Material:
        base = self._texture(node, "base_color", 0.5)
        metallic = self._number(node, "metallic", 0.0)
        rough = self._number(node, "roughness", 0.5)
        alpha = roughness(rough**2, node.name, self.ledger)
        if metallic >= 0.5:
            self.ledger.replace(
                problem,
                f"taken as rough metal by Schlick, alpha = roughness² = {alpha:g}, for"
                f" its metallic is {metallic:g}",
            )
            return Conductor(base, alpha=alpha, schlick=True, two_sided=two_sided)
        self.ledger.replace(
            problem,
            f"taken as a diffuse base under a coat of ior 1.5, alpha = roughness² ="
            f" {alpha:g}, for its metallic is {metallic:g}",
        )
        return Coated(base, alpha=alpha, ior=1.5, two_sided=two_sided)

    def _texture(self, node: Node, key: str, default: float) -> Texture:
        return read_texture(self.mi, node, key, default, self.ledger)

    def _number(self, node: Node, key: str, default: float) -> float:
        shades = read_color(self.mi, node, key, default, False, self.ledger)
        # The mean of three equal numbers is rounded.
        return shades[0] if len(set(shades)) == 1 else float(np.mean(shades))

    def _alpha(self, node: Node) -> float:
        distribution = node.get("distribution", "beckmann")
        if distribution != "ggx":
            self.ledger.replace(
                f'{node.name}: the distribution "{distribution}" is not modelled, "ggx"'
                " is",
                "taken as GGX of the same alpha",
            )
        alpha = self._number(node, "alpha", 0.1)
        across, along = (self._number(node, f"alpha_{x}", alpha) for x in "uv")
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
            return float(given["int_ior"]) / float(given["ext_ior"])
        with self.ledger.reading(f"index of refraction of {node.name}"):
            glass = self.mi.load_dict({"type": "dielectric", **given})
            return float(self.mi.traverse(glass)["eta"])

    def _complex_ior(self, node: Node) -> tuple[Color, Color] | tuple[None, None]:
        """Index of refraction of a metal, ``None`` for a perfect mirror."""
        material = node.get("material", "none")
        if {"eta", "k"} & (node.values.keys() | node.children.keys()):
            eta = read_color(self.mi, node, "eta", 0.0, False, self.ledger)
            k = read_color(self.mi, node, "k", 1.0, False, self.ledger)
            return eta, k
        if material == "none":
            return None, None
        with self.ledger.reading(f"metal of {node.name}"):
            metal = self.mi.load_dict({"type": "conductor", "material": material})
            table = self.mi.traverse(metal)
            return color(table["eta.value"]), color(table["k.value"])

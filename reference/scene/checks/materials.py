"""Materials: reflectances, widths and indices within what the models mean."""

from typing import get_args

from restir_gi.reference.scene.checks.textures import check_texture
from restir_gi.reference.scene.checks.values import need_numbers, refuse
from restir_gi.reference.scene.materials.kinds import (
    Coated,
    Conductor,
    Dielectric,
    Distribution,
    Material,
)
from restir_gi.reference.scene.textures import Texture

LEAST_ALPHA = 1e-3
"""Narrowest lobe of microfacets; below it, say 0 for a smooth surface."""


def check_material(where: str, material: Material) -> None:
    """Require a material that never reflects more than it receives.

    Raises UsageError, which names the property.

    Parameters
    ----------
    where : str; the shape that is made of it
    """
    if isinstance(material, Conductor | Coated | Dielectric):
        _check_facets(where, material)
    if isinstance(material, Dielectric):
        _check_index(where, material.ior)
        if material.alpha > 0 and material.ior == 1:
            right = "a rough boundary must refract: leave the shape out"
            refuse(where, "ior is 1", right)
        return
    check_reflectance(where, material.reflectance)
    if isinstance(material, Conductor):
        _check_metal(where, material)
    if isinstance(material, Coated):
        _check_index(where, material.ior)
        if material.ior <= 1:
            right = "a coat must be denser than what surrounds it, above 1"
            refuse(where, f"ior is {material.ior:g}", right)
        need_numbers(where, "specular", material.specular, 0, 1, count=3)


def check_reflectance(where: str, texture: Texture) -> None:
    """Require a reflectance from 0 to 1, wherever it is read.

    Raises UsageError, which names the texture's kind and the value.

    Parameters
    ----------
    where : str; the shape that has it
    texture : Texture; a colour, a bitmap or a checker
    """
    check_texture(where, "reflectance", texture, 1.0)


def _check_facets(where: str, material: Conductor | Coated | Dielectric) -> None:
    need_numbers(where, "alpha", material.alpha)
    if material.alpha != 0 and not LEAST_ALPHA <= material.alpha <= 1:
        right = f"it must be 0 (smooth), or {LEAST_ALPHA:g} to 1"
        refuse(where, f"alpha is {material.alpha:g}", right)
    known = get_args(Distribution)
    if material.distribution not in known:
        wrong = f"distribution is {material.distribution!r}"
        refuse(where, wrong, f"known are {', '.join(known)}")


def _check_metal(where: str, metal: Conductor) -> None:
    if metal.eta is None:
        if metal.k is not None:
            refuse(where, "k is given without eta", "give both or neither")
        return
    need_numbers(where, "eta", metal.eta, count=3)
    if min(metal.eta) <= 0:
        refuse(where, f"eta is {metal.eta}", "it must be above 0 in each channel")
    if metal.k is not None:
        need_numbers(where, "k", metal.k, 0, count=3)


def _check_index(where: str, ior: float) -> None:
    need_numbers(where, "ior", ior)
    if ior <= 0:
        refuse(where, f"ior is {ior:g}", "an index of refraction is above 0")

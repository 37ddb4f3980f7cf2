"""Materials: reflectances, widths and indices within what the models mean."""

from reference.scene.checks.textures import check_texture
from reference.scene.checks.values import need_numbers, refuse
from reference.scene.materials.kinds import Coated, Conductor, Dielectric, Material
from reference.scene.textures import Texture

LEAST_ALPHA = 1e-3
"""Narrowest GGX lobe; below it, say 0 for a smooth surface."""


def check_material(where: str, material: Material) -> None:
    """Require a material that never reflects more than it receives.

    Parameters
    ----------
    where : str
        The shape that is made of it.
    material : Material
        Any kind.

    Raises
    ------
    UsageError
        Names the property.
    """
    if isinstance(material, Dielectric):
        _check_index(where, material.ior)
        return
    check_reflectance(where, material.reflectance)
    if isinstance(material, Conductor | Coated):
        need_numbers(where, "alpha", material.alpha)
        if material.alpha != 0 and not LEAST_ALPHA <= material.alpha <= 1:
            right = f"it must be 0 (smooth), or {LEAST_ALPHA:g} to 1"
            refuse(where, f"alpha is {material.alpha:g}", right)
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

    Parameters
    ----------
    where : str
        The shape that has it.
    texture : Texture
        A colour, a bitmap or a checker.

    Raises
    ------
    UsageError
        Names the texture's kind and the value.
    """
    check_texture(where, "reflectance", texture, 1.0)


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

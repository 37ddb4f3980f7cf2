"""glTF materials as ours: metal, or a diffuse base under a coat, or clear glass."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars, Vec3s
from restir_gi.reference.scene.loaders.framing import color
from restir_gi.reference.scene.loaders.gltf_buffers import Document
from restir_gi.reference.scene.loaders.gltf_check import named, replace_word
from restir_gi.reference.scene.loaders.gltf_forms import LARGEST
from restir_gi.reference.scene.loaders.gltf_textures import (
    bitmap,
    placement,
    read_alpha,
    read_colors,
    read_numbers,
)
from restir_gi.reference.scene.loaders.ledger import roughness
from restir_gi.reference.scene.materials.kinds import (
    Coated,
    Conductor,
    Dielectric,
    Lambertian,
    Material,
)
from restir_gi.reference.scene.textures import Bitmap, Texture, mean_color

PHOTOMETRIC = (
    "Light in the file is photometric (candela, lux, nit); its numbers are taken as"
    " W/sr, W/m² and W/(m² sr), as offline renderers do"
)


@dataclass(frozen=True, slots=True, eq=False)
class Finish:
    """A material as a glTF primitive wears it.

    Attributes
    ----------
    material : Material; how it scatters
    emission : Texture, W/(m² sr); radiance of the front
    two_sided_emission : bool; and of the back
    opacity : Bitmap or None; where there is a surface, as in `Mesh`
    opacity_cutoff : float; least opacity of a surface
    masked : bool; the alpha of vertex colours counts
    absent : bool; its alpha is below the cutoff everywhere
    uv_set : int; which texture coordinates its textures read
    uv_matrix : (3, 3) float64
        From these to places in the picture, in glTF's frame (v downwards).
    """

    material: Material
    emission: Texture
    two_sided_emission: bool
    opacity: Bitmap | None
    opacity_cutoff: float
    masked: bool
    absent: bool
    uv_set: int
    uv_matrix: Scalars


@dataclass(frozen=True, slots=True)
class _GltfEntry:
    """A material of the file, and what its parts are read with."""

    document: Document
    words: Mapping[str, Any]
    where: str

    @property
    def pbr(self) -> Mapping[str, Any]:
        found: Mapping[str, Any] = self.words.get("pbrMetallicRoughness", {})
        return found

    def extension(self, name: str) -> Mapping[str, Any]:
        found: Mapping[str, Any] = self.words.get("extensions", {}).get(name, {})
        return found

    def replace(self, element: str, name: str, problem: str) -> None:
        replace_word(self.document.ledger, element, name, self.where, problem)


def read_finish(document: Document, index: int | None) -> Finish:
    """Material of the file, or glTF's default.

    Parameters
    ----------
    index : int or None; of the material; ``None`` for the default, a rough white metal

    Returns
    -------
    Finish
        Metallic 1 is metal, with Schlick's Fresnel term; 0 a diffuse base under a
        clear coat.
    """
    words: Mapping[str, Any] = {}
    where = "the default material"
    if index is not None:
        words = document.entry("materials", index)
        where = named("material", document.entry("materials", index), index)
    entry = _GltfEntry(document, words, where)
    texture = entry.pbr.get("baseColorTexture")
    material = _material(entry)
    opacity, cutoff, absent = _opacity(entry)
    emission = _emission(entry)
    base_is_read = opacity is not None or not isinstance(material, Dielectric)
    uv_set, uv_matrix = placement(texture or {})
    if isinstance(emission, Bitmap):
        there = placement(words["emissiveTexture"])
        if texture is None or not base_is_read:
            uv_set, uv_matrix = there
        elif there[0] != uv_set or not np.array_equal(there[1], uv_matrix):
            name = "emissiveTexture placed unlike baseColorTexture"
            entry.replace("material", name, f"{name} is not modelled")
            emission = color(mean_color(emission))
    return Finish(
        material=material,
        emission=emission,
        two_sided_emission=bool(words.get("doubleSided", False)),
        opacity=opacity,
        opacity_cutoff=cutoff,
        masked=words.get("alphaMode", "OPAQUE") != "OPAQUE",
        absent=absent,
        uv_set=uv_set,
        uv_matrix=uv_matrix,
    )


def _material(entry: _GltfEntry) -> Material:
    metallic, rough = _metallic_roughness(entry)
    alpha = roughness(rough**2, entry.where, entry.document.ledger)
    if 0 < metallic < 1:
        name = "metallicFactor between 0 and 1"
        problem = f"metallic {metallic:.3g} is neither metal (1) nor none (0)"
        entry.replace("pbrMetallicRoughness", name, problem)
    if metallic >= 0.5:
        _note_sides(entry)
        return Conductor(_reflectance(entry), alpha=alpha, schlick=True)
    ior = float(entry.extension("KHR_materials_ior").get("ior", 1.5))
    if ior < 1:
        problem = f"an index of refraction of {ior:g} is not modelled"
        entry.replace("KHR_materials_ior", "ior below 1", problem)
    if ior > 1 and _transmits(entry):
        return Dielectric(ior, alpha)
    _note_sides(entry)
    if ior <= 1 or not _is_specular(entry):
        entry.document.ledger.note(f"{entry.where} has no coat and is matt")
        return Lambertian(_reflectance(entry))
    return Coated(_reflectance(entry), alpha=alpha, ior=ior)


def _note_sides(entry: _GltfEntry) -> None:
    if not entry.words.get("doubleSided", False):
        entry.document.ledger.note(
            "Single-sided materials of the file scatter on both sides here"
        )


def _metallic_roughness(entry: _GltfEntry) -> tuple[float, float]:
    """Both factors, times the texture's one value or else its mean."""
    metallic = float(entry.pbr.get("metallicFactor", 1.0))
    rough = float(entry.pbr.get("roughnessFactor", 1.0))
    texture = entry.pbr.get("metallicRoughnessTexture")
    if texture is None:
        return metallic, rough
    pixels = read_numbers(entry.document, texture, entry.where)
    parts = metallic * pixels[..., 2], rough * pixels[..., 1]
    if any(part.min() < part.max() for part in parts):
        name = "metallicRoughnessTexture that varies"
        entry.replace("pbrMetallicRoughness", name, f"{name} is not modelled")
        return float(parts[0].mean()), float(parts[1].mean())
    return float(parts[0].flat[0]), float(parts[1].flat[0])


def _transmits(entry: _GltfEntry) -> bool:
    """Whether it is glass; says where that is only nearly so."""
    transmission = entry.extension("KHR_materials_transmission")
    element = "KHR_materials_transmission"
    share = transmission.get("transmissionFactor", 0.0)
    if share == 0:
        return False
    if "transmissionTexture" in transmission:
        entry.replace(element, "transmissionTexture", "transmissionTexture varies")
        return False
    if share < 1:
        name = "transmissionFactor between 0 and 1"
        entry.replace(element, name, f"it transmits {share:g} of the light")
        return False
    volume = entry.extension("KHR_materials_volume")
    if volume.get("thicknessFactor", 0.0) == 0:
        problem = "it is a thin wall of glass, without thicknessFactor"
        entry.replace(element, "without thickness", problem)
    tint = volume.get("attenuationColor", [1, 1, 1])
    if "attenuationDistance" in volume and tint != [1, 1, 1]:
        problem = "light fades within the glass by its attenuationColor"
        entry.replace("KHR_materials_volume", "attenuationColor", problem)
    white = entry.pbr.get("baseColorFactor", [1, 1, 1, 1])[:3] == [1, 1, 1]
    if not white or "baseColorTexture" in entry.pbr:
        entry.replace(element, "with a base colour", "its glass has a base colour")
    return True


def _is_specular(entry: _GltfEntry) -> bool:
    """Whether it has a coat at all; says where that is weaker or coloured."""
    element = "KHR_materials_specular"
    specular = entry.extension(element)
    share = specular.get("specularFactor", 1.0)
    if share == 0:
        return False
    if share < 1:
        name = "specularFactor between 0 and 1"
        entry.replace(element, name, f"specularFactor {share:g} is not modelled")
    if specular.get("specularColorFactor", [1, 1, 1]) != [1, 1, 1]:
        problem = "specularColorFactor is not white"
        entry.replace(element, "specularColorFactor", problem)
    for name in ("specularTexture", "specularColorTexture"):
        if name in specular:
            entry.replace(element, name, f"{name} is not modelled")
    return True


def _reflectance(entry: _GltfEntry) -> Texture:
    factor = np.array(entry.pbr.get("baseColorFactor", [1, 1, 1, 1]), float)[:3]
    texture = entry.pbr.get("baseColorTexture")
    if texture is None:
        return color(factor)
    pixels = read_colors(entry.document, texture, entry.where)
    return bitmap(entry.document, texture, pixels * factor)


def _opacity(entry: _GltfEntry) -> tuple[Bitmap | None, float, bool]:
    """Mask, cutoff, and whether there is nothing to see."""
    mode = entry.words.get("alphaMode", "OPAQUE")
    cutoff = float(entry.words.get("alphaCutoff", 0.5))
    if mode == "OPAQUE":
        return None, 0.5, False
    alpha = np.full((1, 1), entry.pbr.get("baseColorFactor", [1, 1, 1, 1])[3], float)
    texture = entry.pbr.get("baseColorTexture")
    if texture is not None:
        alpha = alpha * read_alpha(entry.document, texture, entry.where)
    if mode == "BLEND":
        if alpha.min() < 1:
            problem = "alphaMode BLEND is not modelled"
            entry.replace("material", "alphaMode BLEND", problem)
        return None, 0.5, False
    if texture is None or alpha.min() >= cutoff or alpha.max() < cutoff:
        return None, 0.5, bool(alpha.max() < cutoff)
    pixels = np.repeat(alpha[..., None], 3, axis=-1)
    return bitmap(entry.document, texture, pixels), cutoff, False


def _emission(entry: _GltfEntry) -> Texture:
    factor = np.array(entry.words.get("emissiveFactor", [0, 0, 0]), float)
    strength = entry.extension("KHR_materials_emissive_strength")
    factor = factor * float(strength.get("emissiveStrength", 1.0))
    ledger = entry.document.ledger
    if not factor.any():
        return 0.0, 0.0, 0.0
    if factor.max() > LARGEST:
        problem = f"{entry.where} emits {factor.max():.3g} W/(m² sr)"
        ledger.stop(f"{problem}; up to {LARGEST:.3g} fit single precision")
    ledger.note(PHOTOMETRIC)
    texture = entry.words.get("emissiveTexture")
    if texture is None:
        return color(factor)
    pixels: Vec3s = read_colors(entry.document, texture, entry.where) * factor
    return bitmap(entry.document, texture, pixels)

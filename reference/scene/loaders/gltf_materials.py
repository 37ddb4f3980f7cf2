"""glTF materials as ours: metal, or a diffuse base under a coat, or clear glass."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from reference.arrays import Scalars, Vec3s
from reference.errors import UsageError
from reference.scene.loaders.framing import color
from reference.scene.loaders.gltf_buffers import Document, resolve_uri, view_bytes
from reference.scene.loaders.ledger import roughness
from reference.scene.loaders.pictures import decode_picture
from reference.scene.materials.kinds import (
    Coated,
    Conductor,
    Dielectric,
    Lambertian,
    Material,
)
from reference.scene.textures import Bitmap, Color

REPEAT, NEAREST = 10497, 9728
KNOWN_EXTENSIONS = {
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
}


@dataclass(frozen=True, slots=True, eq=False)
class Finish:
    """A material as a glTF primitive wears it.

    Attributes
    ----------
    material : Material
        How it scatters.
    emission : Color, W/(m² sr)
        Radiance of the front.
    uv_set : int
        Which texture coordinates the base-colour texture reads.
    uv_matrix : (3, 3) float64
        From these to places in the picture, in glTF's frame (v downwards).
    """

    material: Material
    emission: Color
    uv_set: int
    uv_matrix: Scalars


def read_finish(document: Document, index: int | None) -> Finish:
    """Material of the file, or glTF's default.

    Parameters
    ----------
    document : Document
        The file.
    index : int or None
        Of the material; ``None`` for the default, a rough white metal.

    Returns
    -------
    Finish
        Metallic from one half upwards is metal, with Schlick's Fresnel term; below,
        a diffuse base under a clear coat.
    """
    entry = {} if index is None else document.tree["materials"][index]
    where = f'material "{entry.get("name", index)}"'
    ledger = document.ledger
    extensions = entry.get("extensions", {})
    for name in sorted(extensions.keys() - KNOWN_EXTENSIONS):
        ledger.note(f"{where}: the extension {name} is ignored")
    if "KHR_materials_unlit" in extensions:
        ledger.note(f"{where} is meant to be shown unlit and is lit here")
    if entry.get("alphaMode", "OPAQUE") != "OPAQUE":
        ledger.note(f"{where}: its alpha is ignored, it is opaque")
    for name in ("normalTexture", "occlusionTexture"):
        if name in entry:
            ledger.note(f"{where}: {name} is ignored")
    pbr = entry.get("pbrMetallicRoughness", {})
    factor = np.array(pbr.get("baseColorFactor", [1, 1, 1, 1]), float)[:3]
    texture = pbr.get("baseColorTexture")
    both = bool(entry.get("doubleSided", False))
    return Finish(
        material=_material(document, pbr, extensions, factor, both, where),
        emission=_emission(document, entry, extensions, where),
        uv_set=0 if texture is None else _uv_set(texture),
        uv_matrix=_uv_matrix(texture),
    )


def _material(
    document: Document,
    pbr: Mapping[str, Any],
    extensions: Mapping[str, Any],
    factor: Vec3s,
    double_sided: bool,
    where: str,
) -> Material:
    ledger = document.ledger
    metallic = float(pbr.get("metallicFactor", 1.0))
    rough = float(pbr.get("roughnessFactor", 1.0))
    if "metallicRoughnessTexture" in pbr:
        ledger.note(
            f"{where}: metallicRoughnessTexture is replaced by its mean; roughness does"
            " not vary over a surface here"
        )
        _, rough_mean, metal_mean = _mean(
            document, pbr["metallicRoughnessTexture"], where, raw=True
        )
        metallic, rough = metallic * metal_mean, rough * rough_mean
    alpha = roughness(rough**2, where, ledger)
    ior = float(extensions.get("KHR_materials_ior", {}).get("ior", 1.5))
    transmission = extensions.get("KHR_materials_transmission", {})
    passing = float(transmission.get("transmissionFactor", 0.0))
    if passing == 1 and alpha == 0 and "transmissionTexture" not in transmission:
        ledger.note(
            f"{where} is taken as the boundary of solid, colourless, smooth glass"
        )
        return Dielectric(ior)
    if passing > 0:
        ledger.replace(
            f"{where} transmits light partly or roughly, which is not modelled"
            " (transmissionFactor 1 with roughness 0 is)",
            "taken as opaque",
        )
    reflectance: Color | Bitmap = color(factor)
    if "baseColorTexture" in pbr:
        reflectance = _bitmap(document, pbr["baseColorTexture"], factor, where)
    if not double_sided:
        ledger.note("Single-sided materials of the file scatter on both sides here")
    if 0 < metallic < 1:
        kind = "all metal" if metallic >= 0.5 else "no metal"
        ledger.note(f"{where}: metallic {metallic:.3g} is taken as {kind}")
    if metallic >= 0.5:
        return Conductor(reflectance, alpha=alpha, schlick=True)
    if ior <= 1:
        ledger.note(f"{where}: with ior {ior:g} it has no coat and is matt")
        return Lambertian(reflectance)
    return Coated(reflectance, alpha=alpha, ior=ior)


def _emission(
    document: Document,
    entry: Mapping[str, Any],
    extensions: Mapping[str, Any],
    where: str,
) -> Color:
    factor = np.array(entry.get("emissiveFactor", [0, 0, 0]), float)
    strength = extensions.get("KHR_materials_emissive_strength", {})
    factor = factor * float(strength.get("emissiveStrength", 1.0))
    if not factor.any():
        return 0.0, 0.0, 0.0
    if "emissiveTexture" in entry:
        document.ledger.note(f"{where}: emissiveTexture is replaced by its mean colour")
        factor = factor * _mean(document, entry["emissiveTexture"], where, raw=False)
    document.ledger.note(
        "Light in the file is photometric (candela, lux, nit); its numbers are taken as"
        " W/sr, W/m² and W/(m² sr), as offline renderers do"
    )
    if entry.get("doubleSided", False):
        document.ledger.note(f"{where} emits from its front only")
    return color(factor)


def _bitmap(
    document: Document, texture: Mapping[str, Any], factor: Vec3s, where: str
) -> Bitmap:
    entry = document.tree["textures"][texture["index"]]
    sampler = {}
    if "sampler" in entry:
        sampler = document.tree["samplers"][entry["sampler"]]
    if {sampler.get("wrapS", REPEAT), sampler.get("wrapT", REPEAT)} != {REPEAT}:
        document.ledger.note(f"{where}: its texture repeats beyond its edges")
    return Bitmap(
        pixels=_pixels(document, texture, where, raw=False) * factor,
        filter="nearest" if sampler.get("magFilter") == NEAREST else "bilinear",
    )


def _mean(
    document: Document, texture: Mapping[str, Any], where: str, raw: bool
) -> Vec3s:
    mean: Vec3s = _pixels(document, texture, where, raw).mean(axis=(0, 1))
    return mean


def _pixels(
    document: Document, texture: Mapping[str, Any], where: str, raw: bool
) -> Vec3s:
    entry = document.tree["textures"][texture["index"]]
    webp = entry.get("extensions", {}).get("EXT_texture_webp", {})
    source = webp.get("source", entry.get("source"))
    image = document.tree["images"][source]
    name = image.get("uri", f"image {source}")
    name = f"{where}, texture {name if len(name) < 100 else f'image {source}'}"
    try:
        if "bufferView" in image:
            contents = view_bytes(document, image["bufferView"])
        else:
            contents = resolve_uri(image["uri"], document.ledger)
        return decode_picture(contents, name, document.ledger, raw)
    except UsageError as error:
        document.ledger.replace(f"{where}: {error}", "taken as mid grey")
        return np.full((1, 1, 3), 0.5)


def _uv_set(texture: Mapping[str, Any]) -> int:
    transform = texture.get("extensions", {}).get("KHR_texture_transform", {})
    return int(transform.get("texCoord", texture.get("texCoord", 0)))


def _uv_matrix(texture: Mapping[str, Any] | None) -> Scalars:
    """KHR_texture_transform: translation · rotation · scale."""
    given = (texture or {}).get("extensions", {}).get("KHR_texture_transform", {})
    offset = given.get("offset", [0.0, 0.0])
    scale = given.get("scale", [1.0, 1.0])
    c, s = np.cos(given.get("rotation", 0.0)), np.sin(given.get("rotation", 0.0))
    turned = np.array([[c, s], [-s, c]]) * scale
    return np.block([[turned, np.reshape(offset, (2, 1))], [np.eye(3)[2:]]])

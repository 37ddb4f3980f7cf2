"""Every word of glTF 2.0 and of its extensions, and what becomes of it.

The loader decides by this table: :mod:`restir_gi.reference.scene.loaders.gltf_check`
compares the whole JSON with it before anything else is read, and refuses words that are
not in it.
"""

from dataclasses import dataclass
from typing import Any

from restir_gi.reference.scene.loaders.gltf_forms import (
    Anything,
    ChoiceForm,
    Flag,
    Form,
    Index,
    Indexes,
    Many,
    NumberForm,
    NumbersForm,
    One,
    Text,
    Texts,
)
from restir_gi.reference.scene.loaders.words import Use, Word

MODELLED, HARMLESS = Use.MODELLED, Use.HARMLESS
REPLACED, REFUSED = Use.REPLACED, Use.REFUSED

SIZE = NumberForm(0, 2.0**53, whole=True)
POSITIVE = NumberForm(1e-30)
SHARE, SHARES = NumberForm(0, 1), NumbersForm(3, 0, 1)
LIGHT = NumbersForm(3, 0)
WRAPS = (10497, 33071, 33648)
SAME_PICTURE = "the texture's own source shows the same picture"
OTHER_RENDERERS = "a hint for other kinds of renderers"


@dataclass(frozen=True, slots=True)
class GltfWord(Word):
    """A word of glTF.

    Attributes
    ----------
    form : Form; what its value must be
    needed : bool; the file is broken without it
    neutral : tuple; values with which it changes nothing, although it is not modelled
    judged : bool
        Whether it is replaced depends on more than its value: the reader of its
        element finds out.
    """

    form: Form = Anything()  # noqa: RUF009
    needed: bool = False
    neutral: tuple[Any, ...] = ()
    judged: bool = False


def _names(*elements: str) -> tuple[GltfWord, ...]:
    return tuple(GltfWord(each, "name", HARMLESS, form=Text()) for each in elements)


W = GltfWord

FILE = (
    W("file", "asset", MODELLED, form=One("asset"), needed=True),
    W("file", "extensionsUsed", MODELLED, form=Texts()),
    W("file", "extensionsRequired", MODELLED, form=Texts()),
    W("file", "scene", MODELLED, form=Index("scenes")),
    W("file", "scenes", MODELLED, "the default scene", form=Many("scene")),
    W("file", "nodes", MODELLED, form=Many("node")),
    W("file", "cameras", MODELLED, form=Many("camera")),
    W("file", "meshes", MODELLED, form=Many("mesh")),
    W("file", "materials", MODELLED, "those that meshes wear", form=Many("material")),
    W("file", "textures", MODELLED, form=Many("texture")),
    W("file", "samplers", MODELLED, form=Many("sampler")),
    W("file", "images", MODELLED, form=Many("image")),
    W("file", "accessors", MODELLED, form=Many("accessor")),
    W("file", "bufferViews", MODELLED, form=Many("buffer view")),
    W("file", "buffers", MODELLED, form=Many("buffer")),
    W("file", "animations", HARMLESS, "noted: all stands at rest"),
    W("file", "skins", HARMLESS, "unless a node has one"),
    W("asset", "version", MODELLED, "2.x", form=Text(), needed=True),
    W("asset", "minVersion", MODELLED, "2.0", form=Text(("2.0",))),
    W("asset", "generator", HARMLESS),
    W("asset", "copyright", HARMLESS),
    W("scene", "nodes", MODELLED, form=Indexes("nodes")),
)

NODES = (
    W("node", "camera", MODELLED, form=Index("cameras")),
    W("node", "children", MODELLED, form=Indexes("nodes")),
    W("node", "mesh", MODELLED, form=Index("meshes")),
    W("node", "matrix", MODELLED, form=NumbersForm(16)),
    W("node", "rotation", MODELLED, form=NumbersForm(4)),
    W("node", "scale", MODELLED, form=NumbersForm(3)),
    W("node", "translation", MODELLED, form=NumbersForm(3)),
    W("node", "skin", REPLACED, "the mesh stands where its node is", form=Anything()),
    W("node", "weights", REPLACED, "its morph targets are ignored",
      form=NumbersForm(0), judged=True),
    W("camera", "type", MODELLED, form=Text(("perspective", "orthographic")),
      needed=True),
    W("camera", "perspective", MODELLED, "of the first such camera",
      form=One("perspective camera")),
    W("camera", "orthographic", REPLACED, "the camera is ignored", judged=True),
    W("perspective camera", "yfov", MODELLED, form=NumberForm(1e-6, 3.1415926),
      needed=True),
    W("perspective camera", "aspectRatio", MODELLED, form=POSITIVE),
    W("perspective camera", "znear", HARMLESS, OTHER_RENDERERS),
    W("perspective camera", "zfar", HARMLESS, OTHER_RENDERERS),
)  # fmt: skip

MESHES = (
    W("mesh", "primitives", MODELLED, form=Many("primitive"), needed=True),
    W("mesh", "weights", REPLACED, "its morph targets are ignored",
      form=NumbersForm(0), judged=True),
    W("primitive", "attributes", MODELLED, form=One("attribute"), needed=True),
    W("primitive", "indices", MODELLED, form=Index("accessors")),
    W("primitive", "material", MODELLED, form=Index("materials")),
    W("primitive", "mode", MODELLED, "triangles, strips and fans; points and lines have"
      " no surface and are left out, with a note", form=ChoiceForm(tuple(range(7)))),
    W("primitive", "targets", HARMLESS, "unless there are weights"),
    W("attribute", "POSITION", MODELLED, form=Index("accessors")),
    W("attribute", "NORMAL", MODELLED, form=Index("accessors")),
    W("attribute", "TEXCOORD_n", MODELLED, "those that the textures of the material"
      " read", form=Index("accessors")),
    W("attribute", "COLOR_0", MODELLED, form=Index("accessors")),
    W("attribute", "COLOR_0 with alpha", REPLACED, "its alpha is taken as 1",
      judged=True),
    W("attribute", "COLOR_0 outside of 0 to 1", REPLACED, "clamped", judged=True),
    W("attribute", "COLOR_0 on glass", REPLACED, "the glass is colourless",
      judged=True),
    W("attribute", "COLOR_n", HARMLESS, "n above 0: glTF gives it no meaning",
      form=Index("accessors")),
    W("attribute", "TANGENT", HARMLESS, "for normal maps alone"),
    W("attribute", "JOINTS_n", HARMLESS, "unless the node has a skin"),
    W("attribute", "WEIGHTS_n", HARMLESS, "unless the node has a skin"),
    W("attribute", "_*", HARMLESS, "of other programs"),
)  # fmt: skip

MATERIALS = (
    W("material", "pbrMetallicRoughness", MODELLED, form=One("pbrMetallicRoughness")),
    W("material", "emissiveFactor", MODELLED, form=LIGHT),
    W("material", "emissiveTexture", MODELLED, form=One("texture reference")),
    W("material", "emissiveTexture placed unlike baseColorTexture", REPLACED,
      "its mean colour", judged=True),
    W("material", "doubleSided", MODELLED, "emission leaves both faces; every face"
      " scatters on both sides (noted where it is false)", form=Flag()),
    W("material", "alphaMode", MODELLED, "OPAQUE and MASK, and BLEND where alpha is 1",
      form=Text(("OPAQUE", "MASK", "BLEND"))),
    W("material", "alphaMode BLEND", REPLACED, "taken as opaque", judged=True),
    W("material", "alphaCutoff", MODELLED, form=NumberForm(0)),
    W("material", "normalTexture", REPLACED, "the surface is smooth"),
    W("material", "occlusionTexture", HARMLESS, "occlusion is computed"),
    W("pbrMetallicRoughness", "baseColorFactor", MODELLED, form=NumbersForm(4, 0, 1)),
    W("pbrMetallicRoughness", "baseColorTexture", MODELLED,
      form=One("texture reference")),
    W("pbrMetallicRoughness", "metallicFactor", MODELLED, "1 is metal, 0 a diffuse base"
      " under a clear coat", form=SHARE),
    W("pbrMetallicRoughness", "metallicFactor between 0 and 1", REPLACED,
      "taken as the nearer of the two", judged=True),
    W("pbrMetallicRoughness", "roughnessFactor", MODELLED, "GGX of alpha = roughness²;"
      " below 1e-3 smooth (noted)", form=SHARE),
    W("pbrMetallicRoughness", "metallicRoughnessTexture", MODELLED, "of one value",
      form=One("texture reference")),
    W("pbrMetallicRoughness", "metallicRoughnessTexture that varies", REPLACED,
      "its mean", judged=True),
    W("texture reference", "index", MODELLED, form=Index("textures"), needed=True),
    W("texture reference", "texCoord", MODELLED, form=SIZE),
    W("texture", "source", MODELLED, form=Index("images")),
    W("texture", "no source that can be read", REPLACED, "taken as mid grey",
      judged=True),
    W("texture", "sampler", MODELLED, form=Index("samplers")),
    W("sampler", "magFilter", MODELLED, form=ChoiceForm((9728, 9729))),
    W("sampler", "minFilter", HARMLESS, "pictures are read at full resolution"),
    W("sampler", "wrapS", MODELLED, form=ChoiceForm(WRAPS)),
    W("sampler", "wrapT", MODELLED, form=ChoiceForm(WRAPS)),
    W("image", "uri", MODELLED, "a file or data", form=Text()),
    W("image", "bufferView", MODELLED, form=Index("bufferViews")),
    W("image", "mimeType", HARMLESS, "the bytes tell"),
)  # fmt: skip

BUFFERS = (
    W("accessor", "bufferView", MODELLED, form=Index("bufferViews")),
    W("accessor", "byteOffset", MODELLED, form=SIZE),
    W("accessor", "componentType", MODELLED, needed=True,
      form=ChoiceForm((5120, 5121, 5122, 5123, 5125, 5126))),
    W("accessor", "normalized", MODELLED, form=Flag()),
    W("accessor", "count", MODELLED, form=SIZE, needed=True),
    W("accessor", "type", MODELLED, needed=True,
      form=Text(("SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"))),
    W("accessor", "sparse", MODELLED, form=One("sparse accessor")),
    W("accessor", "min", HARMLESS, "of what the buffer holds anyway"),
    W("accessor", "max", HARMLESS, "of what the buffer holds anyway"),
    W("sparse accessor", "count", MODELLED, form=SIZE, needed=True),
    W("sparse accessor", "indices", MODELLED, form=One("sparse indices"), needed=True),
    W("sparse accessor", "values", MODELLED, form=One("sparse values"), needed=True),
    W("sparse indices", "bufferView", MODELLED, form=Index("bufferViews"), needed=True),
    W("sparse indices", "byteOffset", MODELLED, form=SIZE),
    W("sparse indices", "componentType", MODELLED, form=ChoiceForm((5121, 5123, 5125)),
      needed=True),
    W("sparse values", "bufferView", MODELLED, form=Index("bufferViews"), needed=True),
    W("sparse values", "byteOffset", MODELLED, form=SIZE),
    W("buffer view", "buffer", MODELLED, form=Index("buffers"), needed=True),
    W("buffer view", "byteOffset", MODELLED, form=SIZE),
    W("buffer view", "byteLength", MODELLED, form=SIZE, needed=True),
    W("buffer view", "byteStride", MODELLED, form=NumberForm(1, 65535, whole=True)),
    W("buffer view", "target", HARMLESS, OTHER_RENDERERS),
    W("buffer", "uri", MODELLED, "a file or data", form=Text()),
    W("buffer", "byteLength", MODELLED, form=SIZE, needed=True),
)  # fmt: skip

LIGHTS = (
    W("extension", "KHR_lights_punctual", MODELLED),
    W("KHR_lights_punctual", "lights", MODELLED, form=Many("light")),
    W("KHR_lights_punctual", "light", MODELLED, form=Index("lights")),
    W("light", "type", MODELLED, form=Text(("directional", "point", "spot")),
      needed=True),
    W("light", "color", MODELLED, form=LIGHT),
    W("light", "intensity", MODELLED, "photometric numbers as radiometric ones (noted)",
      form=NumberForm(0)),
    W("light", "spot", MODELLED, form=One("spot")),
    W("light", "range", REPLACED, "it falls off with 1/d² alone",
      form=POSITIVE, judged=True),
    W("spot", "innerConeAngle", MODELLED, form=NumberForm(0, 1.5707964)),
    W("spot", "outerConeAngle", MODELLED, form=NumberForm(1e-6, 1.5707964)),
)  # fmt: skip

MATERIAL_EXTENSIONS = (
    W("extension", "KHR_materials_emissive_strength", MODELLED),
    W(
        "KHR_materials_emissive_strength",
        "emissiveStrength",
        MODELLED,
        form=NumberForm(0),
    ),
    W("extension", "KHR_materials_ior", MODELLED),
    W("KHR_materials_ior", "ior", MODELLED, "at 1 without a coat", form=NumberForm(0)),
    W("KHR_materials_ior", "ior below 1", REPLACED, "without a coat", judged=True),
    W("extension", "KHR_materials_specular", MODELLED, "all, or nothing at all"),
    W("KHR_materials_specular", "specularFactor", MODELLED, "0 (matt) or 1",
      form=SHARE),
    W("KHR_materials_specular", "specularFactor between 0 and 1", REPLACED,
      "taken as 1", judged=True),
    W("KHR_materials_specular", "specularTexture", REPLACED, "taken as 1",
      form=One("texture reference"), judged=True),
    W("KHR_materials_specular", "specularColorFactor", REPLACED, "taken as white",
      form=LIGHT, neutral=([1, 1, 1],), judged=True),
    W("KHR_materials_specular", "specularColorTexture", REPLACED, "taken as white",
      form=One("texture reference"), judged=True),
    W("extension", "KHR_materials_transmission", MODELLED, "all, or nothing at all"),
    W("KHR_materials_transmission", "transmissionFactor", MODELLED, "0 or 1: glass,"
      " smooth or rough", form=SHARE),
    W("KHR_materials_transmission", "transmissionFactor between 0 and 1", REPLACED,
      "taken as opaque", judged=True),
    W("KHR_materials_transmission", "transmissionTexture", REPLACED, "taken as opaque",
      form=One("texture reference"), judged=True),
    W("KHR_materials_transmission", "without thickness", REPLACED,
      "taken as the boundary of solid glass", judged=True),
    W("KHR_materials_transmission", "with a base colour", REPLACED,
      "taken as colourless", judged=True),
    W("extension", "KHR_materials_volume", MODELLED),
    W("KHR_materials_volume", "thicknessFactor", MODELLED, "0 is a thin wall, else the"
      " mesh bounds a solid", form=NumberForm(0)),
    W("KHR_materials_volume", "thicknessTexture", HARMLESS,
      "the mesh itself has a thickness"),
    W("KHR_materials_volume", "attenuationDistance", MODELLED, "with white",
      form=POSITIVE),
    W("KHR_materials_volume", "attenuationColor", REPLACED, "taken as white",
      form=SHARES, judged=True),
    W("extension", "KHR_materials_dispersion", REPLACED, "one index of refraction"),
    W("KHR_materials_dispersion", "dispersion", REPLACED, "one index of refraction",
      form=NumberForm(0), neutral=(0,)),
    W("extension", "KHR_materials_clearcoat", REPLACED, "without that coat"),
    W("KHR_materials_clearcoat", "clearcoatFactor", REPLACED, "without that coat",
      form=SHARE, neutral=(0,)),
    W("KHR_materials_clearcoat", "clearcoatTexture", HARMLESS, "a factor on"
      " clearcoatFactor"),
    W("KHR_materials_clearcoat", "clearcoatRoughnessFactor", HARMLESS, "of the coat"),
    W("KHR_materials_clearcoat", "clearcoatRoughnessTexture", HARMLESS, "of the coat"),
    W("KHR_materials_clearcoat", "clearcoatNormalTexture", HARMLESS, "of the coat"),
    W("extension", "KHR_materials_sheen", REPLACED, "without sheen"),
    W("KHR_materials_sheen", "sheenColorFactor", REPLACED, "without sheen",
      form=SHARES, neutral=([0, 0, 0],)),
    W("KHR_materials_sheen", "sheenColorTexture", HARMLESS, "a factor on"
      " sheenColorFactor"),
    W("KHR_materials_sheen", "sheenRoughnessFactor", HARMLESS, "of the sheen"),
    W("KHR_materials_sheen", "sheenRoughnessTexture", HARMLESS, "of the sheen"),
    W("extension", "KHR_materials_anisotropy", REPLACED, "isotropic"),
    W("KHR_materials_anisotropy", "anisotropyStrength", REPLACED, "isotropic",
      form=SHARE, neutral=(0,)),
    W("KHR_materials_anisotropy", "anisotropyRotation", HARMLESS, "of the anisotropy"),
    W("KHR_materials_anisotropy", "anisotropyTexture", HARMLESS, "a factor on"
      " anisotropyStrength"),
    W("extension", "KHR_materials_iridescence", REPLACED, "without iridescence"),
    W("KHR_materials_iridescence", "iridescenceFactor", REPLACED,
      "without iridescence", form=SHARE, neutral=(0,)),
    W("KHR_materials_iridescence", "iridescenceTexture", HARMLESS, "a factor on"
      " iridescenceFactor"),
    W("KHR_materials_iridescence", "iridescenceIor", HARMLESS, "of the film"),
    W("KHR_materials_iridescence", "iridescenceThicknessMinimum", HARMLESS,
      "of the film"),
    W("KHR_materials_iridescence", "iridescenceThicknessMaximum", HARMLESS,
      "of the film"),
    W("KHR_materials_iridescence", "iridescenceThicknessTexture", HARMLESS,
      "of the film"),
    W("extension", "KHR_materials_diffuse_transmission", REPLACED, "taken as opaque"),
    W("KHR_materials_diffuse_transmission", "diffuseTransmissionFactor", REPLACED,
      "taken as opaque", form=SHARE, neutral=(0,)),
    W("KHR_materials_diffuse_transmission", "diffuseTransmissionTexture", HARMLESS,
      "a factor on diffuseTransmissionFactor"),
    W("KHR_materials_diffuse_transmission", "diffuseTransmissionColorFactor", HARMLESS,
      "a factor on diffuseTransmissionFactor"),
    W("KHR_materials_diffuse_transmission", "diffuseTransmissionColorTexture", HARMLESS,
      "a factor on diffuseTransmissionFactor"),
    W("extension", "KHR_materials_unlit", REPLACED, "lit as other materials"),
    W("extension", "KHR_materials_pbrSpecularGlossiness", REPLACED,
      "its pbrMetallicRoughness"),
    W("extension", "KHR_materials_variants", HARMLESS, "materials are the default"),
)  # fmt: skip

OTHER_EXTENSIONS = (
    W("extension", "KHR_texture_transform", MODELLED),
    W("KHR_texture_transform", "offset", MODELLED, form=NumbersForm(2)),
    W("KHR_texture_transform", "rotation", MODELLED, form=NumberForm()),
    W("KHR_texture_transform", "scale", MODELLED, form=NumbersForm(2)),
    W("KHR_texture_transform", "texCoord", MODELLED, form=SIZE),
    W("extension", "EXT_texture_webp", MODELLED),
    W("EXT_texture_webp", "source", MODELLED, form=Index("images")),
    W("extension", "KHR_texture_basisu", HARMLESS, SAME_PICTURE),
    W("extension", "EXT_texture_avif", HARMLESS, SAME_PICTURE),
    W("extension", "MSFT_texture_dds", HARMLESS, SAME_PICTURE),
    W("extension", "KHR_mesh_quantization", MODELLED),
    W("extension", "EXT_mesh_gpu_instancing", MODELLED),
    W("EXT_mesh_gpu_instancing", "attributes", MODELLED, form=One("instance attribute"),
      needed=True),
    W("instance attribute", "TRANSLATION", MODELLED, form=Index("accessors")),
    W("instance attribute", "ROTATION", MODELLED, form=Index("accessors")),
    W("instance attribute", "SCALE", MODELLED, form=Index("accessors")),
    W("instance attribute", "_*", HARMLESS, "of other programs"),
    W("extension", "KHR_draco_mesh_compression", REFUSED, "save the file without"),
    W("extension", "EXT_meshopt_compression", REFUSED, "save the file without"),
    W("extension", "KHR_meshopt_compression", REFUSED, "save the file without"),
    W("extension", "KHR_node_visibility", REPLACED, "shown all the same"),
    W("KHR_node_visibility", "visible", REPLACED, "shown all the same",
      form=Flag(), neutral=(True,)),
    W("extension", "EXT_lights_image_based", REPLACED, "without that light"),
    W("extension", "EXT_lights_ies", REPLACED, "the same in all directions"),
    W("extension", "KHR_animation_pointer", HARMLESS, "all stands at rest"),
    W("extension", "KHR_xmp", HARMLESS, "words about the file"),
    W("extension", "KHR_xmp_json_ld", HARMLESS, "words about the file"),
    W("extension", "EXT_mesh_features", HARMLESS, "words about parts of the file"),
    W("extension", "EXT_instance_features", HARMLESS, "words about parts of the file"),
    W("extension", "EXT_structural_metadata", HARMLESS,
      "words about parts of the file"),
    W("extension", "MSFT_lod", HARMLESS, "the finest level is shown"),
)  # fmt: skip

WORDS: tuple[GltfWord, ...] = (
    *FILE,
    *NODES,
    *MESHES,
    *MATERIALS,
    *BUFFERS,
    *LIGHTS,
    *MATERIAL_EXTENSIONS,
    *OTHER_EXTENSIONS,
    *_names("scene", "node", "camera", "mesh", "material", "texture", "sampler"),
    *_names("image", "accessor", "buffer view", "buffer", "light"),
)
"""All of them; ``extras``, of other programs, may stand in every element."""

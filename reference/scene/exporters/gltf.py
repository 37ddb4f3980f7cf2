"""A scene as glTF 2.0: a .gltf file, and the numbers of its meshes in a .bin file.

Light is written in the numbers that it has: W/sr, W/m² and W/(m² sr) stand for glTF's
candela, lux and nit, as the loader takes them.
"""

import json
from collections.abc import Iterator
from math import atan, frexp
from typing import Any

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.scene.camera import Camera
from restir_gi.reference.scene.exporters.triangles import in_world
from restir_gi.reference.scene.exporters.unsaid import unsaid_in_both
from restir_gi.reference.scene.lights import DirectionalLight, PointLight
from restir_gi.reference.scene.materials.kinds import (
    Coated,
    Conductor,
    Lambertian,
    Material,
)
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.shapes import Mesh, emits
from restir_gi.reference.scene.textures import Color, Pattern

FLOAT, UINT = 5126, 5125
VERTICES, INDICES = 34962, 34963
TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3"}
WHITE = (1.0, 1.0, 1.0)

Json = dict[str, Any]


def gltf_unsaid(scene: Scene) -> Iterator[str]:
    """What glTF cannot say of a scene, a clause each; nothing if it can say it all."""
    yield from unsaid_in_both(scene)
    shines = any(map(emits, scene.meshes)) or any(map(emits, scene.spheres))
    if scene.environment is not None:
        yield "glTF has no environment"
    elif not (scene.lamps or scene.suns or shines):
        yield "nothing shines, and readers of glTF light a scene without light"
    for sphere in scene.spheres:
        yield f'"{sphere.name}" is a sphere, and glTF has only triangles'
    for mesh in scene.meshes:
        for clause in _material_unsaid(mesh.material):
            yield f'"{mesh.name}" {clause}'


def _material_unsaid(material: Material) -> Iterator[str]:
    if isinstance(material, Lambertian | Conductor | Coated):
        if isinstance(material.reflectance, Pattern):
            yield "has a checker whose colours 8 bits of a picture would round"
        if not material.two_sided:
            yield "is black on its back, and glTF's materials are not"
    if isinstance(material, Lambertian):
        return
    if material.alpha > 0 and material.distribution == "beckmann":
        yield "has microfacets of Beckmann, and glTF has those of GGX"
    if isinstance(material, Conductor) and not material.schlick:
        yield "is metal without Schlick's Fresnel term, and glTF's metal has it"
    if isinstance(material, Coated) and material.nonlinear:
        yield "has a base that takes on its colour at each turn, and glTF has none"
    if isinstance(material, Coated) and material.specular != WHITE:
        yield "has a coloured coat, which is not exported"


def gltf_files(scene: Scene) -> dict[str, bytes]:
    """Contents of the files of a scene of which `gltf_unsaid` says nothing, by name.

    Parameters
    ----------
    scene : Scene; validated
    """
    writer = _Writer()
    for mesh in scene.meshes:
        writer.mesh(mesh)
    writer.camera(scene.camera)
    for point in scene.points:
        writer.light(point)
    for sun in scene.suns:
        writer.light(sun)
    return writer.files(scene.name)


class _Writer:
    """A file in the making: the tree, and the bytes beside it."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.tree: Json = {
            "asset": {"version": "2.0", "generator": "restir-gi-oracle"},
            "scene": 0,
            "scenes": [{"nodes": []}],
        }
        self.materials: dict[str, int] = {}
        self.extensions: set[str] = set()

    def add(self, name: str, entry: Json) -> int:
        """Append to one of the lists of the file; its number there."""
        entries: list[Json] = self.tree.setdefault(name, [])
        entries.append(entry)
        return len(entries) - 1

    def node(self, entry: Json) -> None:
        self.tree["scenes"][0]["nodes"].append(self.add("nodes", entry))

    def accessor(self, values: Scalars, kind: int, target: int, **more: Any) -> int:
        contents = values.astype("<u4" if kind == UINT else "<f4").tobytes()
        view = {"buffer": 0, "byteOffset": len(self.data)}
        view |= {"byteLength": len(contents), "target": target}
        self.data += contents  # of four bytes a number: the next begins at a multiple
        entry = {
            "bufferView": self.add("bufferViews", view),
            "componentType": kind,
            "count": len(values),
            "type": TYPES[values.reshape(len(values), -1).shape[1]],
        }
        return self.add("accessors", entry | more)

    def mesh(self, mesh: Mesh) -> None:
        mesh = in_world(mesh)
        corners = mesh.vertices.astype(np.float32)
        low, high = (bound.tolist() for bound in (corners.min(0), corners.max(0)))
        attributes = {
            "POSITION": self.accessor(corners, FLOAT, VERTICES, min=low, max=high)
        }
        if mesh.normals is not None:
            attributes["NORMAL"] = self.accessor(mesh.normals, FLOAT, VERTICES)
        if mesh.uv is not None:
            # glTF counts v from the top of a picture, we from its bottom.
            u, v = mesh.uv.T
            uv = np.stack([u, 1 - v], axis=-1)
            attributes["TEXCOORD_0"] = self.accessor(uv, FLOAT, VERTICES)
        primitive = {
            "attributes": attributes,
            "indices": self.accessor(mesh.faces.ravel(), UINT, INDICES),
            "material": self.material(mesh, np.ptp(corners, axis=0)),
        }
        entry = {"name": mesh.name, "primitives": [primitive]}
        self.node({"name": mesh.name, "mesh": self.add("meshes", entry)})

    def material(self, mesh: Mesh, size: Scalars) -> int:
        """Number of a material; meshes that look the same share one."""
        # Who emits from one side says so by being single-sided.
        both = mesh.two_sided_emission or not emits(mesh)
        pbr, extensions = _scattering(mesh.material, size)
        entry: Json = {"doubleSided": both, "pbrMetallicRoughness": pbr}
        if emits(mesh):
            assert not isinstance(mesh.emission, Pattern)
            factor, strength = _parted(mesh.emission)
            entry["emissiveFactor"] = factor
            if strength != 1:
                name = "KHR_materials_emissive_strength"
                extensions[name] = {"emissiveStrength": strength}
        if extensions:
            entry["extensions"] = extensions
        self.extensions.update(extensions)
        key = json.dumps(entry, sort_keys=True)
        if key not in self.materials:
            self.materials[key] = self.add("materials", {"name": mesh.name, **entry})
        return self.materials[key]

    def camera(self, camera: Camera) -> None:
        tangent = camera.half_width * camera.height / camera.width
        lens = {
            "type": "perspective",
            "perspective": {
                "aspectRatio": camera.width / camera.height,
                "yfov": 2 * atan(tangent),
                "znear": 1e-3,  # of other renderers: a pinhole sees all
            },
        }
        right, up, forward = camera.axes
        matrix = np.eye(4)
        matrix[:3, :3] = np.stack([right, up, -forward], axis=-1)
        matrix[:3, 3] = camera.position
        self.node({"camera": self.add("cameras", lens), "matrix": _columns(matrix)})

    def light(self, light: PointLight | DirectionalLight) -> None:
        matrix = np.eye(4)
        if isinstance(light, PointLight):
            kind, strength = "point", light.intensity
            matrix[:3, 3] = light.position
        else:
            kind, strength = "directional", light.irradiance
            matrix[:3, :3] = _away_from(np.array(light.direction))
        factor, intensity = _parted(strength)
        entry = {"type": kind, "color": factor, "intensity": intensity}
        name = "KHR_lights_punctual"
        extension: Json = self.tree.setdefault("extensions", {}).setdefault(
            name, {"lights": []}
        )
        extension["lights"].append(entry)
        self.extensions.add(name)
        number = {"light": len(extension["lights"]) - 1}
        self.node({"matrix": _columns(matrix), "extensions": {name: number}})

    def files(self, name: str) -> dict[str, bytes]:
        if self.extensions:
            self.tree["extensionsUsed"] = sorted(self.extensions)
        if self.data:
            buffer = {"uri": f"{name}.bin", "byteLength": len(self.data)}
            self.tree["buffers"] = [buffer]
        text = json.dumps(self.tree, indent=1, allow_nan=False) + "\n"
        return {f"{name}.bin": bytes(self.data), f"{name}.gltf": text.encode()}


def _scattering(material: Material, size: Scalars) -> tuple[Json, Json]:
    extensions: Json = {}
    reflectance: Any = WHITE
    metallic, alpha = 0.0, 1.0
    if isinstance(material, Lambertian):
        reflectance = material.reflectance
        extensions["KHR_materials_specular"] = {"specularFactor": 0.0}
    elif isinstance(material, Conductor):
        reflectance, metallic, alpha = material.reflectance, 1.0, material.alpha
    else:
        alpha = material.alpha
        extensions["KHR_materials_ior"] = {"ior": material.ior}
        if isinstance(material, Coated):
            reflectance = material.reflectance
        else:
            extensions["KHR_materials_transmission"] = {"transmissionFactor": 1.0}
            # Of a closed mesh, and for renderers that do not trace rays.
            thickness = float(size.min()) or float(size.max())
            extensions["KHR_materials_volume"] = {"thicknessFactor": thickness}
    pbr = {
        "baseColorFactor": [*reflectance, 1.0],
        "metallicFactor": metallic,
        "roughnessFactor": alpha**0.5,
    }
    return pbr, extensions


def _parted(color: Color) -> tuple[list[float], float]:
    """Factors in [0, 1], and a power of two to multiply them with: exact."""
    _, exponent = frexp(max(color))
    strength = 2.0 ** max(exponent, 0)
    return [part / strength for part in color], strength


def _away_from(direction: Scalars) -> Scalars:
    """Rotation of a node whose light shines along its own -z, (3, 3)."""
    back = -direction
    aside = np.eye(3)[np.argmin(np.abs(back))]
    right = np.cross(aside, back)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(back, right), back], axis=-1)


def _columns(matrix: Scalars) -> list[float]:
    numbers: list[float] = matrix.T.ravel().tolist()
    return numbers

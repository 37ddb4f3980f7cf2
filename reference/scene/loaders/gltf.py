"""glTF 2.0 (.gltf, .glb): nodes, meshes, cameras and lights.

The file is decoded here and not by a library: trimesh's reader fills sparse accessors
with zeros, takes normalized integers for floats, drops what hangs on a camera's node,
and derives the horizontal angle of view by proportion, all without a word; pygltflib
drops the words that it does not know, which are what has to be told, and holds nothing
against the bytes of the buffers.
"""

from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars, normalize
from restir_gi.reference.scene.camera import Camera
from restir_gi.reference.scene.loaders.framing import (
    camera_or_framing,
    color,
    default_environment,
)
from restir_gi.reference.scene.loaders.gltf_buffers import Document, read_document
from restir_gi.reference.scene.loaders.gltf_check import (
    check_words,
    named,
    replace_word,
)
from restir_gi.reference.scene.loaders.gltf_forms import printable
from restir_gi.reference.scene.loaders.gltf_lights import GltfLights, add_light
from restir_gi.reference.scene.loaders.gltf_materials import Finish, read_finish
from restir_gi.reference.scene.loaders.gltf_meshes import (
    SURFACES,
    PlacedPrimitive,
    read_primitive,
)
from restir_gi.reference.scene.loaders.gltf_nodes import instances, nodes
from restir_gi.reference.scene.loaders.ledger import Ledger
from restir_gi.reference.scene.scene import Scene

LONG_SIDE = 256  # pixels; a glTF camera knows the shape of its image, not the size


@dataclass(slots=True)
class _Parts:
    """What hangs in the tree, before any accessor is read."""

    placed: list[PlacedPrimitive] = field(default_factory=list)
    cameras: list[Camera] = field(default_factory=list)
    lights: GltfLights = field(default_factory=GltfLights)


def load(ledger: Ledger) -> Scene:
    """Default scene of a glTF file, all in the world; see the notes.

    Raises UsageError: not glTF 2, truncated, or (unless lenient) with something not
    modelled.

    Parameters
    ----------
    ledger : Ledger; of the file: .gltf with its buffers, or .glb
    """
    document = read_document(ledger)
    check_words(document.tree, ledger)
    parts = _collect(document)
    ledger.settle()
    meshes = tuple(
        mesh for placed in parts.placed if (mesh := read_primitive(document, placed))
    )
    if "animations" in document.tree:
        ledger.note("Animations are ignored: all stands in its rest pose")
    camera = parts.cameras[0] if parts.cameras else None
    lights = parts.lights
    scene = Scene(
        name=ledger.path.stem,
        camera=camera_or_framing(camera, meshes, (), ledger),
        meshes=meshes,
        points=tuple(lights.points),
        spots=tuple(lights.spots),
        suns=tuple(lights.suns),
    )
    environment = default_environment(scene, ledger)
    ledger.settle()
    return replace(scene, environment=environment, notes=tuple(ledger.notes))


def _collect(document: Document) -> _Parts:
    @cache
    def finish(index: int | None) -> Finish:
        return read_finish(document, index)

    parts, orthographic = _Parts(), []
    for where, node, matrix in nodes(document):
        if "mesh" in node:
            mesh = document.entry("meshes", node["mesh"])
            _check_morphs(node, mesh, where, document.ledger)
            name = node.get("name", mesh.get("name", f"mesh {node['mesh']}"))
            stands = instances(document, where, node, matrix)
            for i, primitive in enumerate(mesh["primitives"]):
                label = name if len(mesh["primitives"]) == 1 else f"{name}.{i}"
                label = printable(label[:200])
                if primitive.get("mode", 4) not in SURFACES:
                    told = f'Mesh "{label}": its points or lines are left out'
                    document.ledger.note(f"{told}, they have no surface")
                    continue
                worn = finish(primitive.get("material"))
                if not worn.absent:
                    parts.placed.append(PlacedPrimitive(label, primitive, worn, stands))
        if "camera" in node:
            entry = document.entry("cameras", node["camera"])
            called = named("camera", entry, node["camera"])
            if entry["type"] == "orthographic":
                orthographic.append(called)
            elif "perspective" not in entry:
                document.ledger.stop(f'{called} has no "perspective"')
            else:
                parts.cameras.append(_camera(entry, matrix, document.ledger))
        punctual = node.get("extensions", {}).get("KHR_lights_punctual", {})
        if "light" in punctual:
            listed = document.tree["extensions"]["KHR_lights_punctual"]["lights"]
            light, index = listed[punctual["light"]], punctual["light"]
            add_light(parts.lights, index, light, matrix, document.ledger)
    if orthographic and not parts.cameras:
        problem = "an orthographic camera is not modelled"
        replace_word(
            document.ledger, "camera", "orthographic", orthographic[0], problem
        )
    if len(parts.cameras) + len(orthographic) > 1 and parts.cameras:
        count = len(parts.cameras)
        document.ledger.note(f"The first of {count} perspective cameras is used")
    return parts


def _check_morphs(
    node: dict[str, Any], mesh: dict[str, Any], where: str, ledger: Ledger
) -> None:
    morphs = any("targets" in primitive for primitive in mesh["primitives"])
    element = "node" if "weights" in node else "mesh"
    if morphs and any(node.get("weights", mesh.get("weights", []))):
        problem = "morph targets with weights are not modelled"
        replace_word(ledger, element, "weights", where, problem)


def _camera(entry: dict[str, Any], matrix: Scalars, ledger: Ledger) -> Camera:
    lens = entry["perspective"]
    aspect = float(lens.get("aspectRatio", 1.0))
    longest = max(aspect, 1.0)
    width = max(round(LONG_SIDE * aspect / longest), 1)
    height = max(round(LONG_SIDE / longest), 1)
    ledger.note(f"The file gives no image size: {width}x{height} by its camera's shape")
    position = matrix[:3, 3]
    return Camera(
        position=color(position),
        target=color(position - normalize(matrix[:3, 2])),
        up=color(normalize(matrix[:3, 1])),
        fov=float(np.degrees(lens["yfov"])),
        fov_axis="y",
        width=width,
        height=height,
        mirrored=bool(np.linalg.det(matrix[:3, :3]) < 0),
    )

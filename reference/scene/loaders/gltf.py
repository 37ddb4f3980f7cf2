"""glTF 2.0 (.gltf, .glb): nodes, meshes, cameras and lights.

The file is decoded here and not by trimesh, whose reader fills sparse accessors with
zeros, takes normalized integers for floats, drops what hangs on a camera's node, and
derives the horizontal angle of view by proportion, all without a word.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import numpy as np

from reference.arrays import Scalars, normalize
from reference.scene.camera import Camera
from reference.scene.lights import DirectionalLight, PointLight
from reference.scene.loaders.framing import (
    camera_or_framing,
    color,
    default_environment,
)
from reference.scene.loaders.gltf_buffers import Document, read_document
from reference.scene.loaders.gltf_materials import (
    KNOWN_EXTENSIONS,
    Finish,
    read_finish,
)
from reference.scene.loaders.gltf_meshes import read_primitive
from reference.scene.loaders.ledger import Ledger
from reference.scene.scene import Scene
from reference.scene.shapes import Mesh

LONG_SIDE = 256  # pixels; a glTF camera knows the shape of its image, not the size


@dataclass(slots=True)
class _Parts:
    meshes: list[Mesh] = field(default_factory=list)
    cameras: list[Camera] = field(default_factory=list)
    points: list[PointLight] = field(default_factory=list)
    suns: list[DirectionalLight] = field(default_factory=list)


def load(ledger: Ledger) -> Scene:
    """Scene of a glTF file.

    Parameters
    ----------
    ledger : Ledger
        Of the file: .gltf with its buffers, or .glb.

    Returns
    -------
    Scene
        Of the file's default scene, all in the world; see the notes.

    Raises
    ------
    UsageError
        Not glTF 2, truncated, or (unless lenient) with something not modelled.
    """
    with ledger.reading("glTF file"):
        document = read_document(ledger)
        required = document.tree.get("extensionsRequired", [])
        if unknown := sorted(set(required) - KNOWN_EXTENSIONS):
            ledger.stop(
                f"the file requires {', '.join(unknown)}; of extensions that may be"
                f" required, {', '.join(sorted(KNOWN_EXTENSIONS))} are understood"
            )
        parts = _collect(document)
    if document.tree.keys() & {"animations", "skins"}:
        ledger.note("Animations and skins are ignored: all stands in its rest pose")
    if len(parts.cameras) > 1:
        ledger.note(f"The first of {len(parts.cameras)} cameras is used")
    meshes = tuple(parts.meshes)
    camera = parts.cameras[0] if parts.cameras else None
    scene = Scene(
        name=ledger.path.stem,
        camera=camera_or_framing(camera, meshes, (), ledger),
        meshes=meshes,
        points=tuple(parts.points),
        suns=tuple(parts.suns),
    )
    environment = default_environment(scene, ledger)
    ledger.settle()
    return replace(scene, environment=environment, notes=tuple(ledger.notes))


def _collect(document: Document) -> _Parts:
    @cache
    def finish(index: int | None) -> Finish:
        return read_finish(document, index)

    parts = _Parts()
    for node, matrix in _nodes(document):
        if "mesh" in node:
            mesh = document.tree["meshes"][node["mesh"]]
            name = node.get("name", mesh.get("name", f"mesh {node['mesh']}"))
            for i, primitive in enumerate(mesh["primitives"]):
                label = name if len(mesh["primitives"]) == 1 else f"{name}.{i}"
                worn = finish(primitive.get("material"))
                if placed := read_primitive(document, primitive, label, worn, matrix):
                    parts.meshes.append(placed)
        if "camera" in node:
            entry = document.tree["cameras"][node["camera"]]
            if camera := _camera(entry, matrix, document.ledger):
                parts.cameras.append(camera)
        lights = node.get("extensions", {}).get("KHR_lights_punctual", {})
        if "light" in lights:
            listed = document.tree["extensions"]["KHR_lights_punctual"]["lights"]
            _add_light(parts, listed[lights["light"]], matrix, document.ledger)
    return parts


def _nodes(document: Document) -> Iterator[tuple[dict[str, Any], Scalars]]:
    """All nodes of the default scene, in depth-first order, with their matrices."""
    tree = document.tree
    nodes = tree.get("nodes", [])
    if "scenes" in tree:
        roots = tree["scenes"][tree.get("scene", 0)].get("nodes", [])
    else:
        children = {child for node in nodes for child in node.get("children", [])}
        roots = sorted(set(range(len(nodes))) - children)
    waiting = [(index, np.eye(4)) for index in reversed(roots)]
    seen: set[int] = set()
    while waiting:
        index, parent = waiting.pop()
        if index in seen:
            document.ledger.stop(f"node {index} hangs in the tree twice")
        seen.add(index)
        node = nodes[index]
        matrix = parent @ _local_matrix(node)
        yield node, matrix
        waiting += [(child, matrix) for child in reversed(node.get("children", []))]


def _local_matrix(node: dict[str, Any]) -> Scalars:
    if "matrix" in node:
        return np.array(node["matrix"], float).reshape(4, 4).T
    matrix = np.eye(4)
    x, y, z, w = np.array(node.get("rotation", [0, 0, 0, 1]), float)
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    matrix[:3, :3] = rotation * np.array(node.get("scale", [1, 1, 1]), float)
    matrix[:3, 3] = node.get("translation", [0, 0, 0])
    return matrix


def _camera(entry: dict[str, Any], matrix: Scalars, ledger: Ledger) -> Camera | None:
    if entry.get("type") != "perspective":
        ledger.replace(
            f'camera "{entry.get("name", "")}" is {entry.get("type")}; a perspective'
            " camera is modelled",
            "ignored",
        )
        return None
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


def _add_light(
    parts: _Parts, light: dict[str, Any], matrix: Scalars, ledger: Ledger
) -> None:
    where = f'light "{light.get("name", light["type"])}"'
    strength = np.array(light.get("color", [1, 1, 1]), float)
    strength = strength * float(light.get("intensity", 1.0))
    ledger.note(
        "Light in the file is photometric (candela, lux, nit); its numbers are taken as"
        " W/sr, W/m² and W/(m² sr), as offline renderers do"
    )
    if "range" in light:
        ledger.note(f"{where}: its range is ignored, it falls off with 1/d² only")
    if light["type"] == "directional":
        direction = color(-normalize(matrix[:3, 2]))
        parts.suns.append(DirectionalLight(direction, color(strength)))
        return
    if light["type"] != "point":
        ledger.replace(
            f"{where} is a {light['type']} light; point and directional are modelled",
            "taken as a point light of the same intensity in all directions",
        )
    parts.points.append(PointLight(color(matrix[:3, 3]), color(strength)))

"""Scenes in our plain convention: scene.json beside PLY files (docs: scene_json)."""

import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from restir_gi.reference.scene.camera import Camera
from restir_gi.reference.scene.lights import (
    ConstantEnvironment,
    DirectionalLight,
    Environment,
    Lamp,
    LatLongEnvironment,
    PointLight,
    SpotLight,
)
from restir_gi.reference.scene.loaders.framing import camera_or_framing, color, fov_axis
from restir_gi.reference.scene.loaders.json_entries import JsonObject, shown
from restir_gi.reference.scene.loaders.json_materials import MATT, read_material
from restir_gi.reference.scene.loaders.json_words import names
from restir_gi.reference.scene.loaders.ledger import Ledger
from restir_gi.reference.scene.loaders.meshes import read_parts
from restir_gi.reference.scene.loaders.pictures import read_picture
from restir_gi.reference.scene.loaders.triangles import (
    check_indices,
    drop_texture_without_uv,
)
from restir_gi.reference.scene.materials.kinds import Material
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.shapes import Mesh, Sphere
from restir_gi.reference.scene.textures import Bitmap, Color, Texture
from restir_gi.reference.system.errors import UsageError

LIGHTS = names("light type")


def load(ledger: Ledger) -> Scene:
    """Scene of a scene.json file.

    Raises UsageError: not such a file, or (unless lenient) with something not
    understood.

    Parameters
    ----------
    ledger : Ledger; of the file: .json; meshes and pictures are looked for beside it
    """
    with ledger.reading("scene.json file"):
        tree = json.loads(
            ledger.contents().decode("utf-8-sig"),
            object_pairs_hook=partial(_object, ledger=ledger),
        )
    if not isinstance(tree, dict) or not isinstance(tree.get("shapes"), list):
        ledger.stop('an object with a list "shapes" is needed at the top')
    if ignored := sorted(tree.keys() - set(names("file"))):
        ledger.note(f"Ignored at the top of the file: {', '.join(ignored)}")
    materials = _materials(tree.get("materials", {}), ledger)
    shapes = []
    for i, raw in enumerate(tree["shapes"]):
        name = raw.get("id", raw.get("file", i)) if isinstance(raw, dict) else i
        shapes.append(
            _shape(JsonObject("shape", f'shape "{name}"', raw, ledger), materials)
        )
    lights = tree.get("lights") or []
    if not isinstance(lights, list):
        ledger.stop('"lights" is not a list of objects')
    entries = [
        JsonObject("light", f"light {i}", raw, ledger) for i, raw in enumerate(lights)
    ]
    if tree.get("environment") is not None:
        entries.append(_environment_entry(tree["environment"], ledger))
    made = [light for light in map(_light, entries) if light is not None]
    environments = [x for x in made if isinstance(x, Environment)]
    camera = (
        _camera(JsonObject("camera", "camera", tree["camera"], ledger))
        if "camera" in tree
        else None
    )
    ledger.settle()  # before any mesh is read
    spheres = tuple(shape for shape in shapes if isinstance(shape, Sphere))
    meshes = tuple(mesh for shape in shapes if callable(shape) for mesh in shape())
    framed = camera_or_framing(camera, meshes, spheres, ledger)
    ledger.settle()
    return Scene(
        name=str(tree.get("name", ledger.path.stem)),
        camera=framed,
        meshes=meshes,
        spheres=spheres,
        points=tuple(x for x in made if isinstance(x, PointLight)),
        spots=tuple(x for x in made if isinstance(x, SpotLight)),
        suns=tuple(x for x in made if isinstance(x, DirectionalLight)),
        environment=environments[-1] if environments else None,
        notes=tuple(ledger.notes),
    )


def _object(pairs: list[tuple[str, Any]], ledger: Ledger) -> dict[str, Any]:
    """Refuse what JSON leaves open: which of two values of a key counts."""
    found = dict(pairs)
    if len(found) < len(pairs):
        keys = [key for key, _ in pairs]
        twice = next(key for key in keys if keys.count(key) > 1)
        ledger.stop(f"the key {shown(twice)} stands twice in one object")
    return found


def _materials(raw: Any, ledger: Ledger) -> dict[str, Material]:
    if not isinstance(raw, dict):
        ledger.stop('"materials" is not an object of names and materials')
    return {
        name: read_material(JsonObject("material", f'material "{name}"', entry, ledger))
        for name, entry in raw.items()
    }


def _camera(entry: JsonObject) -> Camera:
    width, height = entry.count("width", 256), entry.count("height", 256)
    camera = Camera(
        position=entry.color("origin"),
        target=entry.color("target"),
        up=entry.color("up", (0.0, 1.0, 0.0)),
        fov=entry.number("fov_deg"),
        fov_axis=fov_axis("camera", entry.get("fov_axis", "x"), entry.ledger),
        width=width,
        height=height,
    )
    entry.refuse_unread()
    return camera


def _shape(
    entry: JsonObject, materials: Mapping[str, Material]
) -> Sphere | Callable[[], Iterator[Mesh]] | None:
    """Sphere; or what reads the meshes, once all words were found to be right."""
    ledger = entry.ledger
    wanted = entry.get("material")
    material = materials.get(wanted) if isinstance(wanted, str) else None
    if material is None:
        ledger.replace(
            f"{entry.name}: its material is {shown(wanted)}; there"
            f" are {', '.join(materials) or 'none at all'}",
            "taken as diffuse with reflectance 0.5",
        )
        material = MATT
    glow = _emission(entry)
    made: Sphere | Callable[[], Iterator[Mesh]] | None = None
    if entry.get("type") == "sphere":
        made = Sphere(
            name=entry.id,
            center=entry.color("center"),
            radius=entry.number("radius"),
            material=material,
            emission=glow.texture,
            two_sided_emission=glow.two_sided,
            inward=bool(entry.get("inward", False)),
        )
    elif name := _mesh_file(entry):
        made = partial(_meshes, entry, name, material, glow)
    entry.refuse_unread()
    return made


def _mesh_file(entry: JsonObject) -> str | None:
    """Name of the file of a shape, if there is one that can be one."""
    name = entry.get("file")
    entry.get("triangles")
    try:
        found = isinstance(name, str) and entry.ledger.has(name)
    except UsageError as error:
        entry.ledger.replace(f"{entry.name}: {error}", "left out")
        return None
    if not found or not name.lower().endswith((".ply", ".obj")):
        entry.ledger.replace(
            f"{entry.name}: {shown(name)} is not a PLY or OBJ file beside the scene",
            "left out",
        )
        return None
    return str(name)


@dataclass(frozen=True, slots=True)
class _Glow:
    """What a shape emits, and whether its back does, too."""

    texture: Texture
    two_sided: bool


def _emission(entry: JsonObject) -> _Glow:
    two_sided = bool(entry.get("two_sided_emission", False))
    raw = entry.get("emission")
    if raw is None:
        return _Glow((0.0, 0.0, 0.0), two_sided)
    if not isinstance(raw, dict):
        return _Glow(entry.color("emission"), two_sided)
    own = JsonObject("emission", f"emission of {entry.name}", raw, entry.ledger)
    name = str(own.get("file"))
    scale = own.number("scale", 1.0)
    own.refuse_unread()
    try:
        return _Glow(Bitmap(read_picture(name, entry.ledger) * scale), two_sided)
    except UsageError as error:
        entry.ledger.replace(f"{own.name}: {error}", "taken as dark")
        return _Glow((0.0, 0.0, 0.0), two_sided)


def _meshes(
    entry: JsonObject, name: str, material: Material, glow: _Glow
) -> Iterator[Mesh]:
    ledger = entry.ledger
    parts = read_parts(name, ledger)
    found, promised = sum(len(p.faces) for p in parts), entry.get("triangles")
    if promised is not None and promised != found:
        ledger.replace(
            f"{entry.name} has {found} triangles in {name}, not {promised}",
            f"taken with its {found}",
        )
    if any(part.normals is not None for part in parts):
        ledger.note(f"{name}: its vertex normals are ignored, faces are flat")
    if any(part.colors is not None for part in parts):
        ledger.note(f"{name}: its vertex colours are ignored, the material counts")
    for part in parts:
        mesh = Mesh(
            name=entry.id,
            vertices=part.vertices,
            faces=part.faces,
            material=material,
            emission=glow.texture,
            two_sided_emission=glow.two_sided,
            uv=part.uv,
        )
        check_indices(mesh, ledger)
        yield drop_texture_without_uv(mesh, ledger)


def _environment_entry(raw: Any, ledger: Ledger) -> JsonObject:
    if not isinstance(raw, dict):
        raw = {"type": "constant", "radiance": raw}
    kind = "envmap" if "file" in raw else "constant"
    return JsonObject("light", "environment", {"type": kind, **raw}, ledger)


def _direction(entry: JsonObject) -> Color:
    direction = np.array(entry.color("direction"))
    # A direction of length zero is the validation's to report.
    return color(direction / (np.linalg.norm(direction) or 1.0))


def _light(entry: JsonObject) -> Lamp | DirectionalLight | Environment | None:
    kind = entry.get("type")
    light: Lamp | DirectionalLight | Environment
    if kind == "point":
        light = PointLight(entry.color("position"), entry.color("intensity"))
    elif kind == "directional":
        light = DirectionalLight(_direction(entry), entry.color("irradiance"))
    elif kind == "spot":
        falloff = entry.get("falloff", "linear")
        if falloff not in ("linear", "smooth"):
            entry.ledger.stop(
                f"{entry.name}: falloff is {shown(falloff)}; it can be linear or smooth"
            )
        light = SpotLight(
            entry.color("position"),
            _direction(entry),
            entry.color("intensity"),
            cutoff=entry.number("cutoff_deg"),
            beam=entry.number("beam_deg"),
            falloff=falloff,
        )
    elif kind == "constant":
        light = ConstantEnvironment(entry.color("radiance"))
    elif kind == "envmap":
        scale = entry.number("scale", 1.0)
        try:
            pixels = read_picture(str(entry.get("file")), entry.ledger)
        except UsageError as error:
            entry.ledger.replace(f"{entry.name}: {error}", "left out")
            return None
        light = LatLongEnvironment(pixels * scale)
    else:
        entry.ledger.replace(
            f"{entry.name} has the type {shown(kind)}; known are {', '.join(LIGHTS)}",
            "left out",
        )
        return None
    entry.refuse_unread()
    return light

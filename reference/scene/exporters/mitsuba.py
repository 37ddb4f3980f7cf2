"""A scene as Mitsuba 3 XML, with a .ply file for each mesh."""

import re
from collections.abc import Iterator
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from restir_gi.reference.scene.camera import Camera
from restir_gi.reference.scene.exporters.triangles import in_world
from restir_gi.reference.scene.exporters.unsaid import unsaid_in_both
from restir_gi.reference.scene.lights import ConstantEnvironment
from restir_gi.reference.scene.materials.kinds import (
    Coated,
    Conductor,
    Dielectric,
    Lambertian,
    Material,
)
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.shapes import Mesh, Sphere, emits
from restir_gi.reference.scene.textures import Checker, Pattern, Texture


def mitsuba_unsaid(scene: Scene) -> Iterator[str]:
    """What Mitsuba XML cannot say of a scene, a clause each; nothing if it can."""
    yield from unsaid_in_both(scene)
    shapes: list[Mesh | Sphere] = [*scene.meshes, *scene.spheres]
    for shape in shapes:
        for clause in _shape_unsaid(shape):
            yield f'"{shape.name}" {clause}'


def _shape_unsaid(shape: Mesh | Sphere) -> Iterator[str]:
    material = shape.material
    if emits(shape) and shape.two_sided_emission:
        yield "shines from both sides, and in Mitsuba only the front does"
    if isinstance(material, Conductor) and material.schlick:
        yield "has Schlick's Fresnel term, and Mitsuba's conductors have not"
    if (
        isinstance(shape, Sphere)
        and not isinstance(material, Dielectric)
        and isinstance(material.reflectance, Pattern)
    ):
        yield "is a sphere with a texture, which lies otherwise in Mitsuba"


def mitsuba_files(scene: Scene) -> dict[str, bytes]:
    """Contents of the files of a scene of which `mitsuba_unsaid` says nothing, by name.

    The meshes lie in a folder of the scene's name.

    Parameters
    ----------
    scene : Scene; validated
    """
    files: dict[str, bytes] = {}
    root = Element("scene", version="3.0.0")
    SubElement(root, "integrator", type="path")
    _camera(root, scene.camera)
    _lights(root, scene)
    for number, mesh in enumerate(scene.meshes):
        name = f"{scene.name}/{number:02}-{_plain(mesh.name)}.ply"
        files[name] = _ply(in_world(mesh))
        shape = SubElement(root, "shape", type="ply", id=mesh.name)
        _value(shape, "string", "filename", name)
        if mesh.normals is None:
            _value(shape, "boolean", "face_normals", "true")
        _look(shape, mesh)
    for sphere in scene.spheres:
        shape = SubElement(root, "shape", type="sphere", id=sphere.name)
        _point(shape, "point", "center", sphere.center)
        _value(shape, "float", "radius", repr(float(sphere.radius)))
        if sphere.inward:
            _value(shape, "boolean", "flip_normals", "true")
        _look(shape, sphere)
    ElementTree.indent(root, " ")
    text = ElementTree.tostring(root, "unicode")
    return {**files, f"{scene.name}.xml": (text + "\n").encode()}


def _camera(root: Element, camera: Camera) -> None:
    sensor = SubElement(root, "sensor", type="perspective")
    _value(sensor, "float", "fov", repr(float(camera.fov)))
    _value(sensor, "string", "fov_axis", camera.fov_axis)
    transform = SubElement(sensor, "transform", name="to_world")
    if camera.mirrored:
        SubElement(transform, "scale", x="-1")
    SubElement(
        transform,
        "lookat",
        origin=_row(camera.position),
        target=_row(camera.target),
        up=_row(camera.up),
    )
    film = SubElement(sensor, "film", type="hdrfilm")
    _value(film, "integer", "width", str(camera.width))
    _value(film, "integer", "height", str(camera.height))
    SubElement(film, "rfilter", type="box")


def _lights(root: Element, scene: Scene) -> None:
    for point in scene.points:
        emitter = SubElement(root, "emitter", type="point")
        _point(emitter, "point", "position", point.position)
        _color(emitter, "intensity", point.intensity)
    for sun in scene.suns:
        emitter = SubElement(root, "emitter", type="directional")
        _point(emitter, "vector", "direction", sun.direction)
        _color(emitter, "irradiance", sun.irradiance)
    if isinstance(scene.environment, ConstantEnvironment):
        emitter = SubElement(root, "emitter", type="constant")
        _color(emitter, "radiance", scene.environment.radiance)


def _look(parent: Element, shape: Mesh | Sphere) -> None:
    material = shape.material
    if getattr(material, "two_sided", False):
        _bsdf(SubElement(parent, "bsdf", type="twosided"), material)
    else:
        _bsdf(parent, material)
    if emits(shape):
        _color(SubElement(parent, "emitter", type="area"), "radiance", shape.emission)


def _bsdf(parent: Element, material: Material) -> None:
    if isinstance(material, Lambertian):
        bsdf = SubElement(parent, "bsdf", type="diffuse")
        _color(bsdf, "reflectance", material.reflectance)
        return
    rough = "rough" if material.alpha > 0 else ""
    kinds = {Conductor: "conductor", Coated: "plastic", Dielectric: "dielectric"}
    bsdf = SubElement(parent, "bsdf", type=rough + kinds[type(material)])
    if rough:
        _value(bsdf, "string", "distribution", material.distribution)
        _value(bsdf, "float", "alpha", repr(float(material.alpha)))
    if isinstance(material, Conductor):
        if material.eta is None or material.k is None:
            _value(bsdf, "string", "material", "none")
        else:
            _color(bsdf, "eta", material.eta)
            _color(bsdf, "k", material.k)
        _color(bsdf, "specular_reflectance", material.reflectance)
        return
    _value(bsdf, "float", "int_ior", repr(float(material.ior)))
    _value(bsdf, "float", "ext_ior", "1.0")
    if isinstance(material, Coated):
        _color(bsdf, "diffuse_reflectance", material.reflectance)
        _color(bsdf, "specular_reflectance", material.specular)
        _value(bsdf, "boolean", "nonlinear", str(material.nonlinear).lower())


def _color(parent: Element, name: str, texture: Texture) -> None:
    if not isinstance(texture, Checker):
        assert isinstance(texture, tuple)
        _value(parent, "rgb", name, _row(texture))
        return
    board = SubElement(parent, "texture", type="checkerboard", name=name)
    _value(board, "rgb", "color0", _row(texture.color0))
    _value(board, "rgb", "color1", _row(texture.color1))
    across, along = (repr(float(scale)) for scale in texture.scale)
    transform = SubElement(board, "transform", name="to_uv")
    SubElement(transform, "scale", x=across, y=along)


def _value(parent: Element, kind: str, name: str, value: str) -> None:
    SubElement(parent, kind, name=name, value=value)


def _point(parent: Element, kind: str, name: str, point: tuple[float, ...]) -> None:
    x, y, z = (repr(float(part)) for part in point)
    SubElement(parent, kind, name=name, x=x, y=y, z=z)


def _row(numbers: tuple[float, ...]) -> str:
    return ", ".join(repr(float(number)) for number in numbers)


def _plain(name: str) -> str:
    return re.sub(r"[^A-Za-z0-9]+", "-", name).strip("-")


def _ply(mesh: Mesh) -> bytes:
    """Binary PLY: vertices with what they have, then faces."""
    columns: list[Any] = [mesh.vertices]
    names = ["x", "y", "z"]
    if mesh.normals is not None:
        columns.append(mesh.normals)
        names += ["nx", "ny", "nz"]
    if mesh.uv is not None:
        columns.append(mesh.uv)
        names += ["u", "v"]
    head = ["ply", "format binary_little_endian 1.0"]
    head.append(f"element vertex {len(mesh.vertices)}")
    head += [f"property float {name}" for name in names]
    head.append(f"element face {len(mesh.faces)}")
    head += ["property list uchar int vertex_indices", "end_header", ""]
    faces = np.empty(len(mesh.faces), [("count", "u1"), ("corners", "<i4", 3)])
    faces["count"], faces["corners"] = 3, mesh.faces
    vertices = np.concatenate(columns, axis=1).astype("<f4")
    return "\n".join(head).encode() + vertices.tobytes() + faces.tobytes()

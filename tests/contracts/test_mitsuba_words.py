"""The table of Mitsuba's words is what the loader does: each word is tried.

A scene without the word is loaded beside one with it.  A modelled word changes the
scene, a harmless one does not, and one that is replaced is refused by name, or noted
under --lenient.  The values are none of Mitsuba's defaults.
"""

import re
from dataclasses import fields, is_dataclass

import numpy as np
import pytest
from PIL import Image

from restir_gi.reference.scene.loaders.load import load_scene
from restir_gi.reference.scene.loaders.mitsuba_nodes import mitsuba_session
from restir_gi.reference.scene.loaders.mitsuba_words import ANY, WORDS, find
from restir_gi.reference.scene.loaders.words import Use
from restir_gi.reference.system.errors import UsageError

pytest.importorskip("mitsuba", reason="reads Mitsuba XML by the package mitsuba")

PICTURE = np.array([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [90, 60, 30]]], np.uint8)
CORNERS = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\n"
PLACES = "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
OBJ = f"{CORNERS}{PLACES}vn 0 0.6 0.8\nf 1/1/1 2/2/1 3/3/1 4/4/1\n"
PLY = (
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
    "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
    "property float u\nproperty float v\nelement face 1\n"
    "property list uchar int vertex_indices\nend_header\n"
    "0 0 0 0 0.6 0.8 0 0\n1 0 0 0 0.6 0.8 1 0\n0 1 0 0 0.6 0.8 0 1\n3 0 1 2\n"
)


COLORED = PLY.replace(
    "element face 1",
    "property float r\nproperty float g\nproperty float b\nelement face 1",
)
COLORED = re.sub(r"(0\.8 \d \d)\n", r"\1 0.1 0.5 0.9\n", COLORED)


def tag(kind, name, value):
    return f'<{kind} name="{name}" value="{value}"/>'


def number(name, value=0.3):
    return tag("float", name, value)


def rgb(name, value="0.1, 0.2, 0.3"):
    return tag("rgb", name, value)


def text(name, value):
    return tag("string", name, value)


def flag(name, value="true"):
    return tag("boolean", name, value)


def plugin(tag, kind, inner="", name=""):
    named = f' name="{name}"' if name else ""
    return f'<{tag} type="{kind}"{named}>{inner}</{tag}>'


TURN = '<transform name="{}"><rotate z="1" angle="30"/><translate x="2"/></transform>'
PAINTED = plugin("bsdf", "diffuse", rgb("reflectance"))
LAMP = plugin("emitter", "area", rgb("radiance", "1, 2, 3"))
BLACK = plugin("bsdf", "diffuse", rgb("reflectance", "0"))
CHECKER = plugin("texture", "checkerboard", "", "reflectance")
BOTH = number("alpha_u") + number("alpha_v")
INNER = {
    "bitmap": text("filename", "a.png"),
    "envmap": text("filename", "a.png"),
    "instance": plugin("shape", "shapegroup", plugin("shape", "cube")),
    "mask": number("opacity", 1) + plugin("bsdf", "diffuse"),
    "mesh_attribute": text("name", "vertex_color"),
    "merge": plugin("shape", "cube"),
    "obj": text("filename", "a.obj"),
    "ply": text("filename", "a.ply"),
    "serialized": text("filename", "a.serialized"),
    "shapegroup": plugin("shape", "cube"),
    "twosided": plugin("bsdf", "diffuse"),
}
"""What a plugin has at least."""
PARAMETERS = {
    "alpha": number("alpha"),
    "alpha_u": BOTH,
    "alpha_v": BOTH,
    "beam_width": number("beam_width", 3),
    "center": '<point name="center" x="1" y="2" z="3"/>',
    "color": rgb("color"),
    "color0": rgb("color0"),
    "color1": rgb("color1"),
    "cutoff_angle": number("cutoff_angle", 33),
    "diffuse_reflectance": rgb("diffuse_reflectance"),
    "direction": '<vector name="direction" x="1" y="2" z="2"/>',
    "distribution": text("distribution", "ggx"),
    "eta": rgb("eta"),
    "ext_ior": number("ext_ior", 1.25),
    "face_normals": flag("face_normals"),
    "filter_type": text("filter_type", "nearest"),
    "flip_normals": flag("flip_normals"),
    "flip_tex_coords": flag("flip_tex_coords", "false"),
    "focal_length": text("focal_length", "35mm"),
    "fov": number("fov", 33),
    "fov_axis": number("fov", 33) + text("fov_axis", "y"),
    "height": tag("integer", "height", 33),
    "int_ior": number("int_ior", 1.75),
    "intensity": rgb("intensity"),
    "irradiance": rgb("irradiance"),
    "k": rgb("k"),
    "material": text("material", "Au"),
    "nonlinear": flag("nonlinear"),
    "p0": '<point name="p0" x="0" y="0" z="0.5"/>',
    "p1": '<point name="p1" x="0" y="1" z="1"/>',
    "position": '<point name="position" x="1" y="2" z="3"/>',
    "radiance": rgb("radiance"),
    "radius": number("radius", 2),
    "raw": flag("raw"),
    "reflectance": rgb("reflectance"),
    "scale": number("scale", 3),
    "shape_index": tag("integer", "shape_index", 1),
    "specular_reflectance": rgb("specular_reflectance"),
    "specular_transmittance": rgb("specular_transmittance"),
    "to_uv": TURN.format("to_uv"),
    "to_world": TURN.format("to_world").replace('z="1"', 'x="1"'),
    "value": number("value", 0.75),
    "width": tag("integer", "width", 33),
    "wrap_mode": text("wrap_mode", "mirror"),
}
"""Values that are no defaults; others are numbers, see `number`."""
PARTS = {
    "bsdf": PAINTED,
    "emitter": LAMP,
    "film": plugin("film", "hdrfilm", tag("integer", "width", 33)),
    "medium": plugin("medium", "homogeneous", "", "interior"),
    "rfilter": plugin("rfilter", "box"),
    "sampler": plugin("sampler", "independent"),
    "sensor": plugin("sensor", "irradiancemeter"),
    "shape": plugin("shape", "cube", PAINTED),
    "texture": CHECKER,
}
SCENE = {
    "alias": '<bsdf type="diffuse" id="p"/><alias id="p" as="q"/>'
    '<shape type="disk"><ref id="q"/></shape>',
    "bsdf": f'<shape type="disk">{PAINTED}</shape>',
    "default": '<default name="r" value="3"/><shape type="sphere">'
    '<float name="radius" value="$r"/></shape>',
    "emitter": plugin("emitter", "point"),
    "include": '<include filename="part.xml"/>',
    "integrator": plugin("integrator", "path", tag("integer", "max_depth", 2)),
    "path": '<path value="more"/><shape type="obj">'
    f"{text('filename', 'b.obj')}</shape>",
    "phase": plugin("phase", "isotropic"),
    "ref": '<bsdf type="diffuse" id="p"/><shape type="disk"><ref id="p"/></shape>',
    "sensor": plugin("sensor", "perspective", number("fov", 33)),
    "texture": '<texture type="checkerboard" id="t"/><shape type="rectangle">'
    '<bsdf type="diffuse"><ref name="reflectance" id="t"/></bsdf></shape>',
    "volume": plugin("volume", "constvolume", number("value"), "v"),
}


def holder(kind, element):
    """A scene round a plugin."""
    if kind == "texture":
        element = element.replace("<texture", '<texture name="reflectance"', 1)
        element = plugin("bsdf", "diffuse", element)
    if kind == "texture" and "mesh_attribute" in element:
        return plugin("shape", "ply", text("filename", "c.ply") + element)
    if kind in ("texture", "bsdf"):
        return plugin("shape", "rectangle", element)
    if kind == "film":
        return plugin("sensor", "perspective", number("fov", 60) + element)
    if element.startswith('<emitter type="area"'):
        return plugin("shape", "rectangle", element)
    return element


def kind_of(name):
    """Kind of a plugin: "bsdf" of "diffuse"."""
    kinds = {word.element for word in WORDS if word.name == name}
    (kind,) = kinds & {"bsdf", "emitter", "film", "sensor", "shape", "texture"}
    return kind


def scenes_of(word):
    """A scene without a word, and one with it."""
    name = "unheard-of" if word.name == ANY else word.name
    if word.element == "scene":
        return "", SCENE.get(name, PARTS.get(name, plugin(name, "none")))
    if word.element in {"bsdf", "emitter", "film", "sensor", "shape", "texture"}:
        inner = INNER.get(name, "")
        if find(word.element, word.name).remark.startswith("taken as the first"):
            inner = PAINTED
        return "", holder(word.element, plugin(word.element, name, inner))
    kind, least = kind_of(word.element), INNER.get(word.element, "")
    if word.element == "area":
        kind = "emitter"
    inside = PARAMETERS.get(name, PARTS.get(name, number(name)))
    if word.element == "d65" and name == "scale":
        inside = number("scale", 0.75)
    if word.element == "ply" and name == "flip_tex_coords":
        inside = flag("flip_tex_coords")
    if word.element == "mesh_attribute" and name == "name":
        return holder(kind, ""), holder(kind, plugin(kind, word.element, least))
    if word.element == "spot" and name == "texture":
        inside = plugin("texture", "bitmap", INNER["bitmap"], "texture")
    if f'name="{name}"' in least or f"<{name} " in least:  # it is never without
        return "", holder(kind, plugin(kind, word.element, least))
    without = plugin(kind, word.element, least)
    having = plugin(kind, word.element, least + inside)
    return holder(kind, without), holder(kind, having)


def essence(value):
    """All that a scene holds but its notes, to be compared."""
    if isinstance(value, np.ndarray):
        return value.shape, value.tobytes()
    if is_dataclass(value):
        parts = [f.name for f in fields(value) if f.name not in ("notes", "name")]
        return type(value).__name__, *(essence(getattr(value, name)) for name in parts)
    if isinstance(value, list | tuple):
        return tuple(essence(part) for part in value)
    return value


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("words")
    Image.fromarray(PICTURE).save(path / "a.png")
    (path / "a.obj").write_text(OBJ)
    (path / "a.ply").write_text(PLY)
    (path / "c.ply").write_text(COLORED)
    (path / "more").mkdir()
    (path / "more" / "b.obj").write_text(OBJ)
    (path / "part.xml").write_text(f'<scene version="3.0.0">{LAMP_SHAPE}</scene>')
    (path / "a.serialized").write_bytes(serialized(2))
    with mitsuba_session():
        yield path


LAMP_SHAPE = plugin("shape", "rectangle", LAMP)


def serialized(count):
    """A file of so many triangles, each a mesh of its own, in Mitsuba's own format."""
    import struct
    import zlib

    contents, places = b"", []
    for i in range(count):
        places.append(len(contents))
        corners = np.array([[0, 0, i], [1, 0, i], [0, 1, i]], "<f4")
        body = struct.pack("<I", 0x0001 | 0x0002 | 0x1000) + b"part\0"
        body += struct.pack("<QQ", 3, 1) + corners.tobytes()
        body += np.tile(np.array([0, 0.6, 0.8], "<f4"), 3).tobytes()
        body += np.array([0, 0, 1, 0, 0, 1], "<f4").tobytes()
        body += np.array([0, 1, 2], "<u4").tobytes()
        contents += struct.pack("<HH", 0x041C, 4) + zlib.compress(body)
    return contents + struct.pack(f"<{count}QI", *places, count)


def write(folder, body):
    path = folder / "scene.xml"
    path.write_text(f'<scene version="3.0.0">\n{body}\n</scene>')
    return path


@pytest.mark.parametrize(
    "word", WORDS, ids=[f"{w.element} {w.name}".replace(" ", "-") for w in WORDS]
)
def test_each_word_does_what_the_table_says(folder, word):
    without, having = scenes_of(word)
    path = write(folder, having)
    if word.use is Use.REPLACED:
        name = "unheard-of" if word.name == ANY else word.name
        with pytest.raises(UsageError, match=f"{name}.*is not modelled.*--lenient"):
            load_scene(path)
        assert any(name in note for note in load_scene(path, lenient=True).notes)
        return
    scene = essence(load_scene(path))
    changes = scene != essence(load_scene(write(folder, without)))
    invisible = (word.element, word.name) in NOT_SEEN
    assert changes == (word.use is Use.MODELLED and not invisible)


NOT_SEEN = {("bsdf", "null"), ("shape", "shapegroup"), ("shapegroup", "shape")}
"""Modelled words that leave nothing in a scene."""


def test_no_word_stands_in_the_table_twice():
    names = [(word.element, word.name) for word in WORDS]
    assert len(names) == len(set(names))

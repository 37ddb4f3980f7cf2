"""The table of glTF's words is what the loader does: each word is tried.

One file has all words that are modelled.  Without any of them it is another scene, or
none; with a harmless word it stays the same; with one that is replaced it is refused by
name, and noted under --lenient.
"""

import base64
from dataclasses import fields, is_dataclass

import numpy as np
import pytest

from restir_gi.reference.scene.loaders.gltf_check import TABLE
from restir_gi.reference.scene.loaders.gltf_forms import (
    Flag,
    Index,
    Many,
    NumberForm,
    NumbersForm,
    One,
)
from restir_gi.reference.scene.loaders.gltf_words import WORDS
from restir_gi.reference.scene.loaders.load import load_scene
from restir_gi.reference.scene.loaders.words import Use
from restir_gi.reference.system.errors import UsageError
from tests.contracts.gltf_files import TRIANGLE, Gltf, png

PICTURE = np.array(
    [[(255, 0, 0, 255), (0, 255, 0, 99)], [(0, 0, 255, 0), (90, 60, 30, 255)]], np.uint8
)
EVEN = np.full((1, 1, 3), (0, 128, 255), np.uint8)
COORDINATES = np.float32([[0.1, 0.2], [0.9, 0.3], [1.7, 1.6]])


def whole_file():
    """Every word that is modelled, with a value that no default equals."""
    gltf = Gltf()
    placed = {"offset": [0.1, 0.2], "rotation": 0.3, "scale": [2, 3], "texCoord": 1}
    other = {"index": 1, "texCoord": 1}
    paint = {
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.9, 0.8, 0.7, 0.9],
            "baseColorTexture": {
                "index": 0,
                "extensions": {"KHR_texture_transform": placed},
            },
            "metallicFactor": 0,
            "roughnessFactor": 0.7,
            "metallicRoughnessTexture": {"index": 2},
        },
        "alphaMode": "MASK",
        "alphaCutoff": 0.3,
        "extensions": {"KHR_materials_ior": {"ior": 1.7}},
    }
    lamp = {
        "emissiveFactor": [1, 0.5, 0.25],
        "emissiveTexture": other,
        "doubleSided": True,
        "pbrMetallicRoughness": {"metallicFactor": 0},
        "extensions": {
            "KHR_materials_emissive_strength": {"emissiveStrength": 3},
            "KHR_materials_specular": {"specularFactor": 0},
        },
    }
    glass = {
        "pbrMetallicRoughness": {"roughnessFactor": 0.5, "metallicFactor": 0},
        "extensions": {
            "KHR_materials_transmission": {"transmissionFactor": 1},
            "KHR_materials_volume": {
                "thicknessFactor": 1,
                "attenuationDistance": 2,
                "attenuationColor": [1, 1, 1],
            },
        },
    }
    gltf.tree["materials"] = [paint, lamp, glass]
    views = [
        gltf.view(png(PICTURE)),
        gltf.view(png(PICTURE[::-1])),
        gltf.view(png(EVEN)),
    ]
    uri = "data:image/png;base64,"
    gltf.tree["images"] = [
        {"bufferView": views[0]},
        {"bufferView": views[1]},
        {"uri": uri + base64.b64encode(png(EVEN)).decode()},
    ]
    gltf.tree["textures"] = [
        {"source": 0, "sampler": 0},
        {"source": 0, "extensions": {"EXT_texture_webp": {"source": 1}}},
        {"source": 2},
    ]
    gltf.tree["samplers"] = [{"magFilter": 9728, "wrapS": 33071, "wrapT": 33648}]
    attributes = {
        "POSITION": gltf.accessor(TRIANGLE),
        "NORMAL": gltf.accessor(np.tile(np.float32([0, 0.6, 0.8]), (3, 1))),
        "TEXCOORD_1": gltf.accessor(COORDINATES),
        "COLOR_0": gltf.accessor(
            np.array([[255, 9, 9], [9, 255, 9], [99, 9, 9]], np.uint8), normalized=True
        ),
    }
    strided = gltf.view(np.float32([[*row, 7] for row in TRIANGLE]).tobytes())
    gltf.tree["bufferViews"][strided] |= {"byteStride": 16}
    sparse = {
        "count": 1,
        "indices": {
            "bufferView": gltf.view(np.uint8([0, 1]).tobytes()),
            "byteOffset": 1,
            "componentType": 5121,
        },
        "values": {
            "bufferView": gltf.view(np.float32([9, 5, 6, 7]).tobytes()),
            "byteOffset": 4,
        },
    }
    odd = {"componentType": 5126, "type": "VEC3", "count": 3, "bufferView": strided}
    gltf.tree["accessors"].append(odd | {"sparse": sparse})
    padded = np.concatenate([np.float32([1e9]), TRIANGLE.ravel()])
    view = gltf.view(padded.tobytes())
    gltf.tree["accessors"].append(odd | {"bufferView": view, "byteOffset": 4})
    count = len(gltf.tree["accessors"])
    order = gltf.accessor(np.array([0, 2, 1, 2], np.uint16))
    gltf.tree["meshes"] = [
        {
            "primitives": [
                {"attributes": attributes, "indices": order, "mode": 5, "material": 0},
                {
                    "attributes": {"POSITION": count - 2, "TEXCOORD_1": 2},
                    "material": 1,
                },
                {"attributes": {"POSITION": count - 1}, "material": 2},
            ]
        }
    ]
    for name, row in (
        ("half", (1, 1, 1, 0.5)),
        ("bright", (2, 1, 1)),
        ("red", (1, 0, 0)),
    ):
        gltf.accessor(np.tile(np.float32(row), (3, 1)), name=name)
    instances = {
        "TRANSLATION": gltf.accessor(np.float32([[0, 0, 0], [5, 0, 0]])),
        "ROTATION": gltf.accessor(np.float32([[0, 0, 0, 1], [0, 0, 0.6, 0.8]])),
        "SCALE": gltf.accessor(np.float32([[1, 1, 1], [2, 1, 1]])),
    }
    beam = {"innerConeAngle": 0.1, "outerConeAngle": 0.3}
    light = {"type": "spot", "color": [1, 0.5, 0], "intensity": 5, "spot": beam}
    gltf.tree["extensions"] = {"KHR_lights_punctual": {"lights": [light]}}
    lens = {"yfov": 0.7, "aspectRatio": 1.5}
    gltf.tree["cameras"] = [{"type": "perspective", "perspective": lens}]
    gltf.tree["nodes"] = [
        {"mesh": 0, "children": [1, 2, 3]},
        {"camera": 0, "translation": [0, 0, 5], "rotation": [0, 0.6, 0, 0.8]},
        {
            "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 4, 5, 6, 1],
            "extensions": {"KHR_lights_punctual": {"light": 0}},
        },
        {
            "mesh": 0,
            "scale": [2, 3, 4],
            "extensions": {"EXT_mesh_gpu_instancing": {"attributes": instances}},
        },
    ]
    gltf.tree["scenes"] = [{}, {"nodes": [0]}]
    gltf.tree["buffers"] = [{"byteLength": 0}]
    gltf.tree["scene"] = 1
    gltf.tree["asset"]["minVersion"] = "2.0"
    gltf.tree["extensionsUsed"] = ["KHR_mesh_quantization"]
    gltf.tree["extensionsRequired"] = ["KHR_texture_transform"]
    return gltf


def places(tree):
    """Where each word stands first: (element, name) to object and key."""
    found = {}

    def visit(element, entry):
        for key, value in entry.items():
            if key == "extensions":
                for name, inner in value.items():
                    found.setdefault(("extension", name), (value, name))
                    visit(name, inner)
                continue
            attribute = "TEXCOORD_n" if key.startswith("TEXCOORD_") else key
            found.setdefault((element, attribute), (entry, key))
            form = TABLE[element, attribute].form
            for each in value if isinstance(form, Many) else [value]:
                if isinstance(form, One | Many):
                    visit(form.element, each)

    visit("file", tree)
    return found


def looks(scene):
    """All that a scene is, but its name and its notes."""
    if isinstance(scene, np.ndarray):
        return str(scene.dtype), scene.shape, scene.tobytes()
    if is_dataclass(scene):
        kept = [f.name for f in fields(scene) if f.name not in ("name", "notes")]
        return type(scene).__name__, *(looks(getattr(scene, name)) for name in kept)
    if isinstance(scene, tuple):
        return tuple(looks(each) for each in scene)
    return scene


@pytest.fixture(scope="module")
def unchanged(tmp_path_factory):
    """Looks and notes of the whole file."""
    path = whole_file().write(tmp_path_factory.mktemp("whole") / "a.gltf")
    scene = load_scene(path)
    return looks(scene), " ".join(scene.notes)


@pytest.fixture
def tried(tmp_path):
    """Load the file with a change: its looks and its notes."""

    def load(change, lenient=False):
        gltf = whole_file()
        change(gltf.tree)
        scene = load_scene(gltf.write(tmp_path / "a.gltf"), lenient)
        return looks(scene), " ".join(scene.notes)

    return load


def rows(*uses, judged=False):
    chosen = [w for w in WORDS if w.use in uses and w.judged == judged]
    return pytest.mark.parametrize(
        "word", chosen, ids=lambda w: f"{w.element}-{w.name}"
    )


def put(tree, word, value):
    """Set a word in the first object of its element, or in a new one."""
    extensions = tree["materials"][0]["extensions"]
    homes = [
        home
        for (element, _), (home, _) in places(tree).items()
        if element == word.element
    ]
    if word.element == "extension":
        home = extensions
    else:
        home = homes[0] if homes else extensions.setdefault(word.element, {})
    home[word.name.replace("_*", "_X").replace("_n", "_7")] = value


def example(word):
    """A value of the word's form which is not neutral."""
    match word.form:
        case Flag():
            values = [False, True]
        case NumberForm(low, high):
            values = [min(high, max(low, 0.5)), low]
        case NumbersForm(count, low):
            values = [[max(low, 0.5)] * (count or 2)]
        case Index():
            values = [0]
        case _:
            values = ["anything" if word.name == "name" else {}]
    return next(value for value in values if value not in word.neutral)


# ---------------------------------------------------------------- modelled

INSTEAD = {
    ("file", "extensionsUsed"): ["EXT_unheard_of"],
    ("file", "extensionsRequired"): ["EXT_unheard_of"],
    ("asset", "minVersion"): "2.1",
    ("camera", "type"): "orthographic",
    ("KHR_materials_volume", "attenuationDistance"): 0,
    ("buffer view", "byteOffset"): 4,
    ("accessor", "normalized"): 1,
}
"""Values of words that could as well be missing, or of which the file has several."""

NOT_IN_JSON = {("extension", "KHR_mesh_quantization"), ("buffer", "uri")}
"""Words that have no object, and the one that the writer of the file adds."""


def test_the_whole_file_has_every_word_that_is_modelled(unchanged):
    modelled = {(w.element, w.name) for w in WORDS if w.use is Use.MODELLED}
    assert modelled - places(whole_file().tree).keys() == NOT_IN_JSON
    assert "ignored" not in unchanged[1]
    assert "left out" not in unchanged[1]


@rows(Use.MODELLED)
def test_without_a_word_that_is_modelled_it_is_another_scene(tried, unchanged, word):
    key = word.element, word.name
    if key in NOT_IN_JSON or word.name == "buffers" or word.element == "buffer":
        return  # the writer of the file adds it

    def change(tree):
        entry, name = places(tree)[key]
        if key in INSTEAD:
            entry[name] = INSTEAD[key]
        else:
            del entry[name]

    try:
        changed, _ = tried(change)
    except UsageError:
        return
    assert changed != unchanged[0]


# ---------------------------------------------------------------- harmless


@rows(Use.HARMLESS)
def test_a_harmless_word_changes_nothing(tried, unchanged, word):
    changed, notes = tried(lambda tree: put(tree, word, example(word)))
    assert changed == unchanged[0]
    if word.element == "extension":
        assert f"{word.name} is ignored: {word.remark}" in notes


# ---------------------------------------------------------------- replaced, refused


@rows(Use.REPLACED)
def test_a_word_that_is_replaced_is_refused_or_noted(tried, word):
    inner = [w for w in WORDS if w.element == word.name and w.use is Use.REPLACED]
    tried_word = inner[0] if word.element == "extension" and inner else word

    def change(tree):
        put(tree, tried_word, example(tried_word))

    with pytest.raises(UsageError, match=f"{tried_word.name} is not modelled"):
        tried(change)
    _, notes = tried(change, lenient=True)
    assert f"{tried_word.name} is not modelled: {tried_word.remark}" in notes


@rows(Use.REPLACED)
def test_a_neutral_value_changes_nothing(tried, unchanged, word):
    for value in word.neutral:
        changed, _ = tried(lambda tree, value=value: put(tree, word, value))
        assert changed == unchanged[0]


@rows(Use.REFUSED)
@pytest.mark.parametrize("lenient", [False, True])
def test_a_word_that_is_refused_is_refused_before_any_buffer_is_read(
    tried, word, lenient
):
    def change(tree):
        tree["extensionsUsed"] = [word.name]
        for view in tree["bufferViews"]:
            view["byteLength"] = 10**9

    with pytest.raises(UsageError, match=f"uses {word.name}, which is not modelled"):
        tried(change, lenient)


@pytest.mark.parametrize("lenient", [False, True])
def test_an_unknown_extension_that_is_required_is_refused(tried, lenient):
    def change(tree):
        tree["extensionsRequired"] = ["EXT_unheard_of"]

    with pytest.raises(UsageError, match='requires "EXT_unheard_of", which is unknown'):
        tried(change, lenient)


# ---------------------------------------------------------------- judged by readers


def paint(**words):
    return lambda tree: tree["materials"][0].update(words)


def shine(**words):
    return lambda tree: tree["materials"][0]["pbrMetallicRoughness"].update(words)


def extend(material, name, **words):
    def change(tree):
        extensions = tree["materials"][material]["extensions"]
        extensions[name] = {**extensions.get(name, {}), **words}

    return change


def varied(tree):
    tree["materials"][0]["pbrMetallicRoughness"]["metallicRoughnessTexture"] = {
        "index": 0
    }


def orthographic(tree):
    tree["cameras"][0] = {"type": "orthographic", "orthographic": {}}


def morphed(element):
    def change(tree):
        tree["meshes"][0]["primitives"][0]["targets"] = [{}]
        home = tree["nodes"][0] if element == "node" else tree["meshes"][0]
        home["weights"] = [0.5]

    return change


def colored(name, primitive):
    """Give a primitive the spare accessor of this name as its vertex colours."""

    def change(tree):
        names = [entry.get("name") for entry in tree["accessors"]]
        attributes = tree["meshes"][0]["primitives"][primitive]["attributes"]
        attributes["COLOR_0"] = names.index(name)

    return change


def no_source(tree):
    tree["textures"][0] = {}


def with_range(tree):
    tree["extensions"]["KHR_lights_punctual"]["lights"][0]["range"] = 3


def tinted(tree):
    tree["materials"][2]["pbrMetallicRoughness"]["baseColorFactor"] = [1, 0, 0, 1]


JUDGED = {
    ("node", "weights"): morphed("node"),
    ("mesh", "weights"): morphed("mesh"),
    ("camera", "orthographic"): orthographic,
    ("material", "alphaMode BLEND"): paint(alphaMode="BLEND"),
    ("material", "emissiveTexture placed unlike baseColorTexture"): paint(
        emissiveFactor=[1, 1, 1], emissiveTexture={"index": 1}
    ),
    ("pbrMetallicRoughness", "metallicFactor between 0 and 1"): shine(
        metallicFactor=0.3
    ),
    ("pbrMetallicRoughness", "metallicRoughnessTexture that varies"): varied,
    ("texture", "no source that can be read"): no_source,
    ("light", "range"): with_range,
    ("attribute", "COLOR_0 with alpha"): colored("half", 0),
    ("attribute", "COLOR_0 outside of 0 to 1"): colored("bright", 0),
    ("attribute", "COLOR_0 on glass"): colored("red", 2),
    ("KHR_materials_ior", "ior below 1"): extend(0, "KHR_materials_ior", ior=0),
    ("KHR_materials_specular", "specularFactor between 0 and 1"): extend(
        0, "KHR_materials_specular", specularFactor=0.5
    ),
    ("KHR_materials_specular", "specularTexture"): extend(
        0, "KHR_materials_specular", specularTexture={"index": 0}
    ),
    ("KHR_materials_specular", "specularColorFactor"): extend(
        0, "KHR_materials_specular", specularColorFactor=[1, 0, 0]
    ),
    ("KHR_materials_specular", "specularColorTexture"): extend(
        0, "KHR_materials_specular", specularColorTexture={"index": 0}
    ),
    ("KHR_materials_transmission", "transmissionFactor between 0 and 1"): extend(
        2, "KHR_materials_transmission", transmissionFactor=0.5
    ),
    ("KHR_materials_transmission", "transmissionTexture"): extend(
        2, "KHR_materials_transmission", transmissionTexture={"index": 0}
    ),
    ("KHR_materials_transmission", "without thickness"): extend(
        2, "KHR_materials_volume", thicknessFactor=0
    ),
    ("KHR_materials_transmission", "with a base colour"): tinted,
    ("KHR_materials_volume", "attenuationColor"): extend(
        2, "KHR_materials_volume", attenuationColor=[1, 0, 0]
    ),
}


def test_every_word_that_a_reader_judges_is_tried():
    assert JUDGED.keys() == {(w.element, w.name) for w in WORDS if w.judged}


@rows(Use.REPLACED, judged=True)
def test_a_word_that_a_reader_judges_is_refused_or_noted(tried, word):
    change = JUDGED[word.element, word.name]
    with pytest.raises(UsageError, match=f"with --lenient: {word.remark}"):
        tried(change)
    _, notes = tried(change, lenient=True)
    assert f": {word.remark}." in notes

"""Broken scene files: one line that says what is wrong, where, and what is right."""

import base64
import json
import re
import shutil
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from restir_gi.reference.scene.loaders.ledger import MOST_TOLD
from restir_gi.reference.scene.loaders.load import LOADERS, load_scene
from restir_gi.reference.system.errors import UsageError

SUFFIXES = sorted(LOADERS)
OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
PLY = (
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
    "property float z\nelement face 2\nproperty list uchar int vertex_indices\n"
    "end_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2\n3 1 3 2\n"
)
XML = (
    '<scene version="3.0.0"><shape type="rectangle"><bsdf type="diffuse">'
    '<rgb name="reflectance" value="0.5"/></bsdf></shape></scene>'
)
POSITIONS = np.float32([[0, 0, 0], [1, 0, 0], [0, 1, 0]])


def gltf(positions=POSITIONS, **changes):
    """A glTF tree with one triangle."""
    data = positions.tobytes()
    uri = "data:;base64," + base64.b64encode(data).decode()
    return {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [
            {"componentType": 5126, "type": "VEC3", "count": 3, "bufferView": 0}
        ],
        "bufferViews": [{"buffer": 0, "byteLength": len(data)}],
        "buffers": [{"byteLength": len(data), "uri": uri}],
        **changes,
    }


def glb():
    tree = gltf(buffers=[{"byteLength": 36}])
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    body = len(text).to_bytes(4, "little") + b"JSON" + text
    body += (36).to_bytes(4, "little") + b"BIN\0" + POSITIONS.tobytes()
    length = (12 + len(body)).to_bytes(4, "little")
    return b"glTF" + (2).to_bytes(4, "little") + length + body


JSON = {
    "materials": {"m": {"type": "diffuse", "reflectance": 0.5}},
    "shapes": [{"id": "wall", "file": "a.ply", "material": "m"}],
}
WHOLE = {
    ".gltf": json.dumps(gltf()).encode(),
    ".glb": glb(),
    ".obj": OBJ.encode(),
    ".ply": PLY.encode(),
    ".xml": XML.encode(),
    ".json": json.dumps(JSON).encode(),
}


@pytest.fixture
def put(tmp_path):
    """Return a writer of scene files, with a good a.ply beside them."""
    (tmp_path / "a.ply").write_text(PLY)

    def write(contents, name):
        if isinstance(contents, dict | list):
            contents = json.dumps(contents)
        path = tmp_path / name
        path.write_bytes(contents if isinstance(contents, bytes) else contents.encode())
        return path

    return write


def refused(path, lenient=False):
    """Message of the refusal, which has to be one line that names the file."""
    with pytest.raises(UsageError) as caught:
        load_scene(path, lenient)
    message = str(caught.value)
    assert "\n" not in message
    assert path.name in message
    faults = re.split(r"\(\d+\) ", message)
    assert len(faults) <= 1 + MOST_TOLD
    # One refusal is as short as ever; of several each is a line of its own.
    assert max(map(len, faults)) < (600 if len(faults) == 1 else 300)
    return message


def needs_mitsuba(suffix):
    if suffix == ".xml":
        pytest.importorskip(
            "mitsuba", reason="reads Mitsuba XML by the package mitsuba"
        )


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_control_the_whole_files_load(put, suffix):
    needs_mitsuba(suffix)
    scene = load_scene(put(WHOLE[suffix], f"scene{suffix}"))
    assert sum(len(mesh.faces) for mesh in scene.meshes) in (1, 2)


@pytest.mark.parametrize("lenient", [False, True])
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_missing_files_and_folders(tmp_path, suffix, lenient):
    assert "No such file" in refused(tmp_path / f"no{suffix}", lenient)
    (tmp_path / f"folder{suffix}").mkdir()
    assert "not a file" in refused(tmp_path / f"folder{suffix}", lenient)


@pytest.mark.parametrize("lenient", [False, True])
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_empty_files(put, suffix, lenient):
    assert "is empty" in refused(put(b"", f"scene{suffix}"), lenient)


@pytest.mark.parametrize("name", ["scene.fbx", "scene", "scene.xml.gz", ".gltf"])
def test_unknown_suffixes_are_told_what_is_known(put, name):
    message = refused(put(b"x", name))
    assert all(suffix in message for suffix in SUFFIXES)


def test_suffixes_may_be_in_capitals(put):
    assert load_scene(put(OBJ, "A.OBJ")).name == "A"


@pytest.mark.parametrize("lenient", [False, True])
@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("seed", range(4))
def test_garbage(put, suffix, seed, lenient):
    needs_mitsuba(suffix)
    garbage = np.random.default_rng(seed).bytes(3000)
    refused(put(garbage, f"scene{suffix}"), lenient)
    # Right at the start, wrong then.
    start = WHOLE[suffix][:20]
    refused(put(start + garbage, f"scene{suffix}"), lenient)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_files_of_another_format(put, suffix):
    needs_mitsuba(suffix)
    for other in SUFFIXES:
        if other != suffix and {other, suffix} != {".gltf", ".glb"}:
            refused(put(WHOLE[other], f"scene{suffix}"))


@pytest.mark.parametrize("lenient", [False, True])
@pytest.mark.parametrize("suffix", [".gltf", ".glb", ".ply", ".xml", ".json"])
def test_files_that_end_too_early(put, suffix, lenient):
    """An OBJ file may end after any line, and is whole then."""
    needs_mitsuba(suffix)
    whole = WHOLE[suffix].rstrip()
    for share in (0.3, 0.6, 0.9, 0.98):
        refused(put(whole[: int(share * len(whole))], f"scene{suffix}"), lenient)


def test_binary_ply_that_ends_too_early(put, tmp_path):
    import trimesh

    trimesh.creation.icosphere(subdivisions=1).export(tmp_path / "ball.ply")
    whole = (tmp_path / "ball.ply").read_bytes()
    for kept in (len(whole) - 1, len(whole) - 13, len(whole) // 2):
        refused(put(whole[:kept], "scene.ply"))


@pytest.mark.parametrize("suffix", [".gltf", ".obj", ".ply", ".json"])
@pytest.mark.parametrize("value", ["nan", "inf", "-inf"])
def test_vertices_that_are_not_finite_pass_unchanged(put, suffix, value):
    """The validation of scenes reports them: it knows how many there are."""
    positions = POSITIONS.copy()
    positions[2, 1] = float(value)
    put(PLY.replace("0 1 0", f"0 {value} 0"), "a.ply")
    contents = {
        ".gltf": gltf(positions),
        # With normals, which are compared with those of the faces.
        ".obj": OBJ.replace("0 1 0", f"0 {value} 0").replace(
            "f 1 2 3", "vn 0 0 1\nf 1//1 2//1 3//1"
        ),
        ".ply": PLY.replace("0 1 0", f"0 {value} 0"),
        ".json": JSON,
    }[suffix]
    scene = load_scene(put(contents, f"scene{suffix}"))
    assert str(scene.meshes[0].vertices[2, 1]) == value
    assert (
        np.isfinite(scene.meshes[0].vertices).sum() == scene.meshes[0].vertices.size - 1
    )
    assert np.isfinite(scene.camera.position).all()


# ---------------------------------------------------------------- one format each


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"asset": {"version": "1.0"}}, "glTF 1.0; version 2.0"),
        ({"asset": {}}, 'no "asset" with a "version"'),
        ({"scenes": [{"nodes": [7]}]}, "scene 0: nodes is [7]; it must be"),
        ({"nodes": [{"mesh": 0, "children": [0]}]}, "node 0 hangs in the tree twice"),
        ({"nodes": [{"mesh": "x"}]}, 'node 0: mesh is "x"; it must be the number of'),
        ({"nodes": [{"mesh": 1}]}, "node 0: mesh is 1; it must be the number of one"),
        ({"nodes": [{"mesh": 0, "matrix": [1, 2]}]}, "matrix is [1, 2]; it must be 16"),
        ({"bufferViews": [{"buffer": 0, "byteLength": 99}]}, "view 0 reaches beyond"),
        ({"bufferViews": [{"buffer": 0, "byteLength": 20}]}, "beyond buffer view 0"),
        ({"buffers": [{"byteLength": 36, "uri": "no.bin"}]}, "no.bin"),
        ({"buffers": [{"byteLength": 36, "uri": "data:;base64,AAAA"}]}, "3 of its 36"),
        ({"buffers": [{"byteLength": 36, "uri": "data:;base64,x"}]}, "is not base64"),
        ({"extensionsRequired": ["KHR_draco_mesh_compression"]}, "requires KHR_draco"),
    ],
)
def test_gltf(put, changes, message):
    path = put(gltf(**changes), "scene.gltf")
    assert message in refused(path).removeprefix(str(path))


def test_gltf_faces_of_no_vertex(put):
    indices = {"componentType": 5125, "type": "SCALAR", "count": 3, "bufferView": 1}
    tree = gltf(
        np.concatenate([POSITIONS.ravel(), np.int32([0, 1, 9]).view(np.float32)])
    )
    tree["accessors"].append(indices)
    tree["bufferViews"] = [
        {"buffer": 0, "byteLength": 36},
        {"buffer": 0, "byteOffset": 36, "byteLength": 12},
    ]
    tree["meshes"][0]["primitives"][0]["indices"] = 1
    assert "a face with vertex 9; its vertices are 0 to 2" in refused(
        put(tree, "scene.gltf")
    )


@pytest.mark.parametrize("image", [b"no picture", None])
def test_gltf_textures_that_cannot_be_read(put, image):
    paint = {
        "name": "paint",
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
    }
    tree = gltf(materials=[paint], textures=[{"source": 0}], images=[{"uri": "a.png"}])
    tree["meshes"][0]["primitives"][0]["material"] = 0
    tree["accessors"].append({**tree["accessors"][0], "type": "VEC2"})
    tree["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = 1
    if image:
        put(image, "a.png")
    path = put(tree, "scene.gltf")
    assert 'material "paint"' in refused(path)
    scene = load_scene(path, lenient=True)
    assert np.all(scene.meshes[0].material.reflectance.pixels == 0.5)
    assert any("paint" in note and "mid grey" in note for note in scene.notes)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            OBJ.replace("f 1 2 3", "f 1 2 9"),
            "line 4: a face names vertex 9; they are 1 to 3",
        ),
        (OBJ.replace("f 1 2 3", "f 1 2"), "line 4: a face has 2 corners; it needs 3"),
        (OBJ.replace("v 1 0 0", "v 1 x 0"), 'line 2: v has "x"; it needs numbers'),
        (OBJ.replace("f 1 2 3", "# no face"), "no faces"),
        ("hello world\n", 'line 1: "hello" is not modelled'),
    ],
)
def test_obj(put, text, message):
    assert message in refused(put(text, "scene.obj"))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (PLY.replace("end_header", "the end"), "header is incomplete"),
        (PLY.replace("3 1 3 2", "3 1 9 2"), "vertex 9"),
        (PLY.replace("3 1 3 2\n", ""), "truncated or corrupt"),
        (PLY.replace("face 2", "face 0").split("3 0")[0], "no triangles"),
    ],
)
def test_ply(put, text, message):
    assert message in refused(put(text, "scene.ply"))


@pytest.mark.parametrize(
    ("tree", "message"),
    [
        ([1, 2], 'a list "shapes" is needed'),
        ({**JSON, "shapes": None}, 'a list "shapes" is needed'),
        ({**JSON, "shapes": [3]}, 'shape "0" is not an object'),
        ({**JSON, "materials": [1]}, "not an object of names"),
        ({**JSON, "materials": {"m": 1}}, 'material "m" is not an object'),
        ({**JSON, "camera": {"origin": [0, 0, 0]}}, "camera: "),
        (
            {**JSON, "shapes": [{"id": "w", "file": "a.ply"}]},
            "its material is missing",
        ),
        ({**JSON, "lights": 3}, '"lights" is not a list'),
    ],
)
def test_json(put, tree, message):
    assert message in refused(put(tree, "scene.json"))


def test_json_with_a_broken_mesh_names_the_mesh(put):
    put(PLY.replace("3 1 3 2\n", ""), "a.ply")
    with pytest.raises(UsageError, match=r"a\.ply: .*truncated"):
        load_scene(put(JSON, "scene.json"))


def test_json_with_a_missing_mesh(put, tmp_path):
    (tmp_path / "a.ply").unlink()
    path = put(JSON, "scene.json")
    assert 'shape "wall": "a.ply" is not a PLY' in refused(path)
    scene = load_scene(path, lenient=True)
    assert scene.meshes == ()
    assert any("wall" in note and "left out" in note for note in scene.notes)


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("<shape", "line 1, column 30: not well-formed"),
        ('<shape type="obj"><ref id="zz"/></shape>', '"zz"'),
        ('<shape type="obj"/>', "it names no file"),
        ('<shape type="nonsense" id="it"/>', 'nonsense "it" is not modelled'),
        ('<shape type="sphere"><bsdf type="velvet" id="it"/></shape>', 'velvet "it"'),
        ('<shape type="sphere"><float name="radius" value="$r"/></shape>', "$r"),
        ('<shape type="obj"><string name="filename" value="a.obj"/></shape>', "obj at"),
        (
            '<shape type="sphere"><bsdf type="twosided" id="it"/></shape>',
            '"it" holds no BSDF',
        ),
        (
            '<shape type="sphere"><bsdf type="conductor" id="it">'
            '<string name="material" value="Unobtainium"/></bsdf></shape>',
            'metal of conductor "it"',
        ),
        (
            '<shape type="sphere"><bsdf type="dielectric" id="it">'
            '<string name="int_ior" value="jelly"/></bsdf></shape>',
            'index of refraction of dielectric "it"',
        ),
        (
            '<emitter type="envmap"><string name="filename" value="no.exr"/></emitter>',
            "no.exr",
        ),
    ],
)
def test_mitsuba_xml(put, body, message):
    needs_mitsuba(".xml")
    put("v 0 0 0\nf 1 2 3\n", "a.obj")
    assert message in refused(
        put(f'<scene version="3.0.0">{body}</scene>', "scene.xml")
    )


def test_texture_files_that_are_no_pictures(put, tmp_path):
    """Each reader of pictures refuses what is not one."""
    put(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\nmtllib a.mtl",
        "a.obj",
    )
    whole = BytesIO()
    Image.fromarray(np.zeros((64, 64, 3), np.uint8)).save(whole, "PNG")
    header = b"#?RADIANCE\n\n-Y 4 +X 9\n"
    broken = {
        "a.png": whole.getvalue()[:60],
        "b.png": b"\x89PNG\r\n",
        "a.jpg": b"",
        "a.exr": b"no exr",
        "a.hdr": header + bytes([2, 2, 0, 9, 200, 1]),
        "b.hdr": b"#?RADIANCE\n\n+X 4 +Y 9\n",
        "c.hdr": header,
    }
    for name, contents in broken.items():
        put(contents, name)
        put(f"newmtl m\nmap_Kd {name}\n", "a.mtl")
        with pytest.raises(UsageError, match=name):
            load_scene(tmp_path / "a.obj")


def test_scenes_are_found_from_any_folder(put, monkeypatch, tmp_path):
    """Files are looked for beside the scene, not in the folder of the process."""
    path = put(JSON, "scene.json")
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.chdir(elsewhere)
    assert len(load_scene(path).meshes) == 1
    shutil.move(tmp_path / "a.ply", elsewhere / "a.ply")
    refused(path)

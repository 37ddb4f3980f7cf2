"""glTF, OBJ, PLY and scene.json against files written here, value by value.

Mitsuba XML has `test_mitsuba_loader.py`; files that are broken,
`tests/extremes/test_loader_bad_input.py`.
"""

import base64
import json
from io import BytesIO

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from PIL import Image

from reference.errors import UsageError
from reference.scene.camera import FOV_AXES, camera_rays
from reference.scene.lights import (
    ConstantEnvironment,
    DirectionalLight,
    LatLongEnvironment,
    PointLight,
)
from reference.scene.loaders.ledger import Ledger
from reference.scene.loaders.load import load_scene
from reference.scene.loaders.pictures import decode_srgb, read_picture
from reference.scene.materials.kinds import Coated, Conductor, Dielectric, Lambertian
from reference.scene.textures import Bitmap, read

EPS32 = np.finfo(np.float32).eps  # files hold float32
TRIANGLE = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)


def face_normals(mesh):
    """Unit normals of the front."""
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
    normal = np.cross(b - a, c - a)
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)


def noted(scene, *words):
    """Whether one sentence of the notes has all the words."""
    assert all(note.endswith(".") for note in scene.notes)
    return any(all(word in note for word in words) for note in scene.notes)


def png(pixels, mode=None):
    buffer = BytesIO()
    Image.fromarray(pixels, mode).save(buffer, "PNG")
    return buffer.getvalue()


# ---------------------------------------------------------------- pictures


def test_srgb_is_decoded_as_colour_science_does():
    from colour.models import eotf_sRGB

    encoded = np.arange(256) / 255
    assert_allclose(decode_srgb(encoded), eotf_sRGB(encoded), rtol=1e-14)


@pytest.mark.parametrize("mode", ["RGB", "RGBA", "L", "P"])
def test_pictures_of_any_mode_become_linear_colours(tmp_path, mode):
    stored = np.array([[[10, 10, 10], [200, 200, 200]]], np.uint8)
    picture = Image.fromarray(stored)
    # Converting to "P" would take the nearest of 216 fixed colours.
    picture = picture.quantize(2) if mode == "P" else picture.convert(mode)
    picture.save(tmp_path / "a.png")
    ledger = Ledger(tmp_path / "scene", lenient=False)
    assert_allclose(read_picture("a.png", ledger), decode_srgb(stored / 255))
    assert_allclose(read_picture("a.png", ledger, raw=True), stored / 255)
    assert ledger.notes == []


def test_sixteen_bits_of_grey_are_kept(tmp_path):
    stored = np.array([[1000, 65535]], np.uint16)
    (tmp_path / "a.png").write_bytes(png(stored))
    pixels = read_picture("a.png", Ledger(tmp_path / "scene", False), raw=True)
    assert_allclose(pixels[0, :, 0], [1000 / 65535, 1])
    assert pixels.shape == (1, 2, 3)


def test_exr_is_linear_already(tmp_path):
    import OpenEXR

    pixels = np.arange(24, dtype=np.float32).reshape(2, 4, 3)
    header = {"type": OpenEXR.scanlineimage, "compression": OpenEXR.ZIP_COMPRESSION}
    OpenEXR.File(header, {"RGB": pixels}).write(str(tmp_path / "a.exr"))
    assert_array_equal(read_picture("a.exr", Ledger(tmp_path / "scene", False)), pixels)


def radiance_file(rgbe, packed):
    """A .hdr file: plain, or each channel of each row as one run or as literals."""
    height, width, _ = rgbe.shape
    body = rgbe.tobytes()
    if packed:
        body = b""
        for row in rgbe:
            body += bytes([2, 2, width >> 8, width & 255])
            for channel in row.T:
                if (channel == channel[0]).all():
                    body += bytes([128 + width, channel[0]])
                else:
                    body += bytes([width]) + channel.tobytes()
    return (
        f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n".encode()
        + body
    )


@pytest.mark.parametrize("packed", [False, True])
def test_radiance_files_hold_mantissas_and_an_exponent(tmp_path, packed):
    rgbe = np.zeros((2, 9, 4), np.uint8)
    rgbe[..., 0], rgbe[..., 1] = 128, np.arange(9)
    rgbe[..., 3] = 129
    (tmp_path / "a.hdr").write_bytes(radiance_file(rgbe, packed))
    pixels = read_picture("a.hdr", Ledger(tmp_path / "scene", False))
    # 128 · 2^(129 - 136) = 1
    assert_array_equal(pixels[..., 0], np.ones((2, 9)))
    assert_array_equal(pixels[0, :, 1], np.arange(9) / 128)


# ---------------------------------------------------------------- glTF


class Gltf:
    """A glTF file in the making: one buffer, and the tree around it."""

    def __init__(self):
        self.data = b""
        self.tree = {"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}]}
        self.tree |= {"bufferViews": [], "accessors": [], "materials": []}
        self.tree |= {"nodes": [{"mesh": 0}]}

    def view(self, contents, **more):
        """Append bytes to the buffer."""
        start = len(self.data)
        self.data += contents + b"\0" * (-len(contents) % 4)
        self.tree["bufferViews"].append(
            {"buffer": 0, "byteOffset": start, "byteLength": len(contents), **more}
        )
        return len(self.tree["bufferViews"]) - 1

    def accessor(self, array, **more):
        """Append an array."""
        kinds = {"int8": 5120, "uint8": 5121, "uint16": 5123, "uint32": 5125}
        kinds["float32"] = 5126
        shape = {1: "SCALAR", 2: "VEC2", 3: "VEC3"}[
            array.reshape(len(array), -1).shape[1]
        ]
        entry = {"componentType": kinds[str(array.dtype)], "type": shape}
        entry |= {"count": len(array), "bufferView": self.view(array.tobytes())}
        self.tree["accessors"].append(entry | more)
        return len(self.tree["accessors"]) - 1

    def mesh(self, attributes, indices=None, **more):
        """Append a mesh of one primitive."""
        arrays = {name: self.accessor(array) for name, array in attributes.items()}
        primitive = {"attributes": arrays, **more}
        if indices is not None:
            primitive["indices"] = self.accessor(indices)
        self.tree.setdefault("meshes", []).append({"primitives": [primitive]})

    def texture(self, pixels):
        """Append a PNG."""
        image = {"bufferView": self.view(png(pixels)), "mimeType": "image/png"}
        self.tree.setdefault("images", []).append(image)
        self.tree.setdefault("textures", []).append({"source": 0})

    def write(self, path):
        """Write .gltf with a data URI, or .glb."""
        uri = (
            "data:application/octet-stream;base64,"
            + base64.b64encode(self.data).decode()
        )
        self.tree["buffers"] = [{"byteLength": len(self.data)}]
        if path.suffix == ".gltf":
            self.tree["buffers"][0]["uri"] = uri
            path.write_text(json.dumps(self.tree))
            return path
        text = json.dumps(self.tree).encode()
        text += b" " * (-len(text) % 4)
        chunks = len(text).to_bytes(4, "little") + b"JSON" + text
        chunks += len(self.data).to_bytes(4, "little") + b"BIN\0" + self.data
        head = b"glTF" + (2).to_bytes(4, "little")
        path.write_bytes(head + (12 + len(chunks)).to_bytes(4, "little") + chunks)
        return path


def triangle_file(material=None, **attributes):
    """One triangle, of material 0 if one is given."""
    gltf = Gltf()
    more = {}
    if material is not None:
        gltf.tree["materials"] = [material]
        more = {"material": 0}
    gltf.mesh({"POSITION": TRIANGLE, **attributes}, **more)
    return gltf


def load_gltf(gltf, tmp_path, lenient=False, suffix=".gltf"):
    return load_scene(gltf.write(tmp_path / f"a{suffix}"), lenient)


def gltf_material(tmp_path, lenient=False, extensions=None, **pbr):
    entry = {"name": "paint", "pbrMetallicRoughness": pbr}
    entry["extensions"] = extensions or {}
    scene = load_gltf(triangle_file(entry), tmp_path, lenient)
    return scene.meshes[0].material, scene


@pytest.mark.parametrize("suffix", [".gltf", ".glb"])
def test_gltf_triangles_are_read_from_either_container(tmp_path, suffix):
    gltf = Gltf()
    gltf.mesh({"POSITION": TRIANGLE}, indices=np.array([2, 0, 1], np.uint16))
    scene = load_gltf(gltf, tmp_path, suffix=suffix)
    assert scene.name == "a"
    assert_array_equal(scene.meshes[0].vertices, TRIANGLE)
    assert_array_equal(scene.meshes[0].faces, [[2, 0, 1]])
    assert scene.meshes[0].normals is None


def test_gltf_of_an_independent_writer_is_read(tmp_path):
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions=1)
    node = np.array([[0, -2, 0, 1], [2, 0, 0, 2], [0, 0, 2, 3], [0, 0, 0, 1.0]])
    ball.apply_transform(np.eye(4))
    written = trimesh.Scene()
    written.add_geometry(ball, transform=node)
    written.export(tmp_path / "a.glb")
    mesh = load_scene(tmp_path / "a.glb").meshes[0]
    expected = ball.vertices @ node[:3, :3].T + node[:3, 3]
    assert_allclose(mesh.vertices, expected, atol=8 * EPS32)
    assert_array_equal(np.sort(mesh.faces, axis=1), np.sort(ball.faces, axis=1))
    centre = mesh.vertices[mesh.faces].mean(axis=1) - node[:3, 3]
    assert (np.sum(face_normals(mesh) * centre, axis=1) > 0).all()


def test_gltf_strips_and_fans_keep_one_front(tmp_path):
    zigzag = np.array(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0, 2, 0]], np.float32
    )
    gltf = Gltf()
    gltf.mesh({"POSITION": zigzag}, mode=5)
    strip = load_gltf(gltf, tmp_path).meshes[0]
    gltf = Gltf()
    gltf.mesh({"POSITION": zigzag[[0, 1, 3, 2]]}, mode=6)
    fan = load_gltf(gltf, tmp_path).meshes[0]
    assert_allclose(face_normals(strip), [[0, 0, 1]] * 3)
    assert_allclose(face_normals(fan), [[0, 0, 1]] * 2)


def test_gltf_points_and_lines_are_left_out_with_a_note(tmp_path):
    gltf = Gltf()
    gltf.mesh({"POSITION": TRIANGLE})
    lines = {"attributes": {"POSITION": 0}, "mode": 1}
    gltf.tree["meshes"][0]["primitives"].append(lines)
    scene = load_gltf(gltf, tmp_path)
    assert len(scene.meshes) == 1
    assert noted(scene, "points or lines", "left out")


def test_gltf_accessors_may_be_strided_sparse_or_normalized(tmp_path):
    gltf = Gltf()
    interleaved = np.zeros((3, 5), np.float32)
    interleaved[:, :3], interleaved[:, 3:] = TRIANGLE, 7
    view = gltf.view(interleaved.tobytes(), byteStride=20)
    sparse = {
        "count": 1,
        "indices": {
            "bufferView": gltf.view(np.array([1], np.uint8).tobytes()),
            "componentType": 5121,
        },
        "values": {"bufferView": gltf.view(np.float32([5, 6, 7]).tobytes())},
    }
    position = {"componentType": 5126, "type": "VEC3", "count": 3, "bufferView": view}
    gltf.tree["accessors"].append(position | {"sparse": sparse})
    uv = gltf.accessor(np.array([[0, 255], [51, 0], [0, 0]], np.uint8), normalized=True)
    attributes = {"POSITION": 0, "TEXCOORD_0": uv}
    gltf.tree["meshes"] = [{"primitives": [{"attributes": attributes}]}]
    mesh = load_gltf(gltf, tmp_path).meshes[0]
    assert_array_equal(mesh.vertices, [[0, 0, 0], [5, 6, 7], [0, 1, 0]])
    # v runs upwards here, downwards in glTF.
    assert_allclose(mesh.uv, [[0, 0], [0.2, 1], [0, 1]])


@pytest.mark.parametrize("smooth", [False, True], ids=["flat", "smooth"])
@pytest.mark.parametrize("scale", [(1, 1, 1), (2, 0.5, 3), (-1, 1, 1), (-2, -3, -0.5)])
def test_gltf_fronts_stay_fronts_under_any_scale(tmp_path, scale, smooth):
    normal = {"NORMAL": np.tile(np.float32([0, 0, 1]), (3, 1))}
    gltf = triangle_file(**(normal if smooth else {}))
    gltf.tree["nodes"] = [{"children": [1], "translation": [1, 2, 3]}]
    gltf.tree["nodes"].append(
        {
            "mesh": 0,
            "rotation": [0, np.sqrt(0.5), 0, np.sqrt(0.5)],
            "scale": list(scale),
        }
    )
    mesh = load_gltf(gltf, tmp_path).meshes[0]
    # A quarter turn about y takes x to -z and z to x.
    x, y, z = (TRIANGLE * scale).T
    assert_allclose(mesh.vertices, np.stack([1 + z, 2 + y, 3 - x], axis=-1), atol=1e-15)
    front = np.sign(scale[2]) * np.array([1.0, 0, 0])
    if smooth:
        assert_allclose(mesh.normals, np.tile(front, (3, 1)), atol=1e-15)
    assert_allclose(face_normals(mesh), [front], atol=1e-15)


def test_gltf_normals_turn_with_the_inverse_transpose(tmp_path):
    slope = np.array([[0, 0, 0], [1, 1, 0], [0, 0, -1]], np.float32)  # y = x
    normal = np.tile(np.float32([-np.sqrt(0.5), np.sqrt(0.5), 0]), (3, 1))
    gltf = Gltf()
    gltf.mesh({"POSITION": slope, "NORMAL": normal})
    gltf.tree["nodes"] = [{"mesh": 0, "scale": [2, 1, 1]}]
    mesh = load_gltf(gltf, tmp_path).meshes[0]
    assert_allclose(mesh.normals[0], np.array([-1, 2, 0]) / np.sqrt(5), atol=4 * EPS32)
    assert_allclose(face_normals(mesh)[0], mesh.normals[0], atol=4 * EPS32)


def test_faces_turn_to_where_their_vertex_normals_point(tmp_path):
    normal = np.tile(np.float32([0, 0, -1]), (3, 1))
    mesh = load_gltf(triangle_file(NORMAL=normal), tmp_path).meshes[0]
    assert_allclose(face_normals(mesh), [[0, 0, -1]])


def test_gltf_metal_and_coat_are_told_apart_by_metallic(tmp_path):
    metal, scene = gltf_material(
        tmp_path,
        baseColorFactor=[0.9, 0.5, 0.1, 1],
        metallicFactor=1,
        roughnessFactor=0.5,
    )
    assert isinstance(metal, Conductor)
    assert metal.schlick
    assert (metal.alpha, metal.eta, metal.two_sided) == (0.25, None, True)
    assert_allclose(metal.reflectance, [0.9, 0.5, 0.1])
    coat, _ = gltf_material(
        tmp_path,
        baseColorFactor=[0.9, 0.5, 0.1, 1],
        metallicFactor=0,
        roughnessFactor=0,
    )
    assert isinstance(coat, Coated)
    assert (coat.alpha, coat.ior, coat.nonlinear) == (0.0, 1.5, False)
    assert not noted(scene, "metallic")
    _, half = gltf_material(tmp_path, metallicFactor=0.7)
    assert noted(half, "paint", "metallic 0.7", "all metal")


def test_gltf_reflectors_are_two_sided_with_a_note(tmp_path):
    words = ("Single-sided", "both sides")
    assert noted(load_gltf(triangle_file({"doubleSided": False}), tmp_path), *words)
    scene = load_gltf(triangle_file({"doubleSided": True}), tmp_path)
    assert not noted(scene, *words)
    assert scene.meshes[0].material.two_sided


def test_gltf_default_material_is_rough_white_metal(tmp_path):
    material = load_gltf(triangle_file(), tmp_path).meshes[0].material
    assert isinstance(material, Conductor)
    assert (material.reflectance, material.alpha) == ((1.0, 1.0, 1.0), 1.0)


def test_gltf_index_of_refraction(tmp_path):
    extension = {"KHR_materials_ior": {"ior": 1.8}}
    coat, _ = gltf_material(tmp_path, extensions=extension, metallicFactor=0)
    assert coat.ior == 1.8
    extension = {"KHR_materials_ior": {"ior": 1}}
    matt, scene = gltf_material(tmp_path, extensions=extension, metallicFactor=0)
    assert isinstance(matt, Lambertian)
    assert noted(scene, "matt")


def test_gltf_glass(tmp_path):
    extensions = {
        "KHR_materials_transmission": {"transmissionFactor": 1},
        "KHR_materials_ior": {"ior": 1.33},
    }
    glass, _ = gltf_material(
        tmp_path, extensions=extensions, roughnessFactor=0, metallicFactor=0
    )
    assert glass == Dielectric(1.33)
    rough = {"extensions": extensions, "roughnessFactor": 0.4, "metallicFactor": 0}
    with pytest.raises(
        UsageError, match=r"a\.gltf: material \"paint\" transmits light"
    ):
        gltf_material(tmp_path, **rough)
    opaque, scene = gltf_material(tmp_path, lenient=True, **rough)
    assert isinstance(opaque, Coated)
    assert noted(scene, "paint", "taken as opaque")


def test_a_very_narrow_lobe_is_smooth(tmp_path):
    material, scene = gltf_material(tmp_path, roughnessFactor=0.03)
    assert material.alpha == 0
    assert noted(scene, "paint", "0.0009", "smooth")


def test_gltf_emission_and_its_strength(tmp_path):
    material = {"name": "lamp", "emissiveFactor": [1, 0.5, 0]}
    strength = {"KHR_materials_emissive_strength": {"emissiveStrength": 40}}
    scene = load_gltf(triangle_file({**material, "extensions": strength}), tmp_path)
    assert scene.meshes[0].emission == (40, 20, 0)
    assert scene.environment is None
    assert noted(scene, "photometric")
    scene = load_gltf(triangle_file(material), tmp_path)
    assert scene.meshes[0].emission == (1, 0.5, 0)


def test_gltf_base_colour_is_texture_times_factor(tmp_path):
    stored = np.array(
        [[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [128, 128, 128]]], np.uint8
    )
    uv = np.float32([[0.25, 0.25], [0.75, 0.25], [0.25, 0.75]])
    pbr = {"baseColorTexture": {"index": 0}, "baseColorFactor": [0.5, 1, 1, 1]}
    gltf = triangle_file({"pbrMetallicRoughness": pbr}, TEXCOORD_0=uv)
    gltf.texture(stored)
    mesh = load_gltf(gltf, tmp_path).meshes[0]
    assert isinstance(mesh.material.reflectance, Bitmap)
    seen = read(mesh.material.reflectance, mesh.uv)
    # Texel centres, counted from the top left in glTF.
    assert_allclose(seen, [[0.5, 0, 0], [0, 1, 0], [0, 0, 1]], atol=1e-7)
    linear = decode_srgb(np.array(128 / 255))
    assert_allclose(
        read(mesh.material.reflectance, np.array([[0.75, 0.25]])),
        [[linear / 2, linear, linear]],
    )


def test_gltf_texture_transform(tmp_path):
    """The extension's own example: the lower left quarter, turned by 90 degrees."""
    transform = {"offset": [0, 1], "rotation": np.pi / 2, "scale": [0.5, 0.5]}
    info = {"index": 0, "extensions": {"KHR_texture_transform": transform}}
    corners = np.float32([[0, 0], [1, 0], [0, 1]])
    gltf = triangle_file(
        {"pbrMetallicRoughness": {"baseColorTexture": info}}, TEXCOORD_0=corners
    )
    gltf.texture(np.zeros((2, 2, 3), np.uint8))
    uv = load_gltf(gltf, tmp_path).meshes[0].uv
    assert_allclose(uv, [[0, 0], [0, 0.5], [0.5, 0]], atol=1e-15)


def test_gltf_second_texture_coordinates_and_nearest_filter(tmp_path):
    info = {"index": 0, "texCoord": 1}
    gltf = triangle_file(
        {"pbrMetallicRoughness": {"baseColorTexture": info}},
        TEXCOORD_0=np.zeros((3, 2), np.float32),
        TEXCOORD_1=np.full((3, 2), 0.25, np.float32),
    )
    gltf.texture(np.zeros((2, 2, 3), np.uint8))
    gltf.tree["samplers"] = [{"magFilter": 9728, "wrapS": 33071}]
    gltf.tree["textures"][0]["sampler"] = 0
    scene = load_gltf(gltf, tmp_path)
    assert_allclose(scene.meshes[0].uv, np.tile([0.25, 0.75], (3, 1)))
    assert scene.meshes[0].material.reflectance.filter == "nearest"
    assert noted(scene, "repeats")


def test_gltf_what_is_ignored_is_noted(tmp_path):
    material = {
        "name": "paint",
        "alphaMode": "BLEND",
        "normalTexture": {"index": 0},
        "occlusionTexture": {"index": 0},
        "emissiveTexture": {"index": 0},
        "emissiveFactor": [1, 1, 1],
        "pbrMetallicRoughness": {"metallicRoughnessTexture": {"index": 0}},
        "extensions": {"KHR_materials_sheen": {}, "KHR_materials_unlit": {}},
    }
    gltf = triangle_file(material)
    gltf.texture(np.full((1, 1, 3), (0, 51, 102), np.uint8))
    gltf.tree["animations"] = []
    scene = load_gltf(gltf, tmp_path)
    words = ["alpha", "normalTexture", "occlusionTexture", "emissiveTexture", "unlit"]
    words += ["metallicRoughnessTexture", "KHR_materials_sheen"]
    for word in words:
        assert noted(scene, "paint", word), word
    assert noted(scene, "Animations")
    # Roughness in green, metallic in blue, both linear; colours are sRGB.
    mesh = scene.meshes[0]
    assert isinstance(mesh.material, Coated)
    assert mesh.material.alpha == pytest.approx(0.2**2)
    assert_allclose(mesh.emission, decode_srgb(np.array([0, 0.2, 0.4])))


def test_gltf_camera(tmp_path):
    gltf = triangle_file()
    lens = {"yfov": np.radians(40), "aspectRatio": 2.0, "znear": 0.1}
    gltf.tree["cameras"] = [{"type": "perspective", "perspective": lens}]
    gltf.tree["nodes"] += [{"camera": 0, "translation": [0, 0, 5]}]
    gltf.tree["nodes"] += [{"translation": [1, 2, 3], "children": [1]}]
    gltf.tree["scenes"] = [{"nodes": [0, 2]}]
    scene = load_gltf(gltf, tmp_path)
    camera = scene.camera
    assert camera.position == (1, 2, 8)
    assert (camera.width, camera.height) == (256, 128)
    assert noted(scene, "256x128")
    # The top of the image is half of 40 degrees up, and as much again of it aside.
    _, direction = camera_rays(camera, np.array([128.0, 256.0]), np.array([0.0, 64.0]))
    up = np.tan(np.radians(20))
    expected = [[0, up / np.hypot(1, up), -1 / np.hypot(1, up)]]
    expected += [[2 * up / np.hypot(1, 2 * up), 0, -1 / np.hypot(1, 2 * up)]]
    assert_allclose(direction, expected, atol=1e-15)


def test_gltf_mirrored_camera(tmp_path):
    gltf = triangle_file()
    gltf.tree["cameras"] = [{"type": "perspective", "perspective": {"yfov": 1.0}}]
    gltf.tree["nodes"] += [{"camera": 0, "scale": [-1, 1, 1]}]
    gltf.tree["scenes"][0]["nodes"] = [0, 1]
    camera = load_gltf(gltf, tmp_path).camera
    _, direction = camera_rays(camera, np.array([256.0]), np.array([128.0]))
    assert direction[0, 0] < 0  # what is on the right is seen on the left


def test_gltf_lights(tmp_path):
    gltf = triangle_file()
    listed = [
        {"type": "point", "color": [1, 0.5, 0], "intensity": 8, "range": 3},
        {"type": "directional", "intensity": 2},
        {"type": "spot", "name": "beam", "intensity": 5, "spot": {}},
    ]
    gltf.tree["extensions"] = {"KHR_lights_punctual": {"lights": listed}}

    def node(light, **more):
        return {"extensions": {"KHR_lights_punctual": {"light": light}}, **more}

    turn = [np.sqrt(0.5), 0, 0, np.sqrt(0.5)]  # about x: -z becomes +y
    gltf.tree["nodes"] += [node(0, translation=[1, 2, 3]), node(1, rotation=turn)]
    gltf.tree["scenes"][0]["nodes"] = [0, 1, 2]
    scene = load_gltf(gltf, tmp_path)
    assert scene.points == (PointLight((1.0, 2.0, 3.0), (8.0, 4.0, 0.0)),)
    assert_allclose(scene.suns[0].direction, [0, 1, 0], atol=1e-15)
    assert scene.suns[0].irradiance == (2, 2, 2)
    assert noted(scene, "photometric")
    assert noted(scene, "range")

    gltf.tree["nodes"] += [node(2)]
    gltf.tree["scenes"][0]["nodes"] = [0, 3]
    with pytest.raises(UsageError, match='light "beam" is a spot light'):
        load_gltf(gltf, tmp_path)
    scene = load_gltf(gltf, tmp_path, lenient=True)
    assert scene.points == (PointLight((0.0, 0.0, 0.0), (5.0, 5.0, 5.0)),)
    assert noted(scene, "beam", "point light")


def test_a_file_without_camera_or_light_gets_both_with_a_note(tmp_path):
    scene = load_gltf(triangle_file(), tmp_path)
    assert scene.environment == ConstantEnvironment((1.0, 1.0, 1.0))
    assert noted(scene, "no camera")
    assert noted(scene, "environment of radiance 1")
    # All corners lie within the image.
    right, up, forward = scene.camera.axes
    offset = scene.meshes[0].vertices - scene.camera.position
    reach = scene.camera.half_width * (offset @ forward)
    assert (np.abs(offset @ right) < reach).all()
    assert (np.abs(offset @ up) < reach).all()


# ---------------------------------------------------------------- OBJ and PLY


def write_obj(tmp_path, text, mtl=None):
    (tmp_path / "a.obj").write_text(text)
    if mtl is not None:
        (tmp_path / "a.mtl").write_text(mtl)
    return tmp_path / "a.obj"


QUAD = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


def test_obj_materials(tmp_path):
    (tmp_path / "a.png").write_bytes(png(np.full((1, 2, 3), (255, 0, 0), np.uint8)))
    obj = (
        f"mtllib a.mtl\n{QUAD}vt 0 0\nvt 1 0\nvt 1 1\n"
        "usemtl paint\nf 1 2 3\nusemtl lamp\nf 1 3 4\n"
        "usemtl picture\nf 1/1 2/2 3/3\n"
    )
    mtl = (
        "# a comment\nnewmtl paint\nKd 0.1 0.2 0.3\nNs 10\nillum 2\n"
        "newmtl lamp\nKd 0 0 0\nKe 5 6 7\n"
        "newmtl picture\nKd 0.5 0.5 0.5\nmap_Kd a.png\n"
    )
    scene = load_scene(write_obj(tmp_path, obj, mtl))
    lamp, paint, picture = scene.meshes
    assert [mesh.name for mesh in scene.meshes] == ["lamp", "paint", "picture"]
    assert paint.material.reflectance == (0.1, 0.2, 0.3)
    assert paint.material.two_sided
    assert lamp.emission == (5, 6, 7)
    assert paint.emission == (0, 0, 0)
    assert_allclose(read(picture.material.reflectance, picture.uv), [[0.5, 0, 0]] * 3)
    assert scene.environment is None
    assert noted(scene, "paint", "ns", "ignored")
    assert_allclose(face_normals(lamp), [[0, 0, 1]])
    assert_allclose(lamp.vertices[lamp.faces[0]].sum(axis=0), [1, 2, 0])


def test_obj_polygons_normals_and_defaults(tmp_path):
    text = f"{QUAD}vn 0 0 1\nvn 0 1 0\nf 1//1 2//1 3//2 4//2\n"
    scene = load_scene(write_obj(tmp_path, text))
    (mesh,) = scene.meshes
    assert mesh.name == "a"
    assert len(mesh.faces) == 2
    upper = mesh.vertices[:, 1] > 0.5
    expected = np.where(upper[:, None], [0, 1, 0], [0, 0, 1])
    assert_allclose(mesh.normals, expected)
    assert mesh.material.reflectance == (0.8, 0.8, 0.8)
    assert noted(scene, '"a"', "no material")
    assert scene.environment == ConstantEnvironment((1.0, 1.0, 1.0))


def test_obj_missing_files(tmp_path):
    path = write_obj(tmp_path, f"mtllib no.mtl\n{QUAD}usemtl x\nf 1 2 3\n")
    with pytest.raises(UsageError, match=r'a\.obj: the material file "no\.mtl"'):
        load_scene(path)
    assert noted(load_scene(path, lenient=True), "no.mtl", "0.8")

    mtl = "newmtl x\nmap_Kd no.png\n"
    path = write_obj(
        tmp_path, f"mtllib a.mtl\n{QUAD}vt 0 0\nusemtl x\nf 1/1 2/1 3/1", mtl
    )
    with pytest.raises(UsageError, match=r'a\.mtl: material "x": .*no\.png'):
        load_scene(path)
    scene = load_scene(path, lenient=True)
    assert scene.meshes[0].material.reflectance == (0.5, 0.5, 0.5)
    assert noted(scene, "no.png", "mid grey")


def test_a_texture_without_coordinates_has_its_mean_colour(tmp_path):
    stored = np.array([[[0, 0, 0], [255, 255, 255]]], np.uint8)
    (tmp_path / "a.png").write_bytes(png(stored))
    mtl = "newmtl x\nKd 1 1 1\nmap_Kd a.png\n"
    path = write_obj(tmp_path, f"mtllib a.mtl\n{QUAD}usemtl x\nf 1 2 3\n", mtl)
    with pytest.raises(UsageError, match="no texture coordinates"):
        load_scene(path)
    scene = load_scene(path, lenient=True)
    assert_allclose(scene.meshes[0].material.reflectance, [0.5] * 3)
    assert noted(scene, "mean colour")


def test_obj_faces_that_count_backwards_are_refused(tmp_path):
    path = write_obj(tmp_path, f"{QUAD}f 1 2 3\nf -3 -2 -1\n")
    with pytest.raises(UsageError, match=r"a\.obj: line 6: .* backwards"):
        load_scene(path)


def ply(vertices, faces, properties="x y z"):
    """An ASCII PLY file."""
    columns = "".join(f"property float {name}\n" for name in properties.split())
    head = f"ply\nformat ascii 1.0\nelement vertex {len(vertices)}\n{columns}"
    head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\n"
    rows = [" ".join(map(str, row)) for row in vertices]
    rows += [" ".join(map(str, (len(face), *face))) for face in faces]
    return head + "end_header\n" + "\n".join(rows) + "\n"


def test_ply_keeps_every_vertex_with_its_normal_and_uv(tmp_path):
    # Two faces share vertices; order and number must survive.
    rows = [
        (0, 0, 0, 0, 0, 1, 0.0, 0.0),
        (1, 0, 0, 0, 1, 0, 0.9, 0.1),
        (1, 1, 0, 1, 0, 0, 0.8, 0.7),
        (0, 1, 0, 0, 0.6, 0.8, 0.2, 0.3),
        (9, 9, 9, 0, 0, 1, 0.5, 0.5),
    ]
    text = ply(rows, [(0, 1, 2), (0, 2, 3)], "x y z nx ny nz s t")
    (tmp_path / "a.ply").write_text(text)
    (mesh,) = load_scene(tmp_path / "a.ply").meshes
    table = np.array(rows)
    assert_allclose(mesh.vertices, table[:, :3])
    assert_allclose(mesh.normals, table[:, 3:6])
    assert_allclose(mesh.uv[:4], table[:4, 6:])  # no face has the last
    assert_array_equal(np.sort(mesh.faces), [[0, 1, 2], [0, 2, 3]])


def test_ply_of_an_independent_writer_is_read(tmp_path):
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions=2)
    ball.export(tmp_path / "a.ply")
    (mesh,) = load_scene(tmp_path / "a.ply").meshes
    assert_allclose(mesh.vertices, ball.vertices, atol=EPS32)
    assert_array_equal(mesh.faces, ball.faces)


def test_ply_colours_are_noted(tmp_path):
    rows = [(0, 0, 0, 255, 0, 0), (1, 0, 0, 255, 0, 0), (0, 1, 0, 255, 0, 0)]
    text = ply(rows, [(0, 1, 2)], "x y z red green blue").replace(
        "float red", "uchar red"
    )
    text = text.replace("float green", "uchar green").replace(
        "float blue", "uchar blue"
    )
    (tmp_path / "a.ply").write_text(text)
    assert noted(load_scene(tmp_path / "a.ply"), "a.ply", "vertex colours")


# ---------------------------------------------------------------- scene.json


@pytest.fixture
def write_json(tmp_path):
    """Return a writer of scenes of one triangle, changed as told."""
    (tmp_path / "t.ply").write_text(ply(TRIANGLE, [(0, 1, 2)]))

    def write(material=None, shape=None, **top):
        material = material or {"type": "diffuse", "reflectance": 0.5}
        entry = {"id": "wall", "file": "t.ply", "material": "m", **(shape or {})}
        tree = {"name": "tiny", "materials": {"m": material}, "shapes": [entry], **top}
        (tmp_path / "scene.json").write_text(json.dumps(tree))
        return tmp_path / "scene.json"

    return write


def json_material(write_json, lenient=False, **entry):
    return load_scene(write_json(entry), lenient).meshes[0].material


def test_json_shapes(write_json):
    scene = load_scene(write_json(shape={"emission": [1, 2, 3], "triangles": 1}))
    assert scene.name == "tiny"
    (mesh,) = scene.meshes
    assert (mesh.name, mesh.emission) == ("wall", (1, 2, 3))
    assert_array_equal(mesh.vertices, TRIANGLE)
    assert mesh.normals is None
    assert load_scene(write_json(shape={"emission": None})).meshes[0].emission == (
        0,
        0,
        0,
    )


def test_json_sphere(write_json):
    shape = {"type": "sphere", "center": [1, 2, 3], "radius": 0.5, "inward": True}
    path = write_json(shapes=[{"id": "ball", "material": "m", **shape}])
    (sphere,) = load_scene(path).spheres
    assert (sphere.name, sphere.center, sphere.radius) == ("ball", (1, 2, 3), 0.5)
    assert sphere.inward


def test_json_materials(write_json):
    matt = json_material(write_json, type="diffuse", reflectance=[0.1, 0.2, 0.3])
    assert (matt.reflectance, matt.two_sided) == ((0.1, 0.2, 0.3), False)
    assert json_material(
        write_json, type="diffuse", reflectance=0.5, twosided=True
    ).two_sided

    metal = json_material(
        write_json,
        type="ggx_conductor",
        alpha=0.25,
        specular_reflectance=[0.8, 0.4, 0.2],
        fresnel=0.5,
    )
    assert (metal.alpha, metal.eta, metal.schlick) == (0.25, None, False)
    assert_allclose(metal.reflectance, [0.4, 0.2, 0.1])
    assert not metal.two_sided
    gold = json_material(write_json, type="conductor", eta=[0.1, 0.4, 1.4], k=2)
    assert (gold.alpha, gold.eta, gold.k) == (0, (0.1, 0.4, 1.4), (2, 2, 2))
    assert json_material(write_json, type="mirror").reflectance == (1, 1, 1)

    coat = json_material(
        write_json,
        type="roughplastic",
        alpha=0.1,
        reflectance=0.4,
        int_ior=1.8,
        ext_ior=1.2,
        nonlinear=True,
    )
    assert (coat.alpha, coat.nonlinear) == (0.1, True)
    assert coat.ior == pytest.approx(1.5)
    assert json_material(write_json, type="plastic", diffuse_reflectance=0.4).alpha == 0
    assert json_material(write_json, type="dielectric", ior=1.33) == Dielectric(1.33)


@pytest.mark.parametrize(
    ("material", "message"),
    [
        ({"type": "velvet"}, "'velvet'; known are diffuse,"),
        ({"type": "diffuse"}, "reflectance is None"),
        ({"type": "diffuse", "reflectance": [1, 2]}, r"reflectance is \[1, 2\]"),
        ({"type": "diffuse", "reflectance": 0.5, "sheen": 1}, 'the key "sheen"'),
        ({"type": "mirror", "eta": 1}, "eta together with k"),
        ({"type": "ggx_conductor", "alpha": "x"}, "alpha is 'x'"),
        ({"type": "ggx_conductor", "alpha": 1, "distribution": "beckmann"}, "beckmann"),
    ],
)
def test_json_materials_that_are_not_understood(write_json, material, message):
    with pytest.raises(UsageError, match=f'scene.json: material "m".*{message}'):
        load_scene(write_json(material))


def test_json_lenient_replacements_are_noted(write_json):
    material = {"type": "velvet"}
    scene = load_scene(write_json(material, shape={"triangles": 7}), lenient=True)
    assert scene.meshes[0].material.reflectance == (0.5, 0.5, 0.5)
    assert noted(scene, "velvet", "0.5")
    assert noted(scene, "wall", "not 7")
    assert noted(load_scene(write_json(comment="x", spp=64)), "comment, spp")


def test_json_remarks_are_noted_and_unknown_keys_refused(write_json):
    remark = {"type": "diffuse", "reflectance": 0.5, "source": "guess"}
    assert noted(load_scene(write_json(remark)), "source")
    with pytest.raises(UsageError, match='shape "wall": the key "to_world"'):
        load_scene(write_json(shape={"to_world": [1, 2]}))


@pytest.mark.parametrize("axis", FOV_AXES)
def test_json_camera(write_json, axis):
    camera = {"origin": [0, 0, 5], "target": [0, 0, 0], "up": [0, 2, 0]}
    camera |= {"fov_deg": 40, "fov_axis": axis, "width": 200, "height": 100}
    made = load_scene(write_json(camera=camera)).camera
    assert (made.position, made.target, made.up) == ((0, 0, 5), (0, 0, 0), (0, 2, 0))
    assert (made.width, made.height, made.mirrored) == (200, 100, False)
    assert (made.fov, made.fov_axis) == (40, axis)
    camera["fov_axis"] = "z"
    with pytest.raises(UsageError, match="fov_axis is 'z'"):
        load_scene(write_json(camera=camera))


def test_json_lights(write_json, tmp_path):
    (tmp_path / "sky.png").write_bytes(png(np.full((2, 4, 3), 255, np.uint8)))
    lights = [
        {"type": "point", "position": [1, 2, 3], "intensity": 4},
        {"type": "directional", "direction": [0, -2, 0], "irradiance": [1, 2, 3]},
    ]
    scene = load_scene(write_json(lights=lights, environment=[0.1, 0.2, 0.3]))
    assert scene.points == (PointLight((1.0, 2.0, 3.0), (4.0, 4.0, 4.0)),)
    assert scene.suns == (DirectionalLight((0.0, -1.0, 0.0), (1.0, 2.0, 3.0)),)
    assert scene.environment == ConstantEnvironment((0.1, 0.2, 0.3))
    scene = load_scene(write_json(environment={"file": "sky.png", "scale": 3}))
    assert isinstance(scene.environment, LatLongEnvironment)
    assert_allclose(scene.environment.pixels, np.full((2, 4, 3), 3.0))
    assert_array_equal(scene.environment.to_world, np.eye(3))
    with pytest.raises(UsageError, match="light 0 has the type 'torch'"):
        load_scene(write_json(lights=[{"type": "torch"}]))


def test_json_has_no_default_light(write_json):
    scene = load_scene(write_json())
    assert scene.environment is None
    assert noted(scene, "no camera")

"""glTF against files written here: values, pixels, and the fate of every word."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from reference.errors import UsageError
from reference.scene.camera import camera_rays
from reference.scene.lights import ConstantEnvironment, PointLight
from reference.scene.loaders.load import load_scene
from reference.scene.loaders.pictures import decode_srgb
from reference.scene.materials.kinds import Coated, Conductor, Dielectric, Lambertian
from reference.scene.textures import Bitmap, read
from tests.contracts.gltf_files import (
    TRIANGLE,
    Gltf,
    gltf_material,
    load_gltf,
    triangle_file,
)
from tests.contracts.test_loaders import EPS32, face_normals, noted


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

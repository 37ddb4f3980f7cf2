"""glTF against files written here: values, pixels, and the use of every word."""

import json

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from restir_gi.reference.scene.camera import camera_rays
from restir_gi.reference.scene.lights import ConstantEnvironment, PointLight, SpotLight
from restir_gi.reference.scene.loaders.load import load_scene
from restir_gi.reference.scene.loaders.pictures import decode_srgb
from restir_gi.reference.scene.materials.kinds import (
    Coated,
    Conductor,
    Dielectric,
    Lambertian,
)
from restir_gi.reference.scene.textures import Bitmap, read
from restir_gi.reference.system.errors import UsageError
from tests.analytic.rendering import path_traced, what_is_seen, world_of
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
    with pytest.raises(UsageError, match=r"paint.*metallic 0\.7 is neither"):
        gltf_material(tmp_path, metallicFactor=0.7)
    metal, half = gltf_material(tmp_path, lenient=True, metallicFactor=0.7)
    assert isinstance(metal, Conductor)
    assert noted(half, "paint", "metallic 0.7", "the nearer of the two")


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


GLASS = {
    "KHR_materials_transmission": {"transmissionFactor": 1},
    "KHR_materials_ior": {"ior": 1.33},
    "KHR_materials_volume": {"thicknessFactor": 1},
}


@pytest.mark.parametrize("rough", [0, 0.4])
def test_gltf_glass_with_a_volume_is_a_solid(tmp_path, rough):
    pbr = {"roughnessFactor": rough, "metallicFactor": 0}
    glass, scene = gltf_material(tmp_path, extensions=GLASS, **pbr)
    assert glass == Dielectric(1.33, pytest.approx(rough**2))
    assert not noted(scene, "paint")


@pytest.mark.parametrize(
    ("changes", "pbr", "problem", "instead"),
    [
        ({"KHR_materials_volume": {}}, {}, "a thin wall of glass", "of solid glass"),
        (
            {"KHR_materials_transmission": {"transmissionFactor": 0.5}},
            {},
            "transmits 0.5 of the light",
            "taken as opaque",
        ),
        (
            {
                "KHR_materials_volume": {
                    "thicknessFactor": 1,
                    "attenuationDistance": 2,
                    "attenuationColor": [1, 0.5, 0.5],
                }
            },
            {},
            "fades within the glass",
            "taken as white",
        ),
        ({}, {"baseColorFactor": [1, 0, 0, 1]}, "base colour", "colourless"),
    ],
)
def test_gltf_glass_of_other_kinds(tmp_path, changes, pbr, problem, instead):
    given = {"extensions": GLASS | changes, "metallicFactor": 0, **pbr}
    with pytest.raises(UsageError, match=problem):
        gltf_material(tmp_path, **given)
    material, scene = gltf_material(tmp_path, lenient=True, **given)
    assert noted(scene, "paint", problem, instead)
    assert isinstance(material, Coated if "opaque" in instead else Dielectric)


def test_gltf_metal_transmits_nothing(tmp_path):
    metal, _ = gltf_material(tmp_path, extensions=GLASS, metallicFactor=1)
    assert isinstance(metal, Conductor)


def test_gltf_specular_is_all_or_nothing(tmp_path):
    def made(factor, lenient=False):
        extension = {"KHR_materials_specular": {"specularFactor": factor}}
        return gltf_material(tmp_path, lenient, extension, metallicFactor=0)

    assert isinstance(made(1)[0], Coated)
    assert isinstance(made(0)[0], Lambertian)
    with pytest.raises(UsageError, match=r"specularFactor 0\.5"):
        made(0.5)
    assert isinstance(made(0.5, lenient=True)[0], Coated)


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


def test_gltf_second_texture_coordinates_and_sampler(tmp_path):
    info = {"index": 0, "texCoord": 1}
    gltf = triangle_file(
        {"pbrMetallicRoughness": {"baseColorTexture": info}},
        TEXCOORD_0=np.zeros((3, 2), np.float32),
        TEXCOORD_1=np.full((3, 2), 0.25, np.float32),
    )
    gltf.texture(np.zeros((2, 2, 3), np.uint8))
    gltf.tree["samplers"] = [{"magFilter": 9728, "wrapS": 33071, "wrapT": 33648}]
    gltf.tree["textures"][0]["sampler"] = 0
    mesh = load_gltf(gltf, tmp_path).meshes[0]
    assert_allclose(mesh.uv, np.tile([0.25, 0.75], (3, 1)))
    assert mesh.material.reflectance.filter == "nearest"
    assert mesh.material.reflectance.wrap == ("clamp", "mirror")


def test_gltf_all_that_is_refused_is_told_at_once_before_meshes_are_read(tmp_path):
    material = {
        "name": "paint",
        "alphaMode": "BLEND",
        "normalTexture": {"index": 0},
        "occlusionTexture": {"index": 0},
        "pbrMetallicRoughness": {
            "baseColorFactor": [1, 1, 1, 0.5],
            "metallicRoughnessTexture": {"index": 0},
        },
        "extensions": {
            "KHR_materials_sheen": {"sheenColorFactor": [1, 1, 1]},
            "KHR_materials_clearcoat": {"clearcoatFactor": 0},
            "KHR_materials_unlit": {},
        },
    }
    gltf = triangle_file(material)
    # Roughness in green, metallic in blue, both linear.
    gltf.texture(np.array([[(0, 51, 0), (0, 153, 0)]], np.uint8))
    gltf.tree["animations"] = []
    gltf.tree["extensionsUsed"] = ["EXT_unheard_of"]
    gltf.tree["nodes"][0]["scael"] = [1, 2, 3]
    gltf.tree["accessors"][0]["count"] = 10**12  # nobody looks
    told = ["alphaMode BLEND", "normalTexture", "metallicRoughnessTexture that varies"]
    told += ["sheenColorFactor", "KHR_materials_unlit", '"EXT_unheard_of"', '"scael"']
    with pytest.raises(UsageError, match=f"{len(told)} faults") as caught:
        load_gltf(gltf, tmp_path)
    assert all(word in str(caught.value) for word in told)
    gltf.tree["accessors"][0]["count"] = 3
    scene = load_gltf(gltf, tmp_path, lenient=True)
    assert all(noted(scene, word) for word in [*told, "Animations"])
    material = scene.meshes[0].material
    assert isinstance(material, Coated)
    assert material.alpha == pytest.approx(0.4**2)


def test_gltf_materials_that_nothing_wears_do_not_matter(tmp_path):
    gltf = triangle_file({})
    bumpy = {"normalTexture": {"index": 0}, "extensions": {"EXT_unheard_of": {}}}
    gltf.tree["materials"].append(bumpy)
    gltf.tree = dict(reversed(gltf.tree.items()))  # whatever the order of the file
    load_gltf(gltf, tmp_path)
    gltf.tree["meshes"][0]["primitives"][0]["material"] = 1
    with pytest.raises(UsageError, match="2 faults"):
        load_gltf(gltf, tmp_path)


def test_gltf_metallic_roughness_textures_of_one_value_are_factors(tmp_path):
    """Only the channels count that the factors let through."""
    pbr = {"metallicRoughnessTexture": {"index": 0}, "metallicFactor": 0}
    pbr["roughnessFactor"] = 0.5
    gltf = triangle_file({"pbrMetallicRoughness": pbr})
    gltf.texture(np.array([[(9, 102, 0), (0, 102, 255)]], np.uint8))
    material = load_gltf(gltf, tmp_path).meshes[0].material
    assert isinstance(material, Coated)
    assert material.alpha == pytest.approx(0.2**2)


def test_gltf_emission_is_texture_times_factor_times_strength(tmp_path):
    """As many times over 1 as wanted; sRGB is decoded first."""
    strength = {"KHR_materials_emissive_strength": {"emissiveStrength": 10}}
    material = {"emissiveTexture": {"index": 0}, "emissiveFactor": [1, 0.5, 0]}
    gltf = triangle_file(
        material | {"extensions": strength, "doubleSided": True},
        TEXCOORD_0=np.float32([[0.25, 0.5], [0.75, 0.5], [0, 0]]),
    )
    gltf.texture(np.array([[(128, 128, 128), (255, 0, 255)]], np.uint8))
    scene = load_gltf(gltf, tmp_path)
    (mesh,) = scene.meshes
    linear = decode_srgb(np.array(128 / 255))
    expected = [[10 * linear, 5 * linear, 0], [10, 0, 0]]
    assert_allclose(read(mesh.emission, mesh.uv[:2]), expected, atol=1e-12)
    assert mesh.two_sided_emission
    assert scene.environment is None
    assert noted(scene, "photometric")


def test_gltf_a_texture_of_emission_alone_may_lie_where_it_likes(tmp_path):
    move = {"KHR_texture_transform": {"offset": [0.5, 0]}}
    moved = {"index": 0, "extensions": move}
    material = {"emissiveTexture": moved, "emissiveFactor": [1, 1, 1]}
    coordinates = np.zeros((3, 2), np.float32)
    gltf = triangle_file(material, TEXCOORD_0=coordinates)
    gltf.texture(np.array([[(255, 0, 0), (0, 0, 0)]], np.uint8))
    assert_allclose(load_gltf(gltf, tmp_path).meshes[0].uv, [[0.5, 1]] * 3)
    material["pbrMetallicRoughness"] = {"baseColorTexture": {"index": 0}}
    with pytest.raises(UsageError, match="placed unlike baseColorTexture"):
        load_gltf(gltf, tmp_path)
    mesh = load_gltf(gltf, tmp_path, lenient=True).meshes[0]
    assert mesh.emission == (0.5, 0, 0)
    material["pbrMetallicRoughness"] = {"baseColorTexture": moved}
    assert isinstance(load_gltf(gltf, tmp_path).meshes[0].emission, Bitmap)


@pytest.mark.parametrize(
    ("stored", "normalized"),
    [
        (np.float32([[1, 0.2, 0], [0, 1, 0], [0, 0, 1]]), False),
        (np.array([[255, 51, 0], [0, 255, 0], [0, 0, 255]], np.uint8), True),
        (np.array([[65535, 13107, 0], [0, 65535, 0], [0, 0, 65535]], np.uint16), True),
    ],
)
@pytest.mark.parametrize("alpha", [False, True])
def test_gltf_vertex_colours(tmp_path, stored, normalized, alpha):
    if alpha:  # which nothing reads where the material is opaque
        stored = np.c_[stored, stored[:, :1] // 2].astype(stored.dtype)
    gltf = triangle_file()
    color = gltf.accessor(stored, normalized=normalized)
    gltf.tree["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = color
    mesh = load_gltf(gltf, tmp_path).meshes[0]
    assert_allclose(mesh.colors, [[1, 0.2, 0], [0, 1, 0], [0, 0, 1]], rtol=1e-7)


def test_gltf_vertex_colours_that_are_not_modelled(tmp_path):
    colors = np.float32([[1, 0.2, 2], [0, 1, 0], [0, 0, 1]])
    with pytest.raises(
        UsageError, match='mesh "mesh 0": its vertex colours are 0 to 2'
    ):
        load_gltf(triangle_file(COLOR_0=colors), tmp_path)
    mesh = load_gltf(triangle_file(COLOR_0=colors), tmp_path, lenient=True).meshes[0]
    assert mesh.colors.max() == 1
    with_alpha = np.c_[np.minimum(colors, 1), [1, 1, 0.5]].astype(np.float32)
    mask = triangle_file({"alphaMode": "MASK"}, COLOR_0=with_alpha)
    with pytest.raises(UsageError, match="the alpha of its vertex colours"):
        load_gltf(mask, tmp_path)
    assert load_gltf(mask, tmp_path, lenient=True).meshes[0].opacity is None


def test_gltf_masks_are_alpha_times_factor(tmp_path):
    pbr = {"baseColorTexture": {"index": 0}, "baseColorFactor": [1, 1, 1, 0.5]}
    material = {"alphaMode": "MASK", "alphaCutoff": 0.3, "pbrMetallicRoughness": pbr}
    gltf = triangle_file(material, TEXCOORD_0=np.zeros((3, 2), np.float32))
    gltf.texture(np.array([[(0, 0, 0, 255), (0, 0, 0, 51)]], np.uint8))
    mesh = load_gltf(gltf, tmp_path).meshes[0]
    assert_allclose(mesh.opacity.pixels, np.tile([[[0.5]], [[0.1]]], 3).swapaxes(0, 1))
    assert mesh.opacity_cutoff == 0.3
    material["alphaCutoff"] = 0.05
    assert load_gltf(gltf, tmp_path).meshes[0].opacity is None
    material["alphaCutoff"] = 1.5  # glTF: all of it is transparent
    assert load_gltf(gltf, tmp_path).meshes == ()
    material["alphaMode"] = "OPAQUE"
    assert load_gltf(gltf, tmp_path).meshes[0].opacity is None


def test_gltf_blending_with_alpha_1_is_opaque(tmp_path):
    material = {"alphaMode": "BLEND"}
    assert len(load_gltf(triangle_file(material), tmp_path).meshes) == 1
    material["pbrMetallicRoughness"] = {"baseColorFactor": [1, 1, 1, 0.9]}
    with pytest.raises(UsageError, match="alphaMode BLEND is not modelled"):
        load_gltf(triangle_file(material), tmp_path)


def test_gltf_instances(tmp_path):
    """Turned by 90 degrees about z, moved, scaled and mirrored, within the node."""
    gltf = triangle_file(NORMAL=np.tile(np.float32([0, 0, 1]), (3, 1)))
    half = np.sqrt(0.5)
    attributes = {
        "TRANSLATION": gltf.accessor(np.float32([[0, 0, 0], [5, 0, 0]])),
        "ROTATION": gltf.accessor(np.float32([[0, 0, 0, 1], [0, 0, half, half]])),
        "SCALE": gltf.accessor(np.float32([[1, 1, 1], [-2, 1, 1]])),
    }
    gltf.tree["nodes"][0] |= {
        "translation": [0, 0, 7],
        "extensions": {"EXT_mesh_gpu_instancing": {"attributes": attributes}},
    }
    (mesh,) = load_gltf(gltf, tmp_path).meshes
    expected = np.concatenate([TRIANGLE, [[5, 0, 0], [5, -2, 0], [4, 0, 0]]])
    assert_allclose(mesh.vertices, np.add(expected, [0, 0, 7]), atol=8 * EPS32)
    assert_allclose(face_normals(mesh), [[0, 0, 1]] * 2, atol=8 * EPS32)
    assert_allclose(mesh.normals, [[0, 0, 1]] * 6, atol=8 * EPS32)
    attributes["SCALE"] = gltf.accessor(np.float32([[1, 1, 1]]))
    with pytest.raises(UsageError, match=r"node 0: the attributes .* number 1, 2"):
        load_gltf(gltf, tmp_path)


def test_gltf_morph_targets_count_with_their_weights(tmp_path):
    gltf = triangle_file()
    gltf.tree["meshes"][0]["primitives"][0]["targets"] = [{"POSITION": 0}]
    gltf.tree["meshes"][0]["weights"] = [0]
    assert len(load_gltf(gltf, tmp_path).meshes) == 1
    gltf.tree["nodes"][0]["weights"] = [0.5]
    with pytest.raises(UsageError, match="node 0: morph targets"):
        load_gltf(gltf, tmp_path)


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
        {"type": "point", "color": [1, 0.5, 0], "intensity": 8},
        {"type": "directional", "intensity": 2, "range": 3},  # which has no meaning
        {"type": "spot", "intensity": 5},
        {"type": "spot", "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.3}},
        {"type": "point", "name": "lamp", "range": 3},
    ]
    gltf.tree["extensions"] = {"KHR_lights_punctual": {"lights": listed}}

    def node(light, **more):
        return {"extensions": {"KHR_lights_punctual": {"light": light}}, **more}

    turn = [np.sqrt(0.5), 0, 0, np.sqrt(0.5)]  # about x: -z becomes +y
    gltf.tree["nodes"] += [node(0, translation=[1, 2, 3]), node(1, rotation=turn)]
    gltf.tree["nodes"] += [node(2), node(3, rotation=turn, scale=[3, 3, 3])]
    gltf.tree["scenes"][0]["nodes"] = [0, 1, 2, 3, 4]
    scene = load_gltf(gltf, tmp_path)
    assert scene.points == (PointLight((1.0, 2.0, 3.0), (8.0, 4.0, 0.0)),)
    assert_allclose(scene.suns[0].direction, [0, 1, 0], atol=1e-15)
    assert scene.suns[0].irradiance == (2, 2, 2)
    plain, narrow = scene.spots
    assert plain == SpotLight((0, 0, 0), (0, 0, -1), (5, 5, 5), 45, 0, "smooth")
    assert_allclose(narrow.direction, [0, 1, 0], atol=1e-15)
    assert_allclose([narrow.beam, narrow.cutoff], np.degrees([0.1, 0.3]))
    assert scene.environment is None
    assert noted(scene, "photometric")

    gltf.tree["nodes"] += [node(4)]
    gltf.tree["scenes"][0]["nodes"] = [0, 5]
    with pytest.raises(UsageError, match='light "lamp": that its light ends'):
        load_gltf(gltf, tmp_path)
    scene = load_gltf(gltf, tmp_path, lenient=True)
    assert noted(scene, "lamp", "1/d²")
    listed[3]["spot"]["innerConeAngle"] = 0.4
    gltf.tree["scenes"][0]["nodes"] = [0, 4]
    with pytest.raises(UsageError, match=r"light 3: innerConeAngle is 22\.92 degrees"):
        load_gltf(gltf, tmp_path)


def test_gltf_orthographic_cameras(tmp_path):
    """They do no harm beside a perspective one."""
    gltf = triangle_file()
    lens = {"xmag": 1, "ymag": 1, "znear": 0, "zfar": 9}
    gltf.tree["cameras"] = [{"type": "orthographic", "orthographic": lens}]
    gltf.tree["cameras"] += [{"type": "perspective", "perspective": {"yfov": 0.5}}]
    gltf.tree["nodes"] += [{"camera": 0}, {"camera": 1, "translation": [0, 0, 4]}]
    gltf.tree["scenes"][0]["nodes"] = [0, 1]
    with pytest.raises(UsageError, match="camera 0: an orthographic camera"):
        load_gltf(gltf, tmp_path)
    assert noted(load_gltf(gltf, tmp_path, lenient=True), "orthographic", "ignored")
    gltf.tree["scenes"][0]["nodes"] = [0, 1, 2]
    assert load_gltf(gltf, tmp_path).camera.position == (0, 0, 4)


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


# ---------------------------------------------------------------- hostile files


def refusal(gltf, tmp_path, lenient=False):
    """What is told of a file, without its path."""
    path = gltf.write(tmp_path / "a.gltf") if isinstance(gltf, Gltf) else gltf
    with pytest.raises(UsageError) as caught:
        load_scene(path, lenient)
    return str(caught.value).removeprefix(f"{path}: ")


ELSEWHERE = {
    "/dev/zero": "outside the scene's folder",
    "../outside.bin": "outside the scene's folder",
    "https://example.org/a.bin": "not on this machine",
    "missing.bin": "No such file",
    "%00": "not a file path",
    "%ff": "not a file name",
    "data:;base64,?": "not base64",
}


@pytest.mark.parametrize("uri", ELSEWHERE)
@pytest.mark.parametrize("lenient", [False, True])
def test_gltf_buffers_are_files_of_the_folder(tmp_path, uri, lenient):
    gltf = triangle_file()
    path = gltf.write(tmp_path / "a.gltf")
    path.write_text(
        json.dumps(gltf.tree | {"buffers": [{"byteLength": 9, "uri": uri}]})
    )
    told = refusal(path, tmp_path, lenient)
    assert told.startswith("buffer 0: ")
    assert ELSEWHERE[uri] in told


@pytest.mark.parametrize("uri", ELSEWHERE)
def test_gltf_images_are_files_of_the_folder(tmp_path, uri):
    gltf = triangle_file(
        {"name": "paint", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}},
        TEXCOORD_0=np.zeros((3, 2), np.float32),
    )
    gltf.texture(np.zeros((1, 1, 3), np.uint8))
    gltf.tree["images"] = [{"uri": uri}]
    told = refusal(gltf, tmp_path)
    assert told.startswith('material "paint": texture 0: image 0: ')
    assert ELSEWHERE[uri] in told
    grey = load_gltf(gltf, tmp_path, lenient=True).meshes[0].material.reflectance
    assert_array_equal(grey.pixels, [[[0.5, 0.5, 0.5]]])


def test_gltf_files_elsewhere_are_read_if_that_is_allowed(tmp_path):
    gltf = triangle_file()
    (tmp_path / "outside.bin").write_bytes(gltf.data)
    (tmp_path / "scene").mkdir()
    path = gltf.write(tmp_path / "scene" / "a.gltf")
    gltf.tree["buffers"][0]["uri"] = "../outside.bin"
    path.write_text(json.dumps(gltf.tree))
    assert "--allow-outside" in refusal(path, tmp_path)
    assert len(load_scene(path, allow_outside=True).meshes) == 1


def test_gltf_names_cannot_reach_a_terminal(tmp_path):
    name = "a\x1b[31m\nb\ud800 Stühle"
    gltf = triangle_file({"name": name, "normalTexture": {"index": 0}})
    gltf.tree["nodes"][0]["name"] = name
    gltf.texture(np.zeros((1, 1, 3), np.uint8))
    told = refusal(gltf, tmp_path)
    assert told.isprintable()
    assert "Stühle" in told
    scene = load_gltf(gltf, tmp_path, lenient=True)
    assert scene.meshes[0].name.isprintable()
    assert all(note.isprintable() for note in scene.notes)


def accessor(**words):
    return lambda tree: tree["accessors"][0].update(words)


def view(**words):
    return lambda tree: tree["bufferViews"][0].update(words)


def sparse(index):
    """One sparse element, whose index the file has at some byte."""
    at = {"bufferView": 0, "byteOffset": index, "componentType": 5121}
    return accessor(
        sparse={"count": 1, "indices": at, "values": {"bufferView": 0}}, count=3
    )


def lamp(factor, strength=1):
    extension = {"KHR_materials_emissive_strength": {"emissiveStrength": strength}}
    words = {"emissiveFactor": [factor] * 3, "extensions": extension}
    return lambda tree: tree["materials"][0].update(words)


FAULTS = [
    (view(byteOffset=-36), "buffer view 0: byteOffset is -36; it must be a whole"),
    (view(byteOffset=8), "buffer view 0 reaches beyond its buffer: to byte 44 of 36"),
    (view(byteLength=10**15), "buffer view 0 reaches beyond its buffer"),
    (view(byteStride=4), "elements of 12 bytes every 4 bytes; they must not overlap"),
    (accessor(count=-1), "accessor 0: count is -1; it must be a whole number"),
    (accessor(count=4), 'mesh "mesh 0", POSITION (accessor 0) reads beyond buffer'),
    (accessor(count=True), "accessor 0: count is true"),
    (accessor(count=10**12), "POSITION (accessor 0) has 1000000000000 elements"),
    (accessor(type="SCALAR"), "(accessor 0) is of type SCALAR; it must be VEC3"),
    (accessor(byteOffset=1), "reads beyond buffer view 0: to byte 37 of 36"),
    (sparse(15), "has 3 elements, but sparse ones up to number 63"),
    (lamp(1e308), "material 0: emissiveFactor is [1e+308, 1e+308, 1e+308]"),
    (lamp(3e38, 2), "material 0 emits 6e+38"),
    (lamp(10**400), "material 0: emissiveFactor is [1000"),
    (lambda tree: tree["nodes"][0].update(rotation=[0, 0, 1, 1]), "of length 1.41"),
    (lambda tree: tree["nodes"][0].update(matrix=[0] * 16), "is not affine"),
]


@pytest.mark.parametrize(("change", "message"), FAULTS, ids=[m for _, m in FAULTS])
def test_gltf_faults_are_named(tmp_path, change, message):
    gltf = triangle_file({})
    change(gltf.tree)
    assert message in refusal(gltf, tmp_path)


def test_gltf_a_tree_of_large_scales_is_refused(tmp_path):
    gltf = triangle_file()
    chain = [{"scale": [1e30] * 3, "children": [i + 1]} for i in range(20)]
    gltf.tree["nodes"] = [*chain, {"mesh": 0}]
    assert refusal(gltf, tmp_path) == "node 1 stands beyond the range of numbers"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[" * 100_000, "nested too deep"),
        ('{"asset": ' + "9" * 5000 + "}", "thousands of digits"),
        ('{"asset": NaN}', "a number of its JSON is none"),
        ('{"asset": 1,\n}', "line 2, column 1"),
        ("[]", "its JSON is not an object"),
        ('{"asset": {"version": 2}}', 'no "asset" with a "version"'),
        ('{"asset": {"version": "2\\u001b"}}', "this is glTF 2\\u001b;"),
    ],
)
def test_gltf_json_that_is_none(tmp_path, text, message):
    path = tmp_path / "a.gltf"
    path.write_text(text)
    assert message in refusal(path, tmp_path)


def test_glb_chunks_end_with_the_file(tmp_path):
    path = triangle_file().write(tmp_path / "a.glb")
    whole = path.read_bytes()
    path.write_bytes(whole[:12] + (10**6).to_bytes(4, "little") + whole[16:])
    told = "the chunk at byte 12 reaches beyond the end of the file"
    assert refusal(path, tmp_path) == told


def test_huge_texture_coordinates_stay_within_the_texture(tmp_path):
    """Interpolation loses them, and the look-up must not make them worse."""
    pbr = {"baseColorTexture": {"index": 0}}
    stored = np.random.default_rng(5).integers(60, 200, (4, 4, 3)).astype(np.uint8)
    coordinates = np.float32([[-1e38, 3e38], [1e38, -2e30], [7e20, 1e38], [0, 1e19]])
    gltf = quad_file({"pbrMetallicRoughness": pbr}, stored, TEXCOORD_0=coordinates)
    points, image = seen(gltf, tmp_path)
    assert points.hit.all()
    linear = decode_srgb(stored / 255)
    rounding = 4 * np.finfo(float).eps  # of a mean of means
    assert points.color.min() >= linear.min() - rounding
    assert points.color.max() <= linear.max() + rounding
    assert (image >= 0).all()


# ---------------------------------------------------------------- pixels

SIDE = 32


def quad_file(material, picture=None, sampler=None, **attributes):
    """A square that fills the image, from 3 away; its picture upright."""
    corners = np.float32([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    gltf = Gltf()
    gltf.tree["materials"] = [material]
    gltf.mesh(
        {
            "POSITION": corners,
            "TEXCOORD_0": np.float32([[0, 1], [1, 1], [1, 0], [0, 0]]),
            **attributes,
        },
        indices=np.array([0, 1, 2, 0, 2, 3], np.uint16),
        material=0,
    )
    if picture is not None:
        gltf.texture(picture)
        gltf.tree["samplers"] = [sampler or {}]
        gltf.tree["textures"][0]["sampler"] = 0
    lens = {"yfov": float(2 * np.arctan(1 / 3))}
    gltf.tree["cameras"] = [{"type": "perspective", "perspective": lens}]
    gltf.tree["nodes"] += [{"camera": 0, "translation": [0, 0, 3]}]
    gltf.tree["scenes"][0]["nodes"] = [0, 1]
    return gltf


def seen(gltf, tmp_path, light="full"):
    """What the camera sees and its image."""
    world = world_of(load_gltf(gltf, tmp_path), SIDE)
    points = what_is_seen(world)
    image = path_traced(world, light, points=points)
    return points, image.reshape(SIDE, SIDE, 3)


LAMP = {
    "emissiveFactor": [1, 1, 1],
    "emissiveTexture": {"index": 0},
    "pbrMetallicRoughness": {"metallicFactor": 0},
}


def test_an_emissive_texture_of_one_texel_shines_on_a_sixteenth(tmp_path):
    """A plane does not light itself: the image is its emission, and nothing else."""
    picture = np.zeros((4, 4, 3), np.uint8)
    picture[1, 2] = 255
    _, image = seen(quad_file(LAMP, picture, {"magFilter": 9728}), tmp_path)
    expected = np.zeros((SIDE, SIDE, 3))
    expected[8:16, 16:24] = 1
    assert_array_equal(image, expected)
    # Interpolated, it is the same light spread wider: hats of half-width 1 texel that
    # pixel centres sample evenly.
    _, image = seen(quad_file(LAMP, picture), tmp_path)
    assert image.max() < 1
    # Hit points are kept 2⁻¹⁶ half extents off the edge of their triangles, and the
    # hat is no steeper than 4 a half extent.
    assert image.mean() == pytest.approx(1 / 16, abs=4 * 2.0**-16)


@pytest.mark.parametrize("double_sided", [False, True])
@pytest.mark.parametrize("behind", [False, True])
def test_a_double_sided_lamp_shines_from_behind_too(tmp_path, double_sided, behind):
    material = {"emissiveFactor": [1, 0.5, 0], "doubleSided": double_sided}
    gltf = quad_file(material)
    if behind:
        gltf.tree["nodes"][0]["rotation"] = [0, 1, 0, 0]
    _, image = seen(gltf, tmp_path)
    lit = double_sided or not behind
    assert_array_equal(image, np.tile([1.0, 0.5, 0.0] * np.array(lit), (SIDE, SIDE, 1)))


def test_through_the_holes_of_a_mask_the_sky_is_seen(tmp_path):
    pbr = {"baseColorTexture": {"index": 0}, "metallicFactor": 1}
    material = {"alphaMode": "MASK", "pbrMetallicRoughness": pbr}
    picture = np.zeros((2, 2, 4), np.uint8)
    picture[..., 3] = [[255, 0], [127, 128]]  # 127 / 255 is below the cutoff of a half
    gltf = quad_file(material, picture, {"magFilter": 9728})
    points, image = seen(gltf, tmp_path)
    there = np.kron([[1, 0], [0, 1]], np.ones((SIDE // 2, SIDE // 2))).astype(bool)
    assert_array_equal(points.hit.reshape(SIDE, SIDE), there)
    assert_array_equal(image[~there], 1)


def test_vertex_colours_are_interpolated(tmp_path):
    """Colours that are linear in the place are so at every pixel."""
    colors = np.float32([[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]])
    pbr = {"baseColorFactor": [1, 0.5, 0.25, 1]}
    gltf = quad_file({"pbrMetallicRoughness": pbr}, COLOR_0=colors)
    points, _ = seen(gltf, tmp_path)
    x, y = (np.arange(SIDE) + 0.5) / SIDE, 1 - (np.arange(SIDE) + 0.5) / SIDE
    expected = np.stack(np.broadcast_arrays(x, y[:, None] / 2, 0.25), axis=-1)
    # Embree's float32 hits, and points kept 2⁻¹⁶ half extents inside their triangle.
    assert_allclose(points.color.reshape(SIDE, SIDE, 3), expected, atol=2.0**-15)


def test_a_spot_shines_as_its_extension_says(tmp_path):
    """Equations of KHR_lights_punctual, written down anew."""
    black = {"KHR_materials_specular": {"specularFactor": 0}}
    pbr = {"metallicFactor": 0, "baseColorFactor": [0.5, 0.5, 0.5, 1]}
    gltf = quad_file({"pbrMetallicRoughness": pbr, "extensions": black})
    cone = {"innerConeAngle": 0.2, "outerConeAngle": 0.7}
    light = {"type": "spot", "intensity": 3, "spot": cone}
    gltf.tree["extensions"] = {"KHR_lights_punctual": {"lights": [light]}}
    hung = {"extensions": {"KHR_lights_punctual": {"light": 0}}}
    gltf.tree["nodes"] += [hung | {"translation": [0, 0, 1]}]
    gltf.tree["scenes"][0]["nodes"] = [0, 1, 2]
    points, image = seen(gltf, tmp_path, "direct")
    offset = [0, 0, 1] - points.position
    distance = np.linalg.norm(offset, axis=1)
    cosine = offset[:, 2] / distance
    scale = 1 / max(0.001, np.cos(0.2) - np.cos(0.7))
    within = np.clip(cosine * scale - np.cos(0.7) * scale, 0, 1) ** 2
    expected = 0.5 / np.pi * 3 * within * cosine / distance**2
    assert 0.3 < (expected > 0).mean() < 0.6
    assert (within == 1).any()
    # The scale multiplies the rounding of the cosine, of at most 4 half ulps of 1, by
    # 4.65, which at the rim is all there is; 16 more steps of relative rounding.
    scaled = 3 * 0.5 / np.pi
    atol = scaled * 16 * np.finfo(float).eps
    rtol = 32 * np.finfo(float).eps
    assert_allclose(image.reshape(-1, 3), expected[:, None] * [1, 1, 1], rtol, atol)


def test_all_instances_are_seen(tmp_path):
    gltf = quad_file({})
    moves = np.float32([[-3, 0, 0], [0, 0, 0], [3, 0, 0]])
    instances = {"attributes": {"TRANSLATION": gltf.accessor(moves)}}
    gltf.tree["nodes"][0] |= {
        "scale": [0.25, 0.25, 0.25],
        "extensions": {"EXT_mesh_gpu_instancing": instances},
    }
    points, _ = seen(gltf, tmp_path)
    row = np.repeat([True, False, True, False, True], [8, 4, 8, 4, 8])
    column = np.repeat([False, True, False], [12, 8, 12])
    assert_array_equal(points.hit.reshape(SIDE, SIDE), column[:, None] & row)
    assert np.unique(points.primitive[points.hit]).tolist() == [0, 1, 2, 3, 4, 5]

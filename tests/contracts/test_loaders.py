"""glTF, OBJ, PLY and scene.json against files written here, value by value.

Mitsuba XML has `test_mitsuba_loader.py`; files that are broken,
`tests/extremes/test_loader_bad_input.py`.
"""

import json
from dataclasses import replace
from io import BytesIO

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from PIL import Image

from restir_gi.reference.scene.camera import FOV_AXES
from restir_gi.reference.scene.lights import (
    ConstantEnvironment,
    DirectionalLight,
    LatLongEnvironment,
    PointLight,
    SpotLight,
)
from restir_gi.reference.scene.loaders.ledger import Ledger
from restir_gi.reference.scene.loaders.load import load_scene
from restir_gi.reference.scene.loaders.pictures import decode_srgb, read_picture
from restir_gi.reference.scene.materials.kinds import Dielectric
from restir_gi.reference.scene.textures import read
from restir_gi.reference.system.errors import UsageError

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
    with pytest.raises(UsageError, match=r'a\.mtl: line 2: material "x": .*no\.png'):
        load_scene(path)
    scene = load_scene(path, lenient=True)
    assert scene.meshes[0].material.reflectance == (0.5, 0.5, 0.5)
    assert noted(scene, "no.png", "mid grey")


def test_obj_emission_of_a_picture(tmp_path):
    """map_Ke times Ke, or alone."""
    stored = np.array([[[0, 0, 0], [255, 255, 255]]], np.uint8)
    (tmp_path / "a.png").write_bytes(png(stored))
    face = f"mtllib a.mtl\n{QUAD}vt 0.75 0.5\nusemtl x\nf 1/1 2/1 3/1\n"
    for ke, wanted in (("Ke 2 3 4\n", (2, 3, 4)), ("", (1, 1, 1))):
        mtl = f"newmtl x\nKd 0 0 0\n{ke}map_Ke a.png\n"
        scene = load_scene(write_obj(tmp_path, face, mtl))
        (mesh,) = scene.meshes
        assert_allclose(read(mesh.emission, mesh.uv), [wanted] * 3)
        assert scene.environment is None
    path = write_obj(tmp_path, face, "newmtl x\nKe 2 3 4\nmap_Ke no.png\n")
    with pytest.raises(UsageError, match=r'a\.mtl: line 3: material "x": .*no\.png'):
        load_scene(path)


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


@pytest.mark.parametrize("kind", ["uchar", "ushort", "float"])
def test_ply_colours_are_srgb_in_bytes_and_linear_in_floats(tmp_path, kind):
    most = {"uchar": 255, "ushort": 65535, "float": 1}[kind]
    text = (
        "ply\nformat ascii 1.0\nelement vertex 3\n"
        + "".join(f"property float {x}\n" for x in "xyz")
        + "".join(f"property {kind} {x}\n" for x in ("red", "green", "blue"))
        + "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
        + f"0 0 0 {most} 0 0\n1 0 0 0 {most} 0\n0 1 0 {0.2 * most:.9g} 0 {most}\n"
        + "3 0 1 2\n"
    )
    (tmp_path / "a.ply").write_text(text)
    scene = load_scene(tmp_path / "a.ply")
    dim = 0.2 if kind == "float" else ((0.2 + 0.055) / 1.055) ** 2.4
    expected = [[1, 0, 0], [0, 1, 0], [dim, 0, 1]]
    # Files hold float32.
    assert_allclose(scene.meshes[0].colors, expected, rtol=4 * np.finfo("f4").eps)
    assert scene.meshes[0].material.reflectance == (1.0, 1.0, 1.0)
    assert noted(scene, "colours of its vertices")


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
    frosted = json_material(write_json, type="roughdielectric", ior=1.33, alpha=0.2)
    assert frosted == Dielectric(1.33, 0.2, "ggx")


@pytest.mark.parametrize(
    ("kind", "own"),
    [
        ("ggx_conductor", {}),
        ("roughplastic", {"reflectance": 0.5}),
        ("roughdielectric", {}),
    ],
)
def test_json_names_the_distribution_of_rough_materials(write_json, kind, own):
    for name in ("ggx", "beckmann"):
        material = json_material(
            write_json, type=kind, alpha=0.2, distribution=name, **own
        )
        assert material.distribution == name


@pytest.mark.parametrize(
    ("material", "message"),
    [
        ({"type": "velvet"}, '"velvet"; known are diffuse,'),
        ({"type": "diffuse"}, "reflectance is missing"),
        ({"type": "diffuse", "reflectance": [1, 2]}, r"reflectance is \[1, 2\]"),
        ({"type": "diffuse", "reflectance": 0.5, "sheen": 1}, 'the key "sheen"'),
        ({"type": "mirror", "eta": 1}, "eta together with k"),
        ({"type": "ggx_conductor", "alpha": "x"}, 'alpha is "x"'),
        ({"type": "ggx_conductor", "alpha": 1, "distribution": "phong"}, '"phong"'),
        ({"type": "roughdielectric"}, "alpha is missing"),
        (
            {"type": "roughplastic", "reflectance": 1, "alpha": 1, "distribution": []},
            "be",
        ),
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


def test_json_emission_of_a_picture(write_json, tmp_path):
    """A sixteenth of the square shines; the triangle has its lower left half."""
    stored = np.zeros((4, 4, 3), np.uint8)
    stored[2, 1] = 255
    (tmp_path / "lamp.png").write_bytes(png(stored))
    (tmp_path / "t.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n"
    )
    shape = {"file": "t.obj", "emission": {"file": "lamp.png", "scale": 5}}
    (mesh,) = load_scene(write_json(shape={**shape, "two_sided_emission": True})).meshes
    assert mesh.two_sided_emission
    inside = np.array([[0.375, 0.375], [0.1, 0.1]])
    assert_allclose(read(mesh.emission, inside), [[5.0] * 3, [0.0] * 3])
    assert not load_scene(write_json(shape=shape)).meshes[0].two_sided_emission
    shape["emission"]["file"] = "none.png"
    with pytest.raises(UsageError, match=r'emission of shape "wall": .*none\.png'):
        load_scene(write_json(shape=shape))
    dark = load_scene(write_json(shape=shape), lenient=True)
    assert dark.meshes[0].emission == (0.0, 0.0, 0.0)
    assert noted(dark, "none.png", "taken as dark")


def test_json_emission_without_coordinates_has_its_mean_colour(write_json, tmp_path):
    stored = np.array([[[0, 0, 0], [255, 255, 255]]], np.uint8)
    (tmp_path / "lamp.png").write_bytes(png(stored))
    path = write_json(shape={"emission": {"file": "lamp.png"}})
    with pytest.raises(UsageError, match="no texture coordinates"):
        load_scene(path)
    (mesh,) = load_scene(path, lenient=True).meshes
    assert mesh.emission == (0.5, 0.5, 0.5)


def test_json_spot(write_json):
    spot = {"type": "spot", "position": [1, 2, 3], "direction": [0, -2, 0]}
    spot |= {"intensity": 4, "cutoff_deg": 30, "beam_deg": 20}
    scene = load_scene(write_json(lights=[spot, {**spot, "falloff": "smooth"}]))
    wanted = SpotLight((1.0, 2, 3), (0.0, -1, 0), (4.0, 4, 4), cutoff=30.0, beam=20.0)
    assert scene.spots == (wanted, replace(wanted, falloff="smooth"))
    with pytest.raises(UsageError, match='light 0: falloff is "cubic"; it can be'):
        load_scene(write_json(lights=[{**spot, "falloff": "cubic"}]))
    with pytest.raises(UsageError, match="light 0: beam_deg is missing"):
        load_scene(write_json(lights=[{**spot, "beam_deg": None}]))


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
    with pytest.raises(UsageError, match='light 0 has the type "torch"'):
        load_scene(write_json(lights=[{"type": "torch"}]))


def test_json_has_no_default_light(write_json):
    scene = load_scene(write_json())
    assert scene.environment is None
    assert noted(scene, "no camera")

"""Mitsuba XML: what we load is what Mitsuba itself sees, ray by ray."""

import sys
from dataclasses import replace
from textwrap import dedent

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from PIL import Image

from restir_gi.reference.scene.camera import camera_rays
from restir_gi.reference.scene.lights import (
    ConstantEnvironment,
    DirectionalLight,
    LatLongEnvironment,
    PointLight,
)
from restir_gi.reference.scene.loaders import mitsuba_shapes
from restir_gi.reference.scene.loaders.load import load_scene
from restir_gi.reference.scene.loaders.mitsuba_nodes import mitsuba_session
from restir_gi.reference.scene.materials.kinds import (
    Coated,
    Conductor,
    Dielectric,
    Lambertian,
)
from restir_gi.reference.scene.textures import Bitmap, Checker, read
from restir_gi.reference.system.errors import UsageError

mi = pytest.importorskip("mitsuba", reason="reads Mitsuba XML by the package mitsuba")

EPS32 = float(np.finfo(np.float32).eps)  # Mitsuba's precision
TINT = np.array([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [90, 60, 30]]], np.uint8)


@pytest.fixture(autouse=True)
def _scalar():
    with mitsuba_session():
        yield


@pytest.fixture
def write(tmp_path):
    """Return a writer of scenes: body in, path out; a picture and meshes beside it."""
    Image.fromarray(TINT).save(tmp_path / "tint.png")
    corners = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\n"
    corners += "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
    face = "f 1/1/1 2/2/1 3/3/1 4/4/1\n"
    (tmp_path / "flat.obj").write_text(
        corners + face.replace("/1 ", " ").replace("/1\n", "\n")
    )
    (tmp_path / "front.obj").write_text(f"{corners}vn 0 0 1\n{face}")
    (tmp_path / "back.obj").write_text(f"{corners}vn 0 0 -1\n{face}")

    def writer(body):
        text = f'<scene version="3.0.0">\n{dedent(body)}\n</scene>\n'
        (tmp_path / "scene.xml").write_text(text)
        return tmp_path / "scene.xml"

    return writer


def noted(scene, *words):
    """Whether one sentence of the notes has all the words."""
    assert all(note.endswith(".") for note in scene.notes)
    return any(all(word in note for word in words) for note in scene.notes)


def matrix_tag(matrix):
    """XML of a to_world."""
    numbers = " ".join(repr(float(x)) for x in np.ravel(matrix))
    return f'<transform name="to_world"><matrix value="{numbers}"/></transform>'


# ---------------------------------------------------------------- sensor

SENSOR = """
<sensor type="perspective">
  {fov}
  <transform name="to_world">{transform}</transform>
  <film type="hdrfilm">
    <integer name="width" value="{size[0]}"/><integer name="height" value="{size[1]}"/>
  </film>
</sensor>
<shape type="sphere"/>
"""
LOOK_AT = '<lookat origin="1, 2, 5" target="0.5, -1, 0" up="0.3, 1, 0.2"/>'
MIRROR = f'<scale x="-1"/>{LOOK_AT}'  # the first is applied first


@pytest.mark.parametrize("transform", [LOOK_AT, MIRROR], ids=["proper", "mirrored"])
@pytest.mark.parametrize(
    ("written", "size"),
    [((40, 30), (40, 30)), ((30, 40), (40, 30)), ((32, 32), (30, 40))],
    ids=str,
)
@pytest.mark.parametrize(
    "fov",
    [
        f'<float name="fov" value="50"/><string name="fov_axis" value="{axis}"/>'
        for axis in ("x", "y", "diagonal", "smaller", "larger")
    ]
    + [
        '<string name="focal_length" value="35mm"/>',
        '<float name="fov" value="120"/>',
        "",
    ],
)
def test_camera_rays_are_those_of_mitsuba(write, fov, written, size, transform):
    """Also at another size: Mitsuba reads the file with that size written in it."""
    text = SENSOR.format(fov=fov, transform=transform, size=written)
    camera = replace(load_scene(write(text)).camera, width=size[0], height=size[1])
    assert camera.mirrored == (transform == MIRROR)
    path = write(SENSOR.format(fov=fov, transform=transform, size=size))
    sensor = mi.load_file(str(path)).sensors()[0]
    x, y = np.array([0.5, 7.5, size[0] - 0.5, 3.25]), np.array([0.5, 20.5, 0, size[1]])
    origin, direction = camera_rays(camera, x, y)
    for i in range(4):
        place = mi.Point2f(x[i] / size[0], y[i] / size[1])
        ray, _ = sensor.sample_ray(0.0, 0.5, place, mi.Point2f(0.5, 0.5))
        # A dozen roundings; the field of view is squeezed through two tangents.
        assert_allclose(direction[i], ray.d, atol=32 * EPS32)
        # Mitsuba's rays start at the near plane.
        along = np.array(ray.o) - origin[i]
        assert_allclose(np.cross(along, direction[i]), 0, atol=32 * EPS32)


@pytest.mark.parametrize(
    ("change", "message", "words"),
    [
        (("perspective", "thinlens"), "thinlens", ("thinlens", "pinhole")),
        (("perspective", "orthographic"), "orthographic", ("orthographic", "ignored")),
        (("<film", '<float name="principal_point_offset_x" value="0.1"/><film'),) * 1
        + ("principal_point_offset_x", ("principal_point", "0")),
        (("<lookat", '<scale x="2"/><lookat'), "scales or shears", ("shears",)),
        (('name="height"', 'name="crop_width"'), "crop_width", ("crop_width",)),
    ],
)
def test_sensors_that_are_not_modelled(write, change, message, words):
    fov = '<float name="fov" value="50"/>'
    text = SENSOR.format(fov=fov, transform=LOOK_AT, size=(40, 30)).replace(*change)
    with pytest.raises(UsageError, match=f"scene.xml: .*{message}.*--lenient"):
        load_scene(write(text))
    assert noted(load_scene(write(text), lenient=True), *words)


# ---------------------------------------------------------------- shapes


def hit(shape, origin, direction):
    """Distance, position, front normal and shading normal of the nearest hit."""
    if hasattr(shape, "radius"):
        offset = origin - np.array(shape.center)
        b, c = offset @ direction, offset @ offset - shape.radius**2
        position = origin + (-b - np.sqrt(b * b - c)) * direction
        normal = (position - shape.center) / shape.radius * (-1 if shape.inward else 1)
        return position, normal, normal, None
    nearest = (np.inf,)
    for face in shape.faces:
        a, b, c = shape.vertices[face]
        normal = np.cross(b - a, c - a)
        distance = (a - origin) @ normal / (direction @ normal)
        position = origin + distance * direction
        weights = np.linalg.solve(np.stack([a, b, c], axis=-1), position)
        if (weights > -1e-9).all() and 1e-9 < distance < nearest[0]:
            normal /= np.linalg.norm(normal)
            smooth = normal if shape.normals is None else weights @ shape.normals[face]
            smooth = smooth / np.linalg.norm(smooth)
            uv = None if shape.uv is None else weights @ shape.uv[face]
            nearest = distance, position, normal, smooth, uv
    return nearest[1:]


SKEW = np.array(
    [[1.5, 0.2, 0.1, 0.3], [-0.2, 0.8, 0.1, 0.2], [0.1, -0.3, 1.1, 3], [0, 0, 0, 1]]
)
ROUND = np.array([[0, -2, 0, 0.3], [2, 0, 0, 0.2], [0, 0, 2, 5], [0, 0, 0, 1.0]])
FILES = ["flat.obj", "front.obj", "back.obj"]


@pytest.mark.parametrize("flip", [False, True], ids=["", "flipped"])
@pytest.mark.parametrize("mirror", [0, 1, 3], ids=["proper", "mirrored", "thrice"])
@pytest.mark.parametrize(
    "kind",
    ["rectangle", "disk", "cube", "sphere", *FILES, *(f"{f} flat" for f in FILES)],
)
def test_shapes_are_where_mitsuba_has_them_and_emit_where_they_do(
    write, kind, mirror, flip
):
    name, _, flat = kind.partition(" ")
    matrix = (ROUND if kind == "sphere" else SKEW) @ np.diag(
        [-1 if mirror > axis else 1 for axis in range(3)] + [1]
    )
    inner = matrix_tag(matrix)
    if name.endswith("obj"):
        inner += f'<string name="filename" value="{name}"/>'
        inner += f'<boolean name="face_normals" value="{"true" if flat else "false"}"/>'
        name = "obj"
    if flip:
        inner += '<boolean name="flip_normals" value="true"/>'
    inner += '<emitter type="area"><rgb name="radiance" value="1, 2, 3"/></emitter>'
    path = write(f'<shape type="{name}" id="it">{inner}</shape>')
    scene = load_scene(path)
    (shape,) = (*scene.meshes, *scene.spheres)
    theirs = mi.load_file(str(path))
    target = matrix[:3, 3] + matrix[:3, :3] @ [0.21, -0.33, 0]
    for origin in (np.zeros(3), 2 * target, target - np.array([0.5, 0.1, 2])):
        direction = (target - origin) / np.linalg.norm(target - origin)
        si = theirs.ray_intersect(mi.Ray3f(origin.tolist(), direction.tolist()))
        position, normal, smooth, uv = hit(shape, origin, direction)
        # Coordinates are up to 10; Mitsuba takes a handful of roundings.
        assert_allclose(position, si.p, atol=100 * EPS32)
        assert_allclose(smooth, si.sh_frame.n, atol=100 * EPS32)
        assert abs(normal @ np.array(si.n)) == pytest.approx(1, abs=100 * EPS32)
        front = direction @ normal < 0
        emitted = si.emitter(theirs).eval(si)
        assert_array_equal(emitted, shape.emission if front else (0, 0, 0))
        if kind not in ("disk", "sphere"):
            assert_allclose(uv, si.uv, atol=100 * EPS32)


def test_a_disk_keeps_its_area_with_a_note(write):
    scene = load_scene(write('<shape type="disk"/>'))
    (mesh,) = scene.meshes
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    assert area == pytest.approx(np.pi, rel=1e-12)
    assert noted(scene, "Disks", "128")


def test_shapes_that_are_not_modelled(write):
    path = write('<shape type="sdfgrid" id="blob"/><shape type="rectangle"/>')
    with pytest.raises(UsageError, match=r'scene\.xml: sdfgrid "blob" is not modelled'):
        load_scene(path)
    scene = load_scene(path, lenient=True)
    assert len(scene.meshes) == 1
    assert noted(scene, 'sdfgrid "blob"', "left out")


def test_missing_mesh_files(write):
    text = '<shape type="obj" id="pot"><string name="filename" value="no.obj"/></shape>'
    path = write(text + '<shape type="rectangle"/>')
    with pytest.raises(UsageError, match=r'obj "pot": the file "no\.obj" is missing'):
        load_scene(path)
    assert noted(load_scene(path, lenient=True), "pot", "no.obj", "left out")


def test_a_medium_is_refused_or_left_out(write):
    path = write(
        '<shape type="sphere" id="ball"><bsdf type="dielectric"/>'
        '<medium type="homogeneous" name="interior"/></shape>'
    )
    with pytest.raises(UsageError, match='"ball": its medium homogeneous'):
        load_scene(path)
    scene = load_scene(path, lenient=True)
    assert noted(scene, "ball", "left empty")
    assert isinstance(scene.spheres[0].material, Dielectric)


# ---------------------------------------------------------------- materials


def material(write, bsdf, lenient=False):
    scene = load_scene(write(f'<shape type="rectangle">{bsdf}</shape>'), lenient)
    return scene.meshes[0].material, scene


GGX = '<string name="distribution" value="ggx"/>'


def test_materials_of_shapes_that_have_none(write):
    plain, _ = material(write, "")
    lamp, _ = material(write, '<emitter type="area"/>')
    assert (plain.reflectance, lamp.reflectance) == ((0.5,) * 3, (0.0,) * 3)
    assert not plain.two_sided


def test_diffuse_and_twosided(write):
    rgb = '<rgb name="reflectance" value="0.1, 0.2, 0.3"/>'
    bsdf = f'<bsdf type="diffuse">{rgb}</bsdf>'
    matt, _ = material(write, bsdf)
    assert isinstance(matt, Lambertian)
    assert (matt.reflectance, matt.two_sided) == ((0.1, 0.2, 0.3), False)
    matt, _ = material(write, f'<bsdf type="twosided">{bsdf}</bsdf>')
    assert (matt.reflectance, matt.two_sided) == ((0.1, 0.2, 0.3), True)
    spectrum = bsdf.replace("rgb", "spectrum").replace("0.1, 0.2, 0.3", "0.25")
    assert material(write, spectrum)[0].reflectance == (0.25,) * 3


def test_materials_that_are_shared_stay_one_object(write):
    scene = load_scene(
        write(
            '<bsdf type="diffuse" id="m"/>'
            '<shape type="rectangle"><ref id="m"/></shape>'
            '<shape type="cube"><ref id="m"/></shape>'
        )
    )
    assert scene.meshes[0].material is scene.meshes[1].material


@pytest.mark.parametrize("metal", ["Au", "Cu", "Cr", "none"])
@pytest.mark.parametrize("kind", ["conductor", "roughconductor"])
def test_metals_have_mitsubas_indices(write, kind, metal):
    name = f'<string name="material" value="{metal}"/>'
    rough = (
        f'<float name="alpha" value="0.2"/>{GGX}' if kind == "roughconductor" else ""
    )
    ours, _ = material(write, f'<bsdf type="{kind}">{name}{rough}</bsdf>')
    assert isinstance(ours, Conductor)
    assert ours.alpha == (0.2 if rough else 0)
    assert ours.reflectance == (1, 1, 1)
    if metal == "none":
        assert ours.eta is ours.k is None
        return
    theirs = mi.traverse(mi.load_dict({"type": kind, "material": metal}))
    assert_array_equal(ours.eta, theirs["eta.value"])
    assert_array_equal(ours.k, theirs["k.value"])


def test_metals_by_number(write):
    text = '<rgb name="eta" value="1.5, 0.9, 0.5"/><rgb name="k" value="9, 6, 5"/>'
    text += '<rgb name="specular_reflectance" value="0.9, 0.8, 0.7"/>'
    metal, _ = material(write, f'<bsdf type="conductor">{text}</bsdf>')
    assert (metal.eta, metal.k) == ((1.5, 0.9, 0.5), (9, 6, 5))
    assert metal.reflectance == (0.9, 0.8, 0.7)
    assert not metal.schlick


@pytest.mark.parametrize("given", ["eta", "k"])
def test_the_other_half_of_an_index_is_mitsubas_default(write, given):
    text = f'<bsdf type="conductor"><rgb name="{given}" value="2, 3, 4"/></bsdf>'
    path = write(f'<shape type="rectangle">{text}</shape>')
    ours = load_scene(path).meshes[0].material
    theirs = mi.traverse(mi.load_file(str(path)).shapes()[0].bsdf())
    for name in ("eta", "k"):
        assert_array_equal(getattr(ours, name), np.zeros(3) + theirs[f"{name}.value"])


@pytest.mark.parametrize("kind", ["plastic", "roughplastic", "dielectric"])
@pytest.mark.parametrize(
    "ior",
    [
        "",
        '<string name="int_ior" value="bk7"/>',
        '<float name="int_ior" value="1.7"/>',
        '<string name="int_ior" value="diamond"/><float name="ext_ior" value="1.33"/>',
        '<float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/>',
    ],
)
def test_indices_of_refraction_are_mitsubas(write, kind, ior):
    rough = GGX if kind == "roughplastic" else ""
    path = write(
        f'<shape type="rectangle"><bsdf type="{kind}">{ior}{rough}</bsdf></shape>'
    )
    ours = load_scene(path).meshes[0].material
    assert isinstance(ours, Dielectric if kind == "dielectric" else Coated)
    theirs = mi.traverse(mi.load_file(str(path)).shapes()[0].bsdf())
    assert ours.ior == pytest.approx(theirs["eta"], rel=2 * EPS32)


def test_plastics(write):
    text = '<rgb name="diffuse_reflectance" value="0.1, 0.2, 0.3"/>'
    text += '<boolean name="nonlinear" value="true"/>'
    coat, _ = material(write, f'<bsdf type="plastic">{text}</bsdf>')
    assert (coat.reflectance, coat.alpha, coat.nonlinear) == ((0.1, 0.2, 0.3), 0, True)
    assert (coat.specular, coat.two_sided) == ((1, 1, 1), False)
    text = f'{GGX}<float name="alpha" value="0.3"/>'
    text += '<rgb name="specular_reflectance" value="0.5"/>'
    coat, _ = material(write, f'<bsdf type="roughplastic">{text}</bsdf>')
    assert (coat.reflectance, coat.alpha, coat.nonlinear) == ((0.5,) * 3, 0.3, False)
    assert coat.specular == (0.5,) * 3


@pytest.mark.parametrize("filtered", ["nearest", "bilinear"])
@pytest.mark.parametrize("raw", ["true", "false"])
@pytest.mark.parametrize("scale", [(1, 1), (2.5, 3.25)], ids=str)
def test_bitmaps_are_read_as_mitsuba_reads_them(write, filtered, raw, scale):
    path = write(
        f"""
        <shape type="rectangle"><bsdf type="diffuse">
          <texture type="bitmap" name="reflectance">
            <string name="filename" value="tint.png"/>
            <boolean name="raw" value="{raw}"/>
            <string name="filter_type" value="{filtered}"/>
            <transform name="to_uv"><scale x="{scale[0]}" y="{scale[1]}"/></transform>
          </texture>
        </bsdf></shape>
        """
    )
    ours = load_scene(path).meshes[0].material.reflectance
    assert isinstance(ours, Bitmap)
    assert_same_texture(ours, path, atol=1e-3)  # Mitsuba keeps half precision


def assert_same_texture(ours, path, atol):
    bsdf = mi.load_file(str(path)).shapes()[0].bsdf()
    uv = np.random.default_rng(5).uniform(-2, 3, (60, 2)).astype(np.float32)
    si = mi.SurfaceInteraction3f()
    si.wi = mi.Vector3f(0, 0, 1)
    for place, color in zip(uv, read(ours, uv), strict=True):
        si.uv = mi.Point2f(*place.tolist())
        assert_allclose(color, bsdf.eval_diffuse_reflectance(si), atol=atol)


def test_checkers_are_read_as_mitsuba_reads_them(write):
    path = write(
        """
        <shape type="rectangle"><bsdf type="diffuse">
          <texture type="checkerboard" name="reflectance">
            <rgb name="color0" value="0.8, 0.7, 0.6"/><rgb name="color1" value="0.1"/>
            <transform name="to_uv"><scale x="3" y="5.5"/></transform>
          </texture>
        </bsdf></shape>
        """
    )
    ours = load_scene(path).meshes[0].material.reflectance
    assert ours == Checker((0.8, 0.7, 0.6), (0.1, 0.1, 0.1), (3.0, 5.5))
    assert_same_texture(ours, path, atol=EPS32)


def test_missing_textures(write):
    texture = '<texture type="bitmap" name="reflectance">'
    texture += '<string name="filename" value="no.png"/></texture>'
    bsdf = f'<bsdf type="diffuse" id="paint">{texture}</bsdf>'
    with pytest.raises(UsageError, match=r'bitmap in diffuse "paint": .*no\.png'):
        material(write, bsdf)
    grey, scene = material(write, bsdf, lenient=True)
    assert grey.reflectance == (0.5, 0.5, 0.5)
    assert noted(scene, "paint", "no.png", "mid grey")


PRINCIPLED = '<bsdf type="principled"><float name="metallic" value="{}"/>'
PRINCIPLED += '<float name="roughness" value="0.6"/></bsdf>'


@pytest.mark.parametrize(
    ("bsdf", "message", "kind"),
    [
        (PRINCIPLED.format(0.7), "principled", Conductor),
        (PRINCIPLED.format(0.2), "principled", Coated),
        ('<bsdf type="hair"/>', "hair", Lambertian),
        ('<bsdf type="bumpmap"><bsdf type="plastic"/></bsdf>', "bumpmap", Coated),
        ('<bsdf type="mask"><bsdf type="conductor"/></bsdf>', "mask", Conductor),
        (
            '<bsdf type="diffuse"><float name="gloss" value="1"/></bsdf>',
            "gloss",
            Lambertian,
        ),
        (
            '<bsdf type="twosided"><bsdf type="diffuse"/><bsdf type="plastic"/></bsdf>',
            "two different sides",
            Lambertian,
        ),
        (
            f'<bsdf type="roughconductor">{GGX}<float name="alpha_u" value="0.4"/>'
            '<float name="alpha_v" value="0.1"/></bsdf>',
            "anisotropic",
            Conductor,
        ),
    ],
)
def test_materials_that_are_not_modelled(write, bsdf, message, kind):
    with pytest.raises(UsageError, match=f"scene.xml: .*{message}.*--lenient"):
        material(write, bsdf)
    ours, scene = material(write, bsdf, lenient=True)
    assert isinstance(ours, kind)
    assert noted(scene, message)


def test_lenient_replacements_have_the_stated_values(write):
    metal, _ = material(write, PRINCIPLED.format(0.7), lenient=True)
    assert metal.schlick
    assert metal.alpha == pytest.approx(0.36)
    pane = '<shape type="rectangle" id="pane"><bsdf type="thindielectric"/></shape>'
    scene = load_scene(write(pane), lenient=True)
    assert scene.meshes == ()
    assert noted(scene, "thindielectric", "left out")


# ---------------------------------------------------------------- lights


def test_lights(write):
    scene = load_scene(
        write(
            """
            <emitter type="point"><point name="position" x="1" y="2" z="3"/>
              <rgb name="intensity" value="4, 5, 6"/></emitter>
            <emitter type="point">
              <transform name="to_world"><translate x="7"/></transform></emitter>
            <emitter type="directional"><vector name="direction" x="0" y="-2" z="0"/>
              <rgb name="irradiance" value="1, 2, 3"/></emitter>
            <emitter type="directional">
              <transform name="to_world"><rotate y="1" angle="90"/></transform>
            </emitter>
            <emitter type="constant">
              <rgb name="radiance" value="0.1, 0.2, 0.3"/></emitter>
            """
        )
    )
    assert scene.points[0] == PointLight((1.0, 2.0, 3.0), (4.0, 5.0, 6.0))
    assert scene.points[1] == PointLight((7.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    assert scene.suns[0] == DirectionalLight((0.0, -1.0, 0.0), (1.0, 2.0, 3.0))
    assert_allclose(scene.suns[1].direction, [1, 0, 0], atol=1e-15)
    assert scene.environment == ConstantEnvironment((0.1, 0.2, 0.3))


def test_environment_maps_are_turned_as_in_mitsuba(write, tmp_path):
    import OpenEXR

    height, width = 128, 256
    # Smooth, so that the two ways of interpolating hardly differ.
    theta = np.arange(height)[:, None] / (height - 1) * np.pi
    phi = (np.arange(width) + 0.5) / width * 2 * np.pi
    colors = [1 + np.sin(theta) * np.cos(phi), 2 + np.sin(theta) * np.sin(2 * phi)]
    colors += [1.5 + np.cos(theta) + 0 * phi]
    pixels = np.stack(colors, axis=-1).astype(np.float32)
    header = {"type": OpenEXR.scanlineimage, "compression": OpenEXR.ZIP_COMPRESSION}
    OpenEXR.File(header, {"RGB": pixels}).write(str(tmp_path / "sky.exr"))
    path = write(
        """
        <shape type="sphere"/>
        <emitter type="envmap"><string name="filename" value="sky.exr"/>
          <float name="scale" value="2.5"/>
          <transform name="to_world"><rotate x="0.6" z="0.8" angle="77"/>
            <rotate y="1" angle="30"/></transform></emitter>
        """
    )
    ours = load_scene(path).environment
    assert isinstance(ours, LatLongEnvironment)
    theirs = mi.load_file(str(path)).environment()
    # Towards texel centres, by the convention that `lights.py` states.
    rows, columns = np.meshgrid([0, 13, 64, 90, 127], [0, 50, 128, 200], indexing="ij")
    theta = (rows.ravel() + 0.5) / height * np.pi
    azimuth = (0.5 - (columns.ravel() + 0.5) / width) * 2 * np.pi  # from +z to +x
    local = [np.sin(theta) * np.sin(azimuth), np.cos(theta)]
    local += [np.sin(theta) * np.cos(azimuth)]
    world = np.stack(local, axis=-1) @ ours.to_world.T
    expected = ours.pixels[rows.ravel(), columns.ravel()]
    si = mi.SurfaceInteraction3f()
    for direction, radiance in zip(world, expected, strict=True):
        si.wi = mi.Vector3f(*(-direction).tolist())
        # Mitsuba's own look-up rounds texel coordinates of up to 256.
        assert_allclose(radiance, theirs.eval(si), atol=256 * EPS32 * 8)


def test_emitters_that_are_not_modelled(write):
    path = write('<shape type="cube"/><emitter type="sunsky" id="sky"/>')
    with pytest.raises(UsageError, match='sunsky "sky" is not modelled'):
        load_scene(path)
    scene = load_scene(path, lenient=True)
    assert noted(scene, 'sunsky "sky"', "left out")


# ---------------------------------------------------------------- the file as such


def test_defaults_includes_and_references_are_resolved(write, tmp_path):
    (tmp_path / "part.xml").write_text(
        '<scene version="3.0.0"><bsdf type="diffuse" id="m">'
        '<spectrum name="reflectance" value="$shade"/></bsdf></scene>'
    )
    path = write(
        '<default name="shade" value="0.25"/><include filename="part.xml"/>'
        '<shape type="rectangle"><ref id="m"/></shape>'
    )
    assert load_scene(path).meshes[0].material.reflectance == (0.25,) * 3


def test_old_files_are_upgraded(tmp_path):
    (tmp_path / "a.xml").write_text(
        '<scene version="0.6.0"><shape type="rectangle"><transform name="toWorld">'
        '<scale value="2"/></transform></shape></scene>'
    )
    (mesh,) = load_scene(tmp_path / "a.xml").meshes
    assert np.abs(mesh.vertices).max() == 2


def test_all_refusals_are_told_before_any_mesh_is_read(write, monkeypatch):
    def never(*_):
        raise AssertionError

    monkeypatch.setattr(mitsuba_shapes, "read_mesh", never)
    path = write(
        """
        <sensor type="orthographic" id="eye"/>
        <shape type="obj"><string name="filename" value="flat.obj"/>
          <bsdf type="principled" id="paint"/></shape>
        <shape type="ply" id="gone"><string name="filename" value="no.ply"/></shape>
        <emitter type="sunsky" id="sky"/>
        """
    )
    with pytest.raises(UsageError, match="4 faults") as refusal:
        load_scene(path)
    for name in ("eye", "paint", "gone", "sky"):
        assert f'"{name}"' in str(refusal.value)


def test_files_are_looked_for_where_mitsuba_looks(write, tmp_path):
    (tmp_path / "more").mkdir()
    near, far = ((tmp_path / name / "x.obj") for name in ("", "more"))
    body = '<path value="more"/><shape type="obj">'
    path = write(f'{body}<string name="filename" value="x.obj"/></shape>')
    flat = (tmp_path / "flat.obj").read_text()
    near.write_text(flat)
    for _ in range(2):  # beside the scene alone, then in both
        ours = load_scene(path).meshes[0].vertices
        assert np.abs(ours).max() == mi.load_file(str(path)).bbox().max[0]
        far.write_text(flat.replace("v 1", "v 3"))
    folders = [str(folder) for folder in mi.file_resolver()]
    load_scene(path)
    assert [str(folder) for folder in mi.file_resolver()] == folders


def test_no_default_light_but_a_default_camera(write):
    scene = load_scene(write('<shape type="cube"/>'))
    assert scene.environment is None
    assert noted(scene, "no camera")


def test_the_process_is_left_as_it_was(write):
    others = [variant for variant in mi.variants() if variant != "scalar_rgb"]
    subnormal = np.float32(1e-40)
    mi.set_variant(others[0])
    mi.set_log_level(mi.LogLevel.Info)
    load_scene(write('<shape type="cube"/>'))
    assert mi.variant() == others[0]
    assert mi.log_level() == mi.LogLevel.Info
    # Some libraries make the processor flush these to zero.
    assert subnormal * np.float32(0.5) != 0


def test_without_the_package_the_error_says_how_to_get_it(write, monkeypatch):
    monkeypatch.setitem(sys.modules, "mitsuba", None)
    with pytest.raises(UsageError, match=r"pip install 'restir-gi-oracle\[mitsuba\]'"):
        load_scene(write(""))

"""The view is the file's: at any size of the image the angle stays on its axis.

Evidence: identities.  The pictures of one file differ in shape, and the rays through
the ends of the axis that the file names do not.
"""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from restir_gi.reference.cli.opening import size_in_shape
from restir_gi.reference.oracle.blackbox.convention import Convention
from restir_gi.reference.oracle.blackbox.evidence import Tolerance
from restir_gi.reference.oracle.blackbox.tiles import TILES
from restir_gi.reference.passes.gbuffer import visible_points
from restir_gi.reference.scene.camera import (
    FOV_AXES,
    Camera,
    camera_rays,
    image_points,
    pixel_centers,
)
from restir_gi.reference.scene.loaders.load import load_scene
from restir_gi.reference.scene.named import Named, frames_of
from restir_gi.reference.transport.world import build_world
from restir_gi.reference.truth.pictures import PictureTruths

# Directions are unit vectors after some 40 roundings, and the smallest component that
# is divided by is cos 89.5 degrees = 0.0087: 40 · 2⁻⁵³ / 0.0087 < 1e-12.
ROUNDING = 1e-12

CAMERA = Camera(position=(1.3, 2.6, -3.7), target=(0.2, 0.5, 2.0), up=(0.1, 1.0, 0.0))
SIZES = [(160, 90), (90, 160), (64, 64), (33, 7)]

sides = st.integers(1, 4096)
angles = st.floats(1, 179)
axes = st.sampled_from(FOV_AXES)


def span(axis, width, height):
    """Point of the image where the axis ends."""
    if axis == "smaller":
        axis = "x" if width < height else "y"
    if axis == "larger":
        axis = "x" if width > height else "y"
    return {
        "x": (width, height / 2),
        "y": (width / 2, height),
        "diagonal": (width, height),
    }[axis]


def tangent(camera, x, y):
    """Of the angle between the axis of the camera and a ray."""
    _, direction = camera_rays(camera, np.array([float(x)]), np.array([float(y)]))
    right, up, forward = direction[0] @ np.transpose(camera.axes)
    return np.hypot(right, up) / forward


@given(angles, axes, sides, sides)
def test_the_angle_spans_its_axis(fov, axis, width, height):
    camera = replace(CAMERA, fov=fov, fov_axis=axis, width=width, height=height)
    expected = np.tan(np.radians(fov) / 2)
    assert_allclose(tangent(camera, *span(axis, width, height)), expected, ROUNDING)


def test_control_an_angle_that_follows_the_width_does_not_span_the_height():
    camera = replace(CAMERA, fov=40.0, fov_axis="x", width=160, height=90)
    expected = np.tan(np.radians(20))
    assert abs(tangent(camera, *span("y", 160, 90)) / expected - 1) > 0.4


@given(angles, axes, sides, sides, st.booleans())
def test_projection_inverts_the_rays(fov, axis, width, height, mirrored):
    camera = replace(
        CAMERA, fov=fov, fov_axis=axis, width=width, height=height, mirrored=mirrored
    )
    # Points up to 45 degrees from the axis: no depth is lost to rounding.
    inside = min(1.0, 1 / camera.half_width)
    x = width / 2 * (1 + inside * np.array([-1.0, -0.3, 0.0, 0.9]))
    y = height / 2 + width / 2 * inside * np.array([0.4, -1.0, 0.0, 0.7])
    origin, direction = camera_rays(camera, x, y)
    found = image_points(camera, origin + 3.0 * direction)
    # The unit of the rounding is half a width over its tangent.
    unit = width / min(camera.half_width, 1.0)
    assert_allclose(found, (x, y), rtol=0, atol=unit * ROUNDING)


# ---------------------------------------------------------------- loaders

QUAD = """ply
format ascii 1.0
element vertex 4
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
-2 {low} 0
2 {low} 0
2 1 0
-2 1 0
4 0 1 2 3
"""


def json_file(folder, axis, size=(160, 90)):
    (folder / "quad.ply").write_text(QUAD.format(low=-1))
    view = {"origin": [0, 0, 3], "target": [0, 0, 0], "fov_deg": 40, "fov_axis": axis}
    tree = {
        "camera": view | {"width": size[0], "height": size[1]},
        "materials": {"w": {"type": "diffuse", "reflectance": 0.5, "twosided": True}},
        "shapes": [
            {"id": "quad", "file": "quad.ply", "material": "w", "emission": [1, 1, 1]}
        ],
    }
    (folder / "scene.json").write_text(json.dumps(tree))
    return folder / "scene.json"


def mitsuba_file(folder, lens):
    pytest.importorskip("mitsuba", reason="reads its own files")
    (folder / "scene.xml").write_text(
        f"""<scene version="3.0.0"><sensor type="perspective">{lens}
        <transform name="to_world">
          <lookat origin="0, 0, 3" target="0, 0, 0" up="0, 1, 0"/>
        </transform>
        <film type="hdrfilm">
          <integer name="width" value="160"/><integer name="height" value="90"/>
        </film></sensor>
        <shape type="sphere"><emitter type="area">
          <rgb name="radiance" value="1"/>
        </emitter></shape></scene>"""
    )
    return folder / "scene.xml"


def gltf_file(folder, _):
    lens = {"yfov": np.radians(40), "aspectRatio": 16 / 9, "znear": 0.1}
    tree = {
        "asset": {"version": "2.0"},
        "cameras": [{"type": "perspective", "perspective": lens}],
        "nodes": [{"camera": 0, "translation": [0, 0, 3]}, {"mesh": 0}],
        "scenes": [{"nodes": [0, 1]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
             "min": [0, 0, 0], "max": [1, 1, 0]}
        ],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"uri": "corners.bin", "byteLength": 36}],
    }  # fmt: skip
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4")
    (folder / "corners.bin").write_bytes(corners.tobytes())
    (folder / "scene.gltf").write_text(json.dumps(tree))
    return folder / "scene.gltf"


def ply_file(folder, _):
    (folder / "quad.ply").write_text(QUAD.format(low=-1))
    return folder / "quad.ply"


def lens(axis):
    return (
        f'<float name="fov" value="40"/><string name="fov_axis" value="{axis}"/>',
        axis,
        40,
    )


def diagonal(millimetres):
    """Angle of a film of 36 mm x 24 mm."""
    return 2 * np.degrees(np.arctan(np.hypot(36, 24) / 2 / millimetres))


FILES = {
    **{f"json-{axis}": (json_file, axis, axis, 40) for axis in FOV_AXES},
    **{f"mitsuba-{axis}": (mitsuba_file, *lens(axis)) for axis in FOV_AXES},
    "mitsuba-focal-length": (
        mitsuba_file,
        '<string name="focal_length" value="35mm"/>',
        "diagonal",
        diagonal(35),
    ),
    "mitsuba-nothing": (mitsuba_file, "", "diagonal", diagonal(50)),
    "gltf": (gltf_file, None, "y", 40),
    "no-camera": (ply_file, None, "smaller", 45),
}


@pytest.mark.parametrize("name", FILES)
def test_every_loader_keeps_the_angle_on_its_axis(tmp_path, name):
    write, given_as, axis, fov = FILES[name]
    path = write(tmp_path, given_as)
    scene = load_scene(path)
    assert scene.camera.fov_axis == axis
    for width, height in [(scene.camera.width, scene.camera.height), *SIZES]:
        camera = frames_of(Named(str(path), False, width, height), scene)(0).camera
        assert (camera.width, camera.height) == (width, height)
        found = tangent(camera, *span(axis, width, height))
        # Angles pass through tangents of float64: a dozen roundings more.
        assert_allclose(found, np.tan(np.radians(fov) / 2), 2 * ROUNDING)


def rows_lit(path, width, height):
    scene = frames_of(Named(str(path), False, width, height), load_scene(path))(0)
    seen = visible_points(build_world(scene), *pixel_centers(width, height))
    return seen.surface.hit.reshape(height, width).any(axis=1).sum()


@pytest.mark.parametrize("size", [(160, 90), (90, 90), (45, 90)], ids=str)
def test_a_vertical_angle_shows_the_same_rows_at_any_width(tmp_path, size):
    """The quad is 2 high and 3 away: 90 / (3 tan 20 degrees) = 82.4 of 90 rows."""
    path = json_file(tmp_path, "y")
    assert rows_lit(path, *size) == 82


def test_control_a_horizontal_angle_shows_more_rows_of_a_narrow_picture(tmp_path):
    """2 / (6 tan 20 degrees) of the width, in rows: 41.2 of 90."""
    assert rows_lit(json_file(tmp_path, "x"), 45, 90) == 42


def test_a_scene_without_a_camera_is_seen_as_a_whole_at_any_shape(tmp_path):
    path = ply_file(tmp_path, None)
    scene = load_scene(path)
    for width, height in SIZES:
        camera = frames_of(Named(str(path), False, width, height), scene)(0).camera
        x, y = image_points(camera, scene.meshes[0].vertices)
        assert (x > 0).all()
        assert (x < width).all()
        assert (y > 0).all()
        assert (y < height).all()


# ---------------------------------------------------------------- the oracle


def test_the_truth_of_a_size_is_that_of_the_file_whatever_its_shape(tmp_path):
    """A renderer that keeps the vertical angle is right, and its picture the same."""
    (tmp_path / "wide").mkdir()
    (tmp_path / "square").mkdir()
    wide = load_scene(json_file(tmp_path / "wide", "y", (160, 90)))
    square = load_scene(json_file(tmp_path / "square", "y", (64, 64)))
    about = (16, 16), Convention(), Tolerance(0.9, 0.9), lambda: 1e6
    found = [
        PictureTruths(scene, *about, folder=tmp_path)(Convention())
        for scene in (wide, square)
    ]
    assert_array_equal(found[0].mean, found[1].mean)


@given(sides, sides, st.sampled_from([1, TILES]))
def test_a_size_by_default_has_the_shape_of_the_camera(width, height, multiple):
    camera = replace(CAMERA, width=width, height=height)
    found = np.array(size_in_shape(camera, 4096, multiple))
    assert (found % multiple == 0).all()
    assert (found >= multiple).all()
    # Each side is rounded to the next multiple.
    shape = np.clip(width / height, 0.01, 100)
    exact = np.sqrt([4096 * shape, 4096 / shape])
    assert (np.abs(found - exact) <= multiple / 2 * (1 + 1e-12)).all()


@pytest.mark.parametrize("axis", FOV_AXES)
def test_the_widest_and_the_narrowest_images_have_finite_rays(axis):
    for width, height in [(16384, 1), (1, 16384)]:
        for fov in (1e-6, 179.999999):
            camera = Camera(
                (0, 0, 0), (0, 0, -1), (0, 1, 0), fov, axis, width=width, height=height
            )
            _, direction = camera_rays(camera, np.array([0.0]), np.array([0.0]))
            assert_allclose(np.linalg.norm(direction), 1, rtol=1e-15)

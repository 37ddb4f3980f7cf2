"""A room of Mitsuba's words: what each camera ray meets is what it meets in Mitsuba.

No noise: position, shading normal, reflectance and emission of the nearest surface, ray
by ray, through the holes of a mask.  The controls are rooms with one word taken
otherwise, each of which must differ.
"""

import numpy as np
import pytest
from PIL import Image

from restir_gi.reference.passes.gbuffer import visible_points
from restir_gi.reference.scene.camera import pixel_centers
from restir_gi.reference.scene.loaders.load import load_scene
from restir_gi.reference.scene.loaders.mitsuba_nodes import mitsuba_session
from restir_gi.reference.scene.validation import validate
from restir_gi.reference.transport.world import build_world
from tests.contracts.test_mitsuba_words import COLORED, OBJ

mi = pytest.importorskip("mitsuba", reason="reads Mitsuba XML by the package mitsuba")

WIDTH, HEIGHT = 32, 24
PICTURE = np.kron(
    np.array([[[255, 60, 60], [60, 230, 60]], [[60, 60, 255], [20, 20, 20]]], np.uint8),
    np.ones((4, 4, 1), np.uint8),
)
HOLES = np.kron(np.array([[255, 0], [0, 255]], np.uint8), np.ones((4, 4), np.uint8))
TEXTURE = '<texture name="{}" type="bitmap"><string name="filename" value="a.png"/>{}'
TEXTURE += "</texture>"
TURNED = '<transform name="to_uv"><scale x="2" y="1.5"/><rotate z="1" angle="30"/>'
TURNED += '<translate x="0.3" y="0.1"/></transform>'
ROOM = """
<scene version="3.0.0">
<sensor type="perspective"><float name="fov" value="50"/>
  <float name="focus_distance" value="3"/><transform name="to_world">
  <lookat origin="0, 0, 3.8" target="0, -0.6, 0" up="0 1 0"/></transform>
  <film type="hdrfilm"><integer name="width" value="32"/>
    <integer name="height" value="24"/><rfilter type="box"/>
    <string name="component_format" value="float32"/></film></sensor>
<bsdf type="diffuse" id="pale"><spectrum name="reflectance"
  value="400:0.5, 500:0.7, 600:0.75, 700:0.8"/></bsdf>
<bsdf type="diffuse" id="leaf"><spectrum name="reflectance" filename="leaf.spd"/></bsdf>
<bsdf type="diffuse" id="moved">{moved}</bsdf>
<bsdf type="diffuse" id="clamped">{clamped}</bsdf>
<emitter type="area" id="lamp">{shining}</emitter>
<shape type="cube"><transform name="to_world"><scale x="3" y="2" z="4"/></transform>
  <boolean name="flip_normals" value="true"/><ref id="pale"/></shape>
<shape type="rectangle"><transform name="to_world"><scale x="2.5" y="1.5"/>
  <translate z="-3.9"/></transform><ref id="moved"/></shape>
<shape type="rectangle"><transform name="to_world"><scale x="2" y="2"/>
  <rotate x="1" angle="-90"/><translate y="-1.95"/></transform>
  <ref id="clamped"/></shape>
<shape type="rectangle"><transform name="to_world"><scale value="0.8"/>
  <rotate x="1" angle="90"/><translate y="1.9"/></transform><ref id="lamp"/></shape>
<shape type="shapegroup" id="group"><shape type="obj"><string name="filename"
  value="flat.obj"/><bsdf type="twosided"><ref id="leaf"/></bsdf></shape>
  <shape type="sphere"><float name="radius" value="0.5"/><ref id="pale"/></shape>
</shape>
<shape type="instance"><ref id="group"/><transform name="to_world">{first}
  <translate x="-1.6" y="-0.6"/></transform></shape>
<shape type="instance"><ref id="group"/><transform name="to_world">
  <scale value="0.6"/><rotate y="1" angle="-50"/><translate x="1.7" y="-0.8"/>
  </transform></shape>
<shape type="cylinder"><point name="p0" x="0.4" y="-1.9" z="-1"/>
  <point name="p1" x="0.2" y="0.4" z="-1.5"/><float name="radius" value="0.4"/>
  <bsdf type="twosided"><bsdf type="roughconductor"><string name="material"
  value="Cu"/><float name="alpha" value="0.4"/></bsdf></bsdf></shape>
<shape type="rectangle"><transform name="to_world"><scale value="0.7"/>
  <rotate x="1" angle="-60"/><translate x="-0.5" y="-1.2" z="1"/></transform>
  <bsdf type="mask"><texture name="opacity" type="bitmap"><string name="filename"
  value="holes.png"/><string name="filter_type" value="nearest"/>{holes}
  </texture>
  <bsdf type="twosided"><bsdf type="diffuse"/></bsdf></bsdf></shape>
<shape type="ply"><string name="filename" value="colored.ply"/>
  <transform name="to_world"><scale value="1.2"/><translate x="0.4" y="-0.2" z="-2"/>
  </transform><bsdf type="twosided"><bsdf type="diffuse"><texture name="reflectance"
  type="mesh_attribute"><string name="name" value="{attribute}"/></texture></bsdf>
  </bsdf></shape>
<emitter type="spot"><transform name="to_world"><lookat origin="1, 1.5, 2"
  target="-1, -1, -1" up="0 1 0"/></transform>
  <rgb name="intensity" value="9, 8, 7"/><float name="cutoff_angle" value="50"/>
  <float name="beam_width" value="20"/></emitter>
</scene>
"""
WORDS = {
    "moved": TEXTURE.format("reflectance", TURNED),
    "clamped": TEXTURE.format(
        "reflectance",
        '<string name="wrap_mode" value="mirror"/><transform name="to_uv">'
        '<scale value="3"/><translate x="-0.7" y="-1.2"/></transform>',
    ),
    "shining": TEXTURE.format("radiance", '<boolean name="raw" value="true"/>'),
    "first": '<rotate y="1" angle="45"/>',
    "holes": '<transform name="to_uv"><scale x="2" y="1"/></transform>',
    "attribute": "vertex_color",
}
OTHERWISE = {
    "moved": TEXTURE.format("reflectance", ""),
    "clamped": WORDS["clamped"].replace("mirror", "clamp"),
    "shining": TEXTURE.format("radiance", ""),
    "first": '<rotate y="1" angle="-45"/>',
    "holes": "",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("room")
    furnish(path)
    with mitsuba_session():
        yield path


def furnish(path):
    """The files of the room."""
    Image.fromarray(PICTURE).save(path / "a.png")
    Image.fromarray(HOLES).save(path / "holes.png")
    (path / "flat.obj").write_text(OBJ.replace("vn 0 0.6 0.8", "vn 0 0 1"))
    (path / "leaf.spd").write_text("400 0.1\n500 0.2\n550 0.6\n600 0.3\n700 0.2\n")
    (path / "colored.ply").write_text(COLORED)


def written(folder, **words):
    path = folder / "room.xml"
    path.write_text(ROOM.format(**{**WORDS, **words}))
    return path


def seen(path):
    """Position, normal, reflectance of what a ray through each pixel meets."""
    scene = validate(load_scene(path))
    x, y = pixel_centers(WIDTH, HEIGHT)
    surface = visible_points(build_world(scene), x, y).surface
    return surface.position, surface.smooth, surface.color


def seen_by_mitsuba(path):
    """Likewise, and whether the surface is diffuse."""
    scene = mi.load_file(str(path))
    sensor, context = scene.sensors()[0], mi.BSDFContext()
    x, y = pixel_centers(WIDTH, HEIGHT)
    rows = []
    for place in zip(x / WIDTH, y / HEIGHT, strict=True):
        ray, _ = sensor.sample_ray(0.0, 0.5, mi.Point2f(*place), mi.Point2f(0.5, 0.5))
        si = scene.ray_intersect(ray)
        while si.bsdf().eval_null_transmission(si)[0] > 0.5:
            si = scene.ray_intersect(si.spawn_ray(ray.d))
        normal = np.array(si.sh_frame.n) * np.sign(si.wi[2])
        up = mi.Vector3f(0, 0, abs(si.wi[2]) / si.wi[2])
        si.wi = up
        color = np.array(si.bsdf().eval(context, si, up)) * np.pi
        diffuse = si.bsdf().flags() & mi.BSDFFlags.Diffuse.value
        rows.append((si.p, normal, color, diffuse != 0))
    return [np.array(column) for column in zip(*rows, strict=True)]


def different(ours, theirs):
    """Share of the pixels in which anything differs."""
    position, normal, color = ours
    there, upright, painted, diffuse = theirs
    # Facets of the cylinder lie up to 2.1e-4 of its radius of 0.4 off the round, and
    # rays meet it at an angle: 1e-3.  Its normals are interpolated over 2.8 degrees:
    # 3e-4.  Float32 rays meet the floor within 4e-4 m, which are 2.2e-3 of its texels.
    wrong = np.abs(position - there).max(axis=1) > 1e-3
    wrong |= np.abs(normal - upright).max(axis=1) > 1e-3
    wrong |= (np.abs(color - painted).max(axis=1) > 5e-3) & diffuse
    return wrong.mean()


def test_rays_meet_what_they_meet_in_mitsuba(folder):
    theirs = seen_by_mitsuba(written(folder))
    # Silhouettes, and the edges of holes, are decided by rounding.
    assert different(seen(written(folder)), theirs) <= 3 / (WIDTH * HEIGHT)
    for word, otherwise in OTHERWISE.items():
        if word != "shining":
            other = seen(written(folder, **{word: otherwise}))
            assert different(other, theirs) > 10 / (WIDTH * HEIGHT), word

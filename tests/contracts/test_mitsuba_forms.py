"""Scenes in the forms that people's Mitsuba files have load strictly.

Each form below is one that Mitsuba's public scenes are written in: how they frame,
light, paint and place, with the words that a renderer of one image needs not heed.
"""

import numpy as np
import pytest
from PIL import Image

from restir_gi.reference.scene.loaders.load import load_scene
from restir_gi.reference.scene.loaders.mitsuba_nodes import mitsuba_session
from restir_gi.reference.scene.validation import validate
from tests.contracts.test_mitsuba_words import OBJ, PICTURE, PLY, serialized

mi = pytest.importorskip("mitsuba", reason="reads Mitsuba XML by the package mitsuba")

PREVIEW = """
<default name="spp" value="16"/>
<integrator type="path"/>
<sensor type="perspective" id="eye">
  <string name="fov_axis" value="smaller"/>
  <float name="focus_distance" value="5"/>
  <float name="fov" value="30"/>
  <transform name="to_world">
    <lookat target="0, 0, 0" origin="4, -4, 3" up="0 0 1"/>
  </transform>
  <sampler type="independent"><integer name="sample_count" value="$spp"/></sampler>
  <film type="hdrfilm" id="film">
    <integer name="width" value="48"/><integer name="height" value="36"/>
    <string name="pixel_format" value="rgb"/><rfilter type="gaussian"/>
  </film>
</sensor>
<emitter type="envmap" id="sky">
  <string name="filename" value="sky.exr"/>
  <transform name="to_world"><rotate y="1" angle="-180"/><rotate x="1" angle="90"/>
  </transform>
  <float name="scale" value="3"/>
</emitter>
<texture type="checkerboard" id="squares">
  <rgb name="color0" value="0.2"/><rgb name="color1" value="0.4"/>
  <transform name="to_uv"><matrix value="8 0 0 0 0 8 0 0 0 0 8 0 0 0 0 1"/></transform>
</texture>
<bsdf type="diffuse" id="floor-look"><ref name="reflectance" id="squares"/></bsdf>
<shape type="serialized" id="floor">
  <string name="filename" value="meshes/parts.serialized"/>
  <integer name="shape_index" value="0"/>
  <transform name="to_world"><rotate z="1" angle="-4"/>
    <matrix value="3 -4 0 -1 4 3 0 1 0 0 5 0 0 0 0 1"/></transform>
  <ref name="bsdf" id="floor-look"/>
</shape>
"""
OBJECT = """
<shape type="serialized">
  <string name="filename" value="meshes/parts.serialized"/>
  <integer name="shape_index" value="1"/>
  <ref id="look"/>
</shape>
"""
BOX = """
<sensor type="perspective">
  <string name="fov_axis" value="smaller"/>
  <float name="near_clip" value="0.1"/><float name="far_clip" value="28"/>
  <float name="focus_distance" value="10"/><float name="fov" value="39"/>
  <transform name="to_world">
    <lookat origin="0, 0, 8" target="0, 0, 7" up="  0,   1,    0"/></transform>
  <sampler type="independent"><integer name="sample_count" value="16"/></sampler>
  <film type="hdrfilm"><integer name="width" value="32"/>
    <integer name="height" value="32"/><rfilter type="box"/>
    <string name="pixel_format" value="rgb"/>
    <string name="component_format" value="float32"/>
    <string name="file_format" value="openexr"/><boolean name="banner" value="false"/>
    <boolean name="sample_border" value="true"/></film>
</sensor>
<bsdf type="diffuse" id="grey">
  <spectrum name="reflectance" value="400:0.3, 500:0.6, 600:0.7, 700:0.72"/></bsdf>
<bsdf type="diffuse" id="black">
  <spectrum name="reflectance" value="400:0.78, 700:0.78"/></bsdf>
<shape type="obj"><string name="filename" value="meshes/flat.obj"/>
  <transform name="to_world"><translate x="0" y="-0.5" z="0"/></transform>
  <ref id="black"/><ref id="lamp"/></shape>
<shape type="obj"><string name="filename" value="meshes/flat.obj"/>
  <ref id="grey"/></shape>
<emitter type="area" id="lamp">
  <spectrum name="radiance" value="400:0, 500:8, 600:15.6, 700:18.4"/></emitter>
"""
LOOKS = {
    "diffuse": '<bsdf type="diffuse" id="look">'
    '<rgb name="reflectance" value="0.2, 0.25, 0.7"/></bsdf>',
    "diffuse without commas": '<bsdf type="diffuse" id="look">'
    '<rgb name="reflectance" value="0.2 0.5 0.3"/></bsdf>',
    "textured": '<bsdf type="diffuse" id="look"><texture name="reflectance"'
    ' type="bitmap"><string name="filename" value="pictures/wood.png"/></texture>'
    "</bsdf>",
    "raw, nearest, clamped and moved": '<bsdf type="diffuse" id="look"><texture'
    ' name="reflectance" type="bitmap"><boolean name="raw" value="true"/>'
    '<string name="filename" value="pictures/wood.png"/>'
    '<string name="filter_type" value="nearest"/>'
    '<string name="wrap_mode" value="clamp"/><transform name="to_uv">'
    '<scale value="2"/><translate value="-.5,-.5, 0"/></transform></texture></bsdf>',
    "mirrored": '<bsdf type="diffuse" id="look"><texture name="reflectance"'
    ' type="bitmap"><string name="filename" value="pictures/wood.png"/>'
    '<string name="wrap_mode" value="mirror"/></texture></bsdf>',
    "checkered by numbers": '<bsdf type="diffuse" id="look"><texture'
    ' name="reflectance" type="checkerboard"><float name="color0" value="0.1"/>'
    '<float name="color1" value="0.4"/><transform name="to_uv"><scale x="5" y="5"/>'
    '<translate x="0.5" y="0.5"/></transform></texture></bsdf>',
    "both sides": '<bsdf type="twosided" id="look"><bsdf type="diffuse">'
    '<rgb name="reflectance" value="0.2, 0.25, 0.7"/></bsdf></bsdf>',
    "by a spectrum": '<bsdf type="diffuse" id="look"><spectrum name="reflectance"'
    ' value="400:0.1, 500:0.3, 600:0.2, 700:0.15"/></bsdf>',
    "by a file of a spectrum": '<bsdf type="diffuse" id="look">'
    '<spectrum name="reflectance" filename="leaf.spd"/></bsdf>',
    "gold": '<bsdf type="conductor" id="look">'
    '<string name="material" value="Au"/></bsdf>',
    "metal by two numbers": '<bsdf type="conductor" id="look">'
    '<spectrum name="eta" value="0.789"/><spectrum name="k" value="6.15"/></bsdf>',
    "copper, Beckmann": '<bsdf type="roughconductor" id="look">'
    '<string name="material" value="Cu"/>'
    '<string name="distribution" value="beckmann"/>'
    '<float name="alpha" value="0.1"/></bsdf>',
    "aluminium, no distribution": '<bsdf type="roughconductor" id="look">'
    '<string name="material" value="Al"/><float name="alpha_u" value="0.15"/>'
    '<float name="alpha_v" value="0.15"/></bsdf>',
    "glass": '<bsdf type="dielectric" id="look"><string name="int_ior" value="bk7"/>'
    '<string name="ext_ior" value="air"/></bsdf>',
    "diamond": '<bsdf type="dielectric" id="look">'
    '<string name="int_ior" value="diamond"/></bsdf>',
    "rough glass, GGX": '<bsdf type="roughdielectric" id="look">'
    '<string name="distribution" value="ggx"/><float name="alpha" value="0.3"/>'
    '<string name="int_ior" value="bk7"/><string name="ext_ior" value="air"/></bsdf>',
    "rough glass, Beckmann": '<bsdf type="roughdielectric" id="look">'
    '<string name="distribution" value="beckmann"/><float name="alpha" value="0.1"/>'
    "</bsdf>",
    "plastic": '<bsdf type="plastic" id="look"/>',
    "shiny plastic": '<bsdf type="plastic" id="look">'
    '<rgb name="diffuse_reflectance" value="0.1, 0.27, 0.36"/>'
    '<float name="int_ior" value="1.9"/></bsdf>',
    "plastic, nonlinear and textured": '<bsdf type="plastic" id="look">'
    '<texture name="diffuse_reflectance" type="bitmap">'
    '<string name="filename" value="pictures/wood.png"/></texture>'
    '<boolean name="nonlinear" value="true"/></bsdf>',
    "rough plastic": '<bsdf type="roughplastic" id="look">'
    '<rgb name="diffuse_reflectance" value="0.07 0.09 0.13"/>'
    '<rgb name="specular_reflectance" value="1"/><float name="int_ior" value="2"/>'
    '<float name="alpha" value="0.05"/></bsdf>',
    "rough plastic, GGX": '<bsdf type="roughplastic" id="look">'
    '<string name="distribution" value="ggx"/>'
    '<float name="int_ior" value="1.61"/><boolean name="nonlinear" value="false"/>'
    "</bsdf>",
}
SHAPES = {
    "sphere": '<shape type="sphere"><point name="center" x="1" y="1" z="4"/>'
    '<float name="radius" value=".5"/><ref id="grey"/></shape>',
    "scaled sphere": '<shape type="sphere"><ref id="grey"/><transform name="to_world">'
    '<scale value="0.5"/><translate value="-1 0 0"/></transform></shape>',
    "cylinder": '<shape type="cylinder"><float name="radius" value="0.3"/>'
    '<point name="p0" x="0" y="-1" z="0"/><point name="p1" x="0" y="1" z="0"/>'
    '<bsdf type="twosided"><bsdf type="diffuse"/></bsdf></shape>',
    "disk": '<shape type="disk"><ref id="grey"/></shape>',
    "checkered disk": '<shape type="disk"><bsdf type="diffuse">'
    '<texture name="reflectance" type="checkerboard"/></bsdf></shape>',
    "cubes": '<shape type="cube"><ref id="grey"/><transform name="to_world">'
    '<scale x="1.5" y="1.5" z="0.2"/><rotate y="1.0" angle="25"/></transform></shape>',
    "ply": '<shape type="ply"><string name="filename" value="meshes/bunny.ply"/>'
    '<boolean name="face_normals" value="true"/><boolean name="flip_normals"'
    ' value="true"/><ref id="grey"/></shape>',
    "instances": '<shape type="shapegroup" id="group"><shape type="obj">'
    '<string name="filename" value="meshes/flat.obj"/><ref id="grey"/></shape>'
    '<shape type="sphere"/></shape><shape type="instance"><ref id="group"/></shape>'
    '<shape type="instance"><ref id="group"/><transform name="to_world">'
    '<rotate y="1" angle="45"/><scale value="1.5"/><translate z="2"/></transform>'
    "</shape>",
    "merged": '<shape type="merge"><shape type="cube"><ref id="grey"/></shape>'
    '<shape type="rectangle"><ref id="grey"/></shape></shape>',
    "invisible": '<shape type="cube"><bsdf type="null"/></shape>',
    "a second lamp inside": '<shape type="rectangle"><emitter type="area">'
    '<rgb name="radiance" value="800, 800, 800"/></emitter>'
    '<bsdf type="diffuse"><rgb name="reflectance" value="0,0,0"/></bsdf></shape>',
    "a picture that shines": '<shape type="rectangle"><emitter type="area">'
    '<texture name="radiance" type="bitmap"><string name="filename"'
    ' value="pictures/wood.png"/></texture></emitter></shape>',
}
SETTINGS = {
    "spot": '<emitter type="spot"><transform name="to_world"><lookat origin="0, 3, 0"'
    ' target="0, 0, 0" up="0, 0, 1"/></transform><rgb name="intensity" value="15.0"/>'
    '<float name="cutoff_angle" value="30"/><float name="beam_width" value="15"/>'
    "</emitter>",
    "point": '<emitter type="point"><point name="position" x="-5" y="-6.0" z="0.0"/>'
    '<rgb name="intensity" value="300"/></emitter>',
    "directional": '<emitter type="directional"><vector name="direction"'
    ' value="0,0,1"/><rgb name="irradiance" value="2.0"/></emitter>',
    "constant": '<emitter type="constant"/>',
    "aov": '<integrator type="aov"><string name="aovs" value="d:depth,n:sh_normal"/>'
    '<integrator type="path" name="image"/></integrator>',
    "moment": '<default name="integrator" value="path"/><integrator type="moment">'
    '<integrator type="$integrator"><integer name="max_depth" value="2"/></integrator>'
    "</integrator>",
    "direct": '<integrator type="direct"><integer name="emitter_samples" value="4"/>'
    '<integer name="bsdf_samples" value="0"/></integrator>',
    "particles": '<integrator type="ptracer"><integer name="max_depth" value="4"/>'
    '<boolean name="hide_emitters" value="false"/></integrator>',
    "of a medium that nobody is in": '<medium type="homogeneous" id="fog"/>'
    '<bsdf type="hair" id="hair"/>',
}
FORMS = {
    **{f"look: {name}": f"{look}{PREVIEW}{OBJECT}" for name, look in LOOKS.items()},
    **{f"shape: {name}": f"{BOX}{shape}" for name, shape in SHAPES.items()},
    **{f"setting: {name}": f"{BOX}{words}" for name, words in SETTINGS.items()},
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    import OpenEXR

    path = tmp_path_factory.mktemp("forms")
    (path / "library" / "meshes").mkdir(parents=True)
    (path / "library" / "pictures").mkdir()
    meshes = path / "library" / "meshes"
    (meshes / "flat.obj").write_text(OBJ)
    (meshes / "bunny.ply").write_text(PLY)
    (meshes / "parts.serialized").write_bytes(serialized(2))
    Image.fromarray(PICTURE).save(path / "library" / "pictures" / "wood.png")
    (path / "library" / "leaf.spd").write_text("400 0.1\n500 0.3\n600 0.2\n700 0.1\n")
    header = {"type": OpenEXR.scanlineimage, "compression": OpenEXR.ZIP_COMPRESSION}
    sky = np.ones((4, 8, 3), np.float32)
    OpenEXR.File(header, {"RGB": sky}).write(str(path / "library" / "sky.exr"))
    with mitsuba_session():
        yield path


def test_the_forms_are_at_least_as_many_as_promised():
    assert len(FORMS) >= 35


@pytest.mark.parametrize("form", FORMS)
def test_forms_of_public_scenes_load_strictly(folder, form):
    path = folder / "scene.xml"
    body = f'<path value="library"/>{FORMS[form]}'
    path.write_text(f'<scene version="3.0.0">{body}</scene>')
    scene = load_scene(path)
    validate(scene)
    mi.load_file(str(path))  # it is Mitsuba's, too

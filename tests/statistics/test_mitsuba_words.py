"""The words of Mitsuba's scenes mean what Mitsuba takes them to mean.

Evidence: statistics, and an independent renderer.  One room holds instances, pictures
that are moved, turned, mirrored and clamped, spectra, a cylinder, Beckmann's
metal, a spot and a picture that shines.  Its one-bounce indirect light by our path
tracer is compared with Mitsuba's, see `test_mitsuba`: the image mean within 0.5 %, and
each tile of 8 x 8 pixels.  A correct loader fails the tiles with probability 1e-4, and
the mean with the probability that is printed.  The controls are scenes with one word
taken otherwise, each of which must fail.
"""

import numpy as np
import pytest
from PIL import Image
from scipy import stats

from reference.scene.loaders.load import load_scene
from tests.contracts.test_mitsuba_words import OBJ
from tests.statistics.replicates import Means, path_traced, small_world, threshold
from tests.statistics.test_mitsuba import BATCHES, FAMILY, LIMIT, rendered

WIDTH, HEIGHT = 32, 24
PICTURE = np.kron(
    np.array([[[255, 60, 60], [60, 230, 60]], [[60, 60, 255], [20, 20, 20]]], np.uint8),
    np.ones((4, 4, 1), np.uint8),
)
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
}
OTHERWISE = {
    "moved": TEXTURE.format("reflectance", ""),
    "clamped": WORDS["clamped"].replace("mirror", "clamp"),
    "shining": TEXTURE.format("radiance", ""),
    "first": '<rotate y="1" angle="-45"/>',
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("room")
    Image.fromarray(PICTURE).save(path / "a.png")
    (path / "flat.obj").write_text(OBJ.replace("vn 0 0.6 0.8", "vn 0 0 1"))
    (path / "leaf.spd").write_text("400 0.1\n500 0.2\n550 0.6\n600 0.3\n700 0.2\n")
    return path


def written(folder, **words):
    path = folder / "room.xml"
    path.write_text(ROOM.format(**{**WORDS, **words}))
    return path


def ours(path):
    world = small_world(load_scene(path), WIDTH, HEIGHT)
    return path_traced(world, 800, jitter=np.random.default_rng(5))


def judge(a: Means, b: Means) -> tuple[float, float, float]:
    """Relative difference of the image means, its error, and the tiles' largest |t|."""
    difference, scale = a.mean - b.mean, b.mean[0]
    error = np.sqrt(a.error**2 + b.error**2).clip(1e-300)
    t = np.abs(difference / error)[1:].max()
    return float(difference[0] / scale), float(error[0] / scale), float(t)


@pytest.mark.slow
def test_a_room_of_words(folder):
    theirs = rendered(written(folder), WIDTH, HEIGHT, 60)
    bias, error, t = judge(ours(written(folder)), theirs)
    false_alarm = 2 * stats.norm.sf(LIMIT / error)
    print(
        f"bias {bias:+.3%} +- {error:.3%}, largest |t| {t:.2f}; a correct loader's mean"
        f" would fail with probability {false_alarm:.0e}"
    )
    bound = threshold(len(theirs.mean) - 1, FAMILY, BATCHES)
    assert t <= bound
    assert abs(bias) <= LIMIT
    for word, otherwise in OTHERWISE.items():
        wrong, _, worst = judge(ours(written(folder, **{word: otherwise})), theirs)
        print(f"{word} otherwise: {wrong:+.3%}, largest |t| {worst:.2f}")
        assert worst > bound or abs(wrong) > LIMIT

"""Lamps with a texture, lamps of two sides, and spots, against closed forms.

Densities and spots are free of noise: their tolerances are rounding.  Where light is
estimated, the mean of N independent samples must lie within SIGMAS standard errors of
the closed form, which a right estimator leaves with probability 6e-7 (N is at least 65
thousand, and no sample is more than some hundred times the mean: the mean is normal to
that level).  Each such test states that its standard error is below 1 %, so that a bias
of 6 % would not have gone unnoticed.  Control: a density that does not know the texture
is rejected.
"""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad as integral

from restir_gi.reference.numerics.arrays import divide_or_zero, dot
from restir_gi.reference.numerics.records import take
from restir_gi.reference.numerics.rng import KeyedUniforms, Stream
from restir_gi.reference.scene.camera import Camera
from restir_gi.reference.scene.cones import build_cones, falloff, solid_angles
from restir_gi.reference.scene.emitters import emitted, pdf_light
from restir_gi.reference.scene.light_sampling import points_on_lights, sample_light
from restir_gi.reference.scene.lights import PointLight, SpotLight
from restir_gi.reference.scene.materials.kinds import Lambertian
from restir_gi.reference.scene.origins import step_before
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.shapes import Sphere, quad
from restir_gi.reference.scene.textures import Bitmap, Checker
from restir_gi.reference.scene.validation import validate
from restir_gi.reference.transport import direct_light
from restir_gi.reference.transport.direct_light import choose_light, next_event
from restir_gi.reference.transport.path_tracer import reflected_radiance
from restir_gi.reference.transport.world import build_world
from tests.analytic.rendering import path_traced, what_is_seen, world_of

SIGMAS = 5.0
SAMPLES = 1 << 16
ROUNDING = 2.0**-53

WHITE = Lambertian((0.8, 0.8, 0.8))
BLACK = Lambertian((0.0, 0.0, 0.0))
EYE = Camera(position=(0.1, 1.0, 0.05), target=(0.1, 0.0, 0.0), fov=30.0)


def a_sixteenth():
    """One texel of sixteen shines: the second row from the top, the third column."""
    pixels = np.zeros((4, 4, 3))
    pixels[1, 2] = 8.0, 4.0, 2.0
    return Bitmap(pixels, "nearest")


def spotty(filter="bilinear", **kind):
    """Half of the texels are black, the others differ by a factor of a thousand."""
    pixels = 10.0 ** np.random.default_rng(1).uniform(-3, 0, (6, 5, 3))
    pixels[::2, 1::2] = pixels[1::2, ::2] = 0.0
    return Bitmap(pixels, filter, **kind)


TEXTURES = {
    "a sixteenth": a_sixteenth(),
    "bilinear": spotty(),
    "repeated": spotty("nearest", scale=(2.5, -1.5)),
    "mirrored": spotty(scale=(1.7, 2.2), wrap=("mirror", "clamp")),
    "checker": Checker((0.0, 0.0, 0.0), (3.0, 2.0, 1.0), (2.0, 3.0)),
}


def hall(emission, two_sided=False, also=()):
    """A floor, a ceiling, and between them a lamp a metre wide that looks down."""
    floor = quad("floor", (-2, 0, 2), (4, 0, 0), (0, 0, -4), WHITE)
    ceiling = quad("ceiling", (-2, 2, -2), (4, 0, 0), (0, 0, 4), WHITE)
    lamp = quad("lamp", (-0.5, 1, -0.5), (1, 0, 0), (0, 0, 1), BLACK, emission)
    lamp = replace(lamp, two_sided_emission=two_sided)
    camera = replace(EYE, position=(0.9, 0.7, 0.8), width=16, height=16)
    return validate(
        Scene(name="hall", camera=camera, meshes=(floor, ceiling, lamp, *also))
    )


def below_lamp(world, x, size):
    """The same point of the floor, many times."""
    seen = what_is_seen(world)
    row = np.flatnonzero(seen.hit & (seen.normal[:, 1] > 0.9))[0]
    points = take(seen, np.full(size, row))
    points.position[:] = x
    return points


def of_polygon(x, n, corners):
    """Irradiance over radiance from a polygon, all of it above the horizon.

    Lambert's formula: half the sum, over the edges, of the angle that each subtends
    times the cosine between the receiver's normal and that of the plane of the edge.
    """
    rays = corners - x
    rays /= np.linalg.norm(rays, axis=1)[:, None]
    total = 0.0
    for a, b in zip(rays, np.roll(rays, -1, axis=0), strict=True):
        normal = np.cross(a, b)
        angle = np.arctan2(np.linalg.norm(normal), a @ b)
        total += angle * (normal @ n) / np.linalg.norm(normal)
    return abs(total) / 2


def texel_corners(row, column):
    """Of the lamp's 4 x 4 texels: u runs along +x, v along +z, row 0 is at v = 1."""
    u, v = column / 4, 1 - (row + 1) / 4
    square = np.array([[u, v], [u + 0.25, v], [u + 0.25, v + 0.25], [u, v + 0.25]])
    height = np.ones(4)
    return np.stack([square[:, 0] - 0.5, height, square[:, 1] - 0.5], axis=-1)


def agree(samples, truth):
    """Whether a mean is that of the truth, as far as a small standard error tells."""
    off, error = lies_off(samples, truth)
    assert error < 0.01 * truth
    return off < SIGMAS


def lies_off(samples, truth):
    """Distance of a mean from the truth in standard errors, and the standard error."""
    error = samples.std(ddof=1) / np.sqrt(len(samples))
    return abs(samples.mean() - truth) / error, error


# ------------------------------------------------------------ densities


def met_by(world, x, lights, primitive, front):
    """What rays towards sampled points would meet, without the rounding of rays."""
    points = below_lamp(world, x, len(primitive))
    step = step_before(world.geometry, primitive, lights.n_to, -lights.wi)
    return replace(
        points,
        position=lights.x_to + step,
        normal=lights.n_to,
        wo=-lights.wi,
        primitive=primitive,
        front=front,
    )


@pytest.mark.parametrize("two_sided", [False, True])
@pytest.mark.parametrize("texture", TEXTURES)
def test_a_met_point_has_the_density_with_which_it_is_drawn(texture, two_sided):
    """And the radiance.

    Steps of up to 2⁻¹⁸ are added and taken away at coordinates of up to 2: an error of
    2⁻⁵² m, which a density of distances above 0.2 m multiplies by less than 100.
    """
    world = build_world(hall(TEXTURES[texture], two_sided))
    e, g = world.emitters, world.geometry
    u = tuple(np.random.default_rng(2).random((4, 5000)))
    heights = np.where(u[3] < 0.5, 0.0, 1.4)[:, None]
    x = np.array([0.3, 0.0, 0.2]) + heights * [0.0, 1.0, 0.0]
    lights = sample_light(e, g, x, u)
    light = np.searchsorted(e.cumulative, u[0], side="right")
    primitive = e.primitive[light]
    from_below = x[:, 1] < 1
    met = met_by(world, x, lights, primitive, from_below)
    found = pdf_light(e, g, x, met)
    assert_allclose(found, lights.pdf, rtol=200 * 2 * ROUNDING)
    assert ((found > 0) == (from_below | two_sided)).all()
    radiance = emitted(e, g, met)
    shown = found > 0
    assert_allclose(
        radiance[shown], (lights.weight * lights.pdf[:, None])[shown], atol=1e-10
    )
    # What is never emitted is rarely drawn; and the control: of the lamp as a whole.
    assert np.any(radiance > 0)
    whole = knows_no_texture(e, g, x, met)
    assert np.mean(np.abs(whole[shown] / found[shown] - 1)) > 0.1


def knows_no_texture(emitters, geometry, x, points):
    """Density of a lamp that is chosen by its power, and uniform over its area."""
    area = geometry.area[emitters.primitive[0]] * 2
    density = np.zeros(len(points))
    on_lamp = np.isin(points.primitive, emitters.primitive)
    offset = points.position - x
    cosine = dot(points.normal, points.wo)
    shown = on_lamp & (cosine > 0)
    density[shown] = divide_or_zero(dot(offset, offset) / area, cosine)[shown]
    return density


@pytest.mark.parametrize("texture", TEXTURES)
def test_densities_over_all_cells_sum_to_one(texture):
    """Area of each cell times the density in its middle, from any point.

    Hundreds of terms are summed, each with the rounding of the test before.
    """
    world = build_world(hall(TEXTURES[texture]))
    e, g = world.emitters, world.geometry
    light = np.arange(len(e.primitive))
    half = np.full(len(light), 0.5)
    x = np.broadcast_to([0.3, 0.1, 0.2], (len(light), 3))
    lights = points_on_lights(e, g, x, light, (half, half, half, half))
    met = met_by(world, x, lights, e.primitive, np.ones(len(light), bool))
    offset = lights.x_to - x
    spread = -dot(lights.n_to, lights.wi) / dot(offset, offset)
    area = g.area[e.primitive] / e.cells.side[e.primitive] ** 2
    assert_allclose(np.sum(area), 1.0, rtol=1e-13)
    assert_allclose(pdf_light(e, g, x, met) * spread @ area, 1.0, rtol=1e-12)


def test_cells_that_show_no_light_are_never_drawn():
    """An eighth of one triangle shines, and a little of what surrounds it is drawn."""
    emitters = build_world(hall(a_sixteenth())).emitters
    assert len(emitters.primitive) == 2 * 8 * 8
    assert 8 <= (emitters.probability > 0).sum() <= 32


def test_a_lamp_in_the_dark_of_its_texture_is_no_light():
    dark = replace(a_sixteenth(), scale=(0.25, 0.25))
    assert build_world(hall(dark)).emitters is None


# ------------------------------------------------------------ closed forms


def test_a_lamp_of_which_a_sixteenth_shines():
    """Next-event estimation, against Lambert's formula."""
    x, n = np.array([0.35, 0.0, 0.2]), np.array([0.0, 1.0, 0.0])
    world = build_world(hall(a_sixteenth()))
    points = below_lamp(world, x, SAMPLES)
    u = tuple(np.random.default_rng(3).random((4, SAMPLES)))
    lights = sample_light(world.emitters, world.geometry, points.position, u)
    arriving = lights.weight[:, 0] * np.maximum(dot(points.normal, lights.wi), 0)
    truth = 8.0 * of_polygon(x, n, texel_corners(1, 2))
    assert agree(arriving, truth)
    # The density of a lamp that does not know its texture: the samples stay.
    light = np.searchsorted(world.emitters.cumulative, u[0], side="right")
    primitive = world.emitters.primitive[light]
    met = met_by(world, x, lights, primitive, np.ones(SAMPLES, bool))
    wrong = knows_no_texture(world.emitters, world.geometry, points.position, met)
    assert lies_off(arriving * lights.pdf / wrong, truth)[0] > 10 * SIGMAS


def paths(world, x):
    """Direct light at x by both strategies, weighted: SAMPLES paths."""
    points = below_lamp(world, x, SAMPLES)
    pixel = np.arange(SAMPLES, dtype=np.uint32)
    u = KeyedUniforms(pixel, 0, 4, Stream.PATH)
    return reflected_radiance(world, points, 0, u)[:, 0]


def test_both_strategies_together_see_a_sixteenth_shine(monkeypatch):
    """Close below the lamp, where rays often hit it.

    The rays are of float32: they tell texels apart to 1e-6 of the lamp.
    """
    x, n = np.array([0.15, 0.8, 0.1]), np.array([0.0, 1.0, 0.0])
    world = build_world(hall(a_sixteenth()))
    truth = 0.8 / np.pi * 8.0 * of_polygon(x, n, texel_corners(1, 2))
    assert agree(paths(world, x), truth)
    monkeypatch.setattr(direct_light, "pdf_light", knows_no_texture)
    assert lies_off(paths(world, x), truth)[0] > 2 * SIGMAS


def test_a_sphere_that_glows_in_two_colours_lights_all_its_inside_alike():
    """From any point of a sphere every part of it fills the same share: π times mean L.

    The quadrants of the texture, cut at half its longitudes and at the equator, are of
    one area.
    """
    glow = Checker((4.0, 4.0, 4.0), (0.0, 0.0, 0.0))
    ball = Sphere(
        name="ball", center=(0, 0, 0), radius=1.0, material=WHITE, emission=glow,
        inward=True,
    )  # fmt: skip
    camera = Camera((0, 0, 0), target=(1.0, 0.2, 0.1), fov=90)
    world = world_of(validate(Scene(name="ball", camera=camera, spheres=(ball,))), 32)
    direct = path_traced(world, "direct", 0, samples=64)[:, 0]
    own = emitted(world.emitters, world.geometry, what_is_seen(world))[:, 0]
    assert set(np.unique(own)) == {0.0, 4.0}
    # A thousand pixels of 64 samples each, independent.
    assert agree(direct - own, 0.8 * 2.0)


def test_an_even_bitmap_is_a_colour():
    """Its picture has the expectation of that of the colour, pixel by pixel."""
    even = Bitmap(np.full((3, 3, 3), (0.5, 1.0, 2.0)))
    pictures = []
    for emission in (even, (0.5, 1.0, 2.0)):
        world = build_world(hall(emission))
        pictures.append(path_traced(world, "full", 1, samples=32))
    a, b = (picture.mean(axis=0) for picture in pictures)
    error = np.std(pictures[0] - pictures[1], axis=0) / np.sqrt(len(pictures[0]))
    assert (np.abs(a - b) < SIGMAS * error).all()
    assert (error < 0.02 * b).all()


# ------------------------------------------------------------ both sides


@pytest.mark.parametrize("emission", [(3.0, 2.0, 1.0), a_sixteenth()])
def test_both_sides_of_a_lamp_light_alike(emission):
    """Floor and ceiling are each other's mirror image in the plane of the lamp.

    The same random numbers draw the same points; coordinates are rounded otherwise.
    """
    world = build_world(hall(emission, two_sided=True))
    u = tuple(np.random.default_rng(5).random((4, 1000)))
    found = []
    for height, up in ((2.0**-7, 1.0), (2.0 - 2.0**-7, -1.0)):
        x = (0.35, height, 0.2)
        n = np.broadcast_to([0.0, up, 0.0], (1000, 3))
        points = replace(below_lamp(world, x, 1000), normal=n, wo=n)
        found.append(next_event(world, points, u))
    assert_allclose(*found, rtol=1e-12)
    assert found[0].any()
    # One side alone leaves the ceiling dark.
    single = build_world(hall(emission))
    assert not next_event(single, points, u).any()


def test_both_sides_of_a_lamp_are_seen():
    for two_sided in (False, True):
        scene = hall((3.0, 2.0, 1.0), two_sided)
        for height, shines in ((0.5, True), (1.5, two_sided)):
            eye = Camera((0, height, 0), target=(0, 1, 0), up=(1, 0, 0), fov=20)
            world = world_of(replace(scene, camera=eye), 4)
            seen = emitted(world.emitters, world.geometry, what_is_seen(world))
            assert (seen == ((3.0, 2.0, 1.0) if shines else (0.0,) * 3)).all()


def test_a_back_that_emits_doubles_the_power():
    """Beside a lamp of one side it is chosen twice as often."""
    other = quad("other", (1, 1, -0.5), (1, 0, 0), (0, 0, 1), BLACK, (1.0, 1.0, 1.0))
    world = build_world(hall((1.0, 1.0, 1.0), True, also=(other,)))
    assert_allclose(world.emitters.probability, [1 / 3, 1 / 3, 1 / 6, 1 / 6])


# ------------------------------------------------------------ spots

SPOTS = [
    SpotLight((0.0, 1.0, 0.0), (0.0, -1.0, 0.0), (5.0, 3.0, 1.0), c, b, kind)
    for c, b in ((40.0, 25.0), (40.0, 40.0), (80.0, 0.0), (170.0, 100.0), (0.5, 0.2))
    for kind in ("linear", "smooth")
]


def fallen(spot, angle):
    """The falloff as its two definitions state it, in degrees."""
    if angle <= spot.beam:
        return 1.0
    if angle >= spot.cutoff:
        return 0.0
    if spot.falloff == "linear":
        return (spot.cutoff - angle) / (spot.cutoff - spot.beam)
    cosine, inner, outer = np.cos(np.radians([angle, spot.beam, spot.cutoff]))
    return ((cosine - outer) / (inner - outer)) ** 2


@pytest.mark.parametrize("spot", SPOTS, ids=str)
def test_a_spot_on_a_plane(spot):
    """One light that no ray meets: ρ / π I f(θ) cos θ / d², without noise.

    The angle comes from an arc cosine: at θ its error is some roundings over sin θ,
    and the falloff's over the width of the cone as well.
    """
    floor = quad("floor", (-9, 0, 9), (18, 0, 0), (0, 0, -18), WHITE)
    camera = replace(EYE, width=4, height=4)
    world = build_world(
        validate(Scene(name="s", camera=camera, meshes=(floor,), spots=(spot,)))
    )
    angles = np.array([0.0, 0.15, 0.3, 0.45, 0.6, 20.0, 30.0, 39.0, 41.0, 70.0, 79.0])
    x = np.tan(np.radians(angles))
    points = take(what_is_seen(world), np.zeros(len(x), int))
    points = replace(points, position=np.stack([x, 0 * x, 0 * x], axis=-1))
    found = next_event(world, points, tuple(np.full((4, len(x)), 0.5)))
    cosine = np.cos(np.radians(angles))
    shape = np.array([fallen(spot, angle) for angle in angles])
    wanted = 0.8 / np.pi * (shape * cosine**3)[:, None] * np.array(spot.intensity)
    wide = np.radians(max(spot.cutoff - spot.beam, 0.3))
    assert_allclose(found, wanted, rtol=1e-12, atol=100 * ROUNDING / 0.002 / wide)


@pytest.mark.parametrize("spot", SPOTS, ids=str)
def test_a_spot_is_chosen_by_its_power(spot):
    """Intensity over the cone by quadrature, whose own error is below 1e-8."""
    wanted, error = integral(
        lambda t: 2 * np.pi * np.sin(t) * fallen(spot, np.degrees(t)),
        0, np.pi, points=np.radians([spot.beam, spot.cutoff]), limit=200,
    )  # fmt: skip
    assert error < 1e-8
    found = solid_angles(build_cones((spot,)))[0]
    assert_allclose(found, wanted, rtol=1e-8, atol=1e-8)


def test_a_point_light_among_spots_shines_everywhere():
    cones = build_cones((PointLight((0, 0, 0), (1.0, 1, 1)), SPOTS[0]))
    directions = np.random.default_rng(6).normal(size=(1000, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    directions[0] = 0.0, 0.0, -1.0
    assert (falloff(cones, np.zeros(1000, int), directions) == 1.0).all()
    assert_allclose(solid_angles(cones)[0], 4 * np.pi, rtol=1e-15)


def test_points_and_spots_share_their_light_by_power():
    """A spot of 60 degrees without falloff has a quarter of the sphere."""
    spot = SpotLight((0, 0.9, 0), (0.0, -1.0, 0.0), (2.0, 2, 2), 60.0, 60.0)
    lamp = PointLight((0, 0.5, 0), (1.0, 1, 1))
    dark = [replace(m, emission=(0.0, 0.0, 0.0)) for m in hall((1.0, 1, 1)).meshes]
    scene = replace(hall((1.0, 1, 1)), points=(lamp,), spots=(spot,))
    world = build_world(replace(scene, meshes=tuple(dark)))
    assert_allclose(world.emitters.probability, [2 / 3, 1 / 3])
    u = tuple(np.random.default_rng(7).random((4, SAMPLES)))
    x = (0.3, 0.01, 0.2)
    light = choose_light(world, below_lamp(world, x, SAMPLES), u)
    both = np.array([(0.0, 0.5, 0.0), (0.0, 0.9, 0.0)]) - x
    square = np.sum(both * both, axis=1)
    truth = 0.8 / np.pi * np.sum([1.0, 2.0] * both[:, 1] / square**1.5)
    assert agree(light.value[:, 0], truth)


@pytest.mark.parametrize(
    "spot", [s for s in SPOTS if s.falloff == "linear" and s.cutoff > 1], ids=str
)
def test_a_spot_is_that_of_mitsuba(spot):
    """Irradiance facing the light at points around it, as Mitsuba's emitter has it.

    Mitsuba computes in float32: angles of arc cosines of it are off by ε / sin θ, which
    the width of the falloff multiplies: a cone of half a degree tells nothing.
    """
    mi = pytest.importorskip("mitsuba", reason="Mitsuba's own spot")
    mi.set_variant("scalar_rgb")
    away = np.array(spot.position) + np.array(spot.direction)
    frame = mi.ScalarTransform4f().look_at(
        list(spot.position), away.tolist(), [1, 0, 0]
    )
    theirs = mi.load_dict(
        {
            "type": "spot",
            "to_world": frame,
            "intensity": {"type": "rgb", "value": list(spot.intensity)},
            "cutoff_angle": spot.cutoff,
            "beam_width": spot.beam,
        }
    )
    rng = np.random.default_rng(8)
    x = np.array(spot.position) + rng.normal(size=(200, 3))
    x[:50] = spot.position + np.array([0.005, 0.3, 0.005]) * (x[:50] - spot.position)
    offset = x - spot.position
    distance = np.linalg.norm(offset, axis=1)
    direction = offset / distance[:, None]
    shape = falloff(build_cones((spot,)), np.zeros(len(x), int), direction)
    ours = shape[:, None] * np.array(spot.intensity) / distance[:, None] ** 2
    si = mi.SurfaceInteraction3f()
    found = []
    for at in x:
        si.p = mi.Point3f(*at.tolist())
        _, weight = theirs.sample_direction(si, mi.Point2f(0.5, 0.5))
        found.append([weight[k] for k in range(3)])
    sine = np.sqrt(1 - (direction @ spot.direction) ** 2)
    wide = np.radians(max(spot.cutoff - spot.beam, 0.1))
    slack = 16 * np.finfo(np.float32).eps * (1 + 1 / (np.maximum(sine, 1e-3) * wide))
    bright = np.max(spot.intensity) / distance**2
    assert (np.abs(found - ours) <= (slack * bright)[:, None]).all()
    assert shape.any()
    assert (shape < 1).any()
    # Another width would have been told apart.
    narrower = replace(spot, beam=0.9 * spot.beam, cutoff=0.9 * spot.cutoff)
    changed = falloff(build_cones((narrower,)), np.zeros(len(x), int), direction)
    assert (np.abs(changed - shape) > 10 * slack).any()

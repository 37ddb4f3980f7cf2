"""Two pictures whose relation is known, though neither picture is.

Relations by powers of two, and those between runs that differ in nothing that may
matter, hold bit for bit: no multiplication by 2^k rounds.  The others state their
rounding.  Each is tried on the path tracer and on ReSTIR GI.
"""

from dataclasses import replace

import numpy as np
import pytest

from restir_gi.reference.frame import FrameContext
from restir_gi.reference.numerics.frames import to_world
from restir_gi.reference.numerics.records import take
from restir_gi.reference.numerics.rng import KeyedUniforms, Stream, TabledUniforms
from restir_gi.reference.numerics.sampling import sample_cosine_hemisphere
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.restir_gi import next_frame
from restir_gi.reference.scene.brightness import brightened
from restir_gi.reference.scene.camera import Camera
from restir_gi.reference.scene.catalogue.registry import CATALOGUE, find_scene
from restir_gi.reference.scene.catalogue.rooms import pose
from restir_gi.reference.scene.lights import ConstantEnvironment
from restir_gi.reference.scene.materials.bsdf_sampling import BsdfSamples
from restir_gi.reference.scene.materials.kinds import Lambertian
from restir_gi.reference.scene.origins import STEP
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.shapes import Mesh, Sphere, box
from restir_gi.reference.settings import Settings
from restir_gi.reference.transport.path_tracer import reflected_radiance
from tests.analytic.rendering import (
    ONE_BAND,
    frames_of,
    moved,
    path_traced,
    what_is_seen,
    world_of,
)

SIZE = 24
EPS = 2.0**-52


def pt(scene, **choice):
    """A path-traced picture."""
    options = {"light": "full", "bounces": 3, "samples": 2, "seed": 7} | choice
    return path_traced(world_of(scene, SIZE), **options)


def restir(scene, **choice):
    """Third frame of ReSTIR GI, two bounces."""
    return frames_of(world_of(scene, SIZE), 3, bounces=2, seed=7, **choice)[-1].color


RENDERERS = {
    "path": pt,
    "restir": restir,
    "restir-biased": lambda scene: restir(scene, mis="1/M", target="outgoing"),
    "restir-balance": lambda scene: restir(scene, mis="balance", source="bsdf"),
}
renderers = pytest.mark.parametrize("render", RENDERERS.values(), ids=RENDERERS)
scenes = pytest.mark.parametrize(
    "name", ["cornell-box", "glossy-floor", "checker", "sunlit-wall"]
)


def with_colors(scene, change, names=None):
    """Lambertian reflectances changed, of all meshes or of some."""

    def painted(mesh):
        if names is not None and mesh.name not in names:
            return mesh
        color = tuple(change(np.array(mesh.material.reflectance)))
        return replace(mesh, material=Lambertian(color))

    return replace(scene, meshes=tuple(map(painted, scene.meshes)))


# ---------------------------------------------------------------- light and colour


@renderers
@scenes
@pytest.mark.parametrize("k", [-10, 12, -150, 150])
def test_emission_times_a_power_of_two(render, name, k):
    """T1.  Kills absolute epsilons, clamps of W and of radiance."""
    scene = find_scene(name)
    plain = render(scene)
    assert plain.any()
    assert np.array_equal(render(brightened(scene, 2.0**k)), plain * 2.0**k)


@pytest.mark.parametrize("reuse", ["", "1/Z", "1/M", "balance"])
def test_emission_leaves_choices_and_weights_alone(reuse):
    """T1 again: the same samples are kept, with the same W."""
    plain, bright = (
        frames_of(
            world_of(brightened(find_scene("cornell-box"), factor), SIZE),
            3,
            seed=3,
            **({"mis": reuse} if reuse else {"temporal": False, "spatial": False}),
        )[-1]
        for factor in (1.0, 2.0**9)
    )
    for one, other in (
        (plain.temporal, bright.temporal),
        (plain.spatial, bright.spatial),
    ):
        assert np.array_equal(one.y.position, other.y.position)
        assert np.array_equal(one.W, other.W)
        assert np.array_equal(one.M, other.M)


@pytest.mark.parametrize("k", [1, 4])
def test_albedo_of_what_is_seen_scales_the_picture(k):
    """T2: the floor's own albedo counts once, in one bounce off the wall."""
    scene = find_scene("sunlit-wall")
    dark = with_colors(scene, lambda c: c * 2.0**-k, {"floor"})
    for render in (lambda s: pt(s, light="indirect", bounces=1), restir_one_bounce):
        floor = what_is_seen(world_of(scene, SIZE)).primitive < 2
        plain = render(scene)[floor]
        assert plain.any()
        assert np.array_equal(render(dark)[floor], plain * 2.0**-k)


def restir_one_bounce(scene, **choice):
    return frames_of(world_of(scene, SIZE), 3, bounces=1, seed=7, **choice)[-1].color


@pytest.mark.parametrize("k", [1, 5])
def test_albedo_counts_once_a_vertex(k):
    """T3: n indirect bounces have n + 1 vertices."""
    scene = find_scene("cornell-box")
    dark = with_colors(scene, lambda c: c * 2.0**-k)
    for renders in (
        lambda s, n: pt(s, light="indirect", bounces=n),
        lambda s, n: (
            frames_of(world_of(s, SIZE), 2, n, seed=7, temporal=False, spatial=False)[
                -1
            ].color
        ),
    ):
        light, darker = ([renders(s, n) for n in (1, 2, 3)] for s in (scene, dark))
        assert np.array_equal(darker[0], light[0] * 2.0 ** (-2 * k))
        for n in (1, 2):
            # Orders are differences: a dozen roundings of the brighter picture.
            order, dim = light[n] - light[n - 1], darker[n] - darker[n - 1]
            expected = order * 2.0 ** (-k * (n + 2))
            scale = light[n].max() * 2.0 ** (-2 * k)
            assert order.max() > 0
            assert np.abs(dim - expected).max() <= 16 * EPS * scale


PERMUTED = [2, 0, 1]


def permute(color):
    return np.asarray(color)[..., PERMUTED]


@pytest.mark.parametrize("name", ["cornell-box", "door-ajar"])
def test_channels_are_treated_alike(name):
    """T4.  Where luminance decides nothing: one light, and samples that do not compete.

    ReSTIR GI divides by the luminance by which it multiplies; 8 roundings.
    """
    scene = find_scene(name)
    lamp = next(m for m in scene.meshes if any(m.emission))
    emission = tuple(permute(lamp.emission))
    swapped = with_colors(scene, permute)
    swapped = replace(
        swapped,
        meshes=tuple(
            replace(m, emission=emission) if m.name == lamp.name else m
            for m in swapped.meshes
        ),
    )
    # One light of two triangles: their probabilities are 1/2 to the last bit.
    assert np.array_equal(pt(swapped), permute(pt(scene)))
    alone = {"temporal": False, "spatial": False}
    one, other = restir(swapped, **alone), permute(restir(scene, **alone))
    assert one.any()
    assert np.abs(one - other).max() <= 8 * EPS * other.max()


@renderers
def test_a_grey_scene_stays_grey(render):
    """T5: R == G == B, bit for bit."""
    scene = with_colors(find_scene("cornell-box"), lambda c: np.full(3, c.mean()))
    lamps = {m.name for m in scene.meshes if any(m.emission)}
    scene = replace(
        scene,
        meshes=tuple(
            replace(m, emission=(5.0, 5.0, 5.0)) if m.name in lamps else m
            for m in scene.meshes
        ),
    )
    color = render(scene)
    assert color.any()
    assert (color == color[:, :1]).all()


@renderers
@pytest.mark.parametrize("name", ["cornell-box", "checker"])
def test_a_black_scene_is_black(render, name):
    """T9: nothing emits."""
    assert not render(brightened(find_scene(name), 0.0)).any()


def test_nulls_of_a_black_scene_count():
    """T9: M counts every trial, whatever it found."""
    world = world_of(brightened(find_scene("cornell-box"), 0.0), SIZE)
    for number, frame in enumerate(frames_of(world, 3)):
        assert not frame.temporal.W.any()
        assert set(frame.temporal.M) == {number + 1}
        assert frame.spatial.M.min() >= number + 1


def test_black_surfaces_send_no_indirect_light():
    """T10: what is seen, or what lights it, is black."""
    scene = find_scene("sunlit-wall")
    floor = what_is_seen(world_of(scene, SIZE)).primitive < 2
    for name in ("floor", "wall"):
        black = with_colors(scene, lambda c: 0 * c, {name})
        for render in (lambda s: pt(s, light="indirect", bounces=1), restir_one_bounce):
            assert render(scene)[floor].any()
            assert not render(black)[floor].any()


@pytest.mark.parametrize("name", ["cornell-box", "glossy-floor"])
def test_light_is_additive(name):
    """T26: e = e1 + e2.  The tests of each vertex add, eight roundings a bounce."""
    scene = find_scene(name)
    whole = pt(scene)
    parts = pt(brightened(scene, 0.3)) + pt(brightened(scene, 0.7))
    assert np.abs(parts - whole).max() <= 64 * EPS * whole.max()


# ---------------------------------------------------------------- space


@renderers
@scenes
@pytest.mark.parametrize("k", [-10, 9])
def test_all_lengths_times_a_power_of_two(render, name, k):
    """T6.  Kills absolute offsets, absolute depths, missing squares of distances."""
    scene = find_scene(name)
    scaled = moved(scene, np.diag([2.0**k, 2.0**k, 2.0**k, 1.0]))
    assert np.array_equal(render(scaled), render(scene))


@pytest.mark.parametrize("name", CATALOGUE)
def test_a_mirrored_camera_sees_the_picture_mirrored(name):
    """T7, as far as it holds bit for bit: what is seen.

    Of 32 columns, since 2x / 32 - 1 does not round.
    """
    scene = find_scene(name)
    plain = what_is_seen(world_of(scene, 32))
    mirrored = replace(scene, camera=replace(scene.camera, mirrored=True))
    seen = what_is_seen(world_of(mirrored, 32))
    rows = np.arange(32 * 32).reshape(32, 32)[:, ::-1].ravel()
    assert np.array_equal(seen.position[rows], plain.position)
    assert np.array_equal(seen.primitive[rows], plain.primitive)


@renderers
def test_geometry_that_no_ray_can_reach_changes_nothing(render):
    """T11: a box within a closed block, first or last in the list."""
    scene = find_scene("cornell-box")
    hidden = box("hidden", (0.1, 0.2, 0.3), pose(40, (-0.35, 0.6, -0.35)), RED)
    plain = render(scene)
    last = replace(scene, meshes=(*scene.meshes, hidden))
    first = replace(scene, meshes=(hidden, *scene.meshes))
    assert np.array_equal(render(last), plain)
    assert np.array_equal(render(first), plain)


@renderers
def test_the_order_of_shapes_does_not_matter(render):
    """T11: reversed, and every mesh with its faces from last to first."""
    scene = find_scene("cornell-box")
    meshes = tuple(
        replace(m, faces=m.faces[::-1]) if not any(m.emission) else m
        for m in scene.meshes[::-1]
    )
    assert np.array_equal(render(replace(scene, meshes=meshes)), render(scene))


RED = Lambertian((0.6, 0.1, 0.1))


def divided(mesh, parts):
    """A parallelogram of 2 parts² triangles instead of two."""
    o, a, _, b = mesh.vertices
    s, t = np.meshgrid(np.arange(parts + 1) / parts, np.arange(parts + 1) / parts)
    s, t = s.ravel(), t.ravel()
    vertices = o + s[:, None] * (a - o) + t[:, None] * (b - o)
    row = np.arange(parts * (parts + 1)).reshape(parts, parts + 1)[:, :-1].ravel()
    lower = np.stack([row, row + 1, row + parts + 2], axis=1)
    upper = np.stack([row, row + parts + 2, row + parts + 1], axis=1)
    uv = np.stack([s, t], axis=1)
    faces = np.concatenate([lower, upper])
    return Mesh(
        name=mesh.name,
        vertices=vertices,
        faces=faces,
        uv=uv,
        material=mesh.material,
        emission=mesh.emission,
    )


@pytest.mark.parametrize("name", ["sunlit-wall", "parallel-plates", "checker"])
def test_more_triangles_show_the_same_surface(name):
    """T12: floor and wall in 18 triangles each.

    Points stand some steps of 2⁻¹⁹ from where the ray met the surface; up to 16 of
    them, of scenes up to 4 m about their middle.
    """
    scene = find_scene(name)
    finer = replace(
        scene,
        meshes=tuple(
            divided(m, 3) if len(m.vertices) == 4 else m for m in scene.meshes
        ),
    )
    plain, fine = (what_is_seen(world_of(s, 48)) for s in (scene, finer))
    both = plain.hit & fine.hit
    # A pixel centre on an outline may fall to either side.
    assert (plain.hit == fine.hit).mean() > 0.999
    distance = np.linalg.norm(plain.position - fine.position, axis=1)
    same = both & (np.einsum("ij,ij->i", plain.normal, fine.normal) > 0.999)
    assert same.sum() > 0.99 * both.sum()
    slanted = np.abs(np.einsum("ij,ij->i", plain.normal, plain.wo))
    assert (distance[same] * slanted[same]).max() < 16 * STEP * 4.0


CONVEX = {
    "block": {"meshes": (box("block", (1, 2, 0.5), pose(25, (0.1, 0.2, 0)), RED),)},
    "ball": {
        "spheres": (Sphere(name="ball", center=(0, 0, 0), radius=0.9, material=RED),)
    },
}


@pytest.mark.parametrize("shape", CONVEX)
@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("offset", [0.0, 1e3])
def test_a_convex_body_under_the_sky_lights_nothing_of_itself(shape, scale, offset):
    """T30: indirect light is exactly 0; none of its rays may meet it again."""
    scene = Scene(
        name=shape,
        camera=Camera(position=(1.5, 1.2, 2.5), target=(0, 0, 0), fov=50.0),
        environment=ConstantEnvironment((1.0, 1.0, 1.0)),
        **CONVEX[shape],
    )
    move = np.diag([scale, scale, scale, 1.0])
    move[:3, 3] = offset, -offset, offset / 3
    scene = moved(scene, move)
    assert pt(scene, light="direct").any()
    assert not pt(scene, light="indirect", samples=8).any()
    assert not restir(scene).any()


# ---------------------------------------------------------------- runs


@pytest.mark.parametrize("name", CATALOGUE)
def test_same_seed_same_picture_another_seed_another(name):
    """T22."""
    # Few paths find the light of a polished floor, or of a shaft.
    hard = name in ("specular-floor", "shaft")
    size, bounces = (64, 2) if hard else (16, 1)
    world = world_of(find_scene(name), size)

    def last(seed):
        return frames_of(world, 2, bounces, seed)[-1].color

    one = last(5)
    assert np.array_equal(one, last(5))
    if name != "sphere-furnace":
        assert not np.array_equal(last(6), one)


@pytest.mark.parametrize("name", ["cornell-box", "glossy-floor", "half-lit-sphere"])
@pytest.mark.parametrize(
    "schedule",
    [
        Schedule(band=1),
        Schedule(band=7),
        Schedule(band=100, threads=2),
        Schedule(band=37, threads=5),
        Schedule(band=576, threads=2),
    ],
    ids=str,
)
@pytest.mark.few(3)
def test_bands_and_threads_do_not_change_a_bit(name, schedule):
    """T22."""
    size = 8 if schedule.band == 1 else SIZE
    world = world_of(find_scene(name), size)
    whole = frames_of(world, 3, bounces=2, seed=4)[-1]
    cut = frames_of(world, 3, bounces=2, seed=4, schedule=schedule)[-1]
    assert np.array_equal(cut.color, whole.color)
    assert np.array_equal(cut.spatial.W, whole.spatial.W)
    assert np.array_equal(cut.temporal.y.position, whole.temporal.y.position)


def test_path_tracer_does_not_know_how_rows_are_cut():
    """T22: some pixels alone are the same pixels."""
    world = world_of(find_scene("glossy-floor"), SIZE)
    points = what_is_seen(world)
    pixel = np.arange(len(points), dtype=np.uint32)
    u = KeyedUniforms(pixel, 0, 3, Stream.PATH)
    whole = reflected_radiance(world, points, 3, u)
    for rows in (np.arange(5), np.arange(100, 300, 7), np.array([575])):
        part = reflected_radiance(world, take(points, rows), 3, u.rows(rows))
        assert np.array_equal(part, whole[rows])


@pytest.mark.parametrize("cap", [2, 3, 5])
def test_a_cap_shows_from_the_frame_on_that_exceeds_it(cap):
    """T23: frames 0 to cap - 1 merge at most cap - 1 old samples with the new one."""
    world = world_of(find_scene("cornell-box"), SIZE)
    capped, free = (
        frames_of(world, cap + 3, seed=9, spatial=False, temporal_cap=limit)
        for limit in (cap, np.inf)
    )
    same = [np.array_equal(a.color, b.color) for a, b in zip(capped, free, strict=True)]
    # M = cap + 1 is cut at frame ``cap``; its own picture is made before.
    assert same[: cap + 1] == [True] * (cap + 1)
    assert not any(same[cap + 1 :])
    assert [f.temporal.M.max() for f in capped] == [
        min(n + 1, cap) for n in range(cap + 3)
    ]


def test_after_a_reset_comes_frame_zero():
    """T24: a run leaves nothing behind in the world."""
    world = world_of(find_scene("cornell-box"), SIZE)
    first = frames_of(world, 4, seed=2)
    again = frames_of(world, 1, seed=2)
    assert np.array_equal(first[0].color, again[0].color)
    visible = first[-1].visible
    frame = FrameContext(
        number=0,
        world=world,
        visible=visible,
        settings=Settings(),
        bounces=1,
        seed=2,
        schedule=ONE_BAND,
    )
    fresh = next_frame(frame, None)
    assert np.array_equal(first[0].color, fresh.color)


@pytest.mark.parametrize(
    ("off", "stream"),
    [
        ({"spatial": False}, Stream.SPATIAL),
        ({"temporal": False}, Stream.TEMPORAL),
        ({}, Stream.SPECULAR),
        ({}, Stream.DIRECT),
        ({}, Stream.PIXEL),
    ],
)
def test_numbers_of_a_pass_that_is_off_change_nothing(monkeypatch, off, stream):
    """T25: no pass reads the numbers of another."""

    def render():
        world = world_of(find_scene("cornell-box"), SIZE)
        return frames_of(world, 3, bounces=2, seed=1, **off)[-1].color

    plain = render()
    disturb(monkeypatch, stream)
    assert np.array_equal(render(), plain)


@pytest.mark.parametrize(
    "stream", [Stream.INITIAL, Stream.PATH, Stream.TEMPORAL, Stream.SPATIAL]
)
def test_control_numbers_of_a_pass_that_is_on_change_the_picture(monkeypatch, stream):
    def render():
        world = world_of(find_scene("cornell-box"), SIZE)
        return frames_of(world, 3, bounces=2, seed=1)[-1].color

    plain = render()
    disturb(monkeypatch, stream)
    assert not np.array_equal(render(), plain)


def disturb(monkeypatch, stream):
    """Turn every number u of a stream into 1 - u."""
    draw = KeyedUniforms.draw

    def disturbed(self, dimension):
        u = draw(self, dimension)
        if self.stream != stream:
            return u
        return tuple(1.0 - 2.0**-24 - x for x in u)

    monkeypatch.setattr(KeyedUniforms, "draw", disturbed)


def test_one_candidate_without_reuse_is_a_path_of_the_path_tracer():
    """T13: f W == f / p, with the same numbers.

    The path tracer takes the vertices of a path from dimension 2 on, ReSTIR GI those
    behind the sample point from 0 on.  Both follow the same cosine-weighted directions;
    f / p = ρ L there, in which cos θ cancels: 8 roundings.
    """
    world = world_of(find_scene("cornell-box"), SIZE)
    points = what_is_seen(world)
    pixel = np.arange(len(points), dtype=np.uint32)
    first = KeyedUniforms(pixel, 0, 6, Stream.INITIAL).draw(0)
    behind = KeyedUniforms(pixel, 0, 6, Stream.PATH)
    table = np.array(
        [[np.zeros(len(pixel))] * 4] * 2 + [behind.draw(d) for d in range(4)]
    )
    wi = to_world(sample_cosine_hemisphere(first[1], first[2]), points.normal)
    pdf = np.maximum(np.einsum("ij,ij->i", points.normal, wi), 0.0) / np.pi
    chosen = BsdfSamples(wi, points.color, pdf, np.zeros(len(pixel), bool))
    expected = reflected_radiance(
        world, points, 2, TabledUniforms(table), skip_direct=True, first=chosen
    )
    alone = {"temporal": False, "spatial": False, "source": "cosine"}
    (frame,) = frames_of(world, 1, bounces=2, seed=6, **alone)
    assert expected.any()
    assert np.abs(frame.color - expected).max() <= 8 * EPS * expected.max()

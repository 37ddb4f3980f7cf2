"""Points on lights: what they are worth, who sees them, and which light is which."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from restir_gi.hashgrid.grid import insert, lattice_of, look_up
from restir_gi.hashgrid.light_settings import LightSettings
from restir_gi.hashgrid.lights import (
    GONE,
    draw_lights,
    light_samples,
    reflected,
    renumbered,
    same_lights,
)
from restir_gi.hashgrid.world_reservoirs import carried, render_light_frames
from restir_gi.reference.numerics.records import NONE, take
from restir_gi.reference.numerics.rng import KeyedUniforms, Stream
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.resampling.reservoir import Reservoirs
from restir_gi.reference.scene.catalogue.registry import find_animation, find_scene
from restir_gi.reference.scene.light_cells import LightCells
from restir_gi.reference.scene.validation import validate
from restir_gi.reference.transport.direct_light import choose_light, sees_light
from restir_gi.reference.transport.world import build_world, next_world
from tests.properties.path_scenes import points, world

SCENES = ["paint", "rough metal", "many-lights", "checker", "sunlit-wall", "lamps"]


def keyed(size, seed=1, stream=Stream.LIGHTS):
    return KeyedUniforms(np.arange(size, dtype=np.uint32), 0, seed, stream)


@pytest.mark.parametrize("name", SCENES)
def test_a_drawn_point_over_its_density_is_next_event_estimation(name):
    """One sample, one ray: the estimator of the path tracer, to rounding."""
    w = world(name)
    x = points(w)
    u = keyed(len(x)).draw(0)
    lights, density = draw_lights(w.emitters, u)
    value = reflected(w, x, lights, "balance")
    seen = sees_light(w, x, light_samples(w, x, lights), value.any(axis=1))
    found = np.where(seen[:, None], value, 0.0) / density[:, None]
    wanted = choose_light(w, x, u)
    # Times the probability, and over it again: two roundings.
    np.testing.assert_allclose(found, wanted.value, rtol=4 * 2.0**-53, atol=0)
    assert_array_equal(seen, wanted.seen)
    assert seen.any()


@pytest.mark.parametrize("name", ["paint", "checker"])
def test_what_chance_does_not_find_is_left_to_choice(name):
    """Paint has no delta lobe: the whole light is chosen, more than the share."""
    w = world(name)
    x = points(w)
    lights, _ = draw_lights(w.emitters, keyed(len(x)).draw(0))
    whole, share = (reflected(w, x, lights, c) for c in ("delta-lobes", "balance"))
    assert (whole >= share).all()
    assert (whole > 1.01 * share).any()


def lamps(*emissions):
    """The Cornell box with lamps of these emissions."""
    found = find_scene("cornell-box")
    (light,) = (mesh for mesh in found.meshes if any(mesh.emission))
    others = tuple(mesh for mesh in found.meshes if not any(mesh.emission))
    shone = tuple(
        replace(light, name=f"lamp {k}", emission=(e, e, e))
        for k, e in enumerate(emissions)
    )
    return build_world(validate(replace(found, meshes=others + shone))).emitters


def test_lights_keep_their_shapes_when_others_go_out():
    """Two triangles a lamp."""
    all_three, middle_out = lamps(1.0, 2.0, 3.0), lamps(1.0, 0.0, 3.0)
    there = same_lights(all_three, middle_out)
    assert there.tolist() == [0, 1, GONE, GONE, 2, 3]
    assert same_lights(middle_out, all_three).tolist() == [0, 1, 4, 5]
    kept = there != GONE
    before, now = all_three.primitive[kept], middle_out.primitive[there[kept]]
    assert_array_equal(before, now)


def test_cells_of_a_textured_light_keep_their_places():
    """A lamp before it goes out; one whose texture is cut otherwise is another."""
    lit = world("lamps").emitters
    size, areas = len(lit.probability), len(lit.primitive)
    assert areas == 2 * 8 * 8
    again = replace(lit)
    assert same_lights(lit, again).tolist() == list(range(size))
    before = lamps(1.0)
    moved = replace(lit, entry=np.where(lit.entry >= 0, lit.entry + 2, lit.entry))
    assert same_lights(lit, moved)[:areas].tolist() == list(range(2, areas + 2))
    coarser = replace(lit, cells=LightCells(np.minimum(lit.cells.side, 7)))
    assert (same_lights(lit, coarser)[:areas] == GONE).all()
    assert same_lights(before, lit)[: len(before.primitive)].tolist() == [GONE] * 2


def test_no_light_and_the_same_lights():
    some = lamps(1.0, 2.0)
    assert same_lights(some, some).tolist() == [0, 1, 2, 3]
    assert same_lights(some, None).tolist() == [GONE] * 4
    assert same_lights(None, some).tolist() == []


def test_points_and_suns_keep_their_places():
    w = build_world(validate(find_scene("sunlit-wall")))
    again = build_world(validate(find_scene("sunlit-wall")))
    size = len(w.emitters.probability)
    assert same_lights(w.emitters, again.emitters).tolist() == list(range(size))
    without = replace(again.emitters, direction=again.emitters.direction[:0])
    assert same_lights(w.emitters, without).tolist() == [GONE] * size


def test_lights_that_are_gone_reflect_nothing():
    w = world("paint")
    x = points(w)
    lights, _ = draw_lights(w.emitters, keyed(len(x)).draw(0))
    gone = replace(lights, light=np.full(len(x), GONE))
    assert not reflected(w, x, gone, "delta-lobes").any()
    assert (renumbered(gone, w.emitters, w.emitters).light == GONE).all()
    assert (renumbered(lights, w.emitters, None).light == GONE).all()


def colors(name, schedule, settings, frames=3):
    """Frames of an animation, small."""
    found = find_animation(name)

    def at(frame):
        scene = found(8 * frame)
        camera = replace(scene.camera, width=40, height=24)
        return validate(replace(scene, camera=camera))

    w = build_world(at(0))
    animation = replace(found, scene_at=at)
    made = render_light_frames(w, settings, 2, 5, schedule, animation)
    return [next(made).color for _ in range(frames)]


@pytest.mark.parametrize("name", ["moving-light", "moving-camera"])
@pytest.mark.few(1)
def test_bands_and_threads_change_no_bit(name):
    settings = LightSettings(cells=2, visible=True)
    whole = colors(name, Schedule(band=1 << 20), settings)
    for schedule in (Schedule(band=37), Schedule(band=101, threads=4)):
        for a, b in zip(whole, colors(name, schedule, settings), strict=True):
            assert_array_equal(a, b)
    assert any(a.any() for a in whole)


def test_light_that_went_out_leaves_nothing():
    """Reservoirs of the last frame hold a light that is no more."""
    frames = 3
    found = find_animation("light-switch")
    before, after = found(0), found(1000)
    w = build_world(validate(before))
    dark = next_world(w, after)
    assert dark.emitters is None

    def at(frame):
        return w.scene if frame == 0 else dark.scene

    made = render_light_frames(
        w, LightSettings(), 1, 1, Schedule(), replace(found, scene_at=at)
    )
    lit = [bool(next(made).color.any()) for _ in range(frames)]
    assert lit == [True, False, False]


def test_nothing_seen_and_no_light():
    away = find_scene("cornell-box")
    camera = replace(
        away.camera, position=(0, 1, 50), target=(0, 1, 60), width=8, height=4
    )
    w = build_world(validate(replace(away, camera=camera)))
    made = render_light_frames(w, LightSettings(), 3, 1, Schedule())
    for _ in range(2):
        frame = next(made)
        assert not frame.color.any()
        assert len(frame.cache.grid) == 0


# ------------------------------------------------------------ the cache


def cached(w, x):
    size = len(x)
    lights, _ = draw_lights(w.emitters, keyed(size).draw(0))
    held = Reservoirs(lights, np.ones(size), np.ones(size))
    u = keyed(size, 3, Stream.CELLS)
    return insert(w, lattice_of(w.camera), x, held, x.hit, u)


def test_those_found_are_near_and_face_alike():
    w = world("paint")
    x = points(w)
    cache = cached(w, x)
    found = look_up(cache, x, keyed(len(x), 4, Stream.CELLS), 2, 4)
    assert len(found) == 8
    for rows, _ in found:
        there = rows != NONE
        a, b = take(x.normal, rows[there]), x.normal[there]
        assert (np.einsum("ij,ij->i", a, b) ** 4 >= 0.5).all()
        assert there.mean() > 0.3


def test_each_choice_has_a_random_number_of_its_own():
    w = world("paint")
    x = points(w)
    found = look_up(cached(w, x), x, keyed(len(x), 4, Stream.CELLS), 2, 4)
    for k, (_, u) in enumerate(found):
        assert ((u >= 0) & (u < 1)).all()
        assert not any((u == other).all() for _, other in found[:k])


def test_samples_know_the_cells_that_they_are_taken_from():
    w = world("paint")
    x = points(w)
    cache = cached(w, x)
    grid, cell = cache.grid, carried(cache, w).reservoirs.y.cell
    for c in range(len(grid)):
        start, end = grid.index_buffer[c], grid.index_buffer[c + 1]
        assert (cell[grid.cell_storage[start:end]] == grid.slot[c] + 1).all()
    assert (cell == 0).sum() == len(x) - len(grid.cell_storage)


def test_samples_are_carried_into_the_list_of_the_next_frame():
    """The lamp in the middle has gone out, and the last one has another number."""
    w = world("paint")
    before, now = lamps(1.0, 2.0, 3.0), lamps(1.0, 0.0, 3.0)
    cache = cached(replace(w, emitters=before), points(w))
    light = cache.reservoirs.y.light
    found = carried(cache, replace(w, emitters=now)).reservoirs.y.light
    there = found != GONE
    assert_array_equal(before.primitive[light[there]], now.primitive[found[there]])
    assert set(light[there]) == {0, 1, 4, 5}
    assert set(light[~there]) == {2, 3}


def test_misses_find_nobody():
    w = world("paint")
    x = points(w)
    lost = replace(x, primitive=np.full(len(x), -1, np.int32))
    u = keyed(len(x), 4, Stream.CELLS)
    for rows, _ in look_up(cached(w, x), lost, u, 1, 4):
        assert (rows == NONE).all()

"""Gradient-domain methods: on the command line, and the same bits in any bands."""

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from restir_gi.gradient_domain.after_restir import render_after_frames
from restir_gi.gradient_domain.gradient_pt import render_gradient_paths
from restir_gi.gradient_domain.gradient_restir import PLUS, render_gradient_frames
from restir_gi.gradient_domain.method import (
    AFTER,
    METHOD,
    PATH_TRACED,
    RECONSTRUCT,
    developed,
)
from restir_gi.gradient_domain.reconstruction import Differences, differences
from restir_gi.gradient_domain.settings import (
    AfterSettings,
    GradientPathSettings,
    GradientSettings,
)
from restir_gi.reference.cli.main import main
from restir_gi.reference.images.exr import read_exr
from restir_gi.reference.methods.discovery import method_named, method_names
from restir_gi.reference.methods.method import Job, drive
from restir_gi.reference.methods.setting_values import with_values
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.scene.catalogue.registry import find_animation
from restir_gi.reference.scene.validation import validate
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.transport.world import build_world
from tests.properties.path_scenes import world

VARIANTS = [
    (render_gradient_paths, GradientPathSettings()),
    (render_after_frames, AfterSettings()),
    (render_gradient_frames, GradientSettings()),
    (render_gradient_frames, GradientSettings(signs="across", primary="keep")),
    (render_gradient_frames, GradientSettings(signs="without", around="random")),
    (render_gradient_frames, GradientSettings(around="none", mis="balance")),
]
IDS = ["pt", "after", "within", "across", "without", "alone"]
each_variant = pytest.mark.parametrize(("render", "settings"), VARIANTS, ids=IDS)


WHOLE = Schedule()


def last(render, settings, schedule=WHOLE, name="moving-camera", frames=3):
    w = world(name)
    animation = find_animation(name, w.scene) if name == "moving-camera" else None
    found = render(w, settings, 2, 5, schedule, animation)
    return list(islice(found, frames))[-1]


@each_variant
@pytest.mark.few(1)
def test_bands_and_threads_change_no_bit(render, settings):
    whole, cut = (
        last(render, settings, schedule)
        for schedule in (Schedule(1 << 20), Schedule(100, 2))
    )
    np.testing.assert_array_equal(whole.estimates, cut.estimates)
    assert np.isfinite(whole.estimates).all()
    assert whole.differences.x.any()
    assert whole.differences.y.any()


@each_variant
def test_no_difference_leads_out_of_the_image(render, settings):
    d = last(render, settings, name="glass").differences
    assert not d.x.reshape(32, 32, 3)[:, -1].any()
    assert not d.y.reshape(32, 32, 3)[-1].any()


@pytest.mark.parametrize("size", [(1, 1), (1, 3), (2, 1)])
@each_variant
def test_images_of_few_pixels(render, settings, size):
    """Of one pixel there is no pair at all."""
    found = world("paint").scene
    camera = replace(found.camera, width=size[0], height=size[1])
    w = build_world(validate(replace(found, camera=camera)))
    frame = list(islice(render(w, settings, 1, 0, Schedule()), 2))[-1]
    assert frame.estimates.shape == (size[0] * size[1], 9)


def test_confidence_grows_to_its_cap_and_looks_at_no_sample():
    settings = GradientSettings(temporal_cap=4, spatial=False)
    frame = last(render_gradient_frames, settings, name="glass", frames=6)
    for r in frame.pairs.values():
        assert set(r.M) == {4.0}


def test_the_past_is_trusted_as_it_says():
    """Of n frames with one sample each the last has its share, 1 / n, more or less.

    Samples compete by their worth, too: a share of the pairs that is twice as large, or
    half as large, would be out of question, and 1 / 2 is what a past has that counts as
    much as a new sample.
    """
    frames = 8
    settings = GradientSettings(spatial=False)
    r = last(render_gradient_frames, settings, name="paint", frames=frames).pairs[PLUS]
    kept = r.W > 0
    new = r.y.base.paths.number // (32 * 32) == frames - 1
    assert 0.5 / frames < new[kept].mean() < 2 / frames


def test_pairs_without_an_edge_keep_what_they_have():
    """Spatial reuse is between edge pairs: the others are as they were before it."""
    apart = GradientSettings(temporal=False, around="none")
    alone, around = (
        last(render_gradient_frames, s, name="checker", frames=1)
        for s in (apart, replace(apart, around="edges"))
    )
    for sign, a in alone.pairs.items():
        b = around.pairs[sign]
        same = a.M == b.M
        assert 0.3 < same.mean() < 1
        np.testing.assert_array_equal(a.W[same], b.W[same])


def test_pixels_and_pairs_begin_with_the_same_paths():
    """So that nothing is drawn twice."""
    alone = GradientSettings(temporal=False, spatial=False)
    mine = last(render_gradient_frames, alone, frames=1)
    theirs = last(render_gradient_paths, GradientPathSettings(), frames=1)
    np.testing.assert_array_equal(mine.color, theirs.color)


# ------------------------------------------------------------ the command line

NAMES = {"gradient-pt": PATH_TRACED, "gradient-after-restir": AFTER}
NAMES["gradient-restir"] = METHOD


@pytest.mark.parametrize("name", NAMES)
def test_they_are_found_by_name(name):
    assert name in method_names()
    assert method_named(name) is NAMES[name]


def rendered(path, name, *more):
    text = (
        f"render cornell-box --method {name} --frames 3 --spp 1 --bounces 2"
        " --size 24x16 --light indirect"
    )
    assert main([*text.split(), *more, "--out", str(path)]) == 0
    found = read_exr(path)
    return {k: v.reshape(-1, v.shape[-1]) for k, v in found.layers.items()}, found


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("kind", ["l1", "l2"])
def test_the_picture_is_made_from_its_layers(tmp_path, name, kind):
    layers, found = rendered(
        tmp_path / "a.exr",
        name,
        *("--set", f"reconstruction={kind}", "--set", "image=last"),
        *("--aov", "dx,dy,primal"),
    )
    picture = found.color.reshape(-1, 3)
    d = Differences(*(layers[k].astype(float) for k in ("dx", "dy")))
    again = RECONSTRUCT[kind](layers["primal"].astype(float), d, 24)
    # Layers are rounded to float32; L1 stops within a thousandth of its minimum.
    scale = np.abs(picture).max()
    tolerance = 2.0**-22 * scale if kind == "l2" else 1e-2 * scale
    assert np.abs(again - picture).max() < tolerance
    assert picture.any()


def test_pixels_and_differences_are_averaged_before_the_image_is_made():
    """For L1, which is not linear, that is another picture than a mean of pictures."""
    w, settings = world("glass"), GradientPathSettings(reconstruction="l1")
    job = Job(
        world=w,
        light="indirect",
        bounces=2,
        seed=5,
        counts={"frames": 3, "spp": 1},
        settings=settings,
        aovs=(),
        schedule=Schedule(),
    )
    found = drive(PATH_TRACED, job, lambda step: None)["color"]
    frames = islice(render_gradient_paths(w, settings, 2, 5, Schedule()), 3)
    each = [frame.estimates for frame in frames]
    mean = np.zeros_like(each[0])
    for number, estimates in enumerate(each):
        mean = mean + (estimates - mean) / (number + 1.0)
    of_means = developed(job, mean)
    of_pictures = np.mean([developed(job, e) for e in each], axis=0)
    np.testing.assert_array_equal(found, of_means)
    assert np.abs(found - of_pictures).max() > 1e-3 * of_means.max()


def test_a_picture_is_made_from_pixels_and_differences():
    """Of any image its own pixels and differences make it again."""
    image = np.random.default_rng(6).random((16 * 24, 3))
    d = differences(image, 24)
    w = world("paint").scene
    w = build_world(validate(replace(w, camera=replace(w.camera, width=24, height=16))))
    job = Job(
        world=w,
        light="indirect",
        bounces=2,
        seed=0,
        counts={"frames": 4},
        settings=GradientSettings(),
        aovs=(),
        schedule=WHOLE,
    )
    found = developed(job, np.concatenate([image, d.x, d.y], axis=1))
    # A transform of 384 numbers and its inverse: a few ten roundings of sums of them.
    assert np.abs(found - image).max() < 1e-12


@pytest.mark.parametrize("kind", ["l1", "l2"])
def test_what_is_biased_is_told(kind):
    job = Job(
        world=world("paint"),
        light="indirect",
        bounces=2,
        seed=0,
        counts={},
        settings=GradientSettings(reconstruction=kind),
        aovs=(),
        schedule=Schedule(),
    )
    assert [line[:17] for line in METHOD.biases(job)] == (
        ["reconstruction=l1"] if kind == "l1" else []
    )
    assert METHOD.biases(replace(job, light="direct")) == ()


@pytest.mark.parametrize(
    ("name", "value", "word"),
    [
        ("gradient-restir", "tries=0", "tries"),
        ("gradient-restir", "tries=257", "tries"),
        ("gradient-restir", "signs=both", "signs"),
        ("gradient-restir", "mis=1/M", "mis"),
        ("gradient-after-restir", "mis=1/M", "mis"),
        ("gradient-pt", "reconstruction=l3", "reconstruction"),
    ],
)
def test_wrong_settings_are_refused(name, value, word):
    with pytest.raises(UsageError, match=word):
        with_values(NAMES[name].settings, [value])

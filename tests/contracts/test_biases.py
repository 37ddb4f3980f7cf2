"""Every setting that biases is named where it matters, and only there."""

from dataclasses import fields, replace
from math import inf

import pytest

from restir_gi.reference.methods.biases import biases
from restir_gi.reference.scene.catalogue.registry import find_scene
from restir_gi.reference.settings import BIASED, UNBIASED

ROOM, GLOSSY, SPHERE = (
    find_scene(name) for name in ("cornell-box", "glossy-floor", "sphere-furnace")
)

BIASING = {
    "mis": "1/M",
    "visibility": "none",
    "jacobian": "divided",
    "max_age": 30.0,
    "boiling_filter": 0.2,
    "storage": "paper",
    "lattice": 2,
}
IN_MOTION = {"motion": "as-stored", "final_visibility": "reused", "checkerboard": True}

HARMLESS = {
    "source": "cosine",
    "target": "outgoing",
    "temporal": False,
    "spatial": False,
    "temporal_cap": 1.0,
    "spatial_cap": 1.0,
    "iterations_few": 1,
    "iterations_many": 1,
    "radius": 0.5,
    "min_radius": 1.0,
    "max_angle": 90.0,
    "max_depth": 1.0,
    "validate_every": 6,
    "validation_tolerance": 0.5,
    "boost_below": 30.0,
    "roulette": 0.25,
    "reuse": "fused",
    "jacobian_limit": 3.0,
    "permutation": True,
    "fallback_search": True,
}
"""Unbiased whatever the scene does; each has a test of its own elsewhere."""

BY_OTHERS = {"glossy_samples", "beyond_limit"}


def test_every_setting_is_judged():
    every = {field.name for field in fields(UNBIASED)}
    assert every == {*BIASING, *IN_MOTION, *HARMLESS} | BY_OTHERS


@pytest.mark.parametrize("changes", ["nothing", "camera", "scene"])
@pytest.mark.parametrize("scene", [ROOM, GLOSSY, SPHERE], ids=lambda scene: scene.name)
def test_the_unbiased_form_has_none(scene, changes):
    assert biases(UNBIASED, scene, changes) == ()
    for name, value in HARMLESS.items():
        assert biases(replace(UNBIASED, **{name: value}), scene, changes) == ()


@pytest.mark.parametrize("name", BIASING)
@pytest.mark.parametrize("changes", ["nothing", "scene"])
def test_a_biased_setting_is_named(name, changes):
    (named,) = biases(replace(UNBIASED, **{name: BIASING[name]}), ROOM, changes)
    assert named.startswith(name)


@pytest.mark.parametrize("name", IN_MOTION)
def test_what_only_motion_biases_is_named_there_alone(name):
    settings = replace(UNBIASED, **{name: IN_MOTION[name]})
    assert biases(settings, ROOM, "nothing") == ()
    (named,) = biases(settings, ROOM, "camera")
    assert named.startswith(name)


def test_a_limit_is_biased_unless_it_is_mirrored():
    limited = replace(UNBIASED, jacobian_limit=3.0)
    assert biases(limited, ROOM, "nothing") == ()
    for beyond in ("reject", "clamp"):
        settings = replace(limited, beyond_limit=beyond)
        (named,) = biases(settings, ROOM, "nothing")
        assert named.startswith(f"beyond_limit={beyond}")
        assert biases(replace(settings, jacobian_limit=inf), ROOM, "nothing") == ()


def test_glossy_sample_points_are_named_where_there_are_some():
    assert not any("glossy" in words for words in biases(BIASED, ROOM, "nothing"))
    (named,) = (w for w in biases(BIASED, GLOSSY, "nothing") if "glossy" in w)
    assert '"floor"' in named


def test_in_a_convex_scene_no_light_leaks():
    settings = replace(UNBIASED, visibility="none")
    assert biases(settings, SPHERE, "nothing") == ()
    assert biases(replace(settings, final_visibility="traced"), ROOM, "nothing") == ()

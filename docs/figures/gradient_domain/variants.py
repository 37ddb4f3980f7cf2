"""The methods that figures compare, and the scenes."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from restir_gi.extensions.area_restir import render_area_frames
from restir_gi.extensions.area_settings import AreaSettings
from restir_gi.figures.gradient_domain.rounds import FRAMES, RoundScene, Variant
from restir_gi.figures.paths import sized_world
from restir_gi.gradient_domain.after_restir import render_after_frames
from restir_gi.gradient_domain.gradient_pt import render_gradient_paths
from restir_gi.gradient_domain.gradient_restir import render_gradient_frames
from restir_gi.gradient_domain.settings import (
    AfterSettings,
    GradientPathSettings,
    GradientSettings,
)
from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.scene.animation import Animation
from restir_gi.reference.scene.catalogue.registry import find_animation
from restir_gi.reference.scene.validation import validate

BOUNCES = 2
PATHS, AFTER, WITH = "Gradient-PT", "after ReSTIR", "with ReSTIR"
ALONE, AREA = "with ReSTIR, nobody around", "Area ReSTIR"

METHODS: dict[str, Variant] = {
    PATHS: Variant(render_gradient_paths, GradientPathSettings()),
    AFTER: Variant(render_after_frames, AfterSettings()),
    WITH: Variant(render_gradient_frames, GradientSettings()),
}


BY_ITSELF = Variant(render_gradient_frames, GradientSettings(around="none"))
"""Gradient with ReSTIR, whose pairs have their own past alone."""


@dataclass(frozen=True, slots=True, eq=False)
class PrimalFrame:
    """A frame without differences.

    Attributes
    ----------
    estimates : (N, 9) float64; pixels; nothing is known of differences
    """

    estimates: Scalars


def _area_frames(*about: Any) -> Iterator[PrimalFrame]:
    for frame in render_area_frames(*about):
        none = np.zeros((len(frame.color), 6))
        yield PrimalFrame(np.concatenate([frame.color, none], axis=1))


PRIMAL = Variant(_area_frames, AreaSettings(neighbors=2))
"""The pass that pixels come from, by itself."""


def with_restir(settings: GradientSettings) -> Variant:
    """Gradient with ReSTIR, with other settings."""
    return Variant(render_gradient_frames, settings)


def scene_of(name: str, size: int, bounces: int = BOUNCES) -> RoundScene:
    """Built-in scene, with its animation if only the camera moves in it."""
    world, found = sized_world(name, size), find_animation(name)
    if found.changes != "camera":
        return RoundScene(name, world, bounces)
    scenes = [found(frame) for frame in range(FRAMES)]
    sized = [
        validate(replace(s, camera=replace(s.camera, width=size, height=size)))
        for s in scenes
    ]
    moving = Animation(lambda frame: sized[frame], found.changes)
    return RoundScene(name, world, bounces, moving)

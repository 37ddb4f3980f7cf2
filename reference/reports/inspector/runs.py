"""A picture's file as a run to look into: made again where its header tells how."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, get_args

import numpy as np

from restir_gi.reference.images.image import Image, to_image
from restir_gi.reference.methods import Job, Layers, Method
from restir_gi.reference.methods.restir_gi import BIASED, UNBIASED
from restir_gi.reference.methods.setting_values import with_values
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.reports.inspector.recorded import Plain
from restir_gi.reference.scene.catalogue.registry import CATALOGUE
from restir_gi.reference.scene.named import Named, find_scene_or_file, frames_of
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.transport.path_tracer import MAX_BOUNCES, Light
from restir_gi.reference.transport.world import build_world

LAYERS = {
    "M": "M",
    "W": "W",
    "radiance": "radiance",
    "sample_position": "position",
    "sample_normal": "normal",
}
"""Layers of reservoirs in a picture's file, and what the page calls them."""

MOST = 2**27 - 1
"""Of counts, seeds and numbers of frames: random numbers are keyed by them."""


def method_of(image: Image) -> Method | None:
    """Method by which a picture was made, if its run can be made again.

    Returns ``None`` unless it is one of those of ReSTIR GI.
    """
    known = {method.name: method for method in (BIASED, UNBIASED)}
    return known.get(image.metadata.get("method", ""))


def job_of(
    path: Path,
    image: Image,
    *,
    scene: str | None,
    lenient: bool,
    allow_outside: bool,
    schedule: Schedule,
) -> Job:
    """The job that a picture's header tells.

    Parameters
    ----------
    image : Image; of one of the methods of ReSTIR GI
    scene : str or None; built-in, or a file; ``None`` for what the header names

    Returns
    -------
    Job; its picture is that of the file, if version and scene are the same

    Raises
    ------
    UsageError
        The header lacks something, or the scene is not to be had.
    """
    words, method = image.metadata, method_of(image)
    assert method is not None
    try:
        counts = {name: _whole(words, name, 1, MOST) for name in method.counts}
        bounces = _whole(words, "bounces", 0, MAX_BOUNCES)
        seed, frame = (_whole(words, name, 0, MOST) for name in ("seed", "frame"))
        light = _light(words["light"])
        settings = with_values(method.settings, _assignments(words))
    except KeyError as error:
        raise UsageError(f"{path}: the header lacks {error.args[0]!r}") from error
    except (ValueError, UsageError) as error:
        raise UsageError(
            f"{path}: the header is not understood by this version: {error}"
        ) from error
    size = (image.width, image.height)
    name = _scene_name(path, words, scene)
    found = find_scene_or_file(name, lenient, allow_outside)
    if found.name != words.get("scene", ""):
        raise UsageError(
            f"{path}: rendered from {words.get('scene', '')!r}, not from {found.name!r}"
        )
    animation = frames_of(Named(name, lenient, *size, frame, allow_outside), found)
    return Job(
        world=build_world(animation(0)),
        light=light,
        bounces=bounces,
        seed=seed,
        counts=counts,
        settings=settings,
        aovs=tuple(name for name in image.layers if name != "color"),
        schedule=schedule,
        animation=animation,
        frame=frame,
    )


def _whole(words: Mapping[str, str], name: str, least: int, most: int) -> int:
    text = words[name]
    is_number = re.fullmatch(r"\d{1,19}", text, re.ASCII)
    if not (is_number and least <= int(text) <= most):
        raise ValueError(
            f"{name}={text:.40} is out of range: whole numbers, {least} to {most}"
        )
    return int(text)


def _light(text: str) -> Light:
    for light in get_args(Light):
        if text == light:
            known: Light = light
            return known
    raise ValueError(f"light={text!r:.40} is none of {', '.join(get_args(Light))}")


def _assignments(words: Mapping[str, str]) -> list[str]:
    prefix = "settings."
    return [
        f"{key.removeprefix(prefix)}={text}"
        for key, text in words.items()
        if key.startswith(prefix)
    ]


def _scene_name(path: Path, words: Mapping[str, str], scene: str | None) -> str:
    named = words.get("scene", "")
    if scene is None and named not in CATALOGUE:
        raise UsageError(
            f"{path}: rendered from {named!r}, which is no built-in scene; name its"
            " file with --scene"
        )
    return scene or named


def standing(image: Image, layers: Layers) -> str:
    """Whether a run that was made again is the one that the file holds."""
    other, most = np.zeros((image.height, image.width), bool), 0.0
    for name, rows in layers.items():
        again, kept = to_image(rows, image.width, image.height), image.layers[name]
        other |= ~((again == kept) | (np.isnan(again) & np.isnan(kept))).all(axis=-1)
        with np.errstate(invalid="ignore"):
            most = max(most, float(np.nan_to_num(np.abs(again - kept)).max()))
    if not other.any():
        return "Made again: every layer is that of the file, bit for bit."
    version = image.metadata.get("version", "unknown")
    return (
        f"Made again, but {other.sum()} of {other.size} pixels are not those of the"
        f" file, by up to {most:.3g}: it is of version {version}, or was made with"
        " --no-plan, or from another scene of this name."
    )


def as_it_is(image: Image) -> Plain:
    """A frame of a picture whose run is not to be had: its layers.

    Parameters
    ----------
    image : Image; of any method, or of a renderer elsewhere

    Returns
    -------
    dict
        As :func:`restir_gi.reference.reports.inspector.recorded.plain_frame`, with what
        there is; which frame it is, is not known.
    """
    found: dict[str, Any] = {
        short: np.ascontiguousarray(image.layers[name], np.float32).ravel()
        for name, short in LAYERS.items()
        if name in image.layers
    }
    return {
        "number": None,
        "color": np.ascontiguousarray(image.color).ravel(),
        "reservoirs": [{"name": "spatial", **found}] if found else [],
        "passes": [],
    }

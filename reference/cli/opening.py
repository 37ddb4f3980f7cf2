"""SCENE on the command line: found, read, sized, and found fit to render."""

import argparse
from collections.abc import Callable

import numpy as np

from restir_gi.reference.cli.console import remark
from restir_gi.reference.cli.memory import refuse_what_does_not_fit
from restir_gi.reference.cli.values import Size
from restir_gi.reference.scene.animation import Animation
from restir_gi.reference.scene.camera import Camera
from restir_gi.reference.scene.named import Named, find_scene_or_file, frames_of
from restir_gi.reference.scene.scene import Scene


def open_named(
    arguments: argparse.Namespace, size: Callable[[Scene], Size] | None = None
) -> tuple[Named, Animation]:
    """Scenes that the arguments name, and the words by which others can open them.

    Raises UsageError: no such scene, or it cannot be read or rendered.

    Parameters
    ----------
    arguments : Namespace; with those of `add_scene`, and ``json``
    size : callable, optional
        Gives the size of the picture where no --size is given; else it is what the
        scene says.
    """
    scene = find_scene_or_file(
        arguments.scene, arguments.lenient, arguments.allow_outside
    )
    width, height = size(scene) if size else (scene.camera.width, scene.camera.height)
    if arguments.size:
        width, height = arguments.size
    named = Named(
        name=arguments.scene,
        lenient=arguments.lenient,
        width=width,
        height=height,
        frame=arguments.frame,
        allow_outside=arguments.allow_outside,
    )
    refuse_what_does_not_fit(width, height)
    frames = frames_of(named, scene)
    if not arguments.json:
        for note in frames(0).notes:
            remark(f"{scene.name}: {note}")
    return named, frames


def open_frames(
    arguments: argparse.Namespace, size: Callable[[Scene], Size] | None = None
) -> Animation:
    """Scenes that the arguments name, ready to be built, frame by frame.

    Its frame 0 is frame ``frame`` of the arguments.  Each frame is validated when it is
    asked for.  What the notes of the scene say was said on stderr, unless ``json``.

    Raises UsageError: no such scene, or it cannot be read or rendered.

    Parameters
    ----------
    arguments : Namespace; with those of `add_scene`, and ``json``
    size : callable, optional
        Gives the size of the picture where no --size is given; else it is what the
        scene says.
    """
    return open_named(arguments, size)[1]


def size_in_shape(camera: Camera, pixels: int, multiple: int = 1) -> Size:
    """Size of a picture in the shape of a camera's, in pixels.

    Parameters
    ----------
    camera : Camera; gives width : height, from 1 : 100 to 100 : 1
    pixels : int; of the picture, about
    multiple : int; of which both sides are multiples
    """
    shape = np.clip(camera.width / max(camera.height, 1), 0.01, 100)
    sides = (pixels * shape) ** 0.5, (pixels / shape) ** 0.5
    width, height = (max(round(side / multiple), 1) * multiple for side in sides)
    return width, height

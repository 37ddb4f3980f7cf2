"""SCENE on the command line: found, read, sized, and found fit to render."""

import argparse
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from reference.commands.console import remark
from reference.commands.memory import refuse_what_does_not_fit
from reference.commands.values import Size
from reference.errors import UsageError
from reference.scene.animation import Animation, still
from reference.scene.catalogue.registry import CATALOGUE, find_animation, find_scene
from reference.scene.loaders.load import LOADERS, load_scene
from reference.scene.scene import Scene
from reference.scene.validation import validate, validate_frames


def open_frames(
    arguments: argparse.Namespace, size: Callable[[Scene], Size] | None = None
) -> Animation:
    """Scenes that the arguments name, ready to be built, frame by frame.

    Parameters
    ----------
    arguments : Namespace
        With ``scene``, ``lenient``, ``size``, ``frame`` and ``json``.
    size : callable, optional
        Gives the size of the picture where no --size is given; else it is what the
        scene says.

    Returns
    -------
    Animation
        Its frame 0 is frame ``frame`` of the arguments.  Each frame is validated when
        it is asked for.  What the notes of the scene say was said on stderr, unless
        ``json``.

    Raises
    ------
    UsageError
        No such scene, or it cannot be read or rendered.
    """
    scene = find_scene_or_file(arguments.scene, arguments.lenient)
    camera = scene.camera
    width, height = size(scene) if size else (camera.width, camera.height)
    if arguments.size:
        width, height = arguments.size
    scene = replace(scene, camera=replace(camera, width=width, height=height))
    refuse_what_does_not_fit(width, height)
    scene = validate(scene)
    if not arguments.json:
        for note in scene.notes:
            remark(f"{scene.name}: {note}")
    built_in = arguments.scene in CATALOGUE
    frames = find_animation(arguments.scene, scene) if built_in else still(scene)
    valid, start = validate_frames(frames), arguments.frame
    return Animation(lambda frame: valid(start + frame), valid.changes)


def find_scene_or_file(name: str, lenient: bool = False) -> Scene:
    """Scene that a word on the command line names.

    Parameters
    ----------
    name : str
        Built-in, or a file.
    lenient : bool
        Replace what the file holds and the project does not model.

    Returns
    -------
    Scene
        Not validated.

    Raises
    ------
    UsageError
        There is none, or it cannot be read.
    """
    path = Path(name)
    is_file = path.suffix.lower() in LOADERS or path.exists()
    if is_file and name not in CATALOGUE:
        return load_scene(path, lenient)
    try:
        return find_scene(name)
    except UsageError as error:
        raise UsageError(
            f"{error}; a scene file ends in one of {', '.join(LOADERS)}"
        ) from None

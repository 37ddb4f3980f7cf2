"""A scene by the words that name it: what a worker needs to open it."""

import os
from dataclasses import dataclass, replace
from pathlib import Path

from restir_gi.reference.scene.animation import Animation, still
from restir_gi.reference.scene.catalogue.registry import (
    CATALOGUE,
    find_animation,
    find_scene,
)
from restir_gi.reference.scene.loaders.load import LOADERS, load_scene
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.validation import validate, validate_frames
from restir_gi.reference.system.errors import UsageError


@dataclass(frozen=True, slots=True)
class Named:
    """A scene by name, and how it is looked at.

    Attributes
    ----------
    name : str; built-in, or a file
    lenient : bool; replace what the file holds and the project does not model
    frame : int; of an animated scene the frame to begin at
    allow_outside : bool; read files outside the scene's folder, if it names them
    """

    name: str
    lenient: bool
    width: int
    height: int
    frame: int = 0
    allow_outside: bool = False


def find_scene_or_file(
    name: str, lenient: bool = False, allow_outside: bool = False
) -> Scene:
    """Scene that a word on the command line names, not validated.

    Raises UsageError: there is none, or it cannot be read.

    Parameters
    ----------
    name : str; built-in, or a file
    lenient : bool; replace what the file holds and the project does not model
    allow_outside : bool; read files outside the scene's folder, if it names them
    """
    path = Path(name)
    is_file = path.suffix.lower() in LOADERS or os.path.exists(path)
    if is_file and name not in CATALOGUE:
        return load_scene(path, lenient, allow_outside)
    try:
        return find_scene(name)
    except UsageError as error:
        raise UsageError(
            f"{error}; a scene file ends in one of {', '.join(LOADERS)}"
        ) from None


def frames_of(named: Named, scene: Scene) -> Animation:
    """Scenes of all frames, of the size asked for; frame 0 is frame ``named.frame``.

    Each frame is validated when it is asked for; that of ``scene`` now.

    Raises UsageError: it cannot be rendered.

    Parameters
    ----------
    scene : Scene; found by its name
    """
    camera = replace(scene.camera, width=named.width, height=named.height)
    scene = validate(replace(scene, camera=camera))
    built_in = named.name in CATALOGUE
    frames = find_animation(named.name, scene) if built_in else still(scene)
    valid = validate_frames(frames)
    return Animation(lambda frame: valid(named.frame + frame), valid.changes)

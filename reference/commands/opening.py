"""SCENE on the command line: found, read, sized, and found fit to render."""

import argparse
from dataclasses import replace
from pathlib import Path

from reference.commands.console import remark
from reference.commands.memory import refuse_what_does_not_fit
from reference.errors import UsageError
from reference.scene.catalogue.registry import CATALOGUE
from reference.scene.loaders.load import LOADERS, load_scene
from reference.scene.scene import Scene
from reference.scene.validation import validate


def open_scene(
    arguments: argparse.Namespace, size: tuple[int, int] | None = None
) -> Scene:
    """Scene that the arguments name, ready to be built.

    Parameters
    ----------
    arguments : Namespace
        With ``scene``, ``lenient``, ``size`` and ``json``.
    size : (int, int), pixels, optional
        Where no --size is given; else as the scene says.

    Returns
    -------
    Scene
        Validated.  What its notes say was said on stderr, unless ``json``.

    Raises
    ------
    UsageError
        No such scene, or it cannot be read or rendered.
    """
    scene = _find(arguments.scene, arguments.lenient)
    size = arguments.size or size
    if size is not None:
        width, height = size
        camera = replace(scene.camera, width=width, height=height)
        scene = replace(scene, camera=camera)
    refuse_what_does_not_fit(scene.camera.width, scene.camera.height)
    scene = validate(scene)
    if not arguments.json:
        for note in scene.notes:
            remark(f"{scene.name}: {note}")
    return scene


def _find(name: str, lenient: bool) -> Scene:
    if name in CATALOGUE:
        return CATALOGUE[name].build()
    path = Path(name)
    if path.suffix.lower() not in LOADERS and not path.exists():
        raise UsageError(
            f"unknown scene {name!r}; built-in are {', '.join(CATALOGUE)};"
            f" a file ends in one of {', '.join(LOADERS)}"
        )
    return load_scene(path, lenient)

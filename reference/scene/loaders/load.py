"""A scene from a file, by the suffix of its name."""

from collections.abc import Callable
from importlib import import_module
from pathlib import Path

from restir_gi.reference.scene.loaders.ledger import Ledger
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.system.errors import UsageError

# The loader of a format is imported when a file of it comes.
LOADERS = {
    ".gltf": "gltf",
    ".glb": "gltf",
    ".obj": "meshes",
    ".ply": "meshes",
    ".xml": "mitsuba_xml",
    ".json": "json_scene",
}


def load_scene(path: Path, lenient: bool = False, allow_outside: bool = False) -> Scene:
    """Scene in a file, as it stands there.

    Not validated: NaN and infinite values pass through.  ``notes`` says in sentences
    what differs from the file.

    Raises UsageError: missing, empty or corrupt file, an unknown suffix, or (unless
    lenient) something that is not modelled.

    Parameters
    ----------
    path : Path; .gltf, .glb, .obj, .ply, .xml (Mitsuba 3) or .json (docs: scene.json)
    lenient : bool
        Replace what is missing or not modelled, and say so in the scene's notes,
        rather than refuse the file.
    allow_outside : bool; read files outside the scene's folder, if it names them
    """
    suffix = path.suffix.lower()
    if suffix not in LOADERS:
        raise UsageError(
            f"{path}: a scene file ends in one of {', '.join(LOADERS)},"
            f" not in {suffix!r}"
        )
    try:
        size = path.stat().st_size
        is_file = path.is_file()
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else "no such name"
        raise UsageError(
            f"cannot read {path}: {reason}; name a scene file that exists"
        ) from error
    if not is_file:
        raise UsageError(f"{path} is not a file; name a scene file")
    if size == 0:
        raise UsageError(f"{path} is empty; name a file with a scene in it")
    module = import_module(f"restir_gi.reference.scene.loaders.{LOADERS[suffix]}")
    loader: Callable[[Ledger], Scene] = module.load
    return loader(Ledger(path, lenient, allow_outside))

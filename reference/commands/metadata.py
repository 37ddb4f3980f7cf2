"""What the header of a picture says about where it comes from."""

import argparse
from collections.abc import Mapping

from reference.scene.scene import Scene
from reference.version import project_version


def metadata(
    scene: Scene,
    arguments: argparse.Namespace,
    method: str,
    settings: Mapping[str, str],
    counts: Mapping[str, int],
    rays: Mapping[str, int],
    seconds: float,
) -> dict[str, str]:
    """Texts for the header of a picture.

    Parameters
    ----------
    scene : Scene
        Of the picture.
    arguments : Namespace
        With ``scene``, ``light``, ``bounces`` and ``seed``.
    method : str
        Its name.
    settings : mapping of str to str
        All of the method's, also those left at their defaults.
    counts : mapping of str to int
        ``"frames"``, ``"spp"``.
    rays : mapping of str to int
        Traced, by kind.
    seconds : float, s
        Wall time of the rendering.

    Returns
    -------
    dict of str to str
        The command and the version fix every bit of the pixels; the rest is for the
        reader.
    """
    words = {
        "scene": scene.name,
        "scene.argument": arguments.scene,
        "method": method,
        "light": arguments.light,
        "bounces": str(arguments.bounces),
        "seed": str(arguments.seed),
        **{name: str(count) for name, count in counts.items()},
        **{f"settings.{key}": value for key, value in settings.items()},
        "version": project_version(),
        "seconds": f"{seconds:.3f}",
        **{f"rays.{kind}": str(count) for kind, count in sorted(rays.items())},
    }
    if scene.notes:
        words["scene.notes"] = " ".join(scene.notes)
    return words

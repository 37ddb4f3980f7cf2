"""Mitsuba's emitters outside its shapes."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from reference.arrays import Vec3s, normalize
from reference.errors import UsageError
from reference.scene.lights import (
    ConstantEnvironment,
    DirectionalLight,
    Environment,
    LatLongEnvironment,
    PointLight,
)
from reference.scene.loaders.framing import color
from reference.scene.loaders.ledger import Ledger
from reference.scene.loaders.mitsuba_nodes import Node
from reference.scene.loaders.mitsuba_textures import read_color
from reference.scene.loaders.pictures import read_picture


@dataclass(slots=True)
class Lights:
    """Lights of one file that are not shapes.

    Attributes
    ----------
    points : list of PointLight
        Point lights.
    suns : list of DirectionalLight
        Directional lights.
    environment : Environment or None
        What surrounds the scene.
    """

    points: list[PointLight] = field(default_factory=list)
    suns: list[DirectionalLight] = field(default_factory=list)
    environment: Environment | None = None


def add_light(mi: Any, lights: Lights, node: Node, ledger: Ledger) -> None:
    """Add what an emitter outside the shapes stands for.

    Parameters
    ----------
    mi : module
        ``mitsuba``.
    lights : Lights
        Grows.
    node : Node
        The emitter.
    ledger : Ledger
        Of the file.
    """
    matrix = node.matrix()
    if node.kind in ("point", "spot"):
        if node.kind == "spot":
            ledger.replace(
                f"{node.name} is not modelled (point is)",
                "taken as a point light of the same intensity in all directions",
            )
            node.unread -= {"cutoff_angle", "beam_width", "texture"}
        position = node.get("position", matrix[:3, 3])
        intensity = read_color(mi, node, "intensity", 1.0, True, ledger)
        lights.points.append(PointLight(color(position), intensity))
    elif node.kind == "directional":
        direction = normalize(np.array(node.get("direction", matrix[:3, 2]), float))
        irradiance = read_color(mi, node, "irradiance", 1.0, True, ledger)
        lights.suns.append(DirectionalLight(color(direction), irradiance))
    elif node.kind == "constant":
        radiance = read_color(mi, node, "radiance", 1.0, True, ledger)
        lights.environment = ConstantEnvironment(radiance)
    elif node.kind == "envmap":
        lights.environment = _environment_map(node, ledger)
    else:
        ledger.replace(
            f"{node.name} is not modelled (of emitters, area, point, directional,"
            " constant and envmap are)",
            "left out",
        )
        return
    node.refuse_unread(ledger, harmless="sampling_weight mis_compensation")


def _environment_map(node: Node, ledger: Ledger) -> Environment | None:
    filename = node.get("filename")
    if filename is None:
        ledger.replace(f"{node.name} has no filename; it needs one", "left out")
        return None
    try:
        pixels = read_picture(filename, ledger)
    except UsageError as error:
        ledger.replace(f"{node.name}: {error}", "left out")
        return None
    axes = node.matrix()[:3, :3]
    if not np.allclose(axes.T @ axes, np.eye(3), atol=1e-4):
        ledger.replace(
            f"{node.name}: to_world does more than turn it, which is not modelled",
            "taken as its nearest rotation",
        )
    left, _, right = np.linalg.svd(axes)
    return LatLongEnvironment(_recentred(pixels * node.get("scale", 1.0)), left @ right)


def _recentred(pixels: Vec3s) -> Vec3s:
    """Rows at the centres of their bands of latitude.

    Mitsuba's first and last rows lie on the poles, i π / (h - 1) from the first; ours
    at (i + 1/2) π / h.  The columns agree.
    """
    height = len(pixels)
    if height == 1:
        return pixels
    at = (np.arange(height) + 0.5) / height * (height - 1)
    upper = np.minimum(at.astype(np.int64), height - 2)
    share = (at - upper)[:, None, None]
    recentred: Vec3s = (1 - share) * pixels[upper] + share * pixels[upper + 1]
    return recentred

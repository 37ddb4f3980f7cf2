"""Mitsuba's emitters outside its shapes."""

from dataclasses import dataclass, field

import numpy as np

from restir_gi.reference.numerics.arrays import Vec3s, normalize
from restir_gi.reference.scene.lights import (
    ConstantEnvironment,
    DirectionalLight,
    Environment,
    LatLongEnvironment,
    PointLight,
    SpotLight,
)
from restir_gi.reference.scene.loaders.framing import color
from restir_gi.reference.scene.loaders.ledger import Ledger
from restir_gi.reference.scene.loaders.mitsuba_nodes import Node
from restir_gi.reference.scene.loaders.mitsuba_textures import Textures
from restir_gi.reference.scene.loaders.pictures import read_picture
from restir_gi.reference.system.errors import UsageError


@dataclass(slots=True)
class MitsubaLights:
    """Lights of one file that are not shapes.

    Attributes
    ----------
    environment : Environment or None; what surrounds the scene
    """

    points: list[PointLight] = field(default_factory=list)
    spots: list[SpotLight] = field(default_factory=list)
    suns: list[DirectionalLight] = field(default_factory=list)
    environment: Environment | None = None


def add_light(lights: MitsubaLights, node: Node, textures: Textures) -> None:
    """Add what an emitter outside the shapes stands for.

    Parameters
    ----------
    lights : MitsubaLights; grows
    """
    ledger = textures.ledger
    # An area emitter outside the shapes shines from those alone that refer to it.
    if node.kind == "area" or not node.is_modelled(ledger):
        return
    node.check_words(ledger)
    matrix = node.matrix(ledger)
    if node.kind == "point":
        position = color(node.point("position", matrix[:3, 3], ledger))
        intensity = textures.color(node, "intensity", 1.0, emission=True)
        lights.points.append(PointLight(position, intensity))
    elif node.kind == "spot":
        lights.spots.append(_spot(node, textures))
    elif node.kind == "directional":
        direction = normalize(node.point("direction", matrix[:3, 2], ledger))
        irradiance = textures.color(node, "irradiance", 1.0, emission=True)
        lights.suns.append(DirectionalLight(color(direction), irradiance))
    elif node.kind == "constant":
        radiance = textures.color(node, "radiance", 1.0, emission=True)
        lights.environment = ConstantEnvironment(radiance)
    else:
        lights.environment = _environment_map(node, ledger)


def _spot(node: Node, textures: Textures) -> SpotLight:
    matrix = node.matrix(textures.ledger)
    cutoff = node.number("cutoff_angle", 20.0, textures.ledger)
    return SpotLight(
        position=color(matrix[:3, 3]),
        direction=color(normalize(matrix[:3, 2])),
        intensity=textures.color(node, "intensity", 1.0, emission=True),
        cutoff=cutoff,
        beam=node.number("beam_width", 0.75 * cutoff, textures.ledger),
    )


def _environment_map(node: Node, ledger: Ledger) -> Environment | None:
    scale = node.number("scale", 1.0, ledger)
    try:
        pixels = read_picture(str(node.file(ledger)), ledger)
    except UsageError as error:
        ledger.replace(f"{node.name}: {error}", "left out")
        return None
    axes = node.matrix(ledger)[:3, :3]
    if not np.allclose(axes.T @ axes, np.eye(3), atol=1e-4):
        ledger.replace(
            f"{node.name}: to_world does more than turn it, which is not modelled",
            "taken as its nearest rotation",
        )
    left, _, right = np.linalg.svd(axes)
    with np.errstate(over="ignore", invalid="ignore"):
        bright = pixels * scale
    if not np.isfinite(bright).all():
        ledger.stop(f"{node.name}: its scale of {scale:g} makes it infinitely bright")
    return LatLongEnvironment(_recentred(bright), left @ right)


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

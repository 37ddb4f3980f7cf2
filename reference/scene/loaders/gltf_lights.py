"""glTF punctual lights: point, spot and directional."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars, normalize
from restir_gi.reference.scene.lights import DirectionalLight, PointLight, SpotLight
from restir_gi.reference.scene.loaders.framing import color
from restir_gi.reference.scene.loaders.gltf_check import named, replace_word
from restir_gi.reference.scene.loaders.gltf_forms import LARGEST
from restir_gi.reference.scene.loaders.gltf_materials import PHOTOMETRIC
from restir_gi.reference.scene.loaders.ledger import Ledger


@dataclass(slots=True)
class GltfLights:
    """Lights of a scene, as they are found."""

    points: list[PointLight] = field(default_factory=list)
    spots: list[SpotLight] = field(default_factory=list)
    suns: list[DirectionalLight] = field(default_factory=list)


def add_light(
    lights: GltfLights,
    index: int,
    light: dict[str, Any],
    matrix: Scalars,
    ledger: Ledger,
) -> None:
    """Put a light of KHR_lights_punctual into the world.

    Parameters
    ----------
    matrix : (4, 4) float64; of its node, to the world; the light shines along -z

    Raises
    ------
    UsageError
        It is too strong for single precision, or its cone has no rim.
    """
    where = named("light", light, index)
    strength = np.array(light.get("color", [1, 1, 1]), float)
    strength = strength * float(light.get("intensity", 1.0))
    if strength.max() > LARGEST:
        problem = f"its intensity is {strength.max():.3g}"
        ledger.stop(f"{where}: {problem}; up to {LARGEST:.3g} fits single precision")
    ledger.note(PHOTOMETRIC)
    position, along = color(matrix[:3, 3]), color(-normalize(matrix[:3, 2]))
    if light["type"] == "directional":
        lights.suns.append(DirectionalLight(along, color(strength)))
        return
    if "range" in light:
        problem = "that its light ends at its range is not modelled"
        replace_word(ledger, "light", "range", where, problem)
    if light["type"] == "point":
        lights.points.append(PointLight(position, color(strength)))
        return
    cone = light.get("spot", {})
    inner = float(np.degrees(cone.get("innerConeAngle", 0.0)))
    outer = float(np.degrees(cone.get("outerConeAngle", np.pi / 4)))
    if inner >= outer:
        problem = f"innerConeAngle is {inner:.4g} degrees, outerConeAngle {outer:.4g}"
        ledger.stop(f"{where}: {problem}; it must be the larger one")
    spot = SpotLight(position, along, color(strength), outer, inner, "smooth")
    lights.spots.append(spot)

"""Lights that are not shapes: a point, the sun, and what surrounds the scene."""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars, Vec3s
from restir_gi.reference.scene.textures import Color


@dataclass(frozen=True, slots=True)
class PointLight:
    """Light from one point, the same in all directions.

    Attributes
    ----------
    position : (float, float, float), m; in the world
    intensity : Color, W/sr; irradiance at distance d facing it is ``intensity / d²``
    """

    position: tuple[float, float, float]
    intensity: Color


@dataclass(frozen=True, slots=True)
class SpotLight:
    """Light from one point into a cone.

    Attributes
    ----------
    position : (float, float, float), m; in the world
    direction : (float, float, float)
        Unit vector along the axis of the cone, away from the light.
    intensity : Color, W/sr
    cutoff : float, degrees
        Angle from the axis beyond which there is no light; 0.01 to 180.
    beam : float, degrees
        Angle up to which the intensity is that on the axis; at most ``cutoff``.
    falloff : 'linear' or 'smooth'
        Between the two angles: linear in the angle, as Mitsuba's spot, or the square
        of what is linear in the cosine, as glTF's.
    """

    position: tuple[float, float, float]
    direction: tuple[float, float, float]
    intensity: Color
    cutoff: float
    beam: float
    falloff: Literal["linear", "smooth"] = "linear"


Lamp = PointLight | SpotLight


@dataclass(frozen=True, slots=True)
class DirectionalLight:
    """The sun: parallel light from infinitely far.

    Attributes
    ----------
    direction : (float, float, float); unit vector along which the light travels
    irradiance : Color, W/m²; on a surface that faces it
    """

    direction: tuple[float, float, float]
    irradiance: Color


@dataclass(frozen=True, slots=True)
class ConstantEnvironment:
    """The same radiance from everywhere beyond the scene.

    Attributes
    ----------
    radiance : Color, W/(m² sr)
    """

    radiance: Color


def _identity() -> Scalars:
    return np.eye(3)


@dataclass(frozen=True, slots=True, eq=False)
class LatLongEnvironment:
    """Radiance from beyond the scene, on a latitude-longitude map.

    Attributes
    ----------
    pixels : (h, w, 3) float64, W/(m² sr)
        Row 0 looks along +y of the map's frame; the middle of a row along +z, and
        +x is a quarter of the width further left (so that the map is seen from
        inside).
    to_world : (3, 3) float64; rotation of the map's frame into the world
    """

    pixels: Vec3s
    to_world: Scalars = field(default_factory=_identity)


Environment = ConstantEnvironment | LatLongEnvironment

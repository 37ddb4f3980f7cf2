"""How the light of spots falls off from the axis of their cone."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from restir_gi.reference.numerics.arrays import (
    Indices,
    Masks,
    Scalars,
    Vec3s,
    divide_or_zero,
    dot,
)
from restir_gi.reference.scene.lights import Lamp, SpotLight


@dataclass(frozen=True, slots=True, eq=False)
class Cones:
    """Cones of L lights.

    Attributes
    ----------
    axis : (L, 3) float64; unit vectors, away from the light
    beam, cutoff : (L,) float64, radians
        Angles from the axis at which the intensity begins to fall, and ends; π for a
        light that shines alike in all directions.
    smooth : (L,) bool
        Falls with the square of what is linear in the cosine, not with the angle.
    """

    axis: Vec3s
    beam: Scalars
    cutoff: Scalars
    smooth: Masks


def build_cones(lamps: Sequence[Lamp]) -> Cones:
    """Cones of lights; that of a point light is the whole sphere.

    Parameters
    ----------
    lamps : sequence of PointLight or SpotLight; validated
    """
    spots = [lamp if isinstance(lamp, SpotLight) else None for lamp in lamps]
    axes = [spot.direction if spot else (0.0, 0.0, 1.0) for spot in spots]
    return Cones(
        axis=np.array(axes, float).reshape(-1, 3),
        beam=np.radians([spot.beam if spot else 180.0 for spot in spots]),
        cutoff=np.radians([spot.cutoff if spot else 180.0 for spot in spots]),
        smooth=np.array([bool(spot and spot.falloff == "smooth") for spot in spots]),
    )


def falloff(cones: Cones, light: Indices, direction: Vec3s) -> Scalars:
    """Intensity in a direction over that on the axis.

    The first is that of Mitsuba's ``spot``, the second that of glTF's
    ``KHR_lights_punctual``.

    Parameters
    ----------
    light : (N,) int; which of them
    direction : (N, 3) float64; unit vectors away from the light

    Returns
    -------
    (N,) float64
        1 up to the angle of the beam, 0 from the cutoff on; between them, at the angle
        θ, (θ_c − θ) / (θ_c − θ_b), or ((cos θ − cos θ_c) / (cos θ_b − cos θ_c))².
    """
    beam, cutoff = cones.beam[light], cones.cutoff[light]
    cosine = np.clip(dot(cones.axis[light], direction), -1.0, 1.0)
    angle, cos_cutoff = np.arccos(cosine), np.cos(cutoff)
    linear = divide_or_zero(cutoff - angle, cutoff - beam)
    smooth = divide_or_zero(cosine - cos_cutoff, np.cos(beam) - cos_cutoff)
    smooth = np.maximum(smooth, 0.0)
    between = np.where(cones.smooth[light], smooth * smooth, linear)
    inside = np.where(angle <= beam, 1.0, np.clip(between, 0.0, 1.0))
    return np.where((angle < cutoff) | (beam >= np.pi), inside, 0.0)


def solid_angles(cones: Cones) -> Scalars:
    """Integral of the falloff over all directions.

    Returns
    -------
    (L,) float64, sr
        Power over the intensity on the axis; 4π for a light without a cone.
    """
    beam, cutoff = cones.beam, cones.cutoff
    # ∫ (c − θ) sin θ dθ / (c − b) from b to c, which tends to 0 as b tends to c; of the
    # square of what is linear in the cosine, the third part of the difference.
    slope = divide_or_zero(np.sin(cutoff) - np.sin(beam), cutoff - beam)
    linear = np.where(cutoff > beam, np.cos(beam) - slope, 0.0)
    smooth = (np.cos(beam) - np.cos(cutoff)) / 3.0
    fallen = np.where(cones.smooth, smooth, linear)
    whole: Scalars = 2.0 * np.pi * (1.0 - np.cos(beam) + fallen)
    return whole

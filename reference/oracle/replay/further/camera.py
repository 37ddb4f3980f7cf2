"""Pinhole camera of the contract's settings, on numbers with error bounds."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi

import numpy as np

from restir_gi.reference.numerics.arrays import Indices
from restir_gi.reference.oracle.contract.fields import Value
from restir_gi.reference.oracle.replay.bounded import Bounded, Rounding, constant, exact
from restir_gi.reference.oracle.replay.further.numbers import product, setting, unit
from restir_gi.reference.oracle.replay.further.rules import FurtherRules
from restir_gi.reference.oracle.replay.neighbors import SINE
from restir_gi.reference.oracle.replay.verbs import inner, square_root, times


@dataclass(frozen=True, slots=True, eq=False)
class Eye:
    """A camera.

    Attributes
    ----------
    position, right, upward, forward : Bounded
        (1, 3) each: the pinhole, and unit vectors.
    half_width : Bounded; (1,): tangent of half the angle of view
    width, height : Bounded; (1,) each, pixels
    """

    position: Bounded
    right: Bounded
    upward: Bounded
    forward: Bounded
    half_width: Bounded
    width: Bounded
    height: Bounded


def eye_of(
    settings: Mapping[str, Value], rounding: Rounding, rules: FurtherRules
) -> Eye:
    """The camera of a case, its axes calculated from the settings as a backend does.

    Parameters
    ----------
    settings : mapping of str to number; ``eye_x`` to ``height``
    """
    position, target, up = (
        _vector(settings, name, rounding) for name in ("eye", "target", "up")
    )
    forward = unit(target - position)
    right = unit(product(forward, up))
    upward = up if rules.up_as_it_is else product(right, forward)
    angle = setting(settings["fov_x"], rounding)
    half_width = _tangent(angle * constant(pi / 360, angle))
    width, height = (setting(settings[n], rounding) for n in ("width", "height"))
    return Eye(
        position=position,
        right=-right if rules.mirrored else right,
        upward=-upward if rules.upside_down else upward,
        forward=forward,
        half_width=half_width * width / height if rules.angle_of_height else half_width,
        width=width,
        height=height,
    )


def _vector(settings: Mapping[str, Value], name: str, rounding: Rounding) -> Bounded:
    parts = [setting(settings[f"{name}_{axis}"], rounding) for axis in "xyz"]
    value, error = (
        np.stack(p, axis=1)
        for p in zip(*((part.value, part.error) for part in parts), strict=True)
    )
    return Bounded(value, error, rounding)


def _tangent(angle: Bounded) -> Bounded:
    """The angle's error times the slope 1 / cos², and that of a sine over a cosine."""
    value = np.tan(angle.value)
    slope = 1 + value**2
    own = (2 * SINE + 1) * angle.rounding.unit * np.abs(value)
    return Bounded(value, angle.error * slope + own, angle.rounding)


def rays(eye: Eye, pixel: Indices, place: float) -> Bounded:
    """Directions through pixels, (N, 3), of which the component along the axis is 1.

    Parameters
    ----------
    pixel : (N,) int; y · width + x
    place : float; in each pixel, from the left and from above: 1/2 is its centre
    """
    y, x = np.divmod(pixel, int(eye.width.value[0]))
    twice_x, twice_y = (exact(2 * (v + place), eye.width.rounding) for v in (x, y))
    right = (twice_x / eye.width - constant(1.0, twice_x)) * eye.half_width
    upward = (eye.height - twice_y) / eye.width * eye.half_width
    return times(eye.right, right) + times(eye.upward, upward) + eye.forward


def seen_at(eye: Eye, points: Bounded) -> tuple[Bounded, Bounded, Bounded]:
    """Where points appear in the image.

    Parameters
    ----------
    points : Bounded; (N, 3), m

    Returns
    -------
    x, y : Bounded; (N,), pixels; without meaning where the depth is not above 0
    depth : Bounded; (N,), m, along the axis
    """
    offset = offset_from(eye, points)
    depth = inner(offset, eye.forward)
    two = constant(2.0, depth)
    scale = eye.width / (two * depth * eye.half_width)
    x = eye.width / two + inner(offset, eye.right) * scale
    y = eye.height / two - inner(offset, eye.upward) * scale
    return x, y, depth


def offset_from(eye: Eye, points: Bounded) -> Bounded:
    """Vectors from the pinhole to points.

    Parameters
    ----------
    points : Bounded; (N, 3), m

    Returns
    -------
    Bounded
        (N, 3).  A view matrix turns point and pinhole before it subtracts one from the
        other: each component then has a rounding of the length of both.
    """
    offset = points - eye.position
    lengths = [np.linalg.norm(v.value, axis=1) for v in (points, eye.position)]
    turned = offset.rounding.unit * (lengths[0] + lengths[1])[:, None]
    return Bounded(offset.value, offset.error + turned, offset.rounding)


def depth_of(eye: Eye, points: Bounded, rules: FurtherRules) -> Bounded:
    """How far points are from the pinhole, along the axis, (N,), m.

    Parameters
    ----------
    points : Bounded; (N, 3), m
    """
    offset = offset_from(eye, points)
    if rules.depth_is_distance:
        return square_root(inner(offset, offset))
    return inner(eye.forward, offset)

"""Pinhole camera."""

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars, Vec3s, dot, normalize

FovAxis = Literal["x", "y", "smaller", "larger", "diagonal"]
FOV_AXES: tuple[FovAxis, ...] = get_args(FovAxis)


@dataclass(frozen=True, slots=True)
class Camera:
    """Pinhole camera with square pixels.

    Attributes
    ----------
    position : (float, float, float), m
    target : (float, float, float), m; seen in the centre of the image
    up : (float, float, float)
        Not parallel to the view; need not be orthogonal to it or unit.
    fov : float, degrees; angle of view, between 0 and 180
    fov_axis : 'x', 'y', 'smaller', 'larger' or 'diagonal'
        What it spans: the width, the height, the smaller or larger of both, or the
        diagonal.  It spans the same at any size of the image.
    width, height : int, pixels; size of the image
    mirrored : bool; left and right exchanged: a camera of a left-handed frame
    """

    position: tuple[float, float, float]
    target: tuple[float, float, float]
    up: tuple[float, float, float] = (0.0, 1.0, 0.0)
    fov: float = 60.0
    fov_axis: FovAxis = "x"
    width: int = 256
    height: int = 256
    mirrored: bool = False

    @property
    def half_width(self) -> float:
        """Tangent of half the horizontal angle of view: tan(fov / 2) · width / side."""
        side = {
            "x": self.width,
            "y": self.height,
            "smaller": min(self.width, self.height),
            "larger": max(self.width, self.height),
            "diagonal": np.hypot(self.width, self.height),
        }[self.fov_axis]
        return float(np.tan(np.radians(self.fov) / 2) * (self.width / side))

    @property
    def axes(self) -> tuple[Vec3s, Vec3s, Vec3s]:
        """Unit vectors (3,) to the right, upwards and forwards."""
        position, target, up = (
            np.asarray(v, float) for v in (self.position, self.target, self.up)
        )
        forward = normalize(target - position)
        right = normalize(np.cross(forward, up))
        upwards = np.cross(right, forward)
        return (-right if self.mirrored else right), upwards, forward


def pixel_centers(width: int, height: int) -> tuple[Scalars, Scalars]:
    """Centres of all pixels, row by row from the top left.

    Returns
    -------
    (N,), (N,) float64, pixels; x to the right and y downwards; row = y · width + x
    """
    rows = np.arange(width * height)
    return rows % width + 0.5, rows // width + 0.5


def camera_rays(camera: Camera, x: Scalars, y: Scalars) -> tuple[Vec3s, Vec3s]:
    """Rays from the pinhole through points of the image.

    Parameters
    ----------
    x, y : (N,) float64, pixels; points of the image, (0, 0) at its top left corner

    Returns
    -------
    (N, 3), (N, 3) float64; origins, and unit directions
    """
    right, up, forward = camera.axes
    half_width = camera.half_width
    along_right = (2.0 * x / camera.width - 1.0) * half_width
    # Square pixels: both axes in units of half the width.
    along_up = (camera.height - 2.0 * y) / camera.width * half_width
    direction = normalize(
        along_right[:, None] * right + along_up[:, None] * up + forward
    )
    origin = np.broadcast_to(np.asarray(camera.position, float), direction.shape)
    return origin, direction


def image_points(camera: Camera, points: Vec3s) -> tuple[Scalars, Scalars]:
    """Where points of the world appear in the image: the inverse of `camera_rays`.

    Parameters
    ----------
    points : (N, 3) float64, m; in the world

    Returns
    -------
    (N,), (N,) float64, pixels
        Points of the image, also outside of it; NaN for points that are not before
        the camera.
    """
    right, up, forward = camera.axes
    offset = points - np.asarray(camera.position, float)
    depth = dot(offset, forward)
    half_width = camera.half_width
    scale = np.full(len(depth), np.nan)
    np.divide(camera.width / 2, depth * half_width, out=scale, where=depth > 0)
    x = camera.width / 2 + dot(offset, right) * scale
    y = camera.height / 2 - dot(offset, up) * scale
    return x, y


def view_depth(camera: Camera, points: Vec3s) -> Scalars:
    """Distance of points from the camera, along its axis.

    Parameters
    ----------
    points : (N, 3) float64, m; in the world

    Returns
    -------
    (N,) float64, m; negative behind the camera
    """
    forward = camera.axes[2]
    return dot(points - np.asarray(camera.position, float), forward)

"""Columns that no buffer holds, from those that are there."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import (
    Masks,
    Scalars,
    Vec3s,
    divide_or_zero,
    dot,
)
from restir_gi.reference.oracle.capture.columns import Column
from restir_gi.reference.oracle.capture.description import CapturedCamera
from restir_gi.reference.scene.camera import Camera, camera_rays, pixel_centers


@dataclass(frozen=True, slots=True)
class Derived:
    """A column that follows from another.

    Attributes
    ----------
    source : str; name of the column that it follows from
    how : str; its formula, or where it is from
    array : (N, ...) float64
    right : str; what would be right where it is not finite
    """

    name: str
    source: str
    how: str
    array: NDArray[Any]
    right: str


UNSEEN = "say by `none` which depth is that of nothing seen, or give another matrix"
SMALL = "numbers should not be so small"


def nothing_seen(columns: Mapping[str, Column]) -> Masks:
    """Pixels whose depth is that of no surface, (N,) bool; none where no depth is."""
    depth = columns["depth"]
    found: Masks = depth.stored[:, 0] == depth.fields[0].none
    return found


def derive(
    role: str,
    columns: Mapping[str, Column],
    arrays: Mapping[str, NDArray[Any]],
    camera: CapturedCamera | None,
    size: tuple[int, int],
) -> list[Derived]:
    """What follows from the columns of a role, in the contract's words.

    ``visible_position`` from ``depth`` and a camera; ``W`` from ``w_sum``, ``M`` and
    ``p_hat``; ``pdf`` of a new sample from its ``W``.

    Parameters
    ----------
    columns : mapping of str to Column; as stored
    arrays : mapping of str to (N, ...) array; the same, converted
    size : (int, int), pixels; width and height
    """
    found: list[Derived] = []
    if "depth" in arrays and camera is not None:
        field = columns["depth"].fields[0]
        points, along = positions(
            depth=arrays["depth"],
            given=field.given,
            nothing=nothing_seen(columns),
            camera=camera,
            size=size,
        )
        if field.given != "view":
            how = f"from the {field.given} depth"
            found.append(Derived("depth", "depth", how, along, UNSEEN))
        if "visible_position" not in arrays:
            how = "from the depth"
            found.append(Derived("visible_position", "depth", how, points, UNSEEN))
    W, source = arrays.get("W"), "W"
    if W is None and {"w_sum", "M", "p_hat"} <= arrays.keys():
        W, source = _quotient(arrays["w_sum"], arrays["M"], arrays["p_hat"]), "w_sum"
        found.append(Derived("W", source, "w_sum / (M p_hat)", W, SMALL))
    if role == "initial" and "pdf" not in arrays and W is not None:
        pdf = _quotient(np.ones_like(W), W)
        found.append(Derived("pdf", source, "1 / W", pdf, SMALL))
    return found


def _quotient(numerator: Scalars, *factors: Scalars) -> Scalars:
    """A number over a product, (N,); 0 where one of its factors is 0.

    Parameters
    ----------
    *factors : (N,) float64; one after the other, whose product may be below the range
    """
    with np.errstate(over="ignore", invalid="ignore"):
        for factor in factors:
            numerator = divide_or_zero(numerator, factor)
    return numerator


def positions(
    *,
    depth: Scalars,
    given: str,
    nothing: Masks,
    camera: CapturedCamera,
    size: tuple[int, int],
) -> tuple[Vec3s, Scalars]:
    """Points that are seen through the centres of the pixels, and their view depths.

    Parameters
    ----------
    depth : (N,) float64, m; or as a depth buffer has it
    given : 'view', 'distance' or 'device'
        Along the camera's axis, along the ray, or as a depth buffer has it.
    nothing : (N,) bool; where nothing is seen
    size : (int, int), pixels; width and height

    Returns
    -------
    (N, 3), (N,) float64, m
        0 where nothing is seen; not finite where the matrix leads to infinity.
    """
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        if camera.pinhole is not None:
            found, along = _along_rays(depth, given, camera.pinhole)
        else:
            found, along = _unprojected(depth, given, camera, size)
    return np.where(nothing[:, None], 0.0, found), np.where(nothing, 0.0, along)


def _along_rays(depth: Scalars, given: str, camera: Camera) -> tuple[Vec3s, Scalars]:
    """Points of a pinhole camera."""
    eye, direction = camera_rays(camera, *pixel_centers(camera.width, camera.height))
    cosine = dot(direction, np.asarray(camera.axes[2]))
    distance = depth / cosine if given == "view" else depth
    return eye + distance[:, None] * direction, distance * cosine


def _unprojected(
    depth: Scalars, given: str, camera: CapturedCamera, size: tuple[int, int]
) -> tuple[Vec3s, Scalars]:
    """Points by the inverse of projection times view, which is one in perspective.

    The eye is where clip space has (0, 0, 1, 0); the w of clip space is the view depth.
    """
    assert camera.inverse is not None
    inverse, (width, height) = camera.inverse, size
    x, y = pixel_centers(width, height)
    upward = 1 - 2 * y / height
    z = depth if given == "device" else np.full(len(depth), 0.5)
    clip = np.stack(
        [
            2 * x / width - 1,
            -upward if camera.clip_y_down else upward,
            2 * z - 1 if camera.clip_depth_signed else z,
            np.ones(len(z)),
        ],
        axis=-1,
    )
    world = clip @ inverse.T
    point, w = world[:, :3] / world[:, 3:], 1 / world[:, 3]
    if given == "device":
        return point, w
    eye = inverse[:3, 2] / inverse[3, 2]
    ray = (point - eye) / w[:, None]  # as far as a view depth of 1
    along = depth / np.sqrt(dot(ray, ray)) if given == "distance" else depth
    return eye + along[:, None] * ray, along

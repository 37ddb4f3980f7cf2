"""Kernels of places, directions and angles."""

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Scalars, Vec3s, dot, triangle_normal
from restir_gi.reference.numerics.frames import normal_frames
from restir_gi.reference.oracle.exact.draws import Draws
from restir_gi.reference.oracle.exact.kernel import Inputs, Kernel, Row
from restir_gi.reference.oracle.exact.numbers import EXACT, literal
from restir_gi.reference.oracle.exact.vectors import Vector, inner, minus
from restir_gi.reference.passes.gbuffer import similar
from restir_gi.reference.scene.surface import direction_and_distance

MAX_ANGLE, MAX_DEPTH = 60.0, 0.0625
"""Limits of similarity that are binary numbers: cosine 1/2 and depth 1/16."""


# ------------------------------------------------------------------ similarity


def _draw_seen(draws: Draws) -> dict[str, Scalars]:
    n_a = draws.unit()
    nearly = 1 + np.round(draws.rng.normal(size=draws.rows)) / 16
    depth = draws("scale") * draws("distance")
    return {
        "normal_a": n_a,
        "depth_a": depth,
        "normal_b": draws.leaning(n_a),
        "depth_b": depth * nearly,
    }


def _run_similar(given: Inputs) -> NDArray[Any]:
    a, b = ((given[f"normal_{k}"], given[f"depth_{k}"]) for k in "ab")
    return similar(*a, *b, MAX_ANGLE, MAX_DEPTH)


@cache
def cosine_of_degrees(angle: float) -> Any:
    """Cosine of an angle.

    Exact where it is rational: for a rational number of degrees that are 0, ±1/2 and ±1
    alone.

    Parameters
    ----------
    angle : float; degrees, 0 to 180
    """
    halves = {0: 2, 60: 1, 90: 0, 120: -1, 180: -2}
    if angle in halves:
        return EXACT.mpf(halves[int(angle)]) / 2
    return EXACT.cospi(EXACT.mpf(angle) / 180)


def similarity(row: Row, max_angle: float, max_depth: float) -> bool:
    """Whether two points look alike: normals within an angle, depths within a share.

    False where a depth is 0; the limits themselves are inside.

    Parameters
    ----------
    max_angle : float, degrees; between the normals
    max_depth : float; largest difference of the depths, as a share of the larger one
    """
    a, b = row["depth_a"], row["depth_b"]
    near, far = (a, b) if a < b else (b, a)
    cosine = literal(cosine_of_degrees(max_angle), a.type)
    there = near > 0
    alike = inner(row["normal_a"], row["normal_b"]) >= cosine
    return there and far - near <= far * literal(max_depth, a.type) and alike


SIMILAR = Kernel(
    "similar", "similar", _draw_seen, _run_similar,
    lambda row: similarity(row, MAX_ANGLE, MAX_DEPTH),
    {
        "points that touch": "false where a depth is 0",
        "points far away": "does not know the unit of length",
        "edge-on": "false beyond the angle; the limit itself is inside",
        "in a corner": "false where a depth is 0",
        "scale of the scene": "does not know the unit of length",
    },
)  # fmt: skip

# ------------------------------------------------------------------ vectors


def _draw_places(draws: Draws) -> dict[str, Scalars]:
    place, normal = draws.place(), draws.unit()
    return {"x": place, "y": draws.seen_from(place, normal)}


def _run_direction(given: Inputs) -> Vec3s:
    return direction_and_distance(given["x"], given["y"])[0]


def _direction(row: Row) -> Vector:
    v = minus(row["y"], row["x"])
    one_over = 1 / inner(v, v).sqrt()
    return v[0] * one_over, v[1] * one_over, v[2] * one_over


_FAR = "finite where d² leaves the type's range"
DIRECTION = Kernel(
    "direction to a point", "", _draw_places, _run_direction, _direction,
    {
        "points that touch": f"0 where the points coincide; {_FAR}",
        "points far away": _FAR,
        "edge-on": "does not know the angle",
        "in a corner": f"0 where the points coincide; {_FAR}",
        "scale of the scene": "does not know it",
        "far from the origin": "that of the rounded places",
    },
)  # fmt: skip


def _draw_triangle(draws: Draws) -> dict[str, Scalars]:
    along, across = draws.unit(), draws.unit()
    corner, size = draws.place(), draws("scale")[:, None]
    height = draws("shape")[:, None]
    b = corner + size * along
    return {"a": corner, "b": b, "c": b + size * height * across}


def _run_normal(given: Inputs) -> Vec3s:
    a, b, c = (given[name] for name in "abc")
    return triangle_normal(b - a, c - a)


def _normal(row: Row) -> Vector:
    u, v = minus(row["b"], row["a"]), minus(row["c"], row["a"])
    if row["b"] == row["c"]:  # all products cancel, however they are rounded
        return u[0] * 0, u[0] * 0, u[0] * 0
    n = (
        u[1] * v[2] - u[2] * v[1],
        u[2] * v[0] - u[0] * v[2],
        u[0] * v[1] - u[1] * v[0],
    )
    size = inner(n, n).sqrt()
    return n[0] / size, n[1] / size, n[2] / size


NORMAL = Kernel(
    "normal of a triangle", "", _draw_triangle, _run_normal, _normal,
    {
        "scale of the scene": "does not know it; finite where the area's square"
        " leaves the type's range",
        "far from the origin": "that of the rounded corners",
        "slivers": "unit, or 0 where the height is lost",
        "no area": "0 where two corners are one",
    },
)  # fmt: skip


def _draw_normal(draws: Draws) -> dict[str, Scalars]:
    return {"n": draws.about_z()}


def _run_tangent(given: Inputs) -> Vec3s:
    return normal_frames(given["n"])[0]


def _tangent(row: Row) -> Vector:
    x, y, z = row["n"]
    sign = -1 if z.value < 0 else 1
    a = -1 / (z + sign)
    return (x * x * a) * sign + 1, (x * y * a) * sign, x * -sign


TANGENT = Kernel(
    "tangent of a normal", "direction", _draw_normal, _run_tangent, _tangent,
    {
        "edge-on": "unit and orthogonal, on either side of n_z = 0",
        "in a corner": "as edge-on",
    },
)  # fmt: skip


def _run_cosine(given: Inputs) -> Scalars:
    return dot(given["n"], given["v"])


COSINE = Kernel(
    "inner product",
    "",
    lambda draws: {
        "n": (n := draws.unit()),
        "v": draws.leaning(n),
    },
    _run_cosine,
    lambda row: inner(row["n"], row["v"]),
    {
        "edge-on": "the difference of large products: as wrong as these are rounded",
        "in a corner": "as edge-on",
    },
)

GEOMETRY = (SIMILAR, DIRECTION, NORMAL, TANGENT, COSINE)

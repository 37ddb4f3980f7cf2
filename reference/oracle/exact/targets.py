"""Kernels of reuse between points: Jacobian, targets, integrand."""

import numpy as np

from restir_gi.reference.images.image import luminance_weights
from restir_gi.reference.numerics.arrays import Scalars, Vec3s
from restir_gi.reference.oracle.exact.draws import Draws
from restir_gi.reference.oracle.exact.kernel import Inputs, Kernel, Row
from restir_gi.reference.oracle.exact.numbers import EXACT, Exact, literal
from restir_gi.reference.oracle.exact.vectors import Vector, inner, minus
from restir_gi.reference.resampling.reservoir import Samples
from restir_gi.reference.resampling.shift import reconnection_jacobian
from restir_gi.reference.resampling.target import luminance, reflected, target
from restir_gi.reference.scene.materials.kinds import Lambertian
from restir_gi.reference.scene.materials.parameters import tabulate
from restir_gi.reference.scene.surface import SurfacePoints

# The decimals are meant, which no binary number is.
_LUMINANCE = tuple(EXACT.mpf(str(w)) for w in luminance_weights())
_WHITE = tabulate([Lambertian((1.0, 1.0, 1.0))])


def luminance_of(color: Vector) -> Exact:
    """Luminance of a colour."""
    r, g, b = (literal(w, color[0].type) for w in _LUMINANCE)
    return color[0] * r + color[1] * g + color[2] * b


# ------------------------------------------------------------------ Jacobian


def _draw_patch(draws: Draws) -> dict[str, Scalars]:
    position, normal = draws.place(), draws.unit()
    return {
        "x_from": draws.seen_from(position, normal),
        "x_to": draws.seen_from(position, normal),
        "position": position,
        "normal": normal,
    }


def _run_jacobian(given: Inputs) -> Scalars:
    names = ("x_from", "x_to", "position", "normal")
    return reconnection_jacobian(*(given[name] for name in names))


def _jacobian(row: Row) -> Exact:
    v_from = minus(row["x_from"], row["position"])
    v_to = minus(row["x_to"], row["position"])
    ratio = (inner(v_from, v_from) / inner(v_to, v_to)).sqrt()
    cosines = abs(inner(row["normal"], v_to)) / abs(inner(row["normal"], v_from))
    return cosines * ratio * ratio * ratio


_OUT_OF_RANGE = "any finite number from 0 on where d² leaves the type's range"

JACOBIAN = Kernel(
    "jacobian",
    "jacobian",
    _draw_patch,
    _run_jacobian,
    _jacobian,
    {
        "points that touch": f"0 where d_from or d_to is 0; {_OUT_OF_RANGE}",
        "points far away": _OUT_OF_RANGE,
        "edge-on": "0 where cos φ_from or cos φ_to is 0",
        "in a corner": f"0 where a distance or cos φ_from is 0; {_OUT_OF_RANGE}",
        "scale of the scene": f"J does not know it; {_OUT_OF_RANGE}",
        "far from the origin": "J of the rounded places; 0 where they fall together",
    },
)

# ------------------------------------------------------------------ targets


def _draw_light(draws: Draws) -> dict[str, Scalars]:
    position, normal, place = draws.unit(), draws.unit(), draws.place()
    return {
        "visible_position": place,
        "visible_normal": normal,
        "albedo": draws.color("albedo"),
        "position": draws.seen_from(place, normal),
        "normal": position,
        "radiance": draws.color("radiance"),
    }


def _points(given: Inputs) -> tuple[SurfacePoints, Samples]:
    rows = len(given["position"])
    normal, albedo = given["visible_normal"], given["albedo"]
    receiver = SurfacePoints(
        given["visible_position"], normal, None, normal, albedo,
        np.zeros(rows, np.int32), np.zeros(rows, np.int32), np.ones(rows, bool),
    )  # fmt: skip
    return receiver, Samples(given["position"], given["normal"], given["radiance"])


def _run_scattered(given: Inputs) -> Scalars:
    return target("scattered", _WHITE, *_points(given))


def _run_outgoing(given: Inputs) -> Scalars:
    return target("outgoing", _WHITE, *_points(given))


def _run_reflected(given: Inputs) -> Vec3s:
    return reflected(_WHITE, *_points(given))


def way_to_sample(row: Row) -> tuple[Vector, Exact, bool]:
    """x_s − x, its inner product with n, and whether light can go that way."""
    toward = minus(row["position"], row["visible_position"])
    along = inner(row["visible_normal"], toward)
    return toward, along, along > 0 and inner(row["normal"], toward) < 0


def _scattered(row: Row) -> Exact:
    toward, along, lit = way_to_sample(row)
    a, light = row["albedo"], row["radiance"]
    color = luminance_of((a[0] * light[0], a[1] * light[1], a[2] * light[2]))
    if not lit:
        return along * 0
    distance = inner(toward, toward).sqrt()
    return color * (along / (literal(EXACT.pi, along.type) * distance))


def _outgoing(row: Row) -> Exact:
    _, along, lit = way_to_sample(row)
    return luminance_of(row["radiance"]) if lit else along * 0


def _reflected(row: Row) -> Vector:
    toward, along, lit = way_to_sample(row)
    if not lit:
        return along * 0, along * 0, along * 0
    one_over = 1 / inner(toward, toward).sqrt()
    omega = toward[0] * one_over, toward[1] * one_over, toward[2] * one_over
    cosine = inner(row["visible_normal"], omega) / literal(EXACT.pi, along.type)
    a, light = row["albedo"], row["radiance"]
    return tuple(a[k] * cosine * light[k] for k in range(3))


_NULLS = {
    "points that touch": "0 where x_s = x",
    "points far away": "finite where d² leaves the type's range",
    "edge-on": "0 where n·ω ≤ 0",
    "in a corner": "0 where x_s = x or n·ω ≤ 0",
    "scale of the scene": "does not know it",
    "far from the origin": "that of the rounded places",
    "radiance at its limits": "finite; what is too large may be any finite number",
    "no light": "0",
}

SCATTERED = Kernel(
    "target, scattered", "target", _draw_light, _run_scattered, _scattered,
    {**_NULLS, "black and white": "0 for black"},
)  # fmt: skip
OUTGOING = Kernel(
    "target, outgoing", "target", _draw_light, _run_outgoing, _outgoing,
    {**_NULLS, "black and white": "does not look at it"},
)  # fmt: skip
REFLECTED = Kernel(
    "integrand", "shade", _draw_light, _run_reflected, _reflected,
    {**_NULLS, "black and white": "0 for black"},
)  # fmt: skip


def _run_luminance(given: Inputs) -> Scalars:
    return luminance(given["radiance"])


LUMINANCE = Kernel(
    "luminance",
    "",
    lambda draws: {"radiance": draws.color("radiance")},
    _run_luminance,
    lambda row: luminance_of(row["radiance"]),
    {"radiance at its limits": "as exact as what underflows", "no light": "0"},
)

TARGETS = (JACOBIAN, SCATTERED, OUTGOING, REFLECTED, LUMINANCE)

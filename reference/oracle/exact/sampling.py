"""Kernels of random directions and points."""

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars, Vec3s
from restir_gi.reference.numerics.sampling import (
    pdf_cosine_hemisphere,
    pdf_uniform_hemisphere,
    sample_cosine_hemisphere,
    sample_triangle,
    sample_uniform_hemisphere,
    sample_uniform_sphere,
)
from restir_gi.reference.oracle.exact.draws import Draws
from restir_gi.reference.oracle.exact.kernel import Inputs, Kernel, Row
from restir_gi.reference.oracle.exact.numbers import EXACT, Exact, literal
from restir_gi.reference.oracle.exact.vectors import Vector
from restir_gi.reference.scene.materials.microfacet import sample_visible_normal


def _draw_two(draws: Draws) -> dict[str, Scalars]:
    return {"u1": draws("u"), "u2": draws("u")}


def uniform_polar(u: Exact) -> tuple[Exact, Exact]:
    """Cosine and sine of the angle to the normal, of equal density all over.

    Parameters
    ----------
    u : Exact; random number

    Returns
    -------
    Exact, Exact; u and √(1 − u²)
    """
    return u, (1 - u * u).sqrt()


def cosine_polar(u: Exact) -> tuple[Exact, Exact]:
    """Cosine and sine of the angle to the normal, of a density in proportion to it.

    √(1 − u) and √u.

    Parameters
    ----------
    u : Exact; random number
    """
    return (1 - u).sqrt(), u.sqrt()


def azimuth(u: Exact) -> Exact:
    """Angle about the normal; 2π u.

    Parameters
    ----------
    u : Exact; random number
    """
    return literal(2 * EXACT.pi, u.type) * u


def _about_z(cosine: Exact, sine: Exact, u: Exact) -> Vector:
    phi = azimuth(u)
    return sine * phi.cos(), sine * phi.sin(), cosine


_CORNERS = "a unit vector"

UNIFORM = Kernel(
    "uniform hemisphere", "direction", _draw_two,
    lambda given: sample_uniform_hemisphere(given["u1"], given["u2"]),
    lambda row: _about_z(*uniform_polar(row["u1"]), row["u2"]),
    {"random numbers": f"{_CORNERS}; cos θ = 0 belongs to the hemisphere"},
)  # fmt: skip

COSINE_WEIGHTED = Kernel(
    "cosine hemisphere", "direction", _draw_two,
    lambda given: sample_cosine_hemisphere(given["u1"], given["u2"]),
    lambda row: _about_z(*cosine_polar(row["u1"]), row["u2"]),
    {"random numbers": f"{_CORNERS}; cos θ > 0, so that 1/pdf ≤ π 2¹²"},
)  # fmt: skip

SPHERE = Kernel(
    "uniform sphere", "", _draw_two,
    lambda given: sample_uniform_sphere(given["u1"], given["u2"]),
    lambda row: _about_z(
        1 - row["u1"] * 2, (row["u1"] * (1 - row["u1"])).sqrt() * 2, row["u2"]
    ),
    {"random numbers": _CORNERS},
)  # fmt: skip


def _draw_cosine(draws: Draws) -> dict[str, Scalars]:
    return {"cosine": draws("cosine")}


UNIFORM_PDF = Kernel(
    "uniform density", "direction", _draw_cosine,
    lambda given: pdf_uniform_hemisphere(given["cosine"]).astype(given["cosine"].dtype),
    lambda row: 1 / literal(2 * EXACT.pi, row["cosine"].type)
    if row["cosine"].value >= 0
    else row["cosine"] * 0,
    {"edge-on": "1/2π at 0, 0 below", "in a corner": "1/2π at 0, 0 below"},
)  # fmt: skip

COSINE_PDF = Kernel(
    "cosine density", "direction", _draw_cosine,
    lambda given: pdf_cosine_hemisphere(given["cosine"]),
    lambda row: row["cosine"] / literal(EXACT.pi, row["cosine"].type)
    if row["cosine"].value > 0
    else row["cosine"] * 0,
    {"edge-on": "0 at 0 and below", "in a corner": "0 at 0 and below"},
)  # fmt: skip


def _run_triangle(given: Inputs) -> Scalars:
    return np.stack(sample_triangle(given["u1"], given["u2"]), axis=1)


def _triangle(row: Row) -> tuple[Exact, Exact]:
    root = row["u1"].sqrt()
    return root * (1 - row["u2"]), root * row["u2"]


TRIANGLE = Kernel(
    "point of a triangle", "", _draw_two, _run_triangle, _triangle,
    {"random numbers": "inside: both at least 0, their sum at most 1"},
)  # fmt: skip


def _draw_visible(draws: Draws) -> dict[str, Scalars]:
    wo = draws.about_z()
    least = float(draws.info.smallest_subnormal)
    wo[:, 2] = np.maximum(np.abs(wo[:, 2]), least)
    return {"wo": wo, "alpha": draws("roughness"), **_draw_two(draws)}


def _run_visible(given: Inputs) -> Vec3s:
    return sample_visible_normal(*(given[name] for name in ("wo", "alpha", "u1", "u2")))


def _unit(v: Vector) -> Vector:
    size = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt()
    return v[0] / size, v[1] / size, v[2] / size


def _not_below_0(x: Exact) -> Exact:
    return Exact(max(x.value, EXACT.mpf(0)), x.error, x.type)


def _visible(row: Row) -> Vector:
    wo, alpha = row["wo"], row["alpha"]
    v = _unit((wo[0] * alpha, wo[1] * alpha, wo[2]))
    root = (v[0] * v[0] + v[1] * v[1]).sqrt()
    t1 = (-v[1] / root, v[0] / root) if root > 0 else (root * 0 + 1, root * 0)
    r, phi = row["u1"].sqrt(), literal(2 * EXACT.pi, alpha.type) * row["u2"]
    p1, p2 = r * phi.cos(), r * phi.sin()
    s = (v[2] + 1) * literal(EXACT.mpf(0.5), alpha.type)
    p2 = (1 - s) * _not_below_0(1 - p1 * p1).sqrt() + s * p2
    p3 = _not_below_0(1 - p1 * p1 - p2 * p2).sqrt()
    x = p1 * t1[0] - p2 * v[2] * t1[1] + p3 * v[0]
    y = p1 * t1[1] + p2 * v[2] * t1[0] + p3 * v[1]
    z = p2 * (v[0] * t1[1] - v[1] * t1[0]) + p3 * v[2]
    return _unit((alpha * x, alpha * y, _not_below_0(z)))


VISIBLE_NORMAL = Kernel(
    "visible microfacet normal", "", _draw_visible, _run_visible, _visible,
    {
        "edge-on": "a unit vector with z ≥ 0",
        "in a corner": "a unit vector with z ≥ 0",
        "smooth": "to +z",
        "random numbers": "a unit vector with z ≥ 0",
    },
)  # fmt: skip

SAMPLING = (
    UNIFORM, COSINE_WEIGHTED, SPHERE, UNIFORM_PDF, COSINE_PDF, TRIANGLE, VISIBLE_NORMAL,
)  # fmt: skip

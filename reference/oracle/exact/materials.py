"""Kernels of microfacets and Fresnel reflectance."""

from functools import partial
from typing import Any

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars, Vec3s
from restir_gi.reference.oracle.exact.draws import Draws
from restir_gi.reference.oracle.exact.kernel import Inputs, Kernel, Row
from restir_gi.reference.oracle.exact.numbers import EXACT, Exact, literal
from restir_gi.reference.oracle.exact.vectors import Vector
from restir_gi.reference.scene.materials.fresnel import (
    fresnel_conductor,
    fresnel_dielectric,
    fresnel_schlick,
)
from restir_gi.reference.scene.materials.microfacet import (
    beckmann_density,
    beckmann_g1,
    ggx_density,
    reflect,
    smith_g1,
)


def _draw_lobe(draws: Draws) -> dict[str, Scalars]:
    return {"cosine": draws("cosine"), "alpha": draws("roughness")}


def _run_density(given: Inputs) -> Scalars:
    return ggx_density(given["cosine"], given["alpha"])


def _density(row: Row) -> Any:
    cosine, alpha = row["cosine"], row["alpha"]
    if cosine.value <= 0:
        return cosine * 0
    t = (alpha * alpha - 1) * cosine * cosine + 1
    return alpha * alpha / (literal(EXACT.pi, t.type) * t * t)


_SMOOTH = "finite for α > 0; the peak 1/(π α²) loses the digits that 1 − cos² has lost"

DENSITY = Kernel(
    "GGX density D", "", _draw_lobe, _run_density, _density,
    {"edge-on": "0 below the surface", "smooth": _SMOOTH, "in a corner": "as edge-on"},
)  # fmt: skip


def _run_masking(given: Inputs) -> Scalars:
    return smith_g1(given["cosine"], given["alpha"])


def _masking(row: Row) -> Any:
    cosine, alpha = row["cosine"], row["alpha"]
    if cosine.value <= 0:
        return cosine * 0
    tan2 = (1 - cosine * cosine) * alpha * alpha
    return cosine * 2 / (cosine + (cosine * cosine + tan2).sqrt())


MASKING = Kernel(
    "Smith masking G1", "", _draw_lobe, _run_masking, _masking,
    {
        "edge-on": "0 below the surface, and to 2 cos / α above it",
        "smooth": "to 1",
        "in a corner": "as edge-on",
    },
)  # fmt: skip


def _run_beckmann(given: Inputs) -> Scalars:
    return beckmann_density(given["cosine"], given["alpha"])


def _beckmann(row: Row) -> Any:
    cosine, alpha = row["cosine"], row["alpha"]
    if cosine.value <= 0:
        return cosine * 0
    cos2 = cosine * cosine
    width = alpha * alpha * cos2
    exponent = (1 - cos2) / width
    return (-exponent).exp() / (literal(EXACT.pi, width.type) * width * cos2)


BECKMANN_DENSITY = Kernel(
    "Beckmann density D", "", _draw_lobe, _run_beckmann, _beckmann,
    {
        "edge-on": "0 below the surface, and to 0 above it",
        "smooth": "finite for α > 0; 0 where α² is too small for the type",
        "in a corner": "as edge-on",
    },
)  # fmt: skip


def _run_beckmann_masking(given: Inputs) -> Scalars:
    return beckmann_g1(given["cosine"], given["alpha"])


def _beckmann_masking(row: Row) -> Any:
    cosine, alpha = row["cosine"], row["alpha"]
    if cosine.value <= 0:
        return cosine * 0
    number = partial(literal, type_=cosine.type)
    spread = alpha * (1 - cosine * cosine).sqrt()
    if cosine >= number(EXACT.mpf(1.6)) * spread:
        return cosine * 0 + 1
    a = cosine / spread
    above = a * (a * number(2.181) + number(3.535))
    fit = above / (a * (a * number(2.577) + number(2.276)) + 1)
    return fit if fit.value < 1 else cosine * 0 + 1


BECKMANN_MASKING = Kernel(
    "Smith masking G1, Beckmann", "", _draw_lobe, _run_beckmann_masking,
    _beckmann_masking,
    {
        "edge-on": "0 below the surface, and to 3.535 cos / α above it",
        "smooth": "to 1",
        "in a corner": "as edge-on",
    },
)  # fmt: skip


def _draw_mirror(draws: Draws) -> dict[str, Scalars]:
    h = draws.unit()
    return {"wo": draws.leaning(h), "h": h}


def _mirrored(row: Row) -> Vector:
    wo, h = row["wo"], row["h"]
    twice = (wo[0] * h[0] + wo[1] * h[1] + wo[2] * h[2]) * 2
    return twice * h[0] - wo[0], twice * h[1] - wo[1], twice * h[2] - wo[2]


MIRROR = Kernel(
    "mirror image", "", _draw_mirror,
    lambda given: reflect(given["wo"], given["h"]), _mirrored,
    {
        "edge-on": "−ω, turned by twice the angle to the plane",
        "in a corner": "as edge-on",
    },
)  # fmt: skip

# ------------------------------------------------------------------ Fresnel


def _draw_boundary(draws: Draws) -> dict[str, Scalars]:
    return {"cosine": np.minimum(abs(draws("cosine")), 1.0), "eta": draws("index")}


def _run_dielectric(given: Inputs) -> Scalars:
    return fresnel_dielectric(given["cosine"], given["eta"])[0]


def _squared_ratio(difference: Exact, total: Exact) -> Exact:
    if total.value == 0 and total.error == 0:
        return total + 1
    ratio = difference / total
    return ratio * ratio


def _dielectric(row: Row) -> Any:
    cosine, eta = row["cosine"], row["eta"]
    cos2_t = 1 - (1 - cosine * cosine) / (eta * eta)
    if cos2_t <= 0:
        return cosine * 0 + 1
    cos_t = cos2_t.sqrt()
    parallel = _squared_ratio(eta * cosine - cos_t, eta * cosine + cos_t)
    perpendicular = _squared_ratio(cosine - eta * cos_t, cosine + eta * cos_t)
    return (parallel + perpendicular) * literal(EXACT.mpf(0.5), cosine.type)


DIELECTRIC = Kernel(
    "Fresnel, clear medium", "", _draw_boundary, _run_dielectric, _dielectric,
    {
        "edge-on": "to 1",
        "in a corner": "to 1",
        "index of refraction": "0 to 1; 1 under total reflection",
    },
)  # fmt: skip


def _draw_metal(draws: Draws) -> dict[str, Scalars]:
    return _draw_boundary(draws) | {"k": draws("index")}


def _run_conductor(given: Inputs) -> Scalars:
    cosine = given["cosine"]
    wide = [given[name][:, None] for name in ("eta", "k")]
    return fresnel_conductor(cosine, *wide)[:, 0]


def _conductor(row: Row) -> Any:
    cosine, eta, k = row["cosine"], row["eta"], row["k"]
    cos2, sin2 = cosine * cosine, 1 - cosine * cosine
    real = eta * eta - k * k - sin2
    size = (real * real + eta * 4 * eta * k * k).sqrt()
    half = literal(EXACT.mpf(0.5), cosine.type)
    a = ((size + real) * half).sqrt()
    sum_s, twice = size + cos2, a * 2 * cosine
    perpendicular = (sum_s - twice) / (sum_s + twice)
    sum_p, cross = size * cos2 + sin2 * sin2, twice * sin2
    parallel = perpendicular * ((sum_p - cross) / (sum_p + cross))
    return (perpendicular + parallel) * half


CONDUCTOR = Kernel(
    "Fresnel, metal", "", _draw_metal, _run_conductor, _conductor,
    {"edge-on": "to 1", "in a corner": "to 1", "index of refraction": "0 to 1"},
)  # fmt: skip


def _draw_schlick(draws: Draws) -> dict[str, Scalars]:
    return {"cosine": np.minimum(abs(draws("cosine")), 1.0), "f0": draws("albedo")}


def _run_schlick(given: Inputs) -> Vec3s:
    return fresnel_schlick(given["cosine"], given["f0"][:, None])[:, 0]


def _schlick(row: Row) -> Any:
    beside = 1 - row["cosine"]
    fifth = beside * beside * beside * beside * beside
    return row["f0"] + (1 - row["f0"]) * fifth


SCHLICK = Kernel(
    "Fresnel, Schlick's fit", "", _draw_schlick, _run_schlick, _schlick,
    {"edge-on": "to 1", "in a corner": "to 1", "black and white": "(1 − cos)⁵, and 1"},
)  # fmt: skip

MATERIALS = (
    DENSITY, MASKING, BECKMANN_DENSITY, BECKMANN_MASKING, MIRROR, DIELECTRIC, CONDUCTOR,
    SCHLICK,
)  # fmt: skip

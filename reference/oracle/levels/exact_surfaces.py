"""Declared surfaces in exact numbers, from the contract's words alone."""

from typing import Any

from restir_gi.reference.oracle.contract.fields import Value
from restir_gi.reference.oracle.contract.surfaces import GGX, NODES
from restir_gi.reference.oracle.exact.kernel import Row
from restir_gi.reference.oracle.exact.materials import (
    DENSITY,
    DIELECTRIC,
    MASKING,
    SCHLICK,
)
from restir_gi.reference.oracle.exact.numbers import EXACT, Exact, exact, literal
from restir_gi.reference.oracle.exact.targets import luminance_of, way_to_sample
from restir_gi.reference.oracle.exact.vectors import Vector, inner


def surface_reflected(row: Row, surface: Value) -> Vector:
    """Integrand f cos θ L_o of a row on a declared surface, channel by channel."""
    way, along, lit = way_to_sample(row)
    n, v, light = row["visible_normal"], row["view"], row["radiance"]
    cos_o = inner(n, v)
    if not (lit and cos_o > 0):
        return along * 0, along * 0, along * 0
    omega = _unit(way)
    cos_i, half = inner(n, omega), _unit(_plus(v, omega))
    cos_h, cos_d = inner(n, half), inner(omega, half)
    lobe = _of(DENSITY, cosine=cos_h, alpha=row["alpha"])
    for cosine in (cos_i, cos_o):
        lobe = lobe * _of(MASKING, cosine=cosine, alpha=row["alpha"])
    lobe = lobe / (cos_i * cos_o * 4)
    scatters = _ggx if surface == GGX else _coated
    f = scatters(row, cos_i, cos_o, cos_d, lobe)
    return tuple(f[k] * cos_i * light[k] for k in range(3))


def surface_target(row: Row, surface: Value) -> Exact:
    """Luminance of the integrand, Equation 9."""
    return luminance_of(surface_reflected(row, surface))


def _ggx(row: Row, cos_i: Exact, cos_o: Exact, cos_d: Exact, lobe: Exact) -> Vector:
    pi = literal(EXACT.pi, cos_d.type)
    return tuple(
        row["albedo"][k] / pi + _of(SCHLICK, cosine=cos_d, f0=row["f0"][k]) * lobe
        for k in range(3)
    )


def _coated(row: Row, cos_i: Exact, cos_o: Exact, cos_d: Exact, lobe: Exact) -> Vector:
    eta, K = row["ior"], row["internal_reflectance"]
    F = _of(DIELECTRIC, cosine=cos_d, eta=eta)
    through = _interpolated(row["transmittance"], cos_i)
    through = through * _interpolated(row["transmittance"], cos_o)
    through = through / (literal(EXACT.pi, eta.type) * eta * eta)
    one = exact(1, eta.type)
    colored = row["nonlinear"] > 0
    return tuple(
        through * a / (1 - K * (a if colored else one)) + F * lobe
        for a in row["albedo"]
    )


def _interpolated(table: tuple[Exact, ...], cosine: Exact) -> Exact:
    """Linear between the nodes; a cosine that its unit vectors make larger is 1."""
    place = cosine * (NODES - 1)
    left = min(int(place.value), NODES - 2)
    if place > NODES - 1:
        return table[-1]
    return table[left] + (place - left) * (table[left + 1] - table[left])


def _of(kernel: Any, **numbers: Exact) -> Exact:
    found: Exact = kernel.formula(numbers)
    return found


def _plus(a: Vector, b: Vector) -> Vector:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def _unit(a: Vector) -> Vector:
    length = inner(a, a).sqrt()
    return a[0] / length, a[1] / length, a[2] / length

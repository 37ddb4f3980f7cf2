"""Declared surfaces: closed forms, other formulas in 60 digits, and white furnaces."""

from fractions import Fraction
from math import isqrt

import mpmath
import numpy as np
import pytest

from restir_gi.reference.oracle.builtin.backend import FLOAT64
from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.contract.surfaces import NODES
from restir_gi.reference.oracle.levels.exact import exact_outputs
from restir_gi.reference.oracle.levels.surfaces import surface_kernel_probes
from restir_gi.reference.scene.materials.coat import (
    internal_reflectance,
    transmittance_table,
)

PI = Fraction("3.14159265358979323846264338327950288419716939937510582")
DIGITS = 10**60

UP, AT_45, LEFT, RIGHT = (0, 1, 0), (1, 1, 0), (-0.75, 1, 0), (0.75, 1, 0)
"""Of the last two each is the mirror image of the other, at 3 : 4 : 5."""


def root(x):
    """Square root of a rational to 60 digits."""
    return Fraction(isqrt(x.numerator * DIGITS**2 // x.denominator), DIGITS)


def unit(a):
    a = np.asarray(a, float)
    return a / np.linalg.norm(a, axis=-1, keepdims=True)


def shaded(surface, to, view, radiance=(1, 1, 1), **material):
    """Case of pass shade about the origin, with W = 1; a row for each direction.

    Parameters
    ----------
    to, view : (N, 3); to the sample, of any length, and to the eye
    """
    to, rows = np.asarray(to, float), len(to)
    inputs = {
        "visible_position": np.zeros((rows, 3)),
        "visible_normal": np.tile([0.0, 1.0, 0.0], (rows, 1)),
        "view": np.broadcast_to(np.asarray(view, float), to.shape),
        "position": to,
        "normal": -to,
        "radiance": np.tile(np.asarray(radiance, float), (rows, 1)),
        "W": np.ones(rows),
    }
    for name, value in material.items():
        value = np.asarray(value)
        kind = np.uint32 if name == "nonlinear" else float
        inputs[name] = np.tile(value.astype(kind), (rows,) + (1,) * value.ndim)
    return Case("by-hand", "shade", {"surface": surface}, inputs)


def exactly(*args, **material):
    """Colours in exact numbers."""
    return exact_outputs(shaded(*args, **material))["color"]


COAT = {
    "alpha": 0.5,
    "ior": 2.0,
    "internal_reflectance": 0.25,
    "transmittance": np.linspace(0.5, 0.75, NODES),
    "nonlinear": 0,
}
GGX = {"alpha": 0.5, "f0": (0.5, 0.25, 0.0)}
ALBEDO = (0.5, 0.0, 1.0)


# ---------------------------------------------------------------- closed forms


def nearest(values):
    return [float(v) for v in values]


def test_at_normal_incidence_the_lobe_is_a_quarter_of_its_peak():
    """All cosines are 1: D is 1 / (π α²), there is no masking, and F is F₀."""
    for alpha in (Fraction(1, 2), Fraction(1), Fraction(1, 64)):
        found = exactly("ggx", [UP], [UP], albedo=ALBEDO, **GGX | {"alpha": alpha})
        lobe = 1 / (4 * PI * alpha**2)
        parts = zip(ALBEDO, GGX["f0"], strict=True)
        wanted = (Fraction(a) / PI + Fraction(f) * lobe for a, f in parts)
        assert found[0].tolist() == nearest(wanted)


C = Fraction(4, 5)
G1 = 2 * C / (C + root(Fraction(16, 25) + Fraction(1, 4) * Fraction(9, 25)))
RATIONAL = (LEFT[0] * 4 / 5, 0.8, 0.0)
"""What stands for a unit vector: LEFT over 5/4, to the last bit of double precision."""


def test_a_mirror_meets_the_peak_at_any_angle():
    """The half vector is the normal, to a rounding of the view: F is at 3 : 4 : 5."""
    found = exactly("ggx", [RIGHT], [RATIONAL], albedo=ALBEDO, **GGX)
    lobe = 1 / (PI * Fraction(1, 4)) * G1 * G1 / (4 * C * C)
    wanted = []
    for a, f0 in zip(ALBEDO, GGX["f0"], strict=True):
        F = Fraction(f0) + (1 - Fraction(f0)) * Fraction(1, 5) ** 5
        wanted.append(float((Fraction(a) / PI + F * lobe) * C))
    assert found[0] == pytest.approx(wanted, rel=1e-15)


def test_towards_the_eye_the_facet_is_seen_head_on():
    """ω = v: the half vector is both, F is F₀, and D is that of 3 : 4 : 5."""
    found = exactly("ggx", [LEFT], [RATIONAL], albedo=ALBEDO, **GGX)
    t = 1 - Fraction(3, 4) * C * C
    lobe = Fraction(1, 4) / (PI * t * t) * G1 * G1 / (4 * C * C)
    wanted = [
        float((Fraction(a) / PI + Fraction(f) * lobe) * C)
        for a, f in zip(ALBEDO, GGX["f0"], strict=True)
    ]
    assert found[0] == pytest.approx(wanted, rel=1e-15)


def test_a_coat_at_normal_incidence():
    """F is ((η − 1) / (η + 1))², and T that of the last node."""
    for nonlinear in (0, 1):
        coat = COAT | {"nonlinear": nonlinear}
        found = exactly("coated", [UP], [UP], albedo=ALBEDO, **coat)
        lobe = Fraction(1, 9) / (4 * PI * Fraction(1, 4))
        wanted = []
        for a in map(Fraction, ALBEDO):
            kept = 1 - Fraction(1, 4) * (a if nonlinear else 1)
            wanted.append(Fraction(9, 16) / (4 * PI) * a / kept + lobe)
        assert found[0].tolist() == nearest(wanted)


def test_no_coat_is_lambertian():
    """An index of 1 reflects nothing and lets all pass."""
    coat = {"ior": 1, "internal_reflectance": 0, "transmittance": np.ones(NODES)}
    found = exactly("coated", [RIGHT, AT_45], [UP] * 2, albedo=ALBEDO, **COAT | coat)
    for color, c in zip(found, (C, root(Fraction(1, 2))), strict=True):
        # F is the square of what is left of a root in 50 digits.
        wanted = nearest(Fraction(a) / PI * c for a in ALBEDO)
        assert color.tolist() == pytest.approx(wanted, rel=1e-16, abs=1e-99)


def test_below_either_horizon_there_is_nothing():
    below = (3, -1, 0)
    for surface, material in (("ggx", GGX), ("coated", COAT)):
        for to, view in ((below, UP), (UP, unit(below)), (UP, (1, 0, 0))):
            assert not exactly(surface, [to], [view], albedo=ALBEDO, **material).any()


# ---------------------------------------------------------------- other formulas


def plainly(row):
    """Colours with Smith's Λ, a density by its tangent, and Walter's Fresnel."""
    mp = mpmath.MPContext()
    mp.dps = 60
    given = {
        k: mp.matrix(v) if np.ndim(v) else mp.mpf(float(v)) for k, v in row.items()
    }

    def dot(a, b):
        return sum(a[k] * b[k] for k in range(3))

    def unit(a):
        return a / mp.sqrt(dot(a, a))

    n, v, a = given["visible_normal"], given["view"], given["alpha"]
    w = unit(given["position"] - given["visible_position"])
    h = unit(v + w)
    i, o, c, d = dot(n, w), dot(n, v), dot(n, h), dot(w, h)
    if i <= 0 or o <= 0 or dot(given["normal"], w) >= 0:
        return [0.0] * 3

    def hidden(cosine):
        return (mp.sqrt(1 + a**2 * (1 - cosine**2) / cosine**2) - 1) / 2

    tan2 = (1 - c**2) / c**2
    D = a**2 / (mp.pi * c**4 * (a**2 + tan2) ** 2)
    lobe = D / ((1 + hidden(i)) * (1 + hidden(o))) / (4 * i * o)
    f = []
    for k in range(3):
        albedo = given["albedo"][k]
        if "f0" in given:
            F = 1 - (1 - given["f0"][k]) * (1 - (1 - d) ** 5)
            f.append(albedo / mp.pi + F * lobe)
            continue
        eta, K, T = given["ior"], given["internal_reflectance"], given["transmittance"]
        g = mp.sqrt(eta**2 - 1 + d**2)
        F = ((g - d) / (g + d)) ** 2 / 2
        F *= 1 + ((d * (g + d) - 1) / (d * (g - d) + 1)) ** 2
        nodes = [k / mp.mpf(NODES - 1) for k in range(NODES)]
        hat = [
            [max(mp.zero, 1 - abs(x - node) * (NODES - 1)) for node in nodes]
            for x in (min(i, mp.one), min(o, mp.one))
        ]
        through = [sum(w * t for w, t in zip(one, T, strict=True)) for one in hat]
        # The series of bounces, in as many terms as 60 digits take.
        again = K * (albedo if given["nonlinear"] else 1)
        series = sum(again**bounce for bounce in range(700))
        f.append(
            through[0] * through[1] / (mp.pi * eta**2) * albedo * series + F * lobe
        )
    return [float(f[k] * i * given["radiance"][k] * given["W"]) for k in range(3)]


@pytest.mark.parametrize("surface", ["ggx", "coated"])
def test_other_formulas_give_the_same(surface):
    case = next(
        p.case
        for p in surface_kernel_probes("float64")
        if p.case.pass_name == "shade" and p.case.settings["surface"] == surface
    )
    found, rows = exact_outputs(case)["color"], range(0, case.rows, 9)
    wanted = [plainly({k: a[r] for k, a in case.inputs.items()}) for r in rows]
    lit = np.any(wanted, axis=1)
    assert lit.sum() > 5
    # Each was rounded once.
    np.testing.assert_allclose(found[rows.start : rows.stop : rows.step], wanted, 3e-16)


def test_light_goes_both_ways():
    """f(v, ω) = f(ω, v): over the cosines both colours are the same."""
    rng = np.random.default_rng(3)
    v, w = (unit(rng.normal(size=(64, 3))) for _ in range(2))
    v[:, 1], w[:, 1] = abs(v[:, 1]), abs(w[:, 1])
    for surface, material in (("ggx", GGX), ("coated", COAT)):
        there, back = (
            exactly(surface, a, b, albedo=ALBEDO, **material) / a[:, 1:2]
            for a, b in ((w, v), (v, w))
        )
        np.testing.assert_allclose(there, back, rtol=1e-13)


# ---------------------------------------------------------------- white furnaces


SETTLED = 3e-4
"""Of the sums over directions and over facets, at all widths and views below."""


def hemisphere(cosines, turns):
    """Directions and their solid angles: Gauss points of the angle, even turns."""
    x, weight = np.polynomial.legendre.leggauss(cosines)
    theta = np.pi / 4 * (x + 1)
    phi = 2 * np.pi * (np.arange(turns) + 0.5) / turns
    t, p = (a.ravel() for a in np.meshgrid(theta, phi, indexing="ij"))
    omega = np.stack([np.sin(t) * np.cos(p), np.cos(t), np.sin(t) * np.sin(p)], axis=1)
    area = np.repeat(weight * np.pi / 4 * np.sin(theta), turns) * 2 * np.pi / turns
    return omega, area


def furnace(surface, view, cosines=96, turns=192, **material):
    """Light that a point shows under an even sky of radiance 1, by the own pass."""
    omega, area = hemisphere(cosines, turns)
    case = shaded(surface, omega, view, **material)
    color = FLOAT64.shade(**case.inputs, **case.settings)["color"]
    return (color * area[:, None]).sum(axis=0)


def shown_by_facets(view, alpha, cells=512):
    """The same of a lobe with F = 1, summed over the facets that are seen.

    Slopes are drawn from P₂₂ on even cells of the unit square; each facet counts with
    the area that it shows, mirrors the view, and is shadowed.
    """
    u, v = ((np.arange(cells) + 0.5) / cells for _ in range(2))
    u, v = (a.ravel() for a in np.meshgrid(u, v))
    slope = alpha * np.sqrt(u / (1 - u))
    x, z = slope * np.cos(2 * np.pi * v), slope * np.sin(2 * np.pi * v)
    facet = unit(np.stack([-x, np.ones_like(x), -z], axis=1))
    along = facet @ view
    mirrored = 2 * along[:, None] * facet - view

    def shadowed(c):
        tangent2 = 1 / np.maximum(c, 1e-9) ** 2 - 1
        return np.where(c > 0, 2 / (1 + np.sqrt(1 + alpha**2 * tangent2)), 0.0)

    area = np.maximum(along, 0) / facet[:, 1] / view[1]
    return np.mean(area * shadowed(view[1]) * shadowed(mirrored[:, 1]))


@pytest.mark.parametrize("alpha", [0.3, 0.6, 1.0])
@pytest.mark.parametrize("tilt", [0.0, 0.7, 1.2])
def test_a_white_lobe_shows_what_its_facets_mirror(alpha, tilt):
    """Both sums have settled: half the points in each direction change them by 3e-4.

    A mistake in the lobe changes it by more than thirty times that.
    """
    view = np.array([np.sin(tilt), np.cos(tilt), 0.0])
    white = {"albedo": (0, 0, 0), "f0": (1, 1, 1), "alpha": alpha}
    found = furnace("ggx", view, **white)
    truth = shown_by_facets(view, alpha)
    assert found == pytest.approx([truth] * 3, abs=SETTLED)
    coarse = furnace("ggx", view, 48, 96, **white)
    assert coarse == pytest.approx(found, abs=SETTLED)
    assert shown_by_facets(view, alpha, 256) == pytest.approx(truth, abs=SETTLED)
    assert truth < 1


def test_a_diffuse_part_shows_its_albedo():
    found = furnace("ggx", UP, albedo=ALBEDO, **GGX)
    lobe = furnace("ggx", UP, albedo=(0, 0, 0), **GGX)
    assert found - lobe == pytest.approx(ALBEDO, abs=1e-9)


@pytest.mark.parametrize("tilt", [0.0, 0.5, 1.0])
def test_a_white_base_gives_back_all_that_passes_a_smooth_coat(tilt):
    """Whatever enters leaves again, after some bounces: it shows T(cos_o).

    By the coat's own K.  T is linear between its cosines, and rises from 0 to 0.93 like
    a root: so its mean, weighted with the cosine, is 4e-4 too small.
    """
    view = np.array([np.sin(tilt), np.cos(tilt), 0.0])
    coat = COAT | {
        "ior": 1.5,
        "internal_reflectance": internal_reflectance(0.0, 1.5),
        "transmittance": transmittance_table(0.0, 1.5),
    }
    white, black = (
        furnace("coated", view, albedo=(a, a, a), **coat) for a in (1.0, 0.0)
    )
    passes = np.interp(view[1], np.linspace(0, 1, NODES), coat["transmittance"])
    assert white - black == pytest.approx([passes] * 3, abs=1e-3)


@pytest.mark.parametrize(
    ("name", "changed"),
    [
        ("f0", {"f0": (0.9, 0.9, 0.9)}),
        ("alpha", {"alpha": 0.55}),
        ("alpha squared", {"alpha": 0.36}),
    ],
)
def test_control_a_furnace_sees_other_lobes(name, changed):
    view = np.array([np.sin(1.2), np.cos(1.2), 0.0])
    white = {"albedo": (0, 0, 0), "f0": (1, 1, 1), "alpha": 0.6}
    found = furnace("ggx", view, **white | changed)
    assert abs(found[0] - shown_by_facets(view, 0.6)) > 1e-2

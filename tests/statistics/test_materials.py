"""Draws of materials follow the densities that the materials state: χ² on the sphere.

The sphere is cut into 40 x 24 cells of (cos θ, φ), and one cell more takes the draws
that reflect nothing.  What a cell should hold is the density, integrated by
20 x 20 Gauss points; cells that expect fewer than 10 draws are pooled.  The numbers are
those of fixed keys, so each test passes or fails for ever: with ideal numbers one of
all would fail with probability 1e-5, by Šidák's rule [Sidak67].

Power: 2^17 draws find a width that is off by 5 % where alpha is 0.3, and a lobe that is
drawn in 4 % of the cases too often (the controls).
"""

import numpy as np
import pytest
from scipy.stats import chi2

from restir_gi.reference.numerics.records import take
from restir_gi.reference.numerics.rng import KeyedUniforms, Stream
from restir_gi.reference.scene.materials import bsdf_sampling, table
from restir_gi.reference.scene.materials.coated import coat_probability
from restir_gi.reference.scene.materials.kinds import (
    Coated,
    Conductor,
    Dielectric,
    Lambertian,
)
from restir_gi.reference.scene.materials.parameters import tabulate
from restir_gi.reference.scene.surface import SurfacePoints

DRAWS = 2**17
HEIGHTS, AZIMUTHS, ORDER = 40, 24, 20
GREY = (0.6, 0.6, 0.6)

MATERIALS = [
    Lambertian(GREY),
    Conductor(GREY, 0.15),
    Conductor(GREY, 0.3),
    Conductor(GREY, 0.8),
    Coated(GREY, 0.3),
    Coated(GREY, 0.6, ior=1.8, nonlinear=True),
    Coated(GREY, 0.0),
    Conductor(GREY, 0.3, distribution="beckmann"),
    Coated(GREY, 0.6, distribution="beckmann"),
    Dielectric(1.5, 0.4),
    Dielectric(1.0 / 1.5, 0.3, "beckmann"),
]
COSINES = [0.2, 0.6, 0.95]
TESTS = len(MATERIALS) * len(COSINES)
RATE = 1e-5
EACH = 1 - (1 - RATE) ** (1 / TESTS)


def point(material, cos_o):
    """One point with normal z, seen under a cosine and 0.7 radians from the x axis."""
    materials = tabulate([material])
    sin_o = np.sqrt(1 - cos_o**2)
    wo = np.array([[sin_o * np.cos(0.7), sin_o * np.sin(0.7), cos_o]])
    z, zero = np.array([[0.0, 0.0, 1.0]]), np.zeros(1, np.int32)
    points = SurfacePoints(
        np.zeros((1, 3)), z, None, wo, materials.color, zero, zero, np.ones(1, bool)
    )
    return materials, points


def rows_of(points, rows):
    return take(points, np.zeros(rows, np.int64))


def observed(materials, points):
    """Draws in each cell; those that reflect nothing in the last one."""
    u = KeyedUniforms(np.arange(DRAWS, dtype=np.uint32), 3, 1, Stream.INITIAL).draw(2)
    drawn = bsdf_sampling.sample(materials, rows_of(points, DRAWS), u)
    wi = drawn.wi
    height = np.clip(np.floor((wi[:, 2] + 1) / 2 * HEIGHTS), 0, HEIGHTS - 1).astype(int)
    turns = np.arctan2(wi[:, 1], wi[:, 0]) / (2 * np.pi) % 1.0
    azimuth = np.minimum(np.floor(turns * AZIMUTHS), AZIMUTHS - 1).astype(int)
    cell = np.where(drawn.pdf > 0, height * AZIMUTHS + azimuth, HEIGHTS * AZIMUTHS)
    return np.bincount(cell, minlength=HEIGHTS * AZIMUTHS + 1)


def expected(materials, points):
    """Draws that each cell should hold, by the stated density."""
    nodes, weights = np.polynomial.legendre.leggauss(ORDER)

    def split(cells, length):
        places = (np.arange(cells)[:, None] + (nodes + 1) / 2) / cells * length
        return places.ravel(), np.tile(weights / 2 / cells * length, cells)

    height, d_cos = split(HEIGHTS, 2.0)
    phi, d_phi = split(AZIMUTHS, 2 * np.pi)
    c, f = (grid.ravel() for grid in np.meshgrid(height - 1, phi, indexing="ij"))
    s = np.sqrt(1 - c * c)
    wi = np.stack([s * np.cos(f), s * np.sin(f), c], axis=-1)
    mass = table.pdf(materials, rows_of(points, len(wi)), wi)
    mass = mass * np.outer(d_cos, d_phi).ravel()
    cells = mass.reshape(HEIGHTS, ORDER, AZIMUTHS, ORDER).sum(axis=(1, 3)).ravel()
    return DRAWS * np.append(cells, 1 - cells.sum())


def chi_square(found, due):
    """p-value, cells with little to expect pooled into one."""
    small = due < 10
    found = np.append(found[~small], found[small].sum())
    due = np.append(due[~small], due[small].sum())
    if due[-1] < 10:
        found[-2], due[-2] = found[-2] + found[-1], due[-2] + due[-1]
        found, due = found[:-1], due[:-1]
    return chi2.sf(np.sum((found - due) ** 2 / due), len(due) - 1)


@pytest.mark.parametrize("cos_o", COSINES)
@pytest.mark.parametrize("material", MATERIALS, ids=repr)
def test_draws_follow_their_density(material, cos_o):
    materials, points = point(material, cos_o)
    due = expected(materials, points)
    # The cells' integrals: what is missing to 1 is lost or on a delta lobe.
    assert due[-1] >= -1e-3 * DRAWS
    due = np.maximum(due, 0)
    assert chi_square(observed(materials, points), due) > EACH


def test_every_draw_is_counted():
    materials, points = point(MATERIALS[1], 0.2)
    assert observed(materials, points).sum() == DRAWS
    assert expected(materials, points).sum() == pytest.approx(DRAWS)


@pytest.mark.parametrize("cos_o", COSINES)
def test_control_a_width_off_by_5_percent_is_found(cos_o):
    found = observed(*point(Conductor(GREY, 0.3), cos_o))
    due = expected(*point(Conductor(GREY, 0.315), cos_o))
    assert chi_square(found, np.maximum(due, 0)) < EACH


def test_control_a_lobe_drawn_too_often_is_found():
    """Coats whose base is a little brighter are drawn from a little less."""
    found = observed(*point(Coated(GREY, 0.3), 0.6))
    due = expected(*point(Coated((0.9, 0.9, 0.9), 0.3), 0.6))
    assert chi_square(found, np.maximum(due, 0)) < EACH
    # The probability of the coat, from reflectances 0.6 and 0.9.
    shares = [
        coat_probability(*point(Coated((c, c, c), 0.3), 0.6))[0] for c in (0.6, 0.9)
    ]
    assert 0.03 < shares[0] - shares[1] < 0.05

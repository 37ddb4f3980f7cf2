"""GGX microfacets: density, separable Smith masking, visible normals."""

import numpy as np

from reference.arrays import Scalars, Vec3s, normalize, vectors


def ggx_density(cos_h: Scalars, alpha: Scalars) -> Scalars:
    """Density D of microfacet normals, ∫ D cos θ dω = 1.

    Parameters
    ----------
    cos_h : (N,) float
        Cosine of the microfacet normal with the surface normal.
    alpha : (N,) float
        Width; positive.

    Returns
    -------
    (N,) float, 1/sr
        0 for normals below the surface.

    Notes
    -----
    [Walter07, Eq. 33], written without a tangent: (1 - cos²) is computed from the
    cosine, so that alpha below 1e-3 loses digits at the peak.
    """
    t = 1.0 + (alpha * alpha - 1.0) * cos_h * cos_h
    density: Scalars = np.where(cos_h > 0, alpha * alpha / (np.pi * t * t), 0.0)
    return density


def smith_g1(cos: Scalars, alpha: Scalars) -> Scalars:
    """Share G1 of microfacets that a direction sees.

    Parameters
    ----------
    cos : (N,) float
        Cosine of the direction with the surface normal.
    alpha : (N,) float
        Width.

    Returns
    -------
    (N,) float
        0 to 1; 0 below the surface.

    Notes
    -----
    [Walter07, Eq. 34].  Masking and shadowing are taken as independent, G1 · G1.
    """
    cos = np.maximum(cos, 0.0)
    tan2 = (1.0 - cos * cos) * alpha * alpha
    denominator = cos + np.sqrt(cos * cos + tan2)
    g1: Scalars = np.divide(
        2.0 * cos, denominator, out=np.zeros_like(cos), where=cos > 0
    )
    return g1


def sample_visible_normal(wo: Vec3s, alpha: Scalars, u1: Scalars, u2: Scalars) -> Vec3s:
    """Microfacet normals with density G1(wo) max(0, wo·h) D(h) / cos θ_o.

    Parameters
    ----------
    wo : (N, 3) float
        Unit directions in the frame of the surface, z > 0.
    alpha : (N,) float
        Width.
    u1, u2 : (N,) float
        In [0, 1).

    Returns
    -------
    (N, 3) float
        Unit vectors with z >= 0.

    Notes
    -----
    [Heitz18, Listing 1].
    """
    # Stretch the view, so that the microfacets are those of a hemisphere.
    v = normalize(wo * vectors(alpha, alpha, np.ones_like(alpha)))
    flat = v[:, 0] ** 2 + v[:, 1] ** 2
    root = np.sqrt(flat)
    safe = np.where(root > 0, root, 1.0)
    t1_x = np.where(root > 0, -v[:, 1] / safe, 1.0)
    t1_y = np.where(root > 0, v[:, 0] / safe, 0.0)
    # Sample the projected half disks.
    r, phi = np.sqrt(u1), 2.0 * np.pi * u2
    p1, p2 = r * np.cos(phi), r * np.sin(phi)
    s = 0.5 * (1.0 + v[:, 2])
    p2 = (1.0 - s) * np.sqrt(np.maximum(1.0 - p1 * p1, 0.0)) + s * p2
    p3 = np.sqrt(np.maximum(1.0 - p1 * p1 - p2 * p2, 0.0))
    # Lift to the hemisphere about v (t2 = v × t1) and unstretch.
    x = p1 * t1_x - p2 * v[:, 2] * t1_y + p3 * v[:, 0]
    y = p1 * t1_y + p2 * v[:, 2] * t1_x + p3 * v[:, 1]
    z = p2 * (v[:, 0] * t1_y - v[:, 1] * t1_x) + p3 * v[:, 2]
    return normalize(vectors(alpha * x, alpha * y, np.maximum(z, 0.0)))


def reflect(wo: Vec3s, h: Vec3s) -> Vec3s:
    """Mirror image 2 (wo·h) h - wo of a direction about a normal.

    Parameters
    ----------
    wo, h : (N, 3) float
        Unit vectors.

    Returns
    -------
    (N, 3) float
        Unit vectors.
    """
    cosine = wo[:, 0] * h[:, 0] + wo[:, 1] * h[:, 1] + wo[:, 2] * h[:, 2]
    mirrored: Vec3s = (2.0 * cosine)[:, None] * h - wo
    return mirrored

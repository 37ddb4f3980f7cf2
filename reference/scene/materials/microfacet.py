"""GGX and Beckmann microfacets: density, separable Smith masking, samplers."""

import numpy as np

from restir_gi.reference.numerics.arrays import (
    Scalars,
    Vec3s,
    divide_or_zero,
    normalize,
    saturate,
    vectors,
)
from restir_gi.reference.numerics.sampling import left_of


def ggx_density(cos_h: Scalars, alpha: Scalars) -> Scalars:
    """Density D of microfacet normals, ∫ D cos θ dω = 1.

    [Walter07, Eq. 33], written without a tangent: (1 - cos²) is computed from the
    cosine, so that alpha below 1e-3 loses digits at the peak.

    Parameters
    ----------
    cos_h : (N,) float; cosine of the microfacet normal with the surface normal
    alpha : (N,) float; width; positive

    Returns
    -------
    (N,) float, 1/sr; 0 for normals below the surface
    """
    t = 1.0 + (alpha * alpha - 1.0) * cos_h * cos_h
    density: Scalars = np.where(cos_h > 0, alpha * alpha / (np.pi * t * t), 0.0)
    return density


def smith_g1(cos: Scalars, alpha: Scalars) -> Scalars:
    """Share G1 of microfacets that a direction sees.

    [Walter07, Eq. 34].  Masking and shadowing are taken as independent, G1 · G1.

    Parameters
    ----------
    cos : (N,) float; cosine of the direction with the surface normal
    alpha : (N,) float; width

    Returns
    -------
    (N,) float; 0 to 1; 0 below the surface
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

    [Heitz18, Listing 1].

    Parameters
    ----------
    wo : (N, 3) float; unit directions in the frame of the surface, z > 0
    alpha : (N,) float; width
    u1, u2 : (N,) float; in [0, 1)

    Returns
    -------
    (N, 3) float; unit vectors with z >= 0
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


def beckmann_density(cos_h: Scalars, alpha: Scalars) -> Scalars:
    """Density D of Beckmann's microfacet normals, ∫ D cos θ dω = 1 [Walter07].

    Parameters
    ----------
    cos_h : (N,) float; cosine of the microfacet normal with the surface normal
    alpha : (N,) float; width: root mean square slope, times √2; positive

    Returns
    -------
    (N,) float, 1/sr; exp(-tan² θ / α²) / (π α² cos⁴ θ); 0 for normals below the surface
    """
    cos2 = cos_h * cos_h
    width = alpha * alpha * cos2
    with np.errstate(over="ignore"):
        exponent = saturate(divide_or_zero(1.0 - cos2, width))
        peak = saturate(divide_or_zero(np.exp(-exponent), np.pi * width * cos2))
    density: Scalars = np.where(cos_h > 0, peak, 0.0)
    return density


def beckmann_g1(cos: Scalars, alpha: Scalars) -> Scalars:
    """Share G1 of Beckmann's microfacets that a direction sees.

    The rational fit of [Walter07] to Smith's function, within 0.35 % of it, since
    Mitsuba has it, too.  From a = 1.55 to 1.6 the fit is above 1 by up to 6e-5, and
    here 1.

    Parameters
    ----------
    cos : (N,) float; cosine of the direction with the surface normal
    alpha : (N,) float; width

    Returns
    -------
    (N,) float; 0 to 1; 0 below the surface
    """
    cos = np.maximum(cos, 0.0)
    spread = alpha * np.sqrt(np.maximum(1.0 - cos * cos, 0.0))
    hides = cos < 1.6 * spread
    a = np.divide(cos, spread, out=np.zeros_like(spread), where=hides)
    fit = a * (3.535 + 2.181 * a) / (1.0 + a * (2.276 + 2.577 * a))
    seen = (cos > 0).astype(spread.dtype)
    g1: Scalars = np.where(hides, np.minimum(fit, 1.0), seen)
    return g1


def sample_facing_normal(
    wo: Vec3s, alpha: Scalars, u1: Scalars, u2: Scalars, u3: Scalars
) -> tuple[Vec3s, Scalars]:
    """Beckmann normals, each turned half around if so it shows more of itself.

    Their density is D(h) max(0, wo·h) / cos θ_o · :func:`facing_share`.

    Slopes as in [Walter07]; of the two sides of a groove the one is taken in proportion
    to its projected area, as [HeitzDEon14] do for V-shaped cavities.  It needs no
    inverse error function, as Smith's visible normals would.

    Parameters
    ----------
    wo : (N, 3) float; unit directions in the frame of the surface, z > 0
    alpha : (N,) float; width
    u1, u2, u3 : (N,) float
        In [0, 1): slope, azimuth, and which of two opposite normals.

    Returns
    -------
    (N, 3) float, (N,) float
        Unit vectors with z >= 0; and what is left of ``u3``, uniform in [0, 1) whatever
        was chosen.
    """
    slope2 = -alpha * alpha * np.log1p(-u1)
    z = 1.0 / np.sqrt(1.0 + slope2)
    across, phi = np.sqrt(slope2) * z, 2.0 * np.pi * u2
    x, y = across * np.cos(phi), across * np.sin(phi)
    tilt, height = wo[:, 0] * x + wo[:, 1] * y, wo[:, 2] * z
    shown, turned = np.maximum(height + tilt, 0.0), np.maximum(height - tilt, 0.0)
    share = divide_or_zero(shown, shown + turned)
    side = np.where(u3 < share, 1.0, -1.0).astype(u3.dtype)
    return normalize(vectors(side * x, side * y, z)), left_of(u3, share)


def facing_share(cos_h: Scalars, cos_o: Scalars, cos_d: Scalars) -> Scalars:
    """Masking min(1, 2 cos θ_h cos θ_o / (wo·h)) of the side of a V-shaped groove.

    [HeitzDEon14].

    Parameters
    ----------
    cos_h, cos_o : (N,) float
        Cosines of the microfacet normal and of the viewer with the surface normal.
    cos_d : (N,) float; cosine of the viewer with the microfacet normal

    Returns
    -------
    (N,) float; 0 to 1; 0 for microfacets seen from behind
    """
    seen = np.maximum(cos_d, 0.0)
    whole = 2.0 * np.maximum(cos_h, 0.0) * np.maximum(cos_o, 0.0)
    return divide_or_zero(np.minimum(whole, seen), seen)


def reflect(wo: Vec3s, h: Vec3s) -> Vec3s:
    """Mirror image 2 (wo·h) h - wo of a direction about a normal.

    Parameters
    ----------
    wo, h : (N, 3) float; unit vectors

    Returns
    -------
    (N, 3) float; unit vectors
    """
    cosine = wo[:, 0] * h[:, 0] + wo[:, 1] * h[:, 1] + wo[:, 2] * h[:, 2]
    mirrored: Vec3s = (2.0 * cosine)[:, None] * h - wo
    return mirrored

"""Fresnel reflectance of unpolarized light."""

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars, Vec3s


def fresnel_dielectric(cos_i: Scalars, eta: Scalars) -> tuple[Scalars, Scalars]:
    """Reflectance between clear media, and the cosine of the refracted ray.

    [Born99, section 1.5.2]: the mean of both polarizations.

    Parameters
    ----------
    cos_i : (N,) float; cosine of incidence, 0 to 1
    eta : (N,) float; index of refraction behind the boundary over that before it

    Returns
    -------
    (N,), (N,) float
        Reflectance, 1 under total internal reflection; cosine of the refracted ray
        with the normal behind, 0 under total internal reflection.
    """
    cos2_t = 1.0 - (1.0 - cos_i * cos_i) / (eta * eta)
    cos_t = np.sqrt(np.maximum(cos2_t, 0.0))
    # The sums vanish only where both cosines do: grazing at eta = 1.
    parallel = _ratio(eta * cos_i - cos_t, eta * cos_i + cos_t)
    perpendicular = _ratio(cos_i - eta * cos_t, cos_i + eta * cos_t)
    reflectance = 0.5 * (parallel * parallel + perpendicular * perpendicular)
    return np.where(cos2_t > 0, reflectance, 1.0), cos_t


def _ratio(a: Scalars, b: Scalars) -> Scalars:
    return np.divide(a, b, out=np.ones_like(a), where=b != 0)


def fresnel_conductor(cos_i: Scalars, eta: Vec3s, k: Vec3s) -> Vec3s:
    """Reflectance of a metal of complex index eta + i k, (N, 3) float; 0 to 1.

    [Born99, section 14.2]: exact, no approximation for large k.

    Parameters
    ----------
    cos_i : (N,) float; cosine of incidence, 0 to 1
    eta, k : (N, 3) float; index of refraction, a channel each
    """
    cos_i = cos_i[:, None]
    cos2, sin2 = cos_i * cos_i, 1.0 - cos_i * cos_i
    real = eta * eta - k * k - sin2
    a2_plus_b2 = np.sqrt(real * real + 4.0 * eta * eta * k * k)
    a = np.sqrt(np.maximum(0.5 * (a2_plus_b2 + real), 0.0))
    sum_s = a2_plus_b2 + cos2
    perpendicular = _ratio(sum_s - 2.0 * a * cos_i, sum_s + 2.0 * a * cos_i)
    sum_p = a2_plus_b2 * cos2 + sin2 * sin2
    cross_term = 2.0 * a * cos_i * sin2
    parallel = perpendicular * _ratio(sum_p - cross_term, sum_p + cross_term)
    reflectance: Vec3s = 0.5 * (perpendicular + parallel)
    return reflectance


def fresnel_schlick(cos_i: Scalars, normal_incidence: Vec3s) -> Vec3s:
    """Schlick's fit F0 + (1 - F0) (1 - cos θ)^5 [Schlick94, Eq. 15].

    Parameters
    ----------
    cos_i : (N,) float; cosine of incidence, 0 to 1
    normal_incidence : (N, 3) float; F0

    Returns
    -------
    (N, 3) float; F0 to 1
    """
    fifth = ((1.0 - cos_i) ** 5)[:, None]
    reflectance: Vec3s = normal_incidence + (1.0 - normal_incidence) * fifth
    return reflectance

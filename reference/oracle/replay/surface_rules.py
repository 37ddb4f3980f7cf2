"""How declared surfaces scatter, made of factors that are chosen one by one."""

from dataclasses import dataclass
from math import log, pi

import numpy as np

from restir_gi.reference.oracle.replay.bounded import Bounded, constant
from restir_gi.reference.oracle.replay.geometry import cosine_at
from restir_gi.reference.oracle.replay.materials import Coat, Material
from restir_gi.reference.oracle.replay.points import ReceiverPoint, SamplePoint
from restir_gi.reference.oracle.replay.verbs import (
    choose,
    inner,
    square_root,
    times,
    where_positive,
)


@dataclass(frozen=True, slots=True, eq=False)
class Angles:
    """Cosines between light, viewer, normal and the vector half between, (N,) each.

    Attributes
    ----------
    i, o, h : Bounded; of light, viewer and half vector with the normal
    d : Bounded; of light and half vector, 1 at most
    """

    i: Bounded
    o: Bounded
    h: Bounded
    d: Bounded


@dataclass(frozen=True, slots=True)
class SurfaceRules:
    """Scattering f cos θ of declared surfaces; the default is the contract's.

    Attributes
    ----------
    alpha : 'asked', 'squared' or 'root'; what stands for α
    view : 'asked', 'turned' or 'turned-in-half'
        The direction from the eye stands for that to the eye: everywhere, or in the
        half vector alone.
    half : bool; the half vector is a unit vector; else its cosines are cut off at 1
    divisor : bool; the lobe is divided by 4 cos θ_i cos θ_o
    pi : bool; D is divided by π
    masking : str
        'separable' masking and shadowing, Smith's height-'correlated' form, or 'none'.
    fresnel : 'half', 'normal' or 'none'
        Which angle F is taken at: with the half vector, of the view with the normal, or
        normal incidence.
    lobe, diffuse : bool; which parts there are
    share : 'all' or 'unreflected'; the diffuse part is multiplied by 1 − F
    view_asked : bool; the diffuse part is 0 where the view is below the horizon
    ways : int; how often light passes the coat, in and out
    index : bool; the base is divided by η²
    bounces : bool; light goes back and forth between base and coat
    lambertian : '', 'own' or 'white'; f = albedo / π, or 1 / π, whatever was declared
    """

    alpha: str = "asked"
    view: str = "asked"
    half: bool = True
    divisor: bool = True
    pi: bool = True
    masking: str = "separable"
    fresnel: str = "half"
    lobe: bool = True
    diffuse: bool = True
    share: str = "all"
    view_asked: bool = True
    ways: int = 2
    index: bool = True
    bounces: bool = True
    lambertian: str = ""

    def __call__(self, x: ReceiverPoint, m: Material, y: SamplePoint) -> Bounded:
        """Scattering f cos θ of light from sample points, (N, 3).

        Parameters
        ----------
        m : Material; of the visible points, N rows

        Returns
        -------
        Bounded
            0 where the viewer is below the horizon; nothing is said where the light is.
        """
        if self.lambertian:
            albedo, cosine = x.albedo, cosine_at(x, y)
            if self.lambertian == "white":
                albedo = constant(1.0, albedo)
            return times(albedo, cosine / constant(pi, cosine))
        at = self._angles(x, m, y)
        F, lobe = self._fresnel(m, at), self._lobe(m, at)
        if isinstance(m.reflects, Coat):
            base = self._base(x, m.reflects, at)
        else:
            base = times(x.albedo, at.i / constant(pi, at.i))
        if self.share == "unreflected":
            base = base * (constant(1.0, F) - F)
        seen = where_positive(at.o, base)
        parts = [seen if self.view_asked else base] if self.diffuse else []
        if self.lobe:
            parts.append(where_positive(at.o, times(F, lobe)))
        return sum(parts[1:], parts[0])

    def _angles(self, x: ReceiverPoint, m: Material, y: SamplePoint) -> Angles:
        toward = y.position - x.position
        omega = toward / square_root(inner(toward, toward))[:, None]
        view = -m.view if self.view == "turned" else m.view
        half = (-view if self.view == "turned-in-half" else view) + omega
        if self.half:
            half = half / square_root(inner(half, half))[:, None]
        h, d = inner(x.normal, half), inner(omega, half)
        if not self.half:
            h = _at_most_one(h)
        # Whoever rounds it to more than 1 cuts it off.
        return Angles(cosine_at(x, y), inner(x.normal, view), h, _at_most_one(d))

    def _width(self, m: Material) -> Bounded:
        if self.alpha == "squared":
            return m.alpha * m.alpha
        return square_root(m.alpha) if self.alpha == "root" else m.alpha

    def _lobe(self, m: Material, at: Angles) -> Bounded:
        """Lobe without its Fresnel reflectance, times cos θ_i, (N,)."""
        alpha = self._width(m)
        alpha2, one = alpha * alpha, constant(1.0, alpha)
        t = (alpha2 - one) * (at.h * at.h) + one
        value = alpha2 / (t * t)
        if self.pi:
            value = value / constant(pi, value)
        value = value * self._masking(alpha2, at)
        if self.divisor:
            return value / (constant(4.0, value) * at.o)
        return value * at.i

    def _masking(self, alpha2: Bounded, at: Angles) -> Bounded:
        one, two = constant(1.0, alpha2), constant(2.0, alpha2)
        if self.masking == "none":
            return one
        i, o = (c + square_root(c * c + alpha2 * (one - c * c)) for c in (at.i, at.o))
        if self.masking == "separable":
            return (two * at.i / i) * (two * at.o / o)
        whole = at.o * (i - at.i) + at.i * (o - at.o)
        return two * at.i * at.o / whole

    def _fresnel(self, m: Material, at: Angles) -> Bounded:
        """Fresnel reflectance, (N, 3) or, of a coat, (N, 1)."""
        cosine = {"half": at.d, "normal": at.o, "none": constant(1.0, at.d)}
        c = cosine[self.fresnel]
        if isinstance(m.reflects, Coat):
            return _fresnel_of_coat(c, m.reflects.ior)[:, None]
        f0, one = m.reflects, constant(1.0, m.reflects)
        fifth = _fifth_power(_not_negative(constant(1.0, c) - c))
        return f0 + (one - f0) * fifth[:, None]

    def _base(self, x: ReceiverPoint, coat: Coat, at: Angles) -> Bounded:
        """What the base reflects through the coat, (N, 3)."""
        through = _interpolated(coat.transmittance, at.i)
        if self.ways == 2:
            through = through * _interpolated(coat.transmittance, at.o)
        through = through * at.i / constant(pi, at.i)
        if self.index:
            through = through / (coat.ior * coat.ior)
        if not self.bounces:
            return times(x.albedo, through)
        one = constant(1.0, x.albedo)
        colored = choose(coat.nonlinear, x.albedo, one)
        kept = one - times(colored, coat.internal_reflectance)
        return times(x.albedo / kept, through)


CONTRACT_SURFACES = SurfaceRules()
"""The contract's."""


def _at_most_one(c: Bounded) -> Bounded:
    return Bounded(np.minimum(c.value, 1.0), c.error, c.rounding)


def _not_negative(x: Bounded) -> Bounded:
    return Bounded(np.maximum(x.value, 0.0), x.error, x.rounding)


def _fifth_power(x: Bounded) -> Bounded:
    """x⁵ of numbers from 0 to 1, by products or by a library's power.

    A power is 2 to the 5 log₂ x.  Of the logarithm Vulkan leaves open 2⁻²¹ from 1/2 on
    and 3 units in the last place below, and of the exponential 3 + 2 · 5 |log₂ x| units
    of the result.
    """
    product = x * x * (x * x) * x
    size = -np.log2(np.clip(x.value, 1e-300, 1.0))
    half_units = 5 * log(2) * np.maximum(8.0, 6 * size) + 2 * (3 + 10 * size)
    room = half_units / 4 * x.rounding.unit * product.value
    return Bounded(product.value, product.error + room, x.rounding)


def _fresnel_of_coat(c: Bounded, ior: Bounded) -> Bounded:
    """Reflectance of an interface for light from outside, (N,)."""
    one, half = constant(1.0, c), constant(0.5, c)
    refracted = square_root(one - (one - c * c) / (ior * ior))
    parallel = (ior * c - refracted) / (ior * c + refracted)
    perpendicular = (c - ior * refracted) / (c + ior * refracted)
    return half * (parallel * parallel + perpendicular * perpendicular)


def _interpolated(table: Bounded, cosine: Bounded) -> Bounded:
    """Between the cosines of a table, linearly, (N,).

    Parameters
    ----------
    table : Bounded; (N, K), one of exact numbers for each row
    """
    last = table.value.shape[1] - 1
    place = np.clip(cosine.value, 0.0, 1.0) * last
    left = np.minimum(place.astype(np.int64), last - 1)
    rows = np.arange(len(place))
    below, above = table.value[rows, left], table.value[rows, left + 1]
    value = below + (place - left) * (above - below)
    # Wherever a rounded cosine may lie, the table is nowhere steeper than here.
    steepest = last * np.abs(np.diff(table.value, axis=1)).max(axis=1)
    unit = cosine.rounding.unit
    moved = steepest * (cosine.error + unit * np.abs(cosine.value))
    own = 2 * unit * np.maximum(np.abs(below), np.abs(above))
    return Bounded(value, moved + own, cosine.rounding)

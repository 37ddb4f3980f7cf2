"""Declared surfaces by hand, with mistakes that are made from their words.

The formulas are written in other forms than those of the project: Smith's masking by
its Λ, the density by a tangent, the coat's reflectance as in [Walter07, Eq. 22].  All
is in the precision of the buffers.
"""

from dataclasses import dataclass, field

import numpy as np

from restir_gi.reference.oracle.builtin.surfaces import SurfacePixels

SHARES = (0.2126, 0.7152, 0.0722)


def dot(a, b):
    return a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1] + a[:, 2] * b[:, 2]


def unit(a):
    length = np.sqrt(dot(a, a))
    return a / np.where(length > 0, length, 1)[:, None]


@dataclass
class Points:
    """Visible points with their materials, N rows."""

    n: np.ndarray
    v: np.ndarray
    albedo: np.ndarray
    alpha: np.ndarray
    f0: np.ndarray | None
    eta: np.ndarray
    K: np.ndarray
    T: np.ndarray
    nonlinear: np.ndarray


def points_of(q, points):
    """What stands in the tables of the built-in passes."""
    t, m = q.world.materials, points.material
    f0 = t.specular[m] if q.surface == "ggx" else None
    return Points(
        points.normal, points.wo, points.color, t.alpha[m], f0, t.ior[m], t.keep[m],
        t.transmittance[m], t.nonlinear[m],
    )  # fmt: skip


def tangent_density(c, alpha):
    c2 = np.minimum(c * c, 1)
    tan2 = (1 - c2) / c2
    return alpha**2 / (np.pi * c2 * c2 * (alpha**2 + tan2) ** 2)


def smith_lambda(c, alpha):
    return (np.sqrt(1 + alpha**2 * (1 - c * c) / (c * c)) - 1) / 2


def separable(c_i, c_o, alpha):
    return 1 / ((1 + smith_lambda(c_i, alpha)) * (1 + smith_lambda(c_o, alpha)))


def correlated(c_i, c_o, alpha):
    return 1 / (1 + smith_lambda(c_i, alpha) + smith_lambda(c_o, alpha))


def walter(c, eta):
    g = np.sqrt(eta * eta - 1 + c * c)
    ratio = (c * (g + c) - 1) / (c * (g - c) + 1)
    return ((g - c) / (g + c)) ** 2 * (1 + ratio * ratio) / 2


def reflectance(x, c):
    if x.f0 is None:
        return walter(c, x.eta)[:, None]
    return x.f0 + (1 - x.f0) * ((1 - c) ** 5)[:, None]


def lerp(T, c):
    place = np.clip(c, 0, 1) * (T.shape[1] - 1)
    k = np.minimum(place.astype(int), T.shape[1] - 2)
    rows = np.arange(len(c))
    t = place - k.astype(place.dtype)
    return T[rows, k] * (1 - t) + T[rows, k + 1] * t


def base(x, c_i, c_o, passes=2, index=True, bounces=True):
    """Diffuse part, without cos θ."""
    if x.f0 is not None:
        return x.albedo / np.pi
    through = lerp(x.T, c_i) * (lerp(x.T, c_o) if passes == 2 else 1)
    through = through / (np.pi * (x.eta * x.eta if index else 1))
    color = np.where(x.nonlinear[:, None], x.albedo, 1)
    again = 1 / (1 - color * x.K[:, None]) if bounces else 1
    return x.albedo * again * through[:, None]


def scattered(
    x,
    w,
    alpha=lambda a: a,
    view=lambda v: v,
    half=lambda v, w: unit(v + w),
    divisor=lambda c_i, c_o: 4 * c_i * c_o,
    density=tangent_density,
    masking=separable,
    fresnel=lambda c_d, c_o: c_d,
    diffuse=base,
    parts=lambda d, F, lobe: d + F * lobe,
    seen=lambda c_o, f, d: np.where((c_o > 0)[:, None], f, 0),
):
    """Scattering f cos θ; each argument is one of its ideas."""
    with np.errstate(all="ignore"):
        a, v = alpha(x.alpha), view(x.v)
        h, c_i, c_o = half(v, w), dot(x.n, w), dot(x.n, v)
        c_h, c_d = dot(x.n, h), np.clip(dot(w, h), 0, 1)
        lobe = density(np.minimum(c_h, 1), a) * masking(c_i, c_o, a)
        lobe = lobe / divisor(c_i, c_o)
        d = diffuse(x, c_i, c_o)
        F = reflectance(x, fresnel(c_d, c_o))
        f = seen(c_o, parts(d, F, lobe[:, None]), d)
        return np.nan_to_num(f * c_i[:, None]).astype(w.dtype)


MISTAKES = {
    "taken-for-lambertian": {
        "parts": lambda d, F, lobe: d,
        "diffuse": lambda x, c_i, c_o: x.albedo / np.pi,
        "seen": lambda c_o, f, d: f,
    },
    "alpha-squared": {"alpha": lambda a: a * a},
    "alpha-not-squared": {"alpha": np.sqrt},
    "view-turned": {"view": lambda v: -v},
    "half-vector-of-the-turned-view": {"half": lambda v, w: unit(w - v)},
    "half-vector-not-normalized": {"half": lambda v, w: v + w},
    "four-cosines-left-out": {"divisor": lambda c_i, c_o: 1.0},
    "lobe-without-pi": {"density": lambda c, a: np.pi * tangent_density(c, a)},
    "masking-left-out": {"masking": lambda c_i, c_o, a: 1.0},
    "masking-height-correlated": {"masking": correlated},
    "fresnel-at-the-normal": {"fresnel": lambda c_d, c_o: c_o},
    "fresnel-left-out": {"fresnel": lambda c_d, c_o: np.ones_like(c_d)},
    "lobe-left-out": {"parts": lambda d, F, lobe: d},
    "diffuse-left-out": {"parts": lambda d, F, lobe: F * lobe},
    "diffuse-times-what-is-not-reflected": {
        "parts": lambda d, F, lobe: (1 - F) * d + F * lobe
    },
    "diffuse-seen-from-below": {
        "seen": lambda c_o, f, d: np.where((c_o > 0)[:, None], f, d)
    },
    "coat-passed-once": {"diffuse": lambda *a: base(*a, passes=1)},
    "base-without-index": {"diffuse": lambda *a: base(*a, index=False)},
    "bounces-below-the-coat-left-out": {"diffuse": lambda *a: base(*a, bounces=False)},
}
"""By the names of the hypotheses, without "target-" and "shade-"."""

WHITE = {
    "parts": lambda d, F, lobe: d,
    "diffuse": lambda x, c_i, c_o: np.ones_like(x.albedo) / np.pi,
    "seen": lambda c_o, f, d: f,
}


@dataclass
class ByHand:
    """Scattering of the built-in passes, in place of their own."""

    changes: dict = field(default_factory=dict)

    def integrand(self, q, points, y):
        """Integrand f cos θ L_o, (N, 3)."""
        w = unit(y.position - points.position)
        f = scattered(points_of(q, points), w, **self.changes)
        there = (dot(points.normal, w) > 0) & (dot(y.normal, w) < 0)
        return np.where(there[:, None], f * y.radiance, 0)

    def target_at(self, q, points, y):
        """In place of `SurfacePixels.target_at`."""
        if q.settings.target == "outgoing":
            return OWN_TARGET(q, points, y)
        return self.integrand(q, points, y) @ np.array(SHARES, y.radiance.dtype)

    def shown(self, q, y, W):
        """In place of `SurfacePixels.shown`."""
        return self.integrand(q, q.points, y) * W[:, None]


OWN_TARGET = SurfacePixels.target_at


def plant(monkeypatch, name, changes):
    """Let the built-in passes make a mistake: in targets, or in shading.

    Parameters
    ----------
    name : str; of the hypothesis, which says where
    changes : dict; arguments of `scattered`
    """
    method = "shown" if name.startswith("shade-") else "target_at"
    by_hand = getattr(ByHand(changes), method)
    monkeypatch.setattr(SurfacePixels, method, lambda q, *args: by_hand(q, *args))

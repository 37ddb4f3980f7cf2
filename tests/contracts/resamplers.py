"""Passes that choose, by hand, as others write them: right ones, and wrong ones.

From the contract's buffers alone; nothing of the project's own passes is used.
"""

from dataclasses import dataclass
from functools import partial

import numpy as np

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


@dataclass(frozen=True)
class SeenPoints:
    """Visible points, N rows."""

    x: np.ndarray
    n: np.ndarray
    albedo: np.ndarray

    def to(self, y):
        """Squared distance and both cosines."""
        v = y.position - self.x
        d2 = (v * v).sum(axis=1)
        d = np.sqrt(d2)
        cosine = (self.n * v).sum(axis=1) / d
        facing = -(y.normal * v).sum(axis=1) / d
        return d2, np.maximum(cosine, 0), np.maximum(facing, 0)

    def target(self, y, kind):
        """p̂, without visibility."""
        _, cosine, facing = self.to(y)
        light = self.albedo / np.pi * y.radiance if kind == "scattered" else y.radiance
        f = light @ LUMINANCE.astype(light.dtype)
        f = f * cosine if kind == "scattered" else f
        return np.where((cosine > 0) & (facing > 0), f, 0)

    def per_area(self, y):
        """Solid angle of a unit of area at y."""
        d2, _, facing = self.to(y)
        return facing / d2


@dataclass(frozen=True)
class Source:
    """A reservoir, and the pixel that drew it, N rows."""

    pixels: SeenPoints
    position: np.ndarray
    normal: np.ndarray
    radiance: np.ndarray
    W: np.ndarray
    M: np.ndarray


@dataclass(frozen=True)
class Resampler:
    """A backend of three passes.

    Attributes
    ----------
    weights : '1/M', '1/Z', 'balance', 'pairwise' or 'chained'
        What the sum of weights is divided by; the last merges two at a time, each time
        by the balance heuristic.
    order : 'contract', 'reversed' or 'own first'
    turned : bool; u is read as 1 - u
    target : str; in place of the one that is asked for
    mistake : str
        'a thousandth', 'hidden', 'canonical', 'hashed', or 'J <limit>' and
        '1/J <limit>', beyond which the Jacobian is clamped, or 'refused <limit>'.
    """

    weights: str = "1/Z"
    order: str = "contract"
    turned: bool = False
    target: str = ""
    mistake: str = ""
    precision: str = "float32"

    def temporal(self, u, target, cap, **given):
        """Pass ``temporal``."""
        q = _pixels(given)
        sources = [_reservoir(given, "past_", q), _new(given, q)]
        sees = _everyone(2, len(u))
        return self._resampled(q, sources, 1, sees, [u], target, cap)

    def moved(self, u, visible, target, cap, mis, **given):
        """Pass ``moved``; without bias, whatever `mis` is."""
        q, x_past = _pixels(given), _pixels(given, "past_")
        sources = [_reservoir(given, "past_", x_past), _new(given, q)]
        sees = _everyone(2, len(u))
        sees[0][0], sees[0][1] = _bit(visible[:, 1], 1), _bit(visible[:, 1], 0)
        hidden = ~_bit(visible[:, 0], 1)
        return self._resampled(q, sources, 1, sees, [u], target, cap, {0: hidden})

    def spatial(
        self, neighbors, visible, u_own, u_neighbors, target, cap, mis, **given
    ):
        """Pass ``spatial``; without bias, whatever `mis` is."""
        q = _pixels(given)
        count = neighbors.shape[1]
        sources = [_reservoir(given, "past_", q), _reservoir(given, "", q)]
        sees = _everyone(2 + count, len(u_own))
        bits = [count + 1, 0, *range(1, count + 1)]
        hidden = {}
        for k in range(count):
            row, there = np.maximum(neighbors[:, k], 0), neighbors[:, k] >= 0
            far = {name: array[row] for name, array in given.items()}
            far["W"], far["M"] = far["W"] * there, far["M"] * there
            sources.append(_reservoir(far, "", _pixels(far)))
            hidden[2 + k] = ~_bit(visible[:, 0], 1 + k)
            for slot, bit in enumerate(bits):
                sees[2 + k][slot] = _bit(visible[:, 1 + k], bit)
        u = [u_own, *u_neighbors.T]
        return self._resampled(q, sources, 1, sees, u, target, cap, hidden)

    def _resampled(self, q, sources, own, sees, u, target, cap, hidden=()):
        kind = self.target or target
        if self.mistake == "hidden":
            sees = _everyone(len(sources), len(u[0]))
        if self.mistake == "canonical":
            sources[own] = _without(sources[own])
        slots = range(len(sources))
        here = [q.target(s, kind) for s in sources]
        J = [self._jacobian(q, s) for s in sources]
        w = [here[k] * sources[k].W * J[k] for k in slots]
        for k in hidden:
            w[k] = np.where(hidden[k], 0, w[k])
        M = [s.M for s in sources]

        def densities(k):
            """What pixel i would have weighed the sample of slot k with, at q."""
            y = sources[k]
            found = []
            for i in slots:
                of = sources[i].pixels
                back = _ratio(of.per_area(y), q.per_area(y))
                found.append(np.where(sees[i][k], of.target(y, kind) * back, 0))
            return found

        order = _ordered(self.order, len(sources), own)
        u = [1 - number if self.turned else number for number in u]
        if self.mistake == "hashed":
            u = [(number * 12345.678) % 1 for number in u]
        if self.weights == "chained":
            return self._chained(sources, order, u, w, here, densities, cap)
        if self.weights in ("1/M", "1/Z"):
            w = [w[k] * M[k] for k in slots]
        else:
            share = {"balance": _balance, "pairwise": partial(_pairwise, own=own)}
            share = share[self.weights]
            w = [w[k] * share(densities(k), M)[k] for k in slots]
        kept, S = np.zeros(len(u[0]), int) + order[0], w[order[0]]
        for number, k in zip(u, order[1:], strict=True):
            S = S + w[k]
            kept = np.where((number * S < w[k]) & (w[k] > 0), k, kept)
        W = _ratio(S, np.choose(kept, here))
        if self.weights == "1/M":
            W = _ratio(W, sum(M))
        elif self.weights == "1/Z":
            Z = [
                sum(np.where(d > 0, M[i], 0) for i, d in enumerate(densities(k)))
                for k in slots
            ]
            W = _ratio(W, np.choose(kept, Z))
        return self._closed(sources, kept, W, cap)

    def _chained(self, sources, order, u, w, here, densities, cap):
        M = [s.M for s in sources]
        density = [densities(k) for k in range(len(sources))]
        kept = np.zeros(len(u[0]), int) + order[0]
        so_far, M_so_far = w[order[0]], M[order[0]]
        for number, k in zip(u, order[1:], strict=True):
            p_kept, p_new = np.choose(kept, here), here[k]
            other = np.choose(kept, [d[k] for d in density])
            a = so_far * _ratio(M_so_far * p_kept, M_so_far * p_kept + M[k] * other)
            own_density = density[k][k]
            b = w[k] * _ratio(M[k] * own_density, M_so_far * p_new + M[k] * own_density)
            so_far, M_so_far = a + b, M_so_far + M[k]
            kept = np.where((number * so_far < b) & (b > 0), k, kept)
        return self._closed(sources, kept, _ratio(so_far, np.choose(kept, here)), cap)

    def _jacobian(self, q, s):
        J = _ratio(q.per_area(s), s.pixels.per_area(s))
        side, _, limit = self.mistake.partition(" ")
        if side == "J":
            return np.minimum(J, J.dtype.type(limit))
        if side == "refused":
            return np.where(J.dtype.type(limit) < J, 0, J)
        return np.maximum(J, 1 / J.dtype.type(limit)) if side == "1/J" else J

    def _closed(self, sources, kept, W, cap):
        def of(name):
            stacked = np.stack([getattr(s, name) for s in sources])
            return stacked[kept, np.arange(len(kept))]

        W = W * W.dtype.type(1.001) if self.mistake == "a thousandth" else W
        M = np.minimum(sum(s.M for s in sources), cap).astype(W.dtype)
        found = {name: of(name) for name in ("position", "normal", "radiance")}
        return found | {"W": W.astype(M.dtype), "M": M}


def _balance(density, M):
    total = sum(m * d for m, d in zip(M, density, strict=True))
    return [_ratio(m * d, total) for m, d in zip(M, density, strict=True)]


def _pairwise(density, M, own):
    """Defensive: the canonical sample has a share of its own."""
    everyone = sum(M)
    others = everyone - M[own]
    mine = M[own] * density[own]
    found = [
        _ratio(m, everyone) * _ratio(others * d, others * d + mine)
        for m, d in zip(M, density, strict=True)
    ]
    found[own] = _ratio(M[own], everyone) + sum(
        _ratio(m, everyone) * _ratio(mine, others * d + mine)
        for i, (m, d) in enumerate(zip(M, density, strict=True))
        if i != own
    )
    return found


def _ordered(order, count, own):
    slots = list(range(count))
    if order == "reversed":
        return slots[::-1]
    if order == "own first":
        return [own, *(k for k in slots if k != own)]
    return slots


def _ratio(above, below):
    return np.divide(above, below, out=np.zeros_like(above + below), where=below > 0)


def _bit(words, place):
    return (words >> np.uint32(place)) & np.uint32(1) != 0


def _everyone(count, rows):
    return [[np.ones(rows, bool) for _ in range(count)] for _ in range(count)]


def _pixels(given, prefix=""):
    names = ("visible_position", "visible_normal", "albedo")
    return SeenPoints(*(given[prefix + name] for name in names))


def _reservoir(given, prefix, pixels):
    names = ("position", "normal", "radiance", "W", "M")
    return Source(pixels, *(given[prefix + name] for name in names))


def _new(given, pixels):
    pdf = given["new_pdf"]
    y = [given["new_" + name] for name in ("position", "normal", "radiance")]
    return Source(pixels, *y, _ratio(np.ones_like(pdf), pdf), np.ones_like(pdf))


def _without(s):
    none = np.zeros_like(s.W)
    return Source(s.pixels, s.position, s.normal, s.radiance, none, none)

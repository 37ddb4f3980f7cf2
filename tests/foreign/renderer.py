"""A renderer in the manner of many: every choice that the contract leaves is an option.

It shares no code with the project.  Whoever makes a mistake on top overrides the method
in which it is made, and nothing else.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from tests.foreign import kernels as k
from tests.foreign.kernels import F, Point, Reservoir
from tests.foreign.storage import STORAGES

PAST, OWN = 0, 1
"""Places of the receiver's own reservoirs among the candidates; neighbours follow."""


@dataclass(frozen=True)
class Options:
    """Choices that bring no bias; what stands here is the contract's own.

    Attributes
    ----------
    order : str; of the stream, as `ORDERS` names it
    draws : 'position' or 'reservoir'
        Whether a random number belongs to a place in the stream, or to a reservoir.
    u : 'u' or '1 - u'
    accept : '<' or '<='
    cap : 'closed', 'arrival', 'past', 'both' or 'never'
    target : 'asked', 'outgoing', 'no albedo', 'no pi', 'doubled' or 'root'
    luminance : str; as `LUMINANCES` names it
    floor : float; least target, where it is positive
    mis : str
        'asked', 'balance', 'balance first', 'uneven' (balance, each in its own solid
        angle), 'pairwise', 'defensive', 'share' or 'chained'
    null_weight : bool; W of a new null is 1 / pdf
    back_test : bool; the target is 0 where the sample shows its back, else J is
    limit : float; a shift is refused where J or 1 / J is larger, both ways; 0: never
    bytes : bool; M is a whole number, 255 at most
    storage : str; between passes, as `STORAGES` names it
    normalize : callable; direction of a vector
    """

    order: str = "contract"
    draws: str = "position"
    u: str = "u"
    accept: str = "<"
    cap: str = "closed"
    target: str = "asked"
    luminance: str = "709"
    floor: float = 0.0
    mis: str = "asked"
    null_weight: bool = False
    back_test: bool = True
    limit: float = 0.0
    bytes: bool = False
    storage: str = "float32"
    normalize: object = k.unit


class ForeignStream(NamedTuple):
    """Candidates of a pixel, C columns: its past, its own, its neighbours.

    Attributes
    ----------
    y : Reservoir; (N, C) of them
    at : Point; who made each, (N, C)
    shifted : (C,) bool; made at another point than the receiver
    seen : (N, C) bool; whether the receiver sees each
    sees : (N, C, C) bool; row s, column j: whether source j sees sample s
    u : (N, C − 1); numbers that decide
    """

    y: Reservoir
    at: Point
    shifted: np.ndarray
    seen: np.ndarray
    sees: np.ndarray
    u: np.ndarray


class Asked(NamedTuple):
    """Settings of a pass."""

    target: str
    cap: float
    mis: str


ORDERS = {
    "contract": lambda n: [*range(n)],
    "own first": lambda n: [OWN, PAST, *range(2, n)],
    "past last": lambda n: [OWN, *range(2, n), PAST],
    "neighbors reversed": lambda n: [PAST, OWN, *range(n - 1, 1, -1)],
    "own first, neighbors reversed": lambda n: [OWN, PAST, *range(n - 1, 1, -1)],
    "reversed": lambda n: [*range(n - 1, -1, -1)],
}


def _own_densities(p):
    """Of each sample by who made it, and of each by the receiver, (N, C)."""
    return np.diagonal(p, axis1=1, axis2=2), p[:, :, OWN]


def balance_first(M, p, there):
    """The balance heuristic over all."""
    own, _ = _own_densities(p)
    return k.quotient(M * own, (M[:, None] * p).sum(axis=2))


def pairwise(M, p, there, defensive=False):
    """Pairwise weights with confidences [Lin22, Eqs. 36 to 38]."""
    others = np.arange(M.shape[1]) != OWN
    own, here = _own_densities(p)
    S, M_c = (M * others).sum(axis=1, keepdims=True), M[:, OWN, None]
    T = S + M_c if defensive else S
    m = k.quotient(M, T) * k.quotient(S * own, S * own + M_c * here)
    # What the receiver's sample is worth beside each of the others.
    c = M_c * here[:, OWN, None]
    share = k.quotient(M, T) * k.quotient(c, c + S * p[:, OWN]) * others
    m_c = share.sum(axis=1) + (k.quotient(M_c, T)[:, 0] if defensive else F(0))
    m_c = np.where(S[:, 0] > 0, m_c, F(1))
    return np.where(others, m, m_c[:, None])


def defensive(M, p, there):
    """The same with a share of the receiver's own."""
    return pairwise(M, p, there, defensive=True)


def canonical_share(M, p, there):
    """Pairs of equal weight, in each of which the receiver stands for M_c / k."""
    others = (np.arange(M.shape[1]) != OWN) & there
    count = np.maximum(others.sum(axis=1, keepdims=True), 1).astype(F)
    own, here = _own_densities(p)
    M_c = M[:, OWN, None] / count
    m = k.quotient(M * own, M * own + M_c * here) / count
    c = M_c * here[:, OWN, None]
    share = k.quotient(c, c + M * p[:, OWN]) / count
    m_c = np.where(others.any(axis=1), (share * others).sum(axis=1), F(1))
    return np.where(others, m, np.where(np.arange(M.shape[1]) == OWN, m_c[:, None], 0))


FIRST = {
    "balance first": balance_first,
    "pairwise": pairwise,
    "defensive": defensive,
    "share": canonical_share,
}


class ForeignRenderer:
    """A backend of the contract, with options."""

    precision = "float32"
    first = FIRST

    def __init__(self, **options):
        self.options = Options(**options)

    # ------------------------------------------------------------ kernels

    @np.errstate(all="ignore")
    def target(
        self,
        visible_position,
        visible_normal,
        albedo,
        position,
        normal,
        radiance,
        target,
    ):
        """Target of a sample."""
        x = Point(visible_position, visible_normal, albedo)
        y = Reservoir(position, normal, radiance, None, None)
        return {"p_hat": self._target(target, x, y)}

    @np.errstate(all="ignore")
    def jacobian(self, x_from, x_to, position, normal):
        """Ratio of solid angles."""
        y = Reservoir(position, normal, None, None, None)
        return {"jacobian": self._jacobian(x_from, x_to, y)}

    @np.errstate(all="ignore")
    def merge(self, w_a, M_a, w_b, M_b, u):
        """Choice of one of two."""
        second = self._accepts(u, w_a, w_b).astype(np.uint32)
        return {"second": second, "w": k.bounded(w_a + w_b), "M": M_a + M_b}

    @np.errstate(all="ignore")
    def finalize(self, w, p_hat, Z):
        """Weight of what is kept."""
        return {"W": self._finalized(w, p_hat, Z)}

    @np.errstate(all="ignore")
    def similar(self, normal_a, depth_a, normal_b, depth_b, max_angle, max_depth):
        """Whether two points may share samples."""
        far, seen = np.maximum(depth_a, depth_b), (depth_a > 0) & (depth_b > 0)
        found = k.dot(normal_a, normal_b) >= F(np.cos(np.deg2rad(max_angle)))
        found &= np.abs(depth_a - depth_b) <= F(max_depth) * far
        return {"similar": (found & seen).astype(np.uint32)}

    # ------------------------------------------------------------ passes

    @np.errstate(all="ignore")
    def initial(
        self,
        visible_position,
        visible_normal,
        albedo,
        position,
        normal,
        radiance,
        pdf,
        target,
    ):
        """A new sample becomes a reservoir."""
        x = Point(visible_position, visible_normal, albedo)
        y = Reservoir(position, normal, radiance, k.quotient(F(1), pdf), None)
        p_hat = self._target(target, x, y)
        null = (radiance == 0).all(axis=-1)
        keeps = (p_hat > 0) | (null & self.options.null_weight)
        W, M = np.where(keeps, y.W, F(0)), self._new_confidence(y, p_hat)
        return {"p_hat": p_hat, "W": W, "M": M}

    @np.errstate(all="ignore")
    def temporal(self, u, target, cap, mis="1/Z", **given):
        """The new sample meets the pixel's past."""
        x, _, y = self._of_past(target, given)
        at = Point(*(np.stack([a, a], axis=1) for a in x))
        rows = len(u)
        always = np.ones((rows, 2), bool), np.ones((rows, 2, 2), bool)
        s = ForeignStream(y, at, np.array([False, False]), *always, u[:, None])
        return self._resample(x, s, Asked(target, cap, mis)).buffers()

    @np.errstate(all="ignore")
    def moved(self, u, visible, target, cap, mis, **given):
        """The same where the past was seen from another point."""
        x, x_past, y = self._of_past(target, given)
        at = Point(*(np.stack(pair, axis=1) for pair in zip(x_past, x, strict=True)))
        bit = (visible[:, :, None] >> np.uint32([1, 0])) & 1 != 0
        seen = bit[:, 0] | [False, True]
        sees = np.stack([bit[:, 1], bit[:, 0]], axis=2) | [False, True]
        s = ForeignStream(y, at, np.array([True, False]), seen, sees, u[:, None])
        return self._resample(x, s, Asked(target, cap, mis)).buffers()

    @np.errstate(all="ignore")
    def spatial(
        self,
        visible_position,
        visible_normal,
        albedo,
        neighbors,
        visible,
        u_own,
        u_neighbors,
        target,
        cap,
        mis,
        **given,
    ):
        """Pixels resample what their neighbours keep."""
        x, own = Point(visible_position, visible_normal, albedo), _reservoirs(given, "")
        past, K = _reservoirs(given, "past_"), neighbors.shape[1]
        rows = np.maximum(neighbors, 0)
        there = (neighbors >= 0).astype(F)
        around = own.map(lambda a: a[rows])
        around = replace(around, W=around.W * there, M=around.M * there)
        y = Reservoir(
            *(
                np.concatenate([p[:, None], o[:, None], n], axis=1)
                for p, o, n in zip(
                    vars(past).values(),
                    vars(own).values(),
                    vars(around).values(),
                    strict=True,
                )
            )
        )
        at = Point(
            *(np.concatenate([a[:, None], a[:, None], a[rows]], axis=1) for a in x)
        )
        bits = np.uint32([1 + K, 0, *range(1, K + 1)])
        bit = (visible[:, :, None] >> bits) & 1 != 0
        always = np.arange(K + 2) < 2
        sees = np.concatenate([bit[:, :1], bit], axis=1).transpose(0, 2, 1) | always
        shifted = ~always
        u = np.concatenate([u_own[:, None], u_neighbors], axis=1)
        s = ForeignStream(y, at, shifted, bit[:, 0] | always, sees, u)
        return self._resample(x, s, Asked(target, cap, mis)).buffers()

    @np.errstate(all="ignore")
    def shade(
        self,
        visible_position,
        visible_normal,
        albedo,
        position,
        normal,
        radiance,
        W,
    ):
        """The estimate of the pixel's indirect light."""
        x = Point(visible_position, visible_normal, albedo)
        y = Reservoir(position, normal, radiance, W, None)
        how = self.options.back_test, self.options.normalize
        return {"color": k.bounded(k.reflected(x, y, *how) * W[:, None])}

    # ------------------------------------------------------------ their parts

    @np.errstate(all="ignore")
    def _target(self, asked, x, y):
        o = self.options
        kind = asked if o.target in ("asked", "no pi", "doubled", "root") else o.target
        above, facing = k.cosines(x, y, o.normalize)
        lit = np.where((above > 0) & ((facing > 0) | (not o.back_test)), above, F(0))
        if kind == "outgoing":
            p_hat = k.LUMINANCES[o.luminance](y.radiance) * (lit > 0)
        elif kind == "no albedo":
            p_hat = k.LUMINANCES[o.luminance](y.radiance) * lit
        else:
            f = (x.albedo / F(np.pi)) * lit[..., None] * y.radiance
            p_hat = k.LUMINANCES[o.luminance](np.minimum(f, k.MOST))
        factor = {"no pi": F(np.pi), "doubled": F(2)}.get(o.target, F(1))
        p_hat = np.sqrt(p_hat) if o.target == "root" else k.bounded(p_hat * factor)
        return np.where(p_hat > 0, np.maximum(p_hat, F(o.floor)), F(0)).astype(F)

    @np.errstate(all="ignore")
    def _jacobian(self, x_from, x_to, y):
        one_sided = not self.options.back_test
        return k.jacobian(x_from, x_to, y.position, y.normal, one_sided)

    def _shift(self, x_from, x_to, y):
        """Jacobian of a shift; 0 where it is refused."""
        J, limit = self._jacobian(x_from, x_to, y), F(self.options.limit)
        if limit == 0:
            return J
        # The same numbers both ways, so that rounding leaves the domain symmetric.
        back = self._jacobian(x_to, x_from, y)
        return np.where(np.maximum(J, back) <= limit, J, F(0))

    def _finalized(self, w, p_hat, Z):
        return k.quotient(k.quotient(w, p_hat), Z)

    def _accepts(self, u, before, w):
        u = F(1) - u if self.options.u == "1 - u" else u
        return (k.at_most if self.options.accept == "<=" else k.accepts)(u, before, w)

    def _new_confidence(self, y, p_hat):
        return np.ones(len(p_hat), F)

    def _arriving(self, M, cap):
        if self.options.cap in ("arrival", "both"):
            return np.minimum(M, F(cap))
        if self.options.cap == "past":
            return np.concatenate([np.minimum(M[:, :1], F(cap)), M[:, 1:]], axis=1)
        return M

    def _closed(self, M, cap):
        M = np.minimum(M, F(cap)) if self.options.cap in ("closed", "both") else M
        return np.minimum(np.floor(M), 255) if self.options.bytes else M

    def _of_past(self, target, given):
        x = Point(given["visible_position"], given["visible_normal"], given["albedo"])
        names = ("past_visible_position", "past_visible_normal", "past_albedo")
        x_past = Point(*(given.get(name) for name in names))
        past, new = _reservoirs(given, "past_"), _samples(given, "new_")
        W = k.quotient(F(1), given["new_pdf"])
        new = replace(
            new, W=W, M=self._new_confidence(new, self._target(target, x, new))
        )
        pairs = zip(vars(past).values(), vars(new).values(), strict=True)
        return x, x_past, Reservoir(*(np.stack(pair, axis=1) for pair in pairs))

    # ------------------------------------------------------------ resampling

    def _resample(self, x, s, asked):
        """The reservoir that is left of a stream."""
        x = Point(*(a[:, None] for a in x))
        J = self._jacobians(x, s)
        p_hat = self._target(asked.target, x, s.y)
        M = self._confidences(s, J, asked)
        # All that a candidate brings, but for its MIS weight.
        brought = self._brought(p_hat, s.y.W, J, s.seen)
        p = self._densities(x, s, asked, p_hat)
        rule = self._rule(asked)
        if rule == "chained":
            kept, W = self._chained(s, M, p_hat, brought, p)
        else:
            first = rule in self.first
            m = self.first[rule](M, p, M > 0) if first else M
            kept, w = self._choose(k.product(m, brought), s.u)
            one = np.ones(len(w), F)
            Z = one if first else self._divisor(rule, M, p, kept, asked)
            W = self._finalized(w, k.pick(self._dividing(asked, x, s), kept), Z)
        R = Reservoir(*(k.pick(a, kept) for a in vars(s.y).values()))
        total = self._closed(self._counted(M, s).sum(axis=1), asked.cap)
        return STORAGES[self.options.storage](replace(R, W=W, M=total))

    def _rule(self, asked):
        return asked.mis if self.options.mis == "asked" else self.options.mis

    def _jacobians(self, x, s):
        return np.where(s.shifted, self._shift(s.at.position, x.position, s.y), F(1))

    def _confidences(self, s, J, asked):
        """M of each candidate, by which it is weighed."""
        return self._arriving(s.y.M, asked.cap)

    def _counted(self, M, s):
        """M of each candidate that the new reservoir has."""
        return M

    def _brought(self, p_hat, W, J, seen):
        return k.product(p_hat, W, J, seen)

    def _densities(self, x, s, asked, p_hat):
        """Density of sample s as source j makes it, in the receiver's solid angle."""
        y = s.y.map(lambda a: a[:, :, None])
        at = Point(*(a[:, None] for a in s.at))
        J = self._shift(x.position[:, :, None], at.position, y)
        there = self._there(self._target(asked.target, at, y), J, s.sees)
        return np.where(s.shifted, there, p_hat[:, :, None])

    def _there(self, p_hat, J, sees):
        J = J > 0 if self.options.mis == "uneven" else J
        return k.product(p_hat, J, sees)

    def _choose(self, weights, u):
        count = weights.shape[1]
        order = ORDERS[self.options.order](count)
        total, kept = np.zeros(len(weights), F), np.full(len(weights), order[0])
        for i, c in enumerate(order):
            w = weights[:, c]
            taken = self._accepts(self._number(u, order, i), total, w)
            kept = np.where(taken, c, kept)
            total = k.bounded(total + w)
        return kept, total

    def _number(self, u, order, i):
        """Number that decides on the place i of the stream; nothing on the first."""
        if i == 0:
            return np.zeros(len(u), F)
        if self.options.draws == "position":
            return u[:, i - 1]
        # The past has none of its own: it takes that of the first.
        return u[:, (order[i] or order[0]) - 1]

    def _divisor(self, rule, M, p, kept, asked):
        if rule == "1/M":
            return M.sum(axis=1)
        p = k.pick(p, kept)
        if rule == "1/Z":
            return (M * (p > 0)).sum(axis=1)
        # The balance heuristic, whatever the densities are: the shares sum to 1.
        return (M * k.quotient(p, k.pick(p, kept)[:, None])).sum(axis=1)

    def _dividing(self, asked, x, s):
        """Target by which W is divided, of each candidate."""
        return self._target(asked.target, x, s.y)

    def _chain(self, count):
        """Order of merges: what is made at the receiver begins, as it holds all."""
        return [OWN, *(c for c in ORDERS[self.options.order](count) if c != OWN)]

    def _chained(self, s, M, p_hat, brought, p):
        """Merges of two at a time, each closed, by the balance heuristic of the two."""
        first, *order = self._chain(M.shape[1])
        row = np.arange(len(M))
        kept, confidence = np.full(len(M), first), M[:, first]
        W = k.quotient(brought[:, first], p_hat[:, first])
        for i, c in enumerate(order, start=1):
            own, other = p_hat[row, kept] * confidence, p[row, kept, c] * M[:, c]
            w_own = k.product(k.quotient(own, own + other), p_hat[row, kept], W)
            own, other = p_hat[:, c] * confidence, p[:, c, c] * M[:, c]
            w = k.product(k.quotient(other, own + other), brought[:, c])
            taken = self._accepts(self._number(s.u, [first, *order], i), w_own, w)
            kept = np.where(taken, c, kept)
            closing = w_own + w, p_hat[row, kept], np.ones(len(w), F)
            W = self._finalized(*closing)
            confidence = confidence + M[:, c]
        return kept, W


def _reservoirs(given, prefix):
    names = ("position", "normal", "radiance", "W", "M")
    return Reservoir(*(given[prefix + name] for name in names))


def _samples(given, prefix):
    names = ("position", "normal", "radiance")
    return Reservoir(*(given[prefix + name] for name in names), None, None)

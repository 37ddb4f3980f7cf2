"""Passes that reuse samples by hand, with weights of many kinds.

As the contract says them, in double precision, one function for all four: where a
renderer may choose there is a line that can be edited.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from restir_gi.reference.numerics.arrays import (
    Masks,
    Scalars,
    Vec3s,
    divide_or_zero,
    dot,
)
from restir_gi.reference.oracle.cases import Buffers, Case

Y = np.array([0.2126, 0.7152, 0.0722])


@dataclass(frozen=True, eq=False)
class PointByHand:
    """Visible points or sample points; ``color`` is albedo or radiance."""

    position: Vec3s
    normal: Vec3s
    color: Vec3s


@dataclass(frozen=True, eq=False)
class SlotByHand:
    """A slot of the stream: its sample, and the point that made it, if another.

    ``old`` is what a past frame has left.
    """

    y: PointByHand
    W: Scalars
    M: Scalars
    x: PointByHand | None = None
    arrives: Masks | bool = True
    sees: Any = None
    old: bool = False


def _point(given: Any, prefix: str, words: tuple[str, str, str]) -> PointByHand:
    return PointByHand(*(given[prefix + word].astype(float) for word in words))


SAMPLE = ("position", "normal", "radiance")
VISIBLE = ("visible_position", "visible_normal", "albedo")


def _at(p: PointByHand, row: Any) -> PointByHand:
    return PointByHand(p.position[row], p.normal[row], p.color[row])


def _bit(words: Any, place: int) -> Masks:
    found: Masks = (words >> np.uint32(place)) & np.uint32(1) == 1
    return found


def target(kind: Any, x: PointByHand, y: PointByHand) -> Scalars:
    """Equation 9 or 10."""
    v = y.position - x.position
    cosine = divide_or_zero(dot(x.normal, v), np.sqrt(dot(v, v)))
    light = y.color @ Y
    if kind == "scattered":
        light = (x.color * y.color) @ Y * cosine / np.pi
    return np.where((cosine > 0) & (dot(y.normal, v) < 0), light, 0.0)


def shift(x_from: PointByHand, x_to: PointByHand, y: PointByHand) -> Scalars:
    """Jacobian of Equation 11."""
    a, b = x_from.position - y.position, x_to.position - y.position
    d_a, d_b = np.sqrt(dot(a, a)), np.sqrt(dot(b, b))
    steep = divide_or_zero(abs(dot(y.normal, b)) / d_b, abs(dot(y.normal, a)) / d_a)
    return steep * (d_a / d_b) ** 2


def sources(case: Case) -> tuple[list[SlotByHand], list[Scalars]]:
    """The stream, and the numbers that decide, of which the first decides nothing."""
    given = case.inputs
    past = SlotByHand(
        _point(given, "past_", SAMPLE),
        given["past_W"].astype(float),
        given["past_M"].astype(float),
        old=True,
    )
    if case.pass_name in ("spatial", "fused"):
        return _around(case, past)
    y = _point(given, "new_", SAMPLE)
    pdf = given["new_pdf"].astype(float)
    new = SlotByHand(y, divide_or_zero(np.ones_like(pdf), pdf), np.ones(case.rows))
    if case.pass_name == "moved":
        seen = given["visible"]
        sees = [_bit(seen[:, 1], 1), _bit(seen[:, 1], 0)]
        x = _point(given, "past_", VISIBLE)
        past = SlotByHand(past.y, past.W, past.M, x, _bit(seen[:, 0], 1), sees, True)
    u = given["u"].astype(float)
    return [past, new], [u, u]


def _around(case: Case, past: SlotByHand) -> tuple[list[SlotByHand], list[Scalars]]:
    given, seen = case.inputs, case.inputs["visible"]
    fused = case.pass_name == "fused"
    W, M = given["W"].astype(float), given["M"].astype(float)
    own = SlotByHand(_point(given, "", SAMPLE), W, M)
    if fused:  # in which nothing stands in the place of the past
        past = SlotByHand(own.y, 0 * W, 0 * M)
    prefix, rows, u = "", given.get("neighbors"), given.get("u_neighbors")
    if fused:
        prefix, rows, u = "past_", given["sources"], given["u"]
    x, y = _point(given, prefix, VISIBLE), _point(given, prefix, SAMPLE)
    W, M = given[prefix + "W"].astype(float), given[prefix + "M"].astype(float)
    first = given.get("u_own", 0 * W).astype(float)
    found, numbers = [past, own], [first] * 2
    count = rows.shape[1]
    for k in range(count):
        row = rows[:, k]
        there, row = row >= 0, np.maximum(row, 0)
        bits = [count + 1, 0, *range(1, count + 1)]
        sees = [_bit(seen[:, 1 + k], bit) & there for bit in bits]
        found.append(
            SlotByHand(
                _at(y, row),
                np.where(there, W[row], 0.0),
                np.where(there, M[row], 0.0),
                _at(x, row),
                _bit(seen[:, 0], 1 + k),
                sees,
                fused,
            )
        )
        numbers.append(u[:, k].astype(float))
    return found, numbers


def reuse(case: Case) -> Buffers:
    """What the pass leaves, in the precision of the case."""
    with np.errstate(all="ignore"):
        return _reuse(case)


def _reuse(case: Case) -> Buffers:
    kind = case.settings["target"]
    x = _point(case.inputs, "", VISIBLE)
    slots, u = sources(case)
    K = len(slots)
    own, order, numbers = 1, list(range(K)), list(range(K))
    if case.pass_name == "fused":
        order, numbers = _without_past(order, numbers)
    p_hat = [target(kind, x, s.y) for s in slots]
    J = [np.ones(case.rows) if s.x is None else shift(s.x, x, s.y) for s in slots]
    M = [s.M for s in slots]
    weight = [
        np.where(s.arrives & (s.W > 0), p * s.W * J_k, 0.0)
        for s, p, J_k in zip(slots, p_hat, J, strict=True)
    ]

    def p_at(j: int, s: int) -> Scalars:
        """Target of the sample of slot s at the source of slot j."""
        x_j = slots[j].x
        if x_j is None:
            return p_hat[s]
        p = np.where(slots[j].sees[s], target(kind, x_j, slots[s].y), 0.0)
        return divide_or_zero(p, shift(x_j, x, slots[s].y))

    weights = str(case.settings.get("mis", "1/M"))
    p = [[p_at(j, s) for j in range(K)] for s in range(K)]
    m = [_shares(weights, s, p[s], M, own, p[own]) for s in range(K)]
    w = [np.where(v > 0, v * m_k, 0.0) for v, m_k in zip(weight, m, strict=True)]
    if weights.startswith("chained"):
        kept, total = _chained(weights, p_hat, p, weight, M, u)
        return _closed(case, slots, kept, total, [np.ones_like(total)] * K, p_hat, M)
    kept = np.full(case.rows, order[0])
    total = w[order[0]]
    for place, k in list(enumerate(order))[1:]:
        total = total + w[k]
        number = u[numbers[place]]
        kept = np.where((number * total < w[k]) & (w[k] > 0), k, kept)
    Z = [_divisor(weights, s, p[s], M) for s in range(K)]
    return _closed(case, slots, kept, total, Z, p_hat, M)


def _without_past(order: list[int], numbers: list[int]) -> tuple[list[int], list[int]]:
    """A stream with no past, of which the first needs no number, and own has none."""
    left = [k for k in order if k]
    if numbers == list(range(len(order))):  # of places
        return left, [1 + place for place in range(len(left))]
    return left, [left[0] if k == 1 else k for k in left]


def _closed(
    case: Case,
    slots: list[SlotByHand],
    kept: Any,
    total: Scalars,
    Z: list[Any],
    p_hat: list[Scalars],
    M: list[Scalars],
) -> Buffers:
    cap = float(case.settings["cap"])
    W = [divide_or_zero(total, Z_k * p) for Z_k, p in zip(Z, p_hat, strict=True)]
    outputs = {
        "W": np.where(total > 0, _of(kept, W), 0.0),
        "M": np.minimum(sum(M), cap),
    }
    for name, field in zip(SAMPLE, ("position", "normal", "color"), strict=True):
        outputs[name] = _of(kept, [getattr(s.y, field) for s in slots])
    real = case.inputs["past_W"].dtype
    return {name: array.astype(real) for name, array in outputs.items()}


def _chained(
    weights: str,
    p_hat: list[Scalars],
    p: list[list[Scalars]],
    weight: list[Scalars],
    M: list[Scalars],
    u: list[Scalars],
) -> tuple[Any, Scalars]:
    """Slots that are kept, and p̂ W, where each merge is closed before the next."""
    kept, held, M_held = np.zeros(len(M[0]), int), weight[0], M[0]
    for k in range(1, len(M)):
        mine = [p[s][0] if k == 1 else p_hat[s] for s in range(len(M))]
        before = M_held * _of(kept, mine), M[k] * _of(kept, [q[k] for q in p])
        after = M_held * mine[k], M[k] * p[k][k]
        if weights == "chained-balance":
            w = held * divide_or_zero(before[0], sum(before))
            w_next = weight[k] * divide_or_zero(after[1], sum(after))
        else:
            w, w_next = held * M_held, weight[k] * M[k]
        taken = (u[k] * (w + w_next) < w_next) & (w_next > 0)
        kept, held = np.where(taken, k, kept), w + w_next
        if weights == "chained-1/Z":
            both = _of(kept, mine) > 0, _of(kept, [q[k] for q in p]) > 0
            held = divide_or_zero(held, M_held * both[0] + M[k] * both[1])
        M_held = M_held + M[k]
    return kept, held


def half(x: Scalars) -> Scalars:
    """Numbers as float16, to nearest."""
    return x.astype(np.float16).astype(float)


def octahedral(normal: Vec3s) -> Vec3s:
    """Normals as two int16 on an octahedron."""
    n = normal / np.maximum(abs(normal).sum(axis=1, keepdims=True), 1e-30)
    sign = np.where(n < 0, -1.0, 1.0)
    folded = (1 - abs(n[:, [1, 0]])) * sign[:, :2]
    uv = np.rint(32767 * np.where(n[:, 2:] < 0, folded, n[:, :2])) / 32767
    z = 1 - abs(uv).sum(axis=1)
    sign = np.where(uv < 0, -1.0, 1.0)
    xy = np.where(z[:, None] < 0, (1 - abs(uv[:, [1, 0]])) * sign, uv)
    found = np.concatenate([xy, z[:, None]], axis=1)
    unit: Vec3s = found / np.sqrt(dot(found, found))[:, None]
    return np.where(normal.any(axis=1)[:, None], unit, 0.0)


def shared(radiance: Vec3s, bits: int) -> Vec3s:
    """Channels that share an exponent, with so many bits each."""
    least = {9: -15, 8: -127}[bits]
    exponent = np.maximum(np.frexp(radiance.max(axis=1))[1], least)
    step = np.ldexp(1.0, exponent - bits)[:, None]
    largest = (2**bits - 1) * step
    return np.minimum(np.rint(radiance / step) * step, largest)


RGB_TO_XYZ = np.array(
    [
        [0.4123907993, 0.3575843394, 0.1804807884],
        [0.2126390059, 0.7151686788, 0.0721923154],
        [0.0193308187, 0.1191947798, 0.9505321522],
    ]
)


def log_luv(radiance: Vec3s) -> Vec3s:
    """Colours as a logarithm of luminance, and chromaticities, in cells."""
    X, Y, Z = (radiance.astype(float) @ RGB_TO_XYZ.T).T
    level = np.floor(np.clip(409.6 * (np.log2(Y) + 20), 0, 16383))
    u, v = (np.floor(820 * c / (X + 15 * Y + 3 * Z)) for c in (4 * X, 9 * Y))
    Y = 2.0 ** ((level + 0.5) / 409.6 - 20)
    u, v = (u + 0.5) / 820, (v + 0.5) / 820
    x, y = (c / (6 * u - 16 * v + 12) for c in (9 * u, 4 * v))
    xyz = np.stack([x / y * Y, Y, (1 - x - y) / y * Y], axis=1)
    found = np.maximum(xyz @ np.linalg.inv(RGB_TO_XYZ).T, 0.0)
    return np.where((level > 0)[:, None], found, 0.0)


def _of(kept: Any, arrays: list[Any]) -> Any:
    return np.stack(arrays)[kept, np.arange(len(kept))]


def _shares(
    weights: str, s: int, p: list[Scalars], M: list[Scalars], own: int, p_own: Any
) -> Scalars:
    """What stands in the weight of slot s: its M, or a share below 1.

    Parameters
    ----------
    p : list of (N,); target of the slot's sample at each source
    p_own : list of (N,); the same of the receiver's own sample
    """
    others = [k for k in range(len(M)) if k != own]
    if weights == "balance-in-weights":
        whole = sum(M_k * p_k for M_k, p_k in zip(M, p, strict=True))
        return divide_or_zero(M[s] * p[s], whole)
    by_count, defensive = weights.endswith("of-k"), weights.startswith("defensive")
    if not by_count and weights not in ("pairwise", "defensive"):
        return M[s]
    part = [(M_k > 0).astype(float) if by_count else M_k for M_k in M]
    S = sum(part[k] for k in others)
    first = np.ones_like(S) if by_count else M[own]
    T = S + first if defensive else S

    def pair(k: int, at: Any) -> tuple[Scalars, Scalars]:
        mine = (M[k] * S if by_count else S) * at[k]
        return mine, M[own] * at[own]

    if s != own:
        mine, theirs = pair(s, p)
        return divide_or_zero(part[s], T) * divide_or_zero(mine, mine + theirs)
    found = divide_or_zero(first, T) if defensive else np.zeros_like(S)
    for k in others:
        mine, theirs = pair(k, p_own)
        share = divide_or_zero(theirs, mine + theirs)
        found = found + divide_or_zero(part[k], T) * share
    return np.where(S > 0, found, 1.0)


def _divisor(weights: str, s: int, p: list[Scalars], M: list[Scalars]) -> Any:
    if weights == "1/M":
        return sum(M)
    if weights == "1/Z":
        held = [np.where(p_k > 0, M_k, 0.0) for p_k, M_k in zip(p, M, strict=True)]
        return sum(held)
    if weights == "balance":
        whole = sum(M_k * p_k for M_k, p_k in zip(M, p, strict=True))
        return divide_or_zero(whole, p[s])
    return np.ones_like(M[0])

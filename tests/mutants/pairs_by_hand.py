"""Passes of pairs and images by hand, with any of the known mistakes.

Written from the contract: other orders of operations, in single precision where that is
asked for, row by row where the project has whole frames, and other solvers.  A mistake
is asked for by the name of its hypothesis.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from restir_gi.reference.oracle.cases import Buffers, Case

Y = (0.2126, 0.7152, 0.0722)
Array = Any
Given = Mapping[str, Any]


def _f(x: Any, like: Array) -> Any:
    return like.dtype.type(x)


def _over(a: Array, b: Array) -> Array:
    """Quotient, 0 over 0."""
    a, b = np.broadcast_arrays(a, b)
    return np.divide(a, b, out=np.zeros_like(a), where=b != 0)


def _light(rgb: Array) -> Array:
    r, g, b = (rgb[..., c] * _f(Y[c], rgb) for c in range(3))
    return b + (g + r)


# ------------------------------------------------ samples


def _omega(p: Array, q: Array, J: Array, m: str) -> Array:
    """1 / (1 + q J / p), which is another order of operations."""
    one, half = _f(1, J), _f(0.5, J)
    by = q * J
    if m == "pair-weight-without-jacobian":
        by = q
    if m == "pair-weight-over-jacobian":
        by = _over(q, J)
    found = np.where(p > 0, one / (one + _over(by, p)), one * 0)
    if m == "pair-weight-of-the-offset":
        found = np.where(by > 0, one / (one + _over(p, by)), one * 0)
    if m == "pair-weight-one-half":
        found = half + 0 * J
    if m == "pair-weight-left-out":
        found = one + 0 * J
    lone = half if m == "pair-alone-halved" else one
    return np.where(J > 0, found, np.where(p > 0, lone, one * 0))


def _signed(k: Array, base: Array, offset: Array, J: Array, w: Array, m: str) -> Array:
    """ω G, each path weighted by itself."""
    if m == "pair-inner-jacobian-twice":
        J_of = J * J
    elif m == "pair-inner-jacobian-divides":
        J_of = _over(J * 0 + 1, J)
    elif m == "pair-inner-jacobian-left-out":
        J_of = (J > 0).astype(J.dtype)
    else:
        J_of = J
    found = base * w[..., None] - offset * (J_of * w)[..., None]
    if m == "pair-alone-dropped":
        found = np.where((J > 0)[..., None], found, 0 * found)
    second = (k == 1) & (m != "pair-second-sign-not-turned")
    return np.where(
        (second != (m == "pair-difference-reversed"))[..., None], -found, found
    )


def _H(k: Array, base: Array, offset: Array, J: Array, m: str) -> Array:
    one = J * 0 + 1
    return _signed(k, base, offset, J, w=_omega(one, one, J, m), m=m)


def _adds(sample: tuple[Array, ...], sign: str, m: str) -> Array:
    H = _H(*sample, m)
    if m == "pair-parts-exchanged":
        sign = {"plus": "minus", "minus": "plus"}.get(sign, sign)
    plus, minus = np.where(H > 0, H, 0 * H), np.where(H < 0, H, 0 * H)
    if m in ("pair-split-by-luminance", "pair-shown-by-luminance"):
        bright = (_light(H) > 0)[..., None]
        dark = (_light(H) < 0)[..., None]
        plus, minus = np.where(bright, H, 0 * H), np.where(dark, H, 0 * H)
    if m == "pair-whole-in-each-sign":
        return H
    if m == "pair-shown-without-weight":
        G = _signed(*sample, w=sample[3] * 0 + 1, m=m)
        plus, minus = np.where(H > 0, G, 0 * G), np.where(H < 0, G, 0 * G)
        H = G
    if m == "pair-negative-part-added" and sign == "minus":
        return -minus
    return {"plus": plus, "minus": minus, "both": H}[sign]


def _p_hat(sample: tuple[Array, ...], sign: str, m: str) -> Array:
    H = _H(*sample, m)
    if m == "pair-target-of-the-sum":
        return abs(_light(H))
    if m == "pair-target-of-the-part":
        light = _light(H)
        part = {"plus": light, "minus": -light, "both": abs(light)}[sign]
        return np.maximum(part, 0 * part)
    if m == "pair-target-of-both-signs":
        return _light(abs(H))
    if m == "pair-target-unweighted":
        H = _signed(*sample, w=sample[3] * 0 + 1, m=m)
        parts = {"plus": np.maximum(H, 0 * H), "minus": np.maximum(-H, 0 * H)}
        return _light(parts.get(sign, abs(H)))
    return _light(abs(_adds(sample, sign, m)))


SAMPLE = ("k", "base", "offset", "inner")


def _sample(i: Given, *at: Any, suffix: str = "") -> tuple[Array, ...]:
    return tuple(i[f"{name}{suffix}"][(slice(None), *at)] for name in SAMPLE)


def _pair_value(i: Given, s: Given, m: str) -> dict[str, Array]:
    return {"G": _signed(*_sample(i), w=i["inner"] * 0 + 1, m=m)}


def _pair_weight(i: Given, s: Given, m: str) -> dict[str, Array]:
    return {"omega": _omega(i["p_base"], i["p_offset"], i["inner"], m)}


def _pair_target(i: Given, s: Given, m: str) -> dict[str, Array]:
    sample = _sample(i)
    return {
        "contribution": _adds(sample, s["sign"], m),
        "p_hat": _p_hat(sample, s["sign"], m),
    }


def _with_k(i: Given, c: int) -> tuple[Array, ...]:
    k = np.full(len(i["inner"]), c, np.uint32)
    return k, i["base"][:, c], i["offset"][:, c], i["inner"][:, c]


def _pair_initial(i: Given, s: Given, m: str) -> dict[str, Array]:
    p = [_p_hat(_with_k(i, c), s["sign"], m) for c in (0, 1)]
    half = 0.5 if m == "pair-candidates-halved" else 1.0
    w = [_f(half, p[c]) * (i["W"][:, c] * p[c]) for c in (0, 1)]
    S, u = w[0] + w[1], i["u"]
    if m == "pair-u-turned":
        u = 1 - u
    second = (u < _over(w[1], S)) | ((w[0] == 0) & (w[1] > 0))
    kept = np.where(second, p[1], p[0])
    W = _over(S, p[0] if m == "pair-target-of-the-first" else kept)
    M = np.ones_like(W)
    if m == "pair-divided-by-candidates":
        W, M = W / 2, 2 * M
    if m == "pair-candidates-count-twice":
        M = 2 * M
    if m == "pair-nulls-not-counted":
        M = (S > 0).astype(M.dtype)
    return {"k": second.astype(np.uint32), "p_hat": kept, "W": W, "M": M}


def _pair_estimate(i: Given, s: Given, m: str) -> dict[str, Array]:
    W = i["W"]
    if s["reservoirs"] == "one" and m != "pair-one-reservoir-read-as-two":
        return {"delta": _adds(_sample(i, 0), "both", m) * W[:, :1]}
    plus = _adds(_sample(i, 0), "plus", m) * W[:, :1]
    minus = _adds(_sample(i, 1), "minus", m)
    minus = minus * (W[:, :1] if m == "pair-weight-of-plus-for-both" else W[:, 1:])
    return {"delta": plus + (minus if m != "pair-second-left-out" else 0 * minus)}


def _after_estimate(i: Given, s: Given, m: str) -> dict[str, Array]:
    terms = []
    for c in (0, 1):
        k, base, offset, J = _with_k(i, c)
        p, q = _light(base), _light(offset)
        if m == "after-densities-for-targets":
            p = q = J * 0 + 1
        w = _omega(p, q, J, m)
        own = i["W"][:, 0 if m == "pair-weight-of-plus-for-both" else c]
        terms.append(_signed(k, base, offset, J, w=w * own, m=m))
    return {"delta": terms[0] if m == "pair-second-left-out" else terms[1] + terms[0]}


# ------------------------------------------------ shifts


def _inner_shift(i: Given, s: Given, m: str) -> dict[str, Array]:
    row, k = np.arange(len(i["k"])), i["k"].astype(int)
    to = k if m == "inner-shift-to-the-own-pixel" else 1 - k
    way = np.where(k == 1, -1, 1) if m != "inner-shift-step-not-turned" else 1
    way = 0 if m == "inner-shift-place-stays" else way
    J, f = i["jacobian_at"][row, to], i["value_at"][row, to]
    if m != "shift-that-fails-has-a-value":
        f = np.where(J[:, None] > 0, f, 0 * f)
    return {
        "pixel": np.where(to == 0, i["first"], i["second"]),
        "x_to": i["x"] + (way * i["dx"]).astype(i["x"].dtype),
        "y_to": i["y"] + (way * i["dy"]).astype(i["x"].dtype),
        "offset": f,
        "inner": J,
    }


def _outer_shift(i: Given, s: Given, m: str) -> dict[str, Array]:
    row, k = np.arange(len(i["k"])), i["k"].astype(int)
    to = 1 - k if m == "outer-shift-to-the-other-pixel" else k
    J, base = i["jacobian_at"][row, to], i["value_at"][row, to]
    offset, inner = i["rebuilt_at"][row, to], i["inner_at"][row, to]
    if m in ("outer-shift-offset-carried", "outer-shift-value-carried"):
        offset = i["offset_from"]
    if m in ("outer-shift-offset-carried", "outer-shift-inner-carried"):
        inner = i["inner_from"]
    there, outer = J > 0, J
    if m == "outer-jacobian-times-inner":
        outer = np.where(inner > 0, J * inner, J)
    if m == "outer-jacobian-left-out":
        outer = there.astype(J.dtype)
    if m == "outer-jacobian-divides":
        outer = _over(J * 0 + 1, J)
    if m != "shift-that-fails-has-a-value":
        base, offset = (np.where(there[:, None], f, 0 * f) for f in (base, offset))
        inner = np.where(there, inner, 0 * inner)
    return {
        "pixel": np.where(to == 0, i["first"], i["second"]),
        "base": base,
        "offset": offset,
        "inner": inner,
        "jacobian": np.where(there, outer, 0 * outer),
    }


# ------------------------------------------------ reuse


def _pair_reuse(i: Given, s: Given, m: str) -> dict[str, Array]:
    rows, K = i["W"].shape
    sign, mis, c = s["sign"], s["mis"], s["canonical"]
    row = np.arange(rows)
    there = i["there"] == 1
    W, M = np.where(there, i["W"], 0), np.where(there, i["M"], 0)
    if m == "pair-reuse-empty-slots-counted":
        M = i["M"].copy()
    if m == "pair-reuse-nulls-not-counted":
        M = np.where(W > 0, M, 0)
    J = i["jacobian"].copy()
    made = np.stack(
        [_p_hat(_sample(i, q, suffix="_from"), sign, m) for q in range(K)], 1
    )
    moved = []
    for q in range(K):
        k, base, offset, inner = _sample(i | {"k": i["k_from"]}, q)
        if m in ("outer-shift-offset-carried", "outer-shift-value-carried"):
            offset = i["offset_from"][:, q]
        if m in ("outer-shift-offset-carried", "outer-shift-inner-carried"):
            inner = i["inner_from"][:, q]
        if m == "outer-jacobian-times-inner":
            J[:, q] = np.where(inner > 0, J[:, q] * inner, J[:, q])
        moved.append((k, base, offset, inner))
    here = np.stack([_p_hat(sample, sign, m) for sample in moved], 1)
    here = np.where(J > 0, here, 0)
    if m == "pair-reuse-target-of-the-source":
        here = made
    at = np.zeros((rows, K, K), W.dtype)
    asked = "both" if m == "pair-reuse-supports-of-both-signs" else sign
    for a in range(K):
        for b in range(K):
            base, offset, inner = (i[f"{n}_at"][:, a, b] for n in SAMPLE[1:])
            if m == "pair-reuse-offset-carried-back":
                _, _, offset, inner = moved[a]
            p = _p_hat((moved[a][0], base, offset, inner), asked, m)
            at[:, a, b] = p * i["jacobian_at"][:, a, b]
    one_J = m in ("outer-jacobian-left-out", "pair-reuse-made-without-jacobian")
    made_here = np.where(J > 0, made if one_J else _over(made, J), 0)
    left_out = m in ("outer-jacobian-left-out", "pair-reuse-jacobian-left-out")
    factor = (J > 0).astype(J.dtype) if left_out else J
    factor = factor.copy()
    factor[:, c] = 1
    weight = M
    if mis in ("pairwise", "defensive"):
        weight = _in_pairs(M, made_here, here, at, c, mis == "defensive", m)
    w = weight * W * here * factor
    total, kept = w[:, 0].copy(), np.zeros(rows, int)
    for q in range(1, K):
        total = total + w[:, q]
        u = 1 - i["u"][:, q] if m == "pair-u-turned" else i["u"][:, q]
        wins = (u * total < w[:, q]) | ((total == w[:, q]) & (w[:, q] > 0))
        kept = np.where(wins, q, kept)
    p_here = here[row, kept]
    p = np.stack(
        [
            np.where(
                kept == q, made_here[:, q] if q != c else here[:, c], at[row, kept, q]
            )
            for q in range(K)
        ],
        1,
    )
    p[:, c] = np.where(kept == c, here[:, c], p_here)
    if mis in ("pairwise", "defensive"):
        Z = np.ones_like(total)
    elif mis == "1/M" or m == "pair-reuse-one-over-m":
        Z = M.sum(axis=1)
    elif mis == "1/Z":
        everybody = m == "pair-reuse-z-of-everybody"
        made_it = kept[:, None] == np.arange(K)
        Z = np.where((p > 0) | made_it | everybody, M, 0).sum(axis=1)
    else:
        Z = _over((M * p).sum(axis=1), p[row, kept])
    cap = np.inf if m == "pair-reuse-never-capped" else s["cap"]
    return {
        "slot": kept,
        "p_hat": p_here,
        "W": _over(_over(total, p_here), Z),
        "M": np.minimum(M.sum(axis=1), cap),
    }


def _in_pairs(
    M: Array, made: Array, here: Array, at: Array, c: int, defensive: bool, m: str
) -> Array:
    found = np.zeros_like(M)
    others = [q for q in range(M.shape[1]) if q != c]
    S = M[:, others].sum(axis=1)
    T = S + M[:, c] if defensive else S
    own = M[:, c] * here[:, c]
    for q in others:
        at_source, at_c = made[:, q], here[:, q]
        if m == "pair-reuse-pairs-exchanged":
            at_source, at_c = at_c, at_source
        mine = S * at_source
        share = _over(mine, mine + M[:, c] * at_c)
        found[:, q] = _over(M[:, q], T) * share
        found[:, c] += _over(M[:, q], T) * _over(own, own + S * at[:, c, q])
    if defensive:
        found[:, c] += _over(M[:, c], T)
    else:
        found[:, c] = np.where(S > 0, found[:, c], 1)
    if m == "pair-reuse-canonical-counts-whole":
        found[:, c] = 1
    return found


# ------------------------------------------------ pixels


def _unlike(a: Given, b: Given, s: Given, m: str) -> Array:
    """As a shader has it: one pixel at a time is compared with another."""
    apart = a["albedo"] - b["albedo"]
    most, least, share = (
        _f(s.get(name, usual), apart)
        for name, usual in (
            ("most_albedo", 0.1),
            ("least_cosine", 0.9),
            ("most_depth", 0.1),
        )
    )
    albedo = (apart if m == "edge-albedo-signed" else abs(apart)) > most
    albedo = albedo.any(axis=-1)
    if m == "edge-albedo-luminance":
        albedo = abs(_light(apart)) > most
    n, o = a["normal"], b["normal"]
    cosine = n[..., 0] * o[..., 0] + n[..., 1] * o[..., 1] + n[..., 2] * o[..., 2]
    if m == "edge-normals-either-side" or s.get("normals") == "either-side":
        cosine = abs(cosine)
    normal = cosine > least if m == "edge-normals-above" else cosine < least
    z, y = a["depth"], b["depth"]
    by = {
        "edge-depth-of-the-first": z,
        "edge-depth-of-the-second": y,
        "edge-depth-in-metres": z * 0 + 1,
    }.get(m, np.maximum(z, y))
    depth = _over(abs(z - y), by) > share
    tests = {"albedo": albedo, "normals": normal, "depth": depth}
    kept = [t for name, t in tests.items() if m != f"edge-{name}-not-compared"]
    how = np.all if m == "edge-all-three" else np.any
    both = (a["hit"] == 1) & (b["hit"] == 1)
    alone = (a["hit"] == 1) != (b["hit"] == 1)
    found = how(kept, axis=0) & both
    return found | alone if m != "edge-lone-pixel-not-asked" else found


PIXEL = ("albedo", "normal", "depth", "hit")


def _edge_pair(i: Given, s: Given, m: str) -> dict[str, Array]:
    a, b = ({n: i[f"{n}_{which}"] for n in PIXEL} for which in "ab")
    return {"edge": _unlike(a, b, s, m).astype(np.uint32)}


def _pair_search(i: Given, s: Given, m: str) -> dict[str, Array]:
    """One pair after another, one try after another."""
    width, r = s["width"], s["radius"]
    height, n = len(i["hit"]) // width, 2 * r + 1
    pixels = {name: i[name] for name in PIXEL}

    # Every pixel beside every other one.
    one = {name: array[:, None] for name, array in pixels.items()}
    others = {name: array[None] for name, array in pixels.items()}
    every = _unlike(one, others, s, m)

    def unlike(a: int, b: int) -> bool:
        return bool(every[a, b])

    def exists(x: int, y: int, axis: int) -> bool:
        return 0 <= x < width - (axis == 0) and 0 <= y < height - (axis == 1)

    def second(first: int, axis: int) -> int:
        return first + (width if axis else 1)

    def is_edge(first: int, axis: int) -> bool:
        return unlike(first, second(first, axis))

    def alike(a: int, b: int, axis: int, onto: int) -> bool:
        p, q = (a, second(a, axis)), (b, second(b, onto))
        if m == "search-pixels-crossed":
            q = q[::-1]
        if m == "search-first-pixels-compared":
            return not unlike(p[0], q[0])
        if m == "search-second-pixels-compared":
            return not unlike(p[1], q[1])
        each = (not unlike(p[0], q[0]), not unlike(p[1], q[1]))
        return any(each) if m == "search-one-pixel-is-enough" else all(each)

    found = np.full((len(i["hit"]), 2), -1)
    for first in range(len(found)):
        for axis in (0, 1):
            x, y = first % width, first // width
            interior = m == "search-of-interior-pairs"
            if not exists(x, y, axis) or not (interior or is_edge(first, axis)):
                continue
            onto = 1 - axis if m == "search-of-the-other-axis" else axis
            for u in i["u"][first, axis]:
                q = int(np.floor(u * _f(n * n, u)))
                column, line = q % n, q // n
                if m == "search-columns-first":
                    column, line = line, column
                to_x, to_y = x + column - r, y + line - r
                if m == "search-clamped":
                    to_x = min(max(to_x, 0), width - 1 - (axis == 0))
                    to_y = min(max(to_y, 0), height - 1 - (axis == 1))
                if not exists(to_x, to_y, onto):
                    continue
                to = to_y * width + to_x
                if to == first and m != "search-finds-itself":
                    continue
                free = m in ("search-finds-interior-pairs", "search-of-interior-pairs")
                if not free and not is_edge(to, onto):
                    continue
                if alike(first, to, axis, onto):
                    found[first, axis] = to
                    if m != "search-last-taken":
                        break
    return {"neighbor": found}


def _pair_motion(i: Given, s: Given, m: str) -> dict[str, Array]:
    width, height = s["width"], s["height"]
    found = []
    for row in range(len(i["axis"])):
        z, y = float(i["depth_first"][row]), float(i["depth_second"][row])
        if m != "motion-with-nothing":
            z = z if i["hit_first"][row] else np.inf
            y = y if i["hit_second"][row] else np.inf
        second = {
            "motion-with-the-farther": y > z,
            "motion-with-the-first": False,
            "motion-second-where-alike": y <= z,
        }.get(m, y < z)
        before = int(i["before_second" if second else "before_first"][row])
        down = bool(i["axis"][row])
        px, py = before % width, before // width
        if second and m != "motion-not-stepped-back":
            along = down != (m == "motion-axes-exchanged")
            px, py = px - (not along), py - along
        inside = before >= 0 and px >= 0 and py >= 0
        if m != "motion-out-of-the-image":
            inside = inside and px < width - (not down) and py < height - down
        found.append(py * width + px if inside else -1)
    return {"row": np.array(found)}


# ------------------------------------------------ images


def _primal(i: Given, s: Given, m: str) -> dict[str, Array]:
    color = i["value"] * (1 if m == "primal-without-weight" else i["W"][:, None])
    return {"color": color + i["emission"] if m == "primal-with-emission" else color}


def _pair_differences(i: Given, s: Given, m: str) -> dict[str, Array]:
    x, y = i["delta_x"].copy(), i["delta_y"].copy()
    if m == "differences-axes-exchanged":
        x, y = y, x
    if m != "differences-sign-of-pairs":
        x, y = -x, -y
    if m != "differences-beyond-the-border":
        x[s["width"] - 1 :: s["width"]] = 0
        y[-s["width"] :] = 0
    return {"dx": x, "dy": y}


def _differences(i: Given, s: Given, m: str) -> dict[str, Array]:
    width, color = s["width"], i["color"]
    height = len(color) // width
    x, y = np.zeros_like(color), np.zeros_like(color)
    sign = -1 if m == "differences-of-the-pixel-less-neighbour" else 1
    for p in range(len(color)):
        px, py = p % width, p // width
        if m == "differences-backward":
            x[p] = color[p] - color[p - 1] if px else 0
            y[p] = color[p] - color[p - width] if py else 0
            continue
        wraps = m == "differences-periodic"
        if px + 1 < width or wraps:
            x[p] = sign * (color[py * width + (px + 1) % width] - color[p])
        if py + 1 < height or wraps:
            y[p] = sign * (color[(py + 1) % height * width + px] - color[p])
    if m == "differences-axes-exchanged":
        x, y = y, x
    return {"dx": x, "dy": y}


class _RowsByHand:
    """Rows of a problem as functions of an image, without a matrix."""

    def __init__(self, i: Given, s: Given, m: str) -> None:
        self.m, self.width = m, s["width"]
        self.height = len(i["primal"]) // self.width
        P, x, y = (i[name] for name in ("primal", "dx", "dy"))
        if m == "differences-axes-exchanged":
            x, y = y, x
        if m == "poisson-divergence-sign":
            x, y = -x, -y
        if m == "poisson-of-the-luminance":
            P, x, y = (np.repeat(_light(a)[:, None], 3, axis=1) for a in (P, x, y))
        alpha = float(s["alpha"])
        alpha = {
            "poisson-alpha-not-squared": np.sqrt(alpha),
            "poisson-alpha-squared-once-more": alpha**2,
            "poisson-alpha-left-out": 1.0,
        }.get(m, alpha)
        swapped = m == "poisson-alpha-on-differences"
        self.a, self.b = (_f(v, P) for v in ((1, alpha) if swapped else (alpha, 1)))
        self.right = [self.a * P, self.b * x, self.b * y]

    def _of(self, image: Array) -> Array:
        return image.reshape(self.height, self.width, -1)

    def _steps(self, grid: Array, axis: int) -> Array:
        """Neighbour less pixel along an axis, 0 where there is none."""
        found = np.roll(grid, -1, axis) - grid
        if self.m == "poisson-periodic":
            return found
        last = [slice(None)] * 3
        last[axis] = slice(-1, None)
        found[tuple(last)] = 0
        return np.roll(found, 1, axis) if self.m == "differences-backward" else found

    def _back(self, d: Array, axis: int) -> Array:
        """Adjoint of `_steps`."""
        if self.m == "differences-backward":
            d = np.roll(d, -1, axis)
        if self.m != "poisson-periodic":
            d = d.copy()
            last = [slice(None)] * 3
            last[axis] = slice(-1, None)
            d[tuple(last)] = 0
        return np.roll(d, 1, axis) - d

    def apply(self, image: Array) -> list[Array]:
        """A I."""
        grid = self._of(image)
        x, y = self._steps(grid, 1), self._steps(grid, 0)
        return [
            self.a * image,
            self.b * x.reshape(image.shape),
            self.b * y.reshape(image.shape),
        ]

    def adjoint(self, rows: list[Array]) -> Array:
        """Aᵀ of rows."""
        P, x, y = rows
        back = self._back(self._of(x), 1) + self._back(self._of(y), 0)
        return self.a * P + self.b * back.reshape(P.shape)

    def normal(self, image: Array, weights: list[Array] | None = None) -> Array:
        """Aᵀ (w A I)."""
        rows = self.apply(image)
        if weights is not None:
            rows = [r * w for r, w in zip(rows, weights, strict=True)]
        found = self.adjoint(rows)
        if self.m == "poisson-black-border":
            grid = self._of(image)
            extra = np.zeros_like(grid)
            extra[0] += grid[0]
            extra[-1] += grid[-1]
            extra[:, 0] += grid[:, 0]
            extra[:, -1] += grid[:, -1]
            found = found + extra.reshape(image.shape)
        return found


def _conjugate_gradients(
    of: Callable[[Array], Array], right: Array, start: Array, steps: int, enough: float
) -> Array:
    """Each channel by itself, until its residual is small enough."""
    image = start.copy()
    left = right - of(image)
    way = left.copy()
    length = (left * left).sum(axis=0)
    most = enough**2 * (right * right).sum(axis=0)
    for _ in range(steps):
        if (length <= most).all():
            break
        moved = of(way)
        step = _over(length, (way * moved).sum(axis=0))
        image = image + step * way
        left = left - step * moved
        now = (left * left).sum(axis=0)
        way = left + _over(now, length) * way
        length = now
    return image


def _poisson_l2(i: Given, s: Given, m: str) -> dict[str, Array]:
    rows = _RowsByHand(i, s, m)
    right = rows.adjoint(rows.right)
    enough = 0.5 * s.get("residual", 1e-4)
    image = _conjugate_gradients(rows.normal, right, i["primal"], 500, enough)
    return {"color": image + i["primal"] if m == "poisson-primal-added" else image}


def _poisson_l1(i: Given, s: Given, m: str) -> dict[str, Array]:
    """By least squares whose weights follow the lengths."""
    i = {name: a.astype(float) for name, a in i.items()}
    if m == "poisson-squares-for-absolute-values":
        return _poisson_l2(i, {**s, "residual": 1e-6}, "")
    rows, image = _RowsByHand(i, s, m), i["primal"]
    for sweep in range(30):
        off = [a - b for a, b in zip(rows.apply(image), rows.right, strict=True)]
        squares = [r * r for r in off]
        if s.get("norm") != "channels":
            squares = [r.sum(axis=1, keepdims=True) for r in squares]
        mean = np.mean([np.sqrt(r).mean() for r in squares])
        least = max(mean * 0.6**sweep, 1e-6 * mean)
        weights = [1 / np.sqrt(r + least**2) for r in squares]
        right = rows.adjoint([b * w for b, w in zip(rows.right, weights, strict=True)])
        image = _conjugate_gradients(
            lambda x, w=weights: rows.normal(x, w), right, image, 60, 1e-5
        )
    return {"color": image + i["primal"] if m == "poisson-primal-added" else image}


PASSES: dict[str, Callable[[Given, Given, str], dict[str, Array]]] = {
    "pair_value": _pair_value,
    "pair_weight": _pair_weight,
    "pair_target": _pair_target,
    "pair_initial": _pair_initial,
    "inner_shift": _inner_shift,
    "outer_shift": _outer_shift,
    "pair_reuse": _pair_reuse,
    "pair_estimate": _pair_estimate,
    "after_estimate": _after_estimate,
    "edge_pair": _edge_pair,
    "pair_search": _pair_search,
    "pair_motion": _pair_motion,
    "primal": _primal,
    "pair_differences": _pair_differences,
    "differences": _differences,
    "poisson_l2": _poisson_l2,
    "poisson_l1": _poisson_l1,
}
INDICES, BITS = ("pixel", "slot", "neighbor", "row"), ("k", "edge")


def by_hand(case: Case, mistake: str = "") -> Buffers:
    """Outputs of a case, in the type of its reals."""
    reals = [a.dtype for a in case.inputs.values() if a.dtype.kind == "f"]
    found = PASSES[case.pass_name](dict(case.inputs), case.settings, mistake)
    types = dict.fromkeys(INDICES, np.int32) | dict.fromkeys(BITS, np.uint32)
    return {n: np.asarray(a).astype(types.get(n, reals[0])) for n, a in found.items()}

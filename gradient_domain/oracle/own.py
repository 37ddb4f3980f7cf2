"""The project's own passes of pairs and images: the production functions."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np

from restir_gi.extensions.area_shift import AreaPaths, AreaShift, PlacedValue
from restir_gi.gradient_domain.after_restir import estimate_after
from restir_gi.gradient_domain.gradient_restir import (
    MINUS,
    PAPER_LIMITS,
    PLUS,
    WHOLE,
    EdgeLimits,
    PairedPaths,
    PairValue,
    choose_pair,
    contribution,
    difference,
    estimate,
    first_alike,
    inner_shift,
    outer_shift,
    shaded,
    share_of_base,
    target,
    unlike,
)
from restir_gi.gradient_domain.least_absolute import least_absolute
from restir_gi.gradient_domain.oracle.contract import BY_CHANNELS, EITHER_SIDE, GIVEN
from restir_gi.gradient_domain.pairs import (
    Axis,
    Pairs,
    as_differences,
    pair_in_square,
    pairs_before,
    pivots,
    pixel_pairs,
)
from restir_gi.gradient_domain.reconstruction import (
    Differences,
    differences,
    least_squares,
)
from restir_gi.reference.numerics.arrays import Indices, Scalars, Vec3s
from restir_gi.reference.numerics.records import NONE, take
from restir_gi.reference.oracle.builtin.buffers import Array, as_real
from restir_gi.reference.oracle.builtin.world import surface_of
from restir_gi.reference.oracle.contract.fields import Precision, dtype_of
from restir_gi.reference.resampling.generalized import resample
from restir_gi.reference.resampling.reservoir import Reservoirs
from restir_gi.reference.scene.surface import VisiblePoints

SIGNS = {"both": WHOLE, "plus": PLUS, "minus": MINUS}

Given = Mapping[str, Array]
Outputs = dict[str, Array]


@dataclass(frozen=True, slots=True)
class _PairSample:
    """In place of `PairedPaths`: what of N samples the passes ask.

    Attributes
    ----------
    slot : (N,) int; who made it
    """

    slot: Indices
    value: PairValue

    @property
    def sign(self) -> Indices:
        return self.value.sign

    def moved(self, value: PairValue, jacobian: Scalars) -> "_PairSample":
        """The same samples elsewhere."""
        return _PairSample(self.slot, value)


@dataclass(frozen=True, slots=True)
class _NewSample:
    """In place of `PairedPaths`, of which the sign is chosen later."""

    k: Indices
    base: PlacedValue
    offset: Vec3s
    inner: Scalars
    sign: Indices

    @property
    def value(self) -> PairValue:
        return PairValue(self.k, self.base, self.offset, self.inner, self.sign)


def _placed(f: Vec3s) -> PlacedValue:
    none = np.zeros(len(f), f.dtype)
    return PlacedValue(none, none, f, none)


def _value(
    k: Array, base: Array, offset: Array, inner: Array, sign: int = WHOLE
) -> PairValue:
    signs = np.full(len(k), sign, np.int8)
    return PairValue(k.astype(np.int8), _placed(base), offset, inner, signs)


def _column(given: Given, c: int, names: tuple[str, ...] = ()) -> dict[str, Any]:
    """Of buffers with a column for each k, or for each slot."""
    names = names or ("k", "base", "offset", "inner")
    return {n: given[n][:, c] for n in names if n in given}


# ------------------------------------------------ samples


def _pair_value(precision: Precision, **sample: Any) -> Outputs:
    return {"G": as_real(precision, difference(_value(**sample)))}


def _pair_weight(
    precision: Precision, p_base: Array, p_offset: Array, inner: Array
) -> Outputs:
    return {"omega": as_real(precision, share_of_base(p_base, p_offset, inner))}


def _pair_target(precision: Precision, sign: str, **sample: Any) -> Outputs:
    value = _value(**sample, sign=SIGNS[sign])
    found = {"contribution": contribution(value), "p_hat": target(value)}
    return {name: as_real(precision, array) for name, array in found.items()}


def _pair_initial(
    precision: Precision, W: Array, u: Array, sign: str, **values: Array
) -> Outputs:
    both = []
    for c in (0, 1):
        k = np.full(len(u), c, np.int8)
        v = _value(k, **_column(values, c))
        y = _NewSample(v.k, v.base, v.offset, v.inner, v.sign)
        both.append(Reservoirs(y, W[:, c], np.ones_like(u)))
    kept = choose_pair(both, SIGNS[sign], u)
    return {
        "k": kept.y.k.astype(np.uint32),
        "p_hat": as_real(precision, target(kept.y.value)),
        "W": as_real(precision, kept.W),
        "M": as_real(precision, kept.M),
    }


def _pair_estimate(
    precision: Precision, W: Array, reservoirs: str, **samples: Array
) -> Outputs:
    signs = (PLUS, MINUS) if reservoirs == "two" else (WHOLE,)
    kept = []
    for c, sign in enumerate(signs):
        value = _value(**_column(samples, c), sign=sign)
        y = _PairSample(np.arange(len(W)), value)
        kept.append(Reservoirs(y, W[:, c], np.ones_like(W[:, c])))
    return {"delta": as_real(precision, estimate(kept))}


def _after_estimate(precision: Precision, W: Array, **values: Array) -> Outputs:
    both = []
    for c in (0, 1):
        value = _value(np.full(len(W), c), **_column(values, c))
        y = _PairSample(np.arange(len(W)), value)
        both.append(Reservoirs(y, W[:, c], np.ones_like(W[:, c])))
    return {"delta": as_real(precision, estimate_after(both))}


# ------------------------------------------------ shifts: tables in place of scenes


@dataclass(frozen=True, slots=True)
class _Row:
    """In place of `AreaPaths`: the row of the tables, and where x_1 appears."""

    row: Indices
    x: Scalars
    y: Scalars

    def __len__(self) -> int:
        return len(self.row)

    def moved(self, value: PlacedValue, jacobian: Scalars) -> "_Row":
        return _Row(self.row, value.x, value.y)


@dataclass(frozen=True, slots=True)
class _RowSample:
    """In place of `PairedPaths`."""

    k: Indices
    base: _Row
    offset: Vec3s
    inner: Scalars
    sign: Indices


@dataclass(frozen=True, slots=True, eq=False)
class _TableShift:
    """In place of `AreaShift`: looks up what a path is worth in each pixel of a pair.

    Attributes
    ----------
    first : (N,) int; pixel i of each row
    outer, inner : pairs of (N, 2, 3) and (N, 2); f and Jacobian in pixels i and j
    asked : list; pixels and places that shifts of each kind were asked for
    """

    first: Indices
    outer: tuple[Array, Array]
    inner: tuple[Array, Array]
    asked: list[tuple[Indices, Scalars, Scalars]]
    primary: str = "reuse"
    world_from: None = None
    world_to: None = None

    def __call__(
        self, base: _Row, pixel: Indices, dx: Scalars, dy: Scalars
    ) -> tuple[PlacedValue, Scalars]:
        """Value and Jacobian, both 0 without a shift."""
        within = self.primary == "move"
        x, y = base.x + dx, base.y + dy
        f, jacobian = self.inner if within else self.outer
        column = (pixel != self.first[base.row]).astype(int)
        self.asked.append((pixel, x, y))
        J = jacobian[base.row, column]
        value = np.where(J[:, None] > 0, f[base.row, column], 0 * f[base.row, column])
        return PlacedValue(x, y, value, J), J


def _pairs(first: Array, second: Array, dx: Array, dy: Array) -> Pairs:
    axis = (dy > 0).astype(np.int8)
    wide = first.astype(np.int64), second.astype(np.int64)
    return Pairs(*wide, axis, dx, dy)


def _inner_shift(
    precision: Precision,
    k: Array,
    first: Array,
    second: Array,
    dx: Array,
    dy: Array,
    x: Array,
    y: Array,
    value_at: Array,
    jacobian_at: Array,
) -> Outputs:
    tables = value_at, jacobian_at
    shift = _TableShift(first, tables, tables, [])
    base = cast(AreaPaths, _Row(np.arange(len(k)), x, y))
    pairs, ks = _pairs(first, second, dx, dy), k.astype(np.int8)
    offset, inner = inner_shift(cast(AreaShift, shift), base, ks, pairs)
    pixel, x_to, y_to = shift.asked[0]
    return {
        "pixel": pixel.astype(dtype_of("index", precision)),
        "x_to": as_real(precision, x_to),
        "y_to": as_real(precision, y_to),
        "offset": as_real(precision, offset),
        "inner": as_real(precision, inner),
    }


def _outer_shift(
    precision: Precision,
    k: Array,
    first: Array,
    second: Array,
    value_at: Array,
    jacobian_at: Array,
    rebuilt_at: Array,
    inner_at: Array,
    offset_from: Array,
    inner_from: Array,
) -> Outputs:
    # Made of a path in i it is in j: the shift is asked for the pixel that it leads to.
    rebuilt = rebuilt_at[:, ::-1], inner_at[:, ::-1]
    shift = _TableShift(first, (value_at, jacobian_at), rebuilt, [])
    none, ks = np.zeros(len(k)), k.astype(np.int8)
    base = _Row(np.arange(len(k)), none, none)
    samples = _RowSample(ks, base, offset_from, inner_from, 0 * ks)
    value, jacobian = outer_shift(
        cast(AreaShift, shift),
        cast(PairedPaths, samples),
        pairs=_pairs(first, second, none, none),
        dx=none,
        dy=none,
        sign=WHOLE,
    )
    pixel, *_ = shift.asked[0]
    return {
        "pixel": pixel.astype(dtype_of("index", precision)),
        "base": as_real(precision, value.base.value),
        "offset": as_real(precision, value.offset),
        "inner": as_real(precision, value.inner),
        "jacobian": as_real(precision, jacobian),
    }


# ------------------------------------------------ reuse


@dataclass(frozen=True, slots=True, eq=False)
class _PairSlot:
    """Slot q of every row: what it brings here, and what it could make."""

    q: int
    here: PairValue
    jacobian: Array
    at_others: Given
    sign: int
    reservoirs: Reservoirs
    rows: Indices
    same_domain: bool

    def unshifted(self, at: Indices) -> PairValue:
        value: PairValue = take(self.reservoirs.y.value, self.rows[at])
        return value

    def shifted(self, at: Indices) -> tuple[PairValue, Scalars]:
        return take(self.here, at), self.jacobian[at]

    def inverse(self, samples: _PairSample, at: Indices) -> tuple[PairValue, Scalars]:
        s = samples.slot[at]
        base, offset, inner, jacobian = (
            self.at_others[name][at, s, self.q]
            for name in ("base_at", "offset_at", "inner_at", "jacobian_at")
        )
        return _value(samples.value.k[at], base, offset, inner, self.sign), jacobian


AT = ("base_at", "offset_at", "inner_at", "jacobian_at")


def _pair_reuse(
    precision: Precision,
    W: Array,
    M: Array,
    there: Array,
    jacobian: Array,
    u: Array,
    sign: str,
    mis: Any,
    canonical: int,
    cap: float,
    **tables: Array,
) -> Outputs:
    rows, slots = W.shape
    row, of_sign = np.arange(rows), SIGNS[sign]
    sources = []
    for q in range(slots):
        made = {
            name: tables[f"{name}_from"][:, q]
            for name in ("k", "base", "offset", "inner")
        }
        here = made | _column(tables, q, ("base", "offset", "inner"))
        sample = _PairSample(np.full(rows, q), _value(**made, sign=of_sign))
        source = _PairSlot(
            q,
            _value(**here, sign=of_sign),
            jacobian[:, q],
            {name: tables[name] for name in AT},
            of_sign,
            Reservoirs(sample, W[:, q], M[:, q]),
            np.where(there[:, q] == 1, row, NONE),
            q == canonical,
        )
        sources.append(source)
    numbers = [u[:, q] for q in range(slots)]
    kept = resample(sources, numbers, mis, float(cap), target)
    return {
        "slot": kept.y.slot.astype(np.int32),
        "p_hat": as_real(precision, target(kept.y.value)),
        "W": as_real(precision, kept.W),
        "M": as_real(precision, kept.M),
    }


# ------------------------------------------------ pairs of pixels


def _seen(albedo: Array, normal: Array, depth: Array, hit: Array) -> VisiblePoints:
    surface = surface_of(normal, normal, albedo)
    there = np.where(hit == 1, 0, NONE).astype(np.int32)
    return VisiblePoints(replace(surface, primitive=there), depth)


PIXEL = ("albedo", "normal", "depth", "hit")


def _limits(
    thresholds: str = "fixed",
    normals: str = "facing",
    most_albedo: float = 0.0,
    least_cosine: float = 0.0,
    most_depth: float = 0.0,
) -> EdgeLimits:
    limits = PAPER_LIMITS
    if thresholds == GIVEN:
        numbers = float(most_albedo), float(least_cosine), float(most_depth)
        limits = EdgeLimits(*numbers)
    return replace(limits, either_side=normals == EITHER_SIDE)


def _edge_pair(precision: Precision, **given: Any) -> Outputs:
    pixels = {n: a for n, a in given.items() if isinstance(a, np.ndarray)}
    limits = _limits(**{n: a for n, a in given.items() if n not in pixels})
    both = {n: np.concatenate([pixels[f"{n}_a"], pixels[f"{n}_b"]]) for n in PIXEL}
    size = len(pixels["hit_a"])
    row = np.arange(size)
    edge = unlike(_seen(**both), row, size + row, limits)
    return {"edge": edge.astype(np.uint32)}


def _pair_search(
    precision: Precision,
    albedo: Array,
    normal: Array,
    depth: Array,
    hit: Array,
    u: Array,
    width: int,
    radius: int,
    **likeness: Any,
) -> Outputs:
    limits = _limits(**likeness)
    visible, height = _seen(albedo, normal, depth, hit), len(hit) // width
    pairs = pixel_pairs(width, height)
    is_edge = unlike(visible, pairs.first, pairs.second, limits)
    numbers = u[pairs.first, pairs.axis]

    def drawn(rows: Indices, first: int, count: int) -> Indices:
        some = numbers[rows, first : first + count].T.ravel()
        own = np.tile(rows, count)
        return pair_in_square(pairs, own, some, radius, width, height)

    edges = np.flatnonzero(is_edge)
    found = first_alike(visible, pairs, is_edge, edges, u.shape[2], drawn, limits)
    neighbor = np.full((len(hit), 2), NONE)
    own = pairs.first[edges], pairs.axis[edges]
    neighbor[own] = np.where(found == NONE, NONE, pairs.first[found])
    return {"neighbor": neighbor.astype(dtype_of("index", precision))}


def _pair_motion(
    precision: Precision,
    axis: Array,
    first: Array,
    depth_first: Array,
    depth_second: Array,
    hit_first: Array,
    hit_second: Array,
    before_first: Array,
    before_second: Array,
    width: int,
    height: int,
) -> Outputs:
    size, across = len(first), (axis == Axis.X).astype(float)
    # A G-buffer of the two pixels alone, and the pairs as rows of it.
    row = np.arange(size)
    depth = np.concatenate([depth_first, depth_second])
    hit = np.concatenate([hit_first, hit_second])
    up = np.tile([0.0, 0.0, 1.0], (2 * size, 1))
    pairs = Pairs(row, size + row, axis.astype(np.int8), across, 1.0 - across)
    pivot = pivots(pairs, _seen(up, up, depth, hit))
    before = np.concatenate([before_first, before_second])[pivot].astype(np.int64)
    found = pairs_before(pairs, pivot, before, width, height)
    every = pixel_pairs(width, height).first
    rows = np.full(size, NONE)
    there = found != NONE
    rows[there] = every[found[there]]
    return {"row": rows.astype(dtype_of("index", precision))}


# ------------------------------------------------ images


def _primal(precision: Precision, value: Array, W: Array, emission: Array) -> Outputs:
    return {"color": as_real(precision, shaded(value, W))}


def _told(precision: Precision, d: Differences) -> Outputs:
    return {"dx": as_real(precision, d.x), "dy": as_real(precision, d.y)}


def _pair_differences(
    precision: Precision, delta_x: Array, delta_y: Array, width: int
) -> Outputs:
    pixels = len(delta_x)
    pairs = pixel_pairs(width, pixels // width)
    across = (pairs.axis == Axis.X)[:, None]
    delta = np.where(across, delta_x[pairs.first], delta_y[pairs.first])
    return _told(precision, as_differences(pairs, delta, pixels))


def _differences(precision: Precision, color: Array, width: int) -> Outputs:
    return _told(precision, differences(color, width))


def _wide(*arrays: Array) -> list[Array]:
    return [a.astype(float) for a in arrays]


def _poisson_l2(
    precision: Precision,
    primal: Array,
    dx: Array,
    dy: Array,
    width: int,
    alpha: float,
    residual: float,
) -> Outputs:
    P, x, y = _wide(primal, dx, dy)
    image = least_squares(P, Differences(x, y), width, float(alpha))
    return {"color": as_real(precision, image)}


def _poisson_l1(
    precision: Precision,
    primal: Array,
    dx: Array,
    dy: Array,
    width: int,
    alpha: float,
    ratio: float,
    norm: str = "length",
) -> Outputs:
    P, x, y = _wide(primal, dx, dy)
    # The length of one channel is its absolute value.
    size = 1 if norm == BY_CHANNELS else P.shape[1]
    images = [
        least_absolute(P[:, c], Differences(x[:, c], y[:, c]), width, float(alpha))
        for c in (slice(c, c + size) for c in range(0, P.shape[1], size))
    ]
    return {"color": as_real(precision, np.concatenate(images, axis=1))}


OWN: Mapping[str, Any] = {
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
"""The passes of this part."""

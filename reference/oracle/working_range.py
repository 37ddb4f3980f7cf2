"""The working range: numbers that a scene can have.

A scene is a room or a landscape in metres, its light between starlight and the sun's,
seen by a camera that keeps its distance.  Each number of a row is 0, or within the
limits of its kind:

=====================  ==============  ================================================
distance of points     1e-6 to 1e6 m   that a pass joins; at least 1e-6 of the places'
                                       own size, or the subtraction has no digit left
their quotient         1e-4 to 1e4     where one sample point is joined to several
cosine at a point      1e-4 to 1       a ray that grazes closer sees rounding alone
length of a normal     1/2 to 2        without a normal a row has no geometry
depth                  1e-6 to 1e6 m   as distances
radiance               1e-7 to 1e7     starlight on a dark wall; the sun's disk is 2e7,
                                       and is no sample of indirect light
density, W             1e-7 to 1e7     of a lobe of 3e-4 radians
target, weight         1e-16 to 1e16   products of the numbers above
confidence             1e-3 to 1e5     no cap of any renderer is as large
width α of a lobe      0.02 to 1       below it float32 has lost the peak's digits
=====================  ==============  ================================================

Squares and products of such numbers, w = p̂ W M J among them, stay within 1e±35, so that
float32 holds them in whatever order they are multiplied.  What a backend does with rows
beyond is told and does not decide, unless it is asked for.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Masks, Scalars, Vec3s
from restir_gi.reference.oracle.cases import source_rows
from restir_gi.reference.oracle.contract.fields import Pass

NEAR, FAR = 1e-6, 1e6
"""Least and largest distance, m; the least also as a share of the places' size."""

QUOTIENT = 1e4
"""Largest quotient of the distances of two points from a sample."""

EDGE_ON = 1e-4
"""Least cosine."""

SHARP, MATT = 0.02, 1.0
"""Least and largest width α of the lobe of a declared surface."""


@dataclass(frozen=True, slots=True)
class NumberRange:
    """Of one kind of number.

    Attributes
    ----------
    names : tuple of str; of buffers, without ``past_`` and ``new_``
    words : str; what the number is, for messages
    """

    names: tuple[str, ...]
    words: str
    least: float
    most: float


LIMITS = (
    NumberRange(
        ("radiance", "radiance_then", "radiance_now"), "a radiance is", 1e-7, 1e7
    ),
    NumberRange(
        ("pdf", "p_from", "p_to", "p_onward_from", "p_onward_to"),
        "a density is",
        1e-7,
        1e7,
    ),
    NumberRange(("W",), "W is", 1e-7, 1e7),
    NumberRange(("M", "M_a", "M_b", "Z"), "M is", 1e-3, 1e5),
    NumberRange(
        (
            *("w", "w_a", "w_b", "p_hat", "p_hat_given"),
            *("target_base", "target_here", "target_at"),
        ),
        "a weight is",
        1e-16,
        1e16,
    ),
    NumberRange(
        ("depth", "depth_a", "depth_b", "depth_before", "distance"),
        "a depth is",
        NEAR,
        FAR,
    ),
)


@dataclass(frozen=True, slots=True, eq=False)
class Excess:
    """Rows that one number puts beyond the working range, N rows.

    Attributes
    ----------
    rows : (N,) bool
    values : (N,) float64; the number
    words : str; with a place for it
    """

    rows: Masks
    values: Scalars
    words: str


def beyond_range(one: Pass, inputs: dict[str, NDArray[Any]]) -> Masks | None:
    """Rows beyond the working range, (N,) bool; ``None`` where there are none.

    Parameters
    ----------
    one : Pass; which says what it joins
    inputs : dict of str to array; of a case of it
    """
    found = np.zeros(len(next(iter(inputs.values()))), bool)
    for excess in excesses(one, inputs):
        found |= excess.rows
    return found if found.any() else None


def where_beyond(one: Pass, inputs: dict[str, NDArray[Any]], row: int) -> str:
    """What puts a row beyond the working range, as 'points lie 1e-25 m apart'."""
    return next(
        excess.words.format(excess.values[row])
        for excess in excesses(one, inputs)
        if excess.rows[row]
    )


def excesses(one: Pass, inputs: dict[str, NDArray[Any]]) -> Iterator[Excess]:
    """All that puts rows beyond the working range, where they lie first."""
    yield from _geometry(one, inputs)
    around = source_rows(inputs) if one.joins else None
    if around is None:
        yield from _of_rows(inputs)
        return
    # What a past frame holds is looked at by those alone who reuse it.
    apart = around.prefix
    theirs = {n: a for n, a in inputs.items() if n.startswith(apart)}
    yield from _of_rows(
        {n: a for n, a in inputs.items() if not apart or n not in theirs}
    )
    reused = list(_of_rows(theirs))
    for row, there in _reused(inputs[around.rows]):
        for e in reused:
            yield Excess(e.rows[row] & there, e.values[row], e.words)


def _of_rows(inputs: dict[str, NDArray[Any]]) -> Iterator[Excess]:
    yield from _numbers(inputs)
    yield from _surfaces(inputs)


def _numbers(inputs: dict[str, NDArray[Any]]) -> Iterator[Excess]:
    for name, array in inputs.items():
        kind = name.removeprefix("past_").removeprefix("new_")
        for limits in LIMITS:
            if kind in limits.names:
                size = np.abs(array.reshape(len(array), -1).astype(np.float64))
                out = (size > 0) & ((size < limits.least) | (size > limits.most))
                worst = np.take_along_axis(size, out.argmax(axis=1)[:, None], 1)[:, 0]
                rows: Masks = np.any(out, axis=1)
                yield Excess(rows, worst, limits.words + " {:.3g}")


def _surfaces(inputs: dict[str, NDArray[Any]]) -> Iterator[Excess]:
    """Of declared surfaces: their lobes, and the eye that they are seen from."""
    for prefix in ("", "past_"):
        if f"{prefix}view" in inputs:
            alpha = inputs[f"{prefix}alpha"].astype(np.float64)
            yield Excess((alpha < SHARP) | (alpha > MATT), alpha, "α is {:.3g}")
            normal = inputs[f"{prefix}visible_normal"].astype(np.float64)
            view = inputs[f"{prefix}view"].astype(np.float64)
            size = np.sqrt((view * view).sum(axis=1))
            none = (size < 0.5) | (size > 2.0)
            yield Excess(none, size, "a view has length {:.3g}")
            yield from _at_point(normal, view, size, np.ones(len(view), bool))


@dataclass(frozen=True, slots=True, eq=False)
class _Point:
    """Places of N rows; normals where the pass has any."""

    position: Vec3s
    normal: Vec3s | None

    def rows(self, rows: NDArray[Any]) -> "_Point":
        normal = None if self.normal is None else self.normal[rows]
        return _Point(self.position[rows], normal)


def _point(inputs: dict[str, NDArray[Any]], name: str) -> _Point:
    normal = inputs.get(name.replace("position", "normal"))
    return _Point(
        inputs[name].astype(np.float64),
        None
        if normal is None or not name.endswith("position")
        else normal.astype(float),
    )


# Which sample it is; the point that is joined to it; its own; and the rows of it.
Join = tuple[str, _Point, _Point, Masks]


def _geometry(one: Pass, inputs: dict[str, NDArray[Any]]) -> Iterator[Excess]:
    joins = list(_joins(one, inputs))
    nearest: dict[str, tuple[Scalars, Scalars]] = {}
    for name, x, y, there in joins:
        v = y.position - x.position
        d = np.sqrt((v * v).sum(axis=1))
        a, b, c = np.maximum(np.abs(x.position), np.abs(y.position)).T
        size = np.maximum(np.maximum(a, b), c)
        out = (d < np.maximum(NEAR, NEAR * size)) | (d > FAR)
        yield Excess(out & there, d, "points lie {:.3g} m apart")
        for point in (x, y):
            if point.normal is not None:
                yield from _at_point(point.normal, v, d, there)
        most, least = nearest.get(name, (d * 0, d * 0 + np.inf))
        nearest[name] = (
            np.where(there, np.maximum(most, d), most),
            np.where(there, np.minimum(least, d), least),
        )
    for most, least in nearest.values():
        out = (least > 0) & (most > QUOTIENT * least)
        quotient = np.divide(most, least, out=np.ones_like(most), where=out)
        words = "one point lies {:.3g} times as far from a sample as another"
        yield Excess(out, quotient, words)


def _at_point(normal: Vec3s, v: Vec3s, d: Scalars, there: Masks) -> Iterator[Excess]:
    length = np.sqrt((normal * normal).sum(axis=1))
    out = (length < 0.5) | (length > 2.0)
    yield Excess(out & there, length, "a normal has length {:.3g}")
    along = np.abs((normal * v).sum(axis=1))
    cosine = np.divide(along, d, out=np.zeros_like(d), where=d > 0)
    grazing = (cosine > 0) & (cosine < EDGE_ON)
    yield Excess(grazing & there, cosine, "a cosine is {:.3g}")


def _joins(one: Pass, inputs: dict[str, NDArray[Any]]) -> Iterator[Join]:
    """Points and samples that the pass joins, those of neighbours too."""
    if not one.joins:
        return
    everywhere = np.ones(len(inputs[one.joins[0][0]]), bool)
    for viewer, sample in one.joins:
        yield sample, _point(inputs, viewer), _point(inputs, sample), everywhere
    around = source_rows(inputs)
    if around is None:
        return
    x, own = (_point(inputs, name) for name in one.joins[0])
    x_from, y = (_point(inputs, around.prefix + name) for name in one.joins[0])
    reused = list(_reused(inputs[around.rows]))
    for k, (row, there) in enumerate(reused):
        yield f"sample of {k}", x, y.rows(row), there
        yield "position", x_from.rows(row), own, there
        if not around.prefix:
            yield "past_position", x.rows(row), _point(inputs, "past_position"), there
        for j, (other, is_there) in enumerate(reused):
            yield f"sample of {j}", x_from.rows(row), y.rows(other), there & is_there


def _reused(neighbors: NDArray[Any]) -> list[tuple[NDArray[Any], Masks]]:
    """Row of each neighbour, and whether there is one."""
    return [(np.maximum(row, 0), row >= 0) for row in neighbors.T]

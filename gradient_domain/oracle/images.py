"""Replay of images: colours, differences, and what is solved from them.

A solver is judged by what it leaves, never by how it gets there.  Least squares leave
a residual of the normal equations; least absolute values a sum that is held against
the smallest one known, and this one against a dual bound, which proves how small it
could be [Boyd11].
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.sparse import csc_array, csr_array, eye_array, vstack
from scipy.sparse.linalg import splu

from restir_gi.gradient_domain.oracle.contract import BY_CHANNELS
from restir_gi.gradient_domain.oracle.rules import PairRules, pairing
from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars, Vec3s
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.replay.bounded import Bounded, exact, rounding_of
from restir_gi.reference.oracle.replay.geometry import LUMINANCE
from restir_gi.reference.oracle.replay.judgement import Compared, Judgement, beside
from restir_gi.reference.oracle.replay.rules import Rules
from restir_gi.reference.oracle.replay.verbs import choose, times

# ------------------------------------------------ colours and differences


def judge_primal(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``primal``."""
    part, rounding = pairing(rules), rounding_of(precision)
    value, W, emission = (
        exact(case.inputs[name], rounding) for name in ("value", "W", "emission")
    )
    color = times(value, W) if part.weighted else value
    color = color + emission if part.emission else color
    return Judgement((beside("color", outputs["color"], color),))


def _told(outputs: Buffers, x: Bounded, y: Bounded) -> Judgement:
    return Judgement((beside("dx", outputs["dx"], x), beside("dy", outputs["dy"], y)))


def judge_pair_differences(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``pair_differences``."""
    part, rounding = pairing(rules), rounding_of(precision)
    x, y = (exact(case.inputs[f"delta_{axis}"], rounding) for axis in "xy")
    if part.exchanged:
        x, y = y, x
    if part.forward:
        x, y = -x, -y
    if not part.border_kept:
        width, row = int(case.settings["width"]), np.arange(case.rows)
        last = row % width == width - 1
        x = choose(last, x - x, x)
        y = choose(row >= case.rows - width, y - y, y)
    return _told(outputs, x, y)


def judge_differences(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``differences``."""
    part, width = pairing(rules), int(case.settings["width"])
    color = exact(case.inputs["color"], rounding_of(precision))
    found = []
    for down in (False, True):
        before, after, exists = neighbors_in(case.rows, width, down, part)
        d = color[after] - color[before]
        d = -d if part.differences == "reversed" else d
        found.append(choose(exists, d, d - d))
    x, y = found[::-1] if part.exchanged else found
    return _told(outputs, x, y)


def neighbors_in(
    size: int, width: int, down: bool, rules: PairRules
) -> tuple[Indices, Indices, Masks]:
    """Pixels between which the difference of each pixel lies, along an axis.

    Parameters
    ----------
    size : int; N, of an image
    down : bool; along columns

    Returns
    -------
    before, after : (N,) int; any where there is none
    exists : (N,) bool
    """
    row = np.arange(size)
    x, step = row % width, width if down else 1
    first, last = row < width, row >= size - width
    if not down:
        first, last = x == 0, (x == width - 1) | (row == size - 1)
    if rules.differences == "backward":
        return np.maximum(row - step, 0), row, ~first
    after = np.minimum(row + step, size - 1)
    if "periodic" in (rules.differences, rules.edges):
        back = row % width if down else row - x
        return row, np.where(last, back, after), np.ones(size, bool)
    return row, after, ~last


# ------------------------------------------------ what an image is solved from


@dataclass(frozen=True, slots=True, eq=False)
class Problem:
    """Rows A I = b that an image of N pixels is to fulfil as well as it can.

    Attributes
    ----------
    A : (3 N, N) sparse; alpha, then D_x, then D_y
    b : (3 N, C); alpha P, then dx, then dy
    """

    A: csr_array
    b: Vec3s


def _steps(case: Case, down: bool, rules: PairRules) -> csr_array:
    """Differences of all pixels along an axis, (N, N); 0 where there is none."""
    width, size = int(case.settings["width"]), case.rows
    before, after, exists = neighbors_in(size, width, down, rules)
    row = np.flatnonzero(exists)
    ones = np.ones(len(row))
    place = np.concatenate([row, row]), np.concatenate([after[row], before[row]])
    return csr_array((np.concatenate([ones, -ones]), place), shape=(size, size))


def _borders(case: Case) -> csr_array:
    """Pixels on each of the four borders, each by itself, (B, N)."""
    width, size = int(case.settings["width"]), case.rows
    row = np.arange(size)
    x = row % width
    sides = (x == 0, x == width - 1, row < width, row >= size - width)
    found = np.concatenate([row[side] for side in sides])
    place = np.arange(len(found)), found
    return csr_array((np.ones(len(found)), place), shape=(len(found), size))


LEAST_ALPHA, MOST_ALPHA = 1e-6, 1e6
"""Beyond them nothing is left of pixels, or of differences."""


def problem_of(case: Case, rules: PairRules) -> Problem:
    """What a case asks for."""
    alpha = min(max(float(case.settings["alpha"]), LEAST_ALPHA), MOST_ALPHA)
    P, x, y = (case.inputs[n].astype(float) for n in ("primal", "dx", "dy"))
    if rules.exchanged:
        x, y = y, x
    if not rules.divergence:
        x, y = -x, -y
    D_x, D_y = (_steps(case, down, rules) for down in (False, True))
    weight = {"squared": alpha, "plain": np.sqrt(alpha), "twice": alpha**2, "one": 1.0}
    a = weight[rules.alpha]
    on_pixels, on_differences = (a, 1.0) if rules.alpha_on == "pixels" else (1.0, a)
    rows = [
        eye_array(case.rows) * on_pixels,
        D_x * on_differences,
        D_y * on_differences,
    ]
    b = np.concatenate([on_pixels * P, on_differences * x, on_differences * y])
    if rules.edges == "black":
        rows.append(_borders(case))
        b = np.concatenate([b, np.zeros((rows[-1].shape[0], b.shape[1]))])
    A = csr_array(vstack(rows))
    if rules.mixed:
        b = np.repeat((b @ np.array(LUMINANCE))[:, None], 3, axis=1)
    return Problem(A, b)


# ------------------------------------------------ least squares


def judge_poisson_l2(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``poisson_l2``: by the residual of the normal equations."""
    part = pairing(rules)
    return _least_squares(
        case, outputs, part, precision, float(case.settings["residual"])
    )


def _least_squares(
    case: Case,
    outputs: Buffers,
    rules: PairRules,
    precision: Precision,
    residual: float,
) -> Judgement:
    found = outputs["color"].astype(float)
    if rules.added:
        found = found - case.inputs["primal"].astype(float)
    p = problem_of(case, rules)
    normal, right = p.A.T @ p.A, p.A.T @ p.b
    left = normal @ found
    allowed = residual * _length(right) + rounding_residual(p, found, precision)
    off = _length(right - left)
    # All pixels of a channel are right together, or some that are far off are wrong.
    row = np.where(off > allowed, allowed / np.sqrt(case.rows), np.inf)
    compared = Compared(
        "alpha² color − div grad color", left, right, np.broadcast_to(row, left.shape)
    )
    share = np.broadcast_to(off / np.maximum(_length(right), 1e-300), left.shape)
    return Judgement((compared,), {"residual": share})


def _length(columns: Vec3s) -> Scalars:
    found: Scalars = np.sqrt((columns * columns).sum(axis=0))
    return found


def rounding_residual(p: Problem, image: Vec3s, precision: Precision) -> Scalars:
    """Residual that rounding alone may leave in each channel, (C,).

    The image is rounded, and so are b and what a solver takes for A I: each number by a
    unit of the sum of magnitudes it is made of [Higham02, section 3.3].
    """
    rounding, A = rounding_of(precision), abs(p.A)
    magnitude = A.T @ (A @ np.abs(image)) + A.T @ np.abs(p.b)
    return rounding.unit * _length(magnitude)


# ------------------------------------------------ least absolute values


def _lengths(rows: Vec3s) -> Scalars:
    found: Scalars = np.sqrt((rows * rows).sum(axis=1))
    return found


def _sums(rows: Vec3s) -> Scalars:
    found: Scalars = np.abs(rows).sum(axis=1)
    return found


@dataclass(frozen=True, slots=True, eq=False)
class LeastSum:
    """The smallest sum of absolute values that is known, and a bound below all of them.

    Attributes
    ----------
    image : (N, C)
    total, bound : float; sum of the image, and what no image is below
    """

    image: Vec3s
    total: float
    bound: float


SWEEPS = 1500
"""Of alternation, at most: it ends where the bound is close enough."""


def least_sum(p: Problem) -> LeastSum:
    """Minimize Σ |A I − b| by alternating directions, with a sparse factorization.

    Multipliers y with Aᵀ y = 0 and |y| ≤ 1 in each row prove Σ |A I − b| ≥ −b · y for
    every image: [Boyd11, section 6.1].
    """
    solve: Callable[[Vec3s], Vec3s] = splu(csc_array(p.A.T @ p.A)).solve
    image = solve(p.A.T @ p.b)
    off = p.A @ image - p.b
    scale = float(np.mean(_lengths(off)))
    if scale == 0:
        return LeastSum(image, 0.0, 0.0)
    u, best, bound = np.zeros_like(off), (float(_lengths(off).sum()), image), 0.0
    shortest = scale / 0.3
    for sweep in range(SWEEPS):
        moved = off + u
        share = np.minimum(1.0, shortest / np.maximum(_lengths(moved), shortest))
        u = moved * share[:, None]
        image = solve(p.A.T @ (p.b + moved - 2.0 * u))
        off = p.A @ image - p.b
        if sweep % 50 == 49:
            total = float(_lengths(off).sum())
            best = min(best, (total, image), key=lambda pair: pair[0])
            bound = max(bound, _dual(p, u / shortest, solve))
            if total <= bound * (1 + 1e-4):
                break
    return LeastSum(best[1], best[0], bound)


def _dual(p: Problem, y: Vec3s, solve: Callable[[Vec3s], Vec3s]) -> float:
    """Bound from multipliers, brought to where they prove something."""
    # The nearest ones with Aᵀ y = 0, shortened together until none is longer than 1.
    y = y - p.A @ solve(p.A.T @ y)
    longest = max(1.0, float(_lengths(y).max()))
    return float(-(p.b * y).sum() / longest)


@lru_cache(maxsize=64)
def _least_sum(
    case_bytes: bytes,
    shape: tuple[int, int],
    settings: tuple[float, ...],
    rules: PairRules,
    by_channels: bool,
) -> LeastSum:
    """By content: the same case is asked for many times."""
    arrays = np.frombuffer(case_bytes).reshape((3, *shape))
    inputs = dict(zip(("primal", "dx", "dy"), arrays, strict=True))
    width, alpha = settings
    case = Case("", "poisson_l1", {"width": int(width), "alpha": alpha}, inputs)
    p = problem_of(case, rules)
    if not by_channels:
        return least_sum(p)
    each = [least_sum(Problem(p.A, b[:, None])) for b in p.b.T]
    # Each channel has a sum of its own, and so a bound.
    return LeastSum(
        np.concatenate([one.image for one in each], axis=1),
        sum(one.total for one in each),
        sum(one.bound for one in each),
    )


def _by_channels(case: Case) -> bool:
    return case.settings.get("norm") == BY_CHANNELS


def least_sum_of(case: Case, rules: PairRules) -> LeastSum:
    """The smallest sum for a case."""
    arrays = [case.inputs[n].astype(float) for n in ("primal", "dx", "dy")]
    settings = float(case.settings["width"]), float(case.settings["alpha"])
    about = np.stack(arrays).tobytes(), arrays[0].shape, settings, rules
    return _least_sum(*about, _by_channels(case))


def judge_poisson_l1(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``poisson_l1``: by the sum of absolute values."""
    part = pairing(rules)
    ratio = float(case.settings["ratio"])
    if part.norm == "squares":
        return _least_squares(case, outputs, part, precision, SQUARES)
    least, p = least_sum_of(case, part), problem_of(case, part)
    found = outputs["color"].astype(float)
    if part.added:
        found = found - case.inputs["primal"].astype(float)
    sizes = _sums if _by_channels(case) else _lengths
    sums, ours = (
        sizes(p.A @ image - p.b).reshape(3, -1).sum(axis=0)
        for image in (found, least.image)
    )
    rounding = rounding_of(precision).unit * float(
        (abs(p.A) @ np.abs(found) + np.abs(p.b)).sum()
    )
    most = (1 + ratio) * least.total + rounding
    # All pixels are right together, or those that add too much are wrong.
    too_much = sums.sum() > most
    share = ours * (most / max(least.total, 1e-300))
    compared = Compared(
        "E of the pixel",
        sums,
        np.minimum(sums, share) if too_much else sums,
        np.zeros_like(sums),
    )
    every = np.ones(case.rows)
    return Judgement(
        (compared,),
        {
            "E": sums.sum() * every,
            "least E": least.total * every,
            "bound of E": least.bound * every,
        },
    )


SQUARES = 1e-3
"""Residual of what is taken for least squares."""

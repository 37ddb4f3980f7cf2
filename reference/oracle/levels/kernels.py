"""L0: formulas one by one, on ordinary rows and at the extremes."""

from functools import lru_cache
from itertools import product
from math import radians

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars, Vec3s, normalize
from restir_gi.reference.oracle.buffers import given
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision, Value
from restir_gi.reference.oracle.levels.draws import ends_of_u, spread, unit_vectors
from restir_gi.reference.oracle.levels.exact import examined_exactly
from restir_gi.reference.oracle.levels.exact_extremes import (
    direction_case,
    jacobian_reaches,
    similar_extremes,
    target_extremes,
)
from restir_gi.reference.oracle.levels.grades import graded
from restir_gi.reference.oracle.levels.probe import Finding, Probe
from restir_gi.reference.oracle.levels.replayed import replayed
from restir_gi.reference.oracle.levels.worst import worst_cases
from restir_gi.reference.oracle.parts import SEED, whole_contract
from restir_gi.reference.oracle.working_range import where_beyond

ROWS = 2048


# The same cases for every backend, so that their exact numbers are calculated once.
@lru_cache(maxsize=4)
def kernel_probes(precision: Precision, seed: int = SEED) -> tuple[Probe, ...]:
    """One probe of level L0 for each kernel, and more where it has extremes.

    All but ``random``, which is integer, are held against exact numbers, which are
    calculated when an answer is examined.

    Parameters
    ----------
    seed : int; of the rows that are no extremes
    """
    rng = np.random.default_rng([2025, seed])
    words = _random(rng, precision)
    cases = [
        _target(rng, precision, "scattered"),
        _target(rng, precision, "outgoing"),
        shade_case(rng, precision),
        _jacobian(rng, precision),
        _merge(rng, precision),
        _merge_extremes(precision),
        _finalize(rng, precision),
        _similar(rng, precision, ROWS, 25.0, 0.05),
        _similar(rng, precision, ROWS // 4, 70.0, 0.4),
        direction_case(rng, "uniform", precision),
        direction_case(rng, "cosine", precision),
        target_extremes("scattered", precision),
        target_extremes("outgoing", precision),
        similar_extremes(precision),
        *worst_cases(precision),
    ]
    return (
        replayed("L0", words),
        *(Probe("L0", graded(case), examined_exactly) for case in cases),
        Probe("L0", graded(_jacobian_extremes(precision)), _total),
    )


def _random(rng: np.random.Generator, precision: Precision) -> Case:
    corners = np.array(list(product([0, 1, 2**31, 2**32 - 1], repeat=4)), np.uint32)
    words = rng.integers(0, 2**32, (ROWS, 4), np.uint32)
    inputs = {"key": np.concatenate([corners, words])}
    return Case("kernel-random", "random", {}, given(inputs, precision))


def light_points(rng: np.random.Generator, rows: int = ROWS) -> dict[str, Scalars]:
    """Visible points and sample points of all kinds, pure colours among them.

    Returns dict of str to (N, 3) float64; buffers, with places in m.
    """
    x = rng.normal(size=(rows, 3))
    scale = 2.0 ** rng.integers(-10, 11, (rows, 1))
    pure = rng.random((2, rows, 3)) < 0.8
    return {
        "visible_position": x,
        "visible_normal": unit_vectors(rng, rows),
        "albedo": rng.random((rows, 3)) * pure[0],
        "position": x + scale * rng.normal(size=(rows, 3)),
        "normal": unit_vectors(rng, rows),
        # From what half precision cannot hold to what it cannot hold either.
        "radiance": 10.0 ** rng.uniform(-7, 6, (rows, 3)) * pure[1],
    }


def _target(rng: np.random.Generator, precision: Precision, kind: str) -> Case:
    name = f"kernel-target-{kind}"
    return Case(name, "target", {"target": kind}, given(light_points(rng), precision))


def shade_case(rng: np.random.Generator, precision: Precision) -> Case:
    """Case of pass ``shade``."""
    W = 10.0 ** rng.uniform(-3, 3, ROWS) * (rng.random(ROWS) < 0.9)
    return Case(
        "kernel-shade", "shade", {}, given(light_points(rng) | {"W": W}, precision)
    )


def _jacobian(rng: np.random.Generator, precision: Precision) -> Case:
    position = rng.normal(size=(ROWS, 3))
    reach = 2.0 ** rng.integers(-9, 10, (2, ROWS, 1))
    inputs = {
        "x_from": position + reach[0] * rng.normal(size=(ROWS, 3)),
        "x_to": position + reach[1] * rng.normal(size=(ROWS, 3)),
        "position": position,
        "normal": unit_vectors(rng, ROWS),
    }
    _without_inverse(inputs)
    for name, extremes in jacobian_reaches().items():
        inputs[name][: len(extremes)] = extremes
    return Case("kernel-jacobian", "jacobian", {}, given(inputs, precision))


def _without_inverse(inputs: dict[str, Vec3s]) -> None:
    """Last rows in which J is 0: seen edge-on, to the last bit, and points that touch.

    32 rows each: from x_from, from x_to, at x_from, and at x_to.
    """
    inputs["normal"][-128:-64] = [0.0, 1.0, 0.0]
    for side, name in enumerate(("x_from", "x_to")):
        rows = slice(-128 + 32 * side, -96 + 32 * side)
        inputs[name][rows, 1] = inputs["position"][rows, 1]
        rows = slice(-64 + 32 * side, -32 + 32 * side or None)
        inputs[name][rows] = inputs["position"][rows]


def _jacobian_extremes(precision: Precision) -> Case:
    """Points that touch, patches seen edge-on, squares that leave the number type."""
    reach = [0.0, 1e-25, 1e-10, 1.0, 1e10, 1e18]
    axes = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.6, 0.8, 0.0]])
    rows = list(product(reach, reach, range(3), range(3)))
    d_from, d_to, a_from, a_to = (
        np.array(column) for column in zip(*rows, strict=True)
    )
    inputs = {
        "x_from": d_from[:, None] * axes[a_from],
        "x_to": d_to[:, None] * axes[a_to],
        "position": np.zeros((len(rows), 3)),
        "normal": np.tile([0.0, 1.0, 0.0], (len(rows), 1)),
    }
    return Case("kernel-jacobian-extremes", "jacobian", {}, given(inputs, precision))


def _total(case: Case, out: Buffers, precision: Precision) -> Finding:
    """Finite everywhere, which was asked before; never negative; 0 for what is not."""
    J = out["jacobian"]
    given_points = case.inputs
    v_from = given_points["x_from"].astype(float)
    edge_on = (v_from[:, 1] == 0) | (~given_points["x_to"].any(axis=1))
    bad = (J < 0) | (edge_on & (J != 0))
    if not bad.any():
        return Finding(True)
    rows = bad & case.within if (bad & case.within).any() else bad
    row = int(np.flatnonzero(rows)[0])
    text = f"{case.name}: row {row} is {J[row]:g}, where the shift has no inverse it"
    text += " is 0, and it is never negative"
    if case.within[row]:
        return Finding(False, text)
    where = where_beyond(whole_contract()[case.pass_name], dict(given_points), row)
    return Finding(True, at_extremes=f"{text}; at extremes alone, where {where}")


def _merge(rng: np.random.Generator, precision: Precision) -> Case:
    def weights() -> Scalars:
        w: Scalars = spread(rng, -6, 6, ROWS) * (rng.random(ROWS) < 0.7)
        return w

    inputs = {
        "w_a": weights(),
        "M_a": rng.integers(0, 500, ROWS).astype(float),
        "w_b": weights(),
        "M_b": rng.integers(0, 500, ROWS).astype(float),
        "u": ends_of_u(rng, ROWS),
    }
    return Case("kernel-merge", "merge", {}, given(inputs, precision), random=True)


def _merge_extremes(precision: Precision) -> Case:
    """Nothing beside something, the smallest and largest u, weights far apart."""
    w = [0.0, 1e-30, 1.0, 1e30]
    u = [0.0, 2.0**-24, 0.5, 1 - 2.0**-24]
    rows = np.array(list(product(w, w, u)))
    ones = np.ones(len(rows))
    inputs = {"w_a": rows[:, 0], "M_a": ones, "w_b": rows[:, 1], "M_b": ones * 2}
    inputs["u"] = rows[:, 2]
    return Case("kernel-merge-extremes", "merge", {}, given(inputs, precision))


def _finalize(rng: np.random.Generator, precision: Precision) -> Case:
    w = 10.0 ** rng.uniform(-15, 15, ROWS)
    p_hat = 10.0 ** rng.uniform(-15, 15, ROWS)
    Z = rng.integers(0, 500, ROWS) * (rng.random(ROWS) < 0.95)
    corners = np.array(
        list(product([0.0, 1e-35, 1.0, 1e30], [0.0, 1e-35, 1.0], [0.0, 1.0]))
    )
    inputs = {
        "w": np.concatenate([w * (rng.random(ROWS) < 0.9), corners[:, 0]]),
        "p_hat": np.concatenate([p_hat * (rng.random(ROWS) < 0.9), corners[:, 1]]),
        "Z": np.concatenate([Z.astype(float), corners[:, 2]]),
    }
    return Case("kernel-finalize", "finalize", {}, given(inputs, precision))


def _similar(
    rng: np.random.Generator,
    precision: Precision,
    rows: int,
    max_angle: float,
    max_depth: float,
) -> Case:
    """Normals and depths about the limits."""
    n = unit_vectors(rng, rows)
    near = normalize(n + rng.normal(size=(rows, 3)) * 0.6 * radians(max_angle))
    depth = 10.0 ** rng.uniform(-2, 3, rows) * (rng.random(rows) < 0.95)
    beside = 1.6 * max_depth
    inputs = {
        "normal_a": n,
        "depth_a": depth,
        "normal_b": near,
        "depth_b": depth * rng.uniform(1 - beside, 1 + beside, rows),
    }
    settings: dict[str, Value] = {"max_angle": max_angle, "max_depth": max_depth}
    name = "kernel-similar" if rows == ROWS else "kernel-similar-wide"
    return Case(name, "similar", settings, given(inputs, precision))

"""Cases of L0 at the ends of what a kernel may be given."""

from collections.abc import Iterable
from itertools import product
from typing import Any

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars, Vec3s
from restir_gi.reference.oracle.buffers import given
from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.levels.draws import STEP


def direction_case(rng: np.random.Generator, source: str, precision: Precision) -> Case:
    """Directions about axes, normals beside the poles and the equator, and others.

    The first row of each normal is the origin of its azimuths, and so leans away from
    it.
    """
    ends = [0.0, STEP, 0.5, 1 - STEP]
    corners = list(product(ends, [*ends, 0.25]))
    others = rng.integers(0, 2**24, (12, 2)) * STEP
    u = np.concatenate([[[0.5, 0.0]], corners, others])
    normals = np.concatenate([_normals(), rng.normal(size=(16, 3))])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    inputs = {
        "visible_normal": np.repeat(normals, len(u), axis=0),
        "u": np.tile(u, (len(normals), 1)),
    }
    settings = {"source": source}
    name = f"kernel-direction-{source}"
    return Case(name, "direction", settings, given(inputs, precision))


def _normals() -> Vec3s:
    """Where frames about a normal change their branch, or nearly divide by 0."""
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    off = [1e-3, 1e-5, 1e-8, 1e-20]
    poles = [[a, -b, z] for a, b in zip(off, off[::-1], strict=True) for z in (1, -1)]
    equator = [[0.6, 0.8, z] for z in (1e-8, -1e-8)]
    # A zero has no sign here: whether the frame heeds it is the backend's affair.
    return np.concatenate([axes, poles, equator]) + 0.0


def target_extremes(kind: str, precision: Precision) -> Case:
    """Points that touch or are far, grazing light, radiance at the ends of the type.

    About the origin, where all distances are kept, and beside it, where positions are
    rounded and the nearest points touch.
    """
    tiny = float(np.finfo(precision).tiny)
    distances = [0.0, 1e-25, 1e-15, 1e-3, 1.0, 1e10]
    slopes = [1e3, 0.75, 1e-3, 1e-7, 1e-20, 0.0, -1e-7]
    sides = np.array([[-0.6, -0.8, 0.0], [-1e-7, 0.0, 1.0], [0.0, 0.0, 1.0]])
    powers = [tiny, 4 * tiny, 1e-30, 1.0, 1e30]
    rows = list(product(distances, slopes, range(len(sides)), powers, [0.0]))
    rows += list(product(distances, slopes, range(len(sides)), [1.0], [1.0]))
    distance, slope, side, power, beside = _columns(rows)
    across = np.ones(len(rows))
    toward = np.stack([across, slope, 0 * across], axis=1)
    x = beside[:, None] * [1.0, -2.0, 4.0]
    inputs = {
        "visible_position": x,
        "visible_normal": np.tile([0.0, 1.0, 0.0], (len(rows), 1)),
        "albedo": np.resize([[1.0, 1.0, 1.0], [0.9, 0.5, 0.0]], (len(rows), 3)),
        "position": x + distance[:, None] * toward,
        "normal": sides[side],
        "radiance": power[:, None] * [1.0, 0.25, 0.0],
    }
    name = f"kernel-target-extremes-{kind}"
    return Case(name, "target", {"target": kind}, given(inputs, precision))


def jacobian_reaches() -> dict[str, Vec3s]:
    """Distances and angles far apart, whose numbers all stay in the type.

    Returns
    -------
    dict of str to (N, 3) float64
        Inputs of pass ``jacobian`` with J from 1e-27 to 1e27; the cube of a quotient of
        distances is in range too.
    """
    reach = [1e-6, 1e-3, 1.0, 1e3, 1e6]
    slopes = np.array([[0.0, 1.0, 0.0], [1.0, 1e-3, 0.0], [0.6, -0.8, 0.0]])
    rows = list(product(reach, reach, range(len(slopes)), range(len(slopes))))
    d_from, d_to, from_slope, to_slope = _columns(rows)
    return {
        "x_from": d_from[:, None] * slopes[from_slope],
        "x_to": d_to[:, None] * slopes[to_slope],
        "position": np.zeros((len(rows), 3)),
        "normal": np.tile([0.0, 1.0, 0.0], (len(rows), 1)),
    }


def similar_extremes(precision: Precision) -> Case:
    """At the limits of angle and depth and some roundings beside them, and depth 0.

    The limits are binary numbers, cosine 1/2 and depth 1/16, so that they are met; once
    along each axis.
    """
    beside = np.array([-64, -8, -1, 0, 1, 8, 64]) * float(np.finfo(precision).eps)
    ends = [0.0, float(np.finfo(precision).tiny), 1.0, 1e30]
    scales = [2.0**-100, 1.0, 2.0**100]
    rows = [(0.5 * (1 + b), 2.0, 2.0) for b in beside]
    rows += [(1.0, 16 * s, 15 * (1 + b) * s) for s, b in product(scales, beside)]
    rows += [(1.0, 15 * (1 + b) * s, 16 * s) for s, b in product(scales, beside)]
    rows += [(1.0, *pair) for pair in product(ends, ends)]
    rows += [(-1.0, z, z) for z in ends]
    cosine, depth_a, depth_b = _columns(rows)
    normal_a = np.tile([1.0, 0.0, 0.0], (len(rows), 1))
    normal_b = np.stack([cosine, 0 * cosine, np.sqrt(1 - cosine**2)], axis=1)
    axes = range(3)
    inputs = {
        "normal_a": np.concatenate([np.roll(normal_a, k, axis=1) for k in axes]),
        "depth_a": np.tile(depth_a, 3),
        "normal_b": np.concatenate([np.roll(normal_b, k, axis=1) for k in axes]),
        "depth_b": np.tile(depth_b, 3),
    }
    settings = {"max_angle": 60.0, "max_depth": 0.0625}
    name = "kernel-similar-extremes"
    return Case(name, "similar", settings, given(inputs, precision))


def _columns(rows: Iterable[tuple[Any, ...]]) -> list[Scalars]:
    return [np.array(column) for column in zip(*rows, strict=True)]

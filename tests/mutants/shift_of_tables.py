"""Pass ``shift`` by hand: from the tables of a case alone, as the contract says.

The project's own pass walks through the scene, where some mistakes cannot be made: it
has no base path to confuse with the offset path, and no table to read past its end.
There another criterion also moves the walk: what may be joined is a point, not a ray.
"""

from typing import Any

import numpy as np

from restir_gi.reference.numerics.arrays import (
    Masks,
    Scalars,
    Vec3s,
    divide_or_zero,
    dot,
    length,
)
from restir_gi.reference.oracle.cases import Buffers, Case

FLAGS = ("hit", "single", "delta", "joint_single", "seen")


def shift(case: Case) -> Buffers:
    """Value and Jacobian of the shifted paths, in the precision of the case."""
    given = {name: array.astype(float) for name, array in case.inputs.items()}
    given |= {name: case.inputs[name] == 1 for name in FLAGS}
    joined = given["joint"] > 0
    m = np.where(joined, given["joint"] - 1, given["end"])
    m = m.astype(int).clip(1, given["hit"].shape[1])
    way = given["joint_position"] - given["position"][np.arange(case.rows), m - 1]
    value, jacobian = _by_joining(given, m, way)
    light = _throughput(given, m) * given["light"]
    value = np.where(joined[:, None], value, light)
    there = _walk(given, case.settings, m) & value.any(axis=1)
    there &= ~joined | _joint(given, case.settings, m, way)
    jacobian = np.where(joined, jacobian, 1.0)
    real = case.inputs["density"].dtype
    return {
        "value": np.where(there[:, None], value, 0.0).astype(real),
        "jacobian": np.where(there, jacobian, 0.0).astype(real),
    }


def _joinable(
    alpha: tuple[Scalars, Scalars],
    single: tuple[Masks, Masks],
    distance: Scalars,
    settings: Any,
) -> Masks:
    """Pass ``joinable``, of any shape."""
    least = settings["least_distance"] * settings["extent"]
    rough = np.where(single, -1.0, np.sqrt(alpha))
    able: Masks = np.minimum(*rough) >= settings["roughness"]
    return able & (distance > 0) & (distance > least)


def _walk(given: Any, settings: Any, m: Any) -> Masks:
    """Whether the offset walk goes as far as x_m, and cannot be joined before."""
    slots = given["hit"].shape[1]
    v = np.arange(1, slots + 1)
    before, at = v < m[:, None], v == m[:, None]
    position, alpha, single = (given[n] for n in ("position", "alpha", "single"))
    distance = np.linalg.norm(given["contact"][:, 1:] - position[:, :-1], axis=2)
    came = np.zeros_like(given["hit"])
    came[:, 1:] = _joinable(
        (alpha[:, :-1], alpha[:, 1:]),
        (single[:, :-1], single[:, 1:]),
        distance,
        settings,
    )
    came[:, 1:] &= ~given["delta"][:, :-1] & (v[1:] <= settings["last_joint"])
    chosen = (given["joint"] > 0) | (given["technique"] == 1)
    early = came & ((before & ~given["delta"]) | (at & chosen[:, None]))
    early |= came & at & ~given["delta"]
    walked = (given["hit"] | (v > m[:, None])).all(axis=1)
    there: Masks = (given["end"] > 0) & walked & ~early.any(axis=1)
    return there & ((given["joint"] == 2) | (settings["replays"] == 1))


def _joint(given: Any, settings: Any, m: Any, way: Vec3s) -> Masks:
    """Whether x_m and x_c may be joined, and see each other's front."""
    at = np.arange(len(m)), m - 1
    able = _joinable(
        (given["alpha"][at], given["joint_alpha"]),
        (given["single"][at], given["joint_single"]),
        length(way),
        settings,
    )
    front = dot(given["joint_normal"], way) < 0
    return able & front & given["seen"]


def _throughput(given: Any, m: Any) -> Vec3s:
    """Product of the weights of x_1 to x_(m-1), (N, 3)."""
    used = np.arange(1, given["hit"].shape[1] + 1) < m[:, None]
    product: Vec3s = np.where(used[..., None], given["weight"], 1.0).prod(axis=1)
    return product


def _spread(given: Any, way: Vec3s) -> Scalars:
    """Solid angle of an area at x_c, |cos| / d², (N,)."""
    d = length(way)
    return divide_or_zero(abs(dot(given["joint_normal"], way)), d**3)


def _by_joining(given: Any, m: Any, way: Vec3s) -> tuple[Vec3s, Scalars]:
    p, q, p_light = (given[n] for n in ("pdf_left", "pdf_onward", "pdf_light"))
    chosen, last = given["technique"] == 1, given["joint"] == given["end"]
    p_last = q
    share = divide_or_zero(np.where(chosen, p_light, p_last), p_light + p_last)
    share = np.where(chosen & (p_light == 0), 1.0, share)
    share = np.where(last, share, 1.0)
    q = np.where(chosen & last, 1.0, q)
    value = _throughput(given, m)
    value = value * divide_or_zero(given["left"], p[:, None])
    value = value * divide_or_zero(given["onward"], q[:, None])
    value = value * share[:, None] * given["incoming"]
    base = given["density"]
    return value, divide_or_zero(p * _spread(given, way) * q, base)

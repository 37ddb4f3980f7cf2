"""Kernels of the contract by the production kernels."""

from collections.abc import Callable, Mapping

import numpy as np

from restir_gi.reference.numerics.frames import to_world
from restir_gi.reference.numerics.rng import pcg4d, to_unit_interval
from restir_gi.reference.numerics.sampling import (
    pdf_cosine_hemisphere,
    pdf_uniform_hemisphere,
    sample_cosine_hemisphere,
    sample_uniform_hemisphere,
)
from restir_gi.reference.oracle.builtin.buffers import Array, as_real, target_of
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.contract.surfaces import LAMBERTIAN
from restir_gi.reference.passes.gbuffer import similar
from restir_gi.reference.resampling.reservoir import Candidates, choose_second, finalize
from restir_gi.reference.resampling.shift import reconnection_jacobian


def _random(
    precision: Precision,
    key: Array,
) -> dict[str, Array]:
    words = np.stack(pcg4d(*(key[:, lane] for lane in range(4))), axis=1)
    return {"words": words, "u": as_real(precision, to_unit_interval(words))}


def _direction(
    precision: Precision, visible_normal: Array, u: Array, source: str
) -> dict[str, Array]:
    uniform = source == "uniform"
    sample = sample_uniform_hemisphere if uniform else sample_cosine_hemisphere
    pdf = pdf_uniform_hemisphere if uniform else pdf_cosine_hemisphere
    local = sample(u[:, 0], u[:, 1])
    return {
        "direction": as_real(precision, to_world(local, visible_normal)),
        "pdf": as_real(precision, pdf(local[:, 2])),
    }


def _target(
    precision: Precision,
    target: str,
    surface: str = LAMBERTIAN,
    **buffers: Array,
) -> dict[str, Array]:
    return {"p_hat": as_real(precision, target_of(target, buffers, surface))}


def _jacobian(
    precision: Precision, x_from: Array, x_to: Array, position: Array, normal: Array
) -> dict[str, Array]:
    return {"jacobian": reconnection_jacobian(x_from, x_to, position, normal)}


def _merge(
    precision: Precision, w_a: Array, M_a: Array, w_b: Array, M_b: Array, u: Array
) -> dict[str, Array]:
    second = choose_second(w_a, w_b, u).astype(np.uint32)
    return {"second": second, "w": w_a + w_b, "M": M_a + M_b}


def _finalize(
    precision: Precision, w: Array, p_hat: Array, Z: Array
) -> dict[str, Array]:
    return {"W": finalize(Candidates(w, p_hat, w, Z), Z).W}


def _similar(
    precision: Precision,
    normal_a: Array,
    depth_a: Array,
    normal_b: Array,
    depth_b: Array,
    max_angle: float,
    max_depth: float,
) -> dict[str, Array]:
    alike = similar(normal_a, depth_a, normal_b, depth_b, max_angle, max_depth)
    return {"similar": alike.astype(np.uint32)}


KERNELS: Mapping[str, Callable[..., dict[str, Array]]] = {
    "random": _random,
    "direction": _direction,
    "target": _target,
    "jacobian": _jacobian,
    "merge": _merge,
    "finalize": _finalize,
    "similar": _similar,
}

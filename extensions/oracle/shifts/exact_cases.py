"""Cases of the two small passes: made here, without a scene, the same for a seed."""

from typing import Any

import numpy as np
from numpy.random import Generator

from restir_gi.reference.oracle.buffers import given
from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.parts import SEED

ROWS = 256
NEAR = 2.0**-16
"""Just above and below a threshold: far more than either type rounds."""


def exact_cases(precision: Precision, seed: int = SEED) -> list[Case]:
    """Cases of both passes, with thresholds and extremes, in the contract's order.

    Parameters
    ----------
    precision : 'float32' or 'float64'
        In which the inputs are given: numbers that float32 holds.
    seed : int; of all rows
    """
    rng = np.random.default_rng([2028, seed])
    cases = [
        _joinable("joinable", _lobes(rng), (0.2, 0.01, 12.0), precision),
        _joinable("joinable-thresholds", _edges(rng), (0.5, 0.25, 2.0), precision),
        _joinable("joinable-always", _lobes(rng), (0.0, 0.0, 1.5), precision),
        _joinable("joinable-never", _lobes(rng), (2.0, 0.0, 1.5), precision),
    ]
    return [
        *cases,
        _jacobian("path-jacobian", _joints(rng, 1.0), precision),
        _jacobian("path-jacobian-large", _joints(rng, 1e3), precision),
        _jacobian("path-jacobian-degenerate", _degenerate(rng), precision),
    ]


def _joinable(
    name: str,
    inputs: dict[str, Any],
    settings: tuple[float, float, float],
    precision: Precision,
) -> Case:
    names = ("roughness", "least_distance", "extent")
    held = dict(zip(names, settings, strict=True))
    return Case(name, "joinable", held, _held(inputs, precision))


def _jacobian(name: str, inputs: dict[str, Any], precision: Precision) -> Case:
    return Case(name, "path_jacobian", {}, _held(inputs, precision))


def _held(inputs: dict[str, Any], precision: Precision) -> dict[str, Any]:
    held = {
        n: v.astype(np.float32) if v.dtype.kind == "f" else v for n, v in inputs.items()
    }
    return given(held, precision)


def _lobes(rng: Generator) -> dict[str, Any]:
    """Widths between their square and their root, where the two units differ."""
    alpha = rng.choice([1.0, 0.01, 0.09, 0.3, 0.1], (2, ROWS))
    single = (rng.random((2, ROWS)) < 0.15).astype(np.uint32)
    alpha[single == 1] = 0.0
    distance = 10.0 ** rng.uniform(-3, 1, ROWS)
    distance[::17] = 0.0
    return {
        "alpha_from": alpha[0],
        "alpha_to": alpha[1],
        "single_from": single[0],
        "single_to": single[1],
        "distance": distance,
    }


def _edges(rng: Generator) -> dict[str, Any]:
    """Just above and below 0.5² and 0.25 · 2, and on them, which is open or not."""
    aside = np.array([-NEAR, 0.0, NEAR])
    alpha = 0.25 * (1 + rng.choice(aside, (2, ROWS)))
    distance = 0.5 * (1 + rng.choice(aside, ROWS))
    alone = rng.integers(0, 3, ROWS)  # each threshold by itself
    alpha[0, alone != 0], alpha[1, alone != 1] = 1.0, 1.0
    distance[alone != 2] = 3.0
    none = np.zeros(ROWS, np.uint32)
    return {
        "alpha_from": alpha[0],
        "alpha_to": alpha[1],
        "single_from": none,
        "single_to": none,
        "distance": distance,
    }


def _joints(rng: Generator, scale: float) -> dict[str, Any]:
    normal = rng.normal(size=(ROWS, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    joint = rng.normal(size=(ROWS, 3)) * scale
    ways = rng.normal(size=(2, ROWS, 3)) * scale
    p = 10.0 ** rng.uniform(-3, 3, (4, ROWS))
    p[2:, ::3] = 1.0
    return {
        "x_from": joint + ways[0],
        "x_to": joint + ways[1],
        "joint_position": joint,
        "joint_normal": normal,
        "p_from": p[0],
        "p_to": p[1],
        "p_onward_from": p[2],
        "p_onward_to": p[3],
    }


def _degenerate(rng: Generator) -> dict[str, Any]:
    """No density, points that coincide, and surfaces seen edge-on."""
    inputs = _joints(rng, 1.0)
    names = ("p_from", "p_to", "p_onward_from", "p_onward_to")
    for place, name in enumerate(names):
        inputs[name][place::8] = 0.0
    for place, name in enumerate(("x_from", "x_to"), start=4):
        inputs[name][place::8] = inputs["joint_position"][place::8]
    edge = slice(6, None, 8)
    up, aside = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
    inputs["joint_normal"][edge] = up
    inputs["joint_position"][edge] = np.rint(inputs["joint_position"][edge])
    inputs["x_to"][edge] = inputs["joint_position"][edge] + aside
    return inputs

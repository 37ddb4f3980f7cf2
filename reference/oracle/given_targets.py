"""Cases whose targets are given as data: what stands in the buffer."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Scalars, divide_or_zero, dot
from restir_gi.reference.oracle.cases import SOURCES, Buffers, Case
from restir_gi.reference.oracle.contract.targets import DATA

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])

# Place, normal and colour of visible points, or of samples, (N, 3) each.
Points = tuple[NDArray[np.float64], ...]

# From visible points and samples to the targets of the samples, (N,).
Formula = Callable[[Points, Points], Scalars]


def with_given_targets(case: Case, formula: Formula) -> Case:
    """The same rows with targets that are given."""
    settings = {**case.settings, "target": DATA}
    inputs = {
        **case.inputs,
        "p_hat_given": given_targets(case.pass_name, case.inputs, formula),
    }
    return replace(case, settings=settings, inputs=inputs)


def given_targets(pass_name: str, inputs: Buffers, formula: Formula) -> Scalars:
    """Targets as a pass is given them.

    Returns
    -------
    (N, V, S) of V points and S samples; (N, S) where nothing moves, (N,) of one sample
        In the type of the pass's other numbers.
    """
    wide = {n: a.astype(float) if a.dtype.kind == "f" else a for n, a in inputs.items()}
    viewers, samples = _points(pass_name, wide)
    p_hat = np.stack(
        [np.stack([formula(x, y) for y in samples], axis=1) for x in viewers], axis=1
    )
    if pass_name in ("initial", "temporal"):
        p_hat = p_hat[:, 0]
    if pass_name == "initial":
        p_hat = p_hat[:, 0]
    return p_hat.astype(inputs["visible_position"].dtype)


def _points(pass_name: str, inputs: Buffers) -> tuple[list[Points], list[Points]]:
    """Visible points and samples, in the order of the words and bits of ``visible``."""
    x, x_past = (_named(inputs, p, "visible_position") for p in ("", "past_"))
    own, past, new = (_named(inputs, p, "position") for p in ("", "past_", "new_"))
    if pass_name == "initial":
        return [x], [own]
    if pass_name in ("temporal", "moved"):
        return [x, x_past] if x_past else [x], [new, past]
    names = SOURCES[pass_name]
    from_past = bool(names.prefix)
    there, held = (x_past, past) if from_past else (x, own)
    rows = np.maximum(inputs[names.rows], 0).T
    viewers = [x, *(tuple(a[row] for a in there) for row in rows)]
    samples = [own, *(tuple(a[row] for a in held) for row in rows)]
    return viewers, samples if from_past else [*samples, past]


def _named(inputs: Buffers, prefix: str, position: str) -> Points:
    """Place, normal and colour of points; nothing where there are none."""
    words = {
        "visible_position": ("visible_position", "visible_normal", "albedo"),
        "position": ("position", "normal", "radiance"),
    }[position]
    if prefix + position not in inputs:
        return ()
    return tuple(inputs[prefix + word] for word in words)


def _shown(x: Points, y: Points) -> tuple[Scalars, Scalars]:
    """Cosine at the visible points, 0 where nothing is reflected; and luminance."""
    v = y[0] - x[0]
    cosine = divide_or_zero(dot(x[1], v), np.sqrt(dot(v, v)))
    lit = (cosine > 0) & (dot(y[1], v) < 0)
    return np.where(lit, cosine, 0.0), y[2] @ LUMINANCE


def glossy(x: Points, y: Points) -> Scalars:
    """Target of a surface that the contract has no formula for, (N,)."""
    cosine, light = _shown(x, y)
    f = 0.02 + x[2] @ LUMINANCE * cosine**6
    return np.where(cosine > 0, f * light, 0.0)


def outgoing(x: Points, y: Points) -> Scalars:
    """Target of Equation 10, (N,)."""
    cosine, light = _shown(x, y)
    return np.where(cosine > 0, light, 0.0)


def scattered(x: Points, y: Points) -> Scalars:
    """Target of Equation 9 on a Lambertian surface, (N,)."""
    cosine, _ = _shown(x, y)
    p_hat: Scalars = cosine / np.pi * ((x[2] * y[2]) @ LUMINANCE)
    return p_hat


FORMULAS: Mapping[str, Formula] = {"scattered": scattered, "outgoing": outgoing}
"""Targets that the contract has a formula for, by the value of the setting."""

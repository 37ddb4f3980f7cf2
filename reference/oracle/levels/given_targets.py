"""Cases of targets that are given as data: designed rows of L3.

The points, samples and reservoirs are those of other rows; the target is that of a
glossy surface that the contract has no formula for.
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Scalars, divide_or_zero, dot
from restir_gi.reference.oracle.cases import SOURCES, Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.contract.targets import DATA
from restir_gi.reference.oracle.contract.weights import MIS
from restir_gi.reference.oracle.levels.probe import Probe
from restir_gi.reference.oracle.levels.replayed import replayed
from restir_gi.reference.oracle.levels.rows import (
    FEW_NEIGHBORS,
    fused_rows,
    in_float32,
    initial_rows,
    moved_rows,
    size_of,
    spatial_rows,
    temporal_rows,
)
from restir_gi.reference.oracle.parts import SEED

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])

Points = tuple[NDArray[np.float64], ...]


# The same cases for every backend.
@lru_cache(maxsize=4)
def given_target_probes(precision: Precision, seed: int = SEED) -> tuple[Probe, ...]:
    """Probes of level L3: designed rows of each pass that has targets as data.

    Parameters
    ----------
    seed : int; of all rows
    """
    rng = np.random.default_rng([2041, seed])
    cases = [initial_rows(rng, "outgoing"), temporal_rows(rng, "outgoing", 20.0)]
    for mis in ("1/Z", "1/M", *MIS.more):
        cases.append(moved_rows(rng, "outgoing", 20.0, mis))
        cases.append(spatial_rows(rng, "outgoing", 40.0, mis, FEW_NEIGHBORS))
        cases.append(fused_rows(rng, "outgoing", 40.0, mis, FEW_NEIGHBORS))
    cases.append(spatial_rows(rng, "outgoing", 60.0, "1/Z", size_of(30)))
    return tuple(
        replayed("L3", in_float32(with_given_targets(case), precision))
        for case in cases
    )


def with_given_targets(case: Case) -> Case:
    """The same rows with the target of a glossy surface, given."""
    inputs = {
        n: a.astype(np.float32).astype(float) if a.dtype.kind == "f" else a
        for n, a in case.inputs.items()
    }
    viewers, samples = _points(case.pass_name, inputs)
    p_hat = np.stack(
        [np.stack([_glossy(x, y) for y in samples], axis=1) for x in viewers], axis=1
    )
    if case.pass_name in ("initial", "temporal"):
        p_hat = p_hat[:, 0]
    if case.pass_name == "initial":
        p_hat = p_hat[:, 0]
    name = case.name.replace("outgoing", DATA)
    settings = {**case.settings, "target": DATA}
    given = {**case.inputs, "p_hat_given": p_hat}
    return replace(case, name=name, settings=settings, inputs=given)


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


def _glossy(x: Points, y: Points) -> Scalars:
    """Target of samples at visible points, (N,): 0 below the horizon and behind."""
    v = y[0] - x[0]
    cosine = divide_or_zero(dot(x[1], v), np.sqrt(dot(v, v)))
    lit = (cosine > 0) & (dot(y[1], v) < 0)
    f = 0.02 + x[2] @ LUMINANCE * cosine**6
    return np.where(lit, f * (y[2] @ LUMINANCE), 0.0)

"""Rows of shifts in a frame: their buffers, and which of them are taken."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from restir_gi.extensions.oracle.shifts.scenes import DrawnPaths
from restir_gi.extensions.oracle.shifts.tables import (
    columns,
    connection,
    filled,
    joints,
    lights,
)
from restir_gi.extensions.oracle.shifts.walks import at_slot, walked
from restir_gi.extensions.shifting import Criterion, Paths, Shift
from restir_gi.reference.numerics.arrays import Indices, Masks
from restir_gi.reference.numerics.records import take
from restir_gi.reference.oracle.cases import Buffers
from restir_gi.reference.scene.surface import SurfacePoints

ROWS = 12
"""Of each kind of event."""


def buffers(
    frame: DrawnPaths, criterion: Criterion, start: Indices, to: Indices, bounces: int
) -> dict[str, Any]:
    """All buffers of shifts; N rows, by name.

    Parameters
    ----------
    start, to : (N,) int; pixels whose paths are shifted, and to which
    """
    paths = take(frame.paths, start)
    base, offset = (
        _side(
            frame,
            criterion,
            points=take(frame.points, at),
            paths=paths,
            bounces=bounces,
        )
        for at in (start, to)
    )
    return {
        "path": paths.number,
        "pixel": to,
        **_record(paths),
        "base_position": base.before.position,
        "base_throughput": _throughput(base.walk["weight"], _before(paths)),
        "base_pdf_left": base.joint["pdf_left"],
        "base_pdf_onward": base.joint["pdf_onward"],
        "base_value": paths.value,
        "hit": offset.hit.astype(np.uint32),
        **filled(offset.hit, offset.walk, base.walk),
        **joints(frame, paths),
        **filled(offset.before.hit, offset.joint, base.joint),
        **filled(offset.ends, offset.light, base.light),
    }


@dataclass(frozen=True, slots=True, eq=False)
class _Side:
    """Buffers of base paths, or of offset paths.

    ``before`` is x_(c-1), and ``ends`` tells whether there is a point x_end.
    """

    hit: Masks
    ends: Masks
    before: SurfacePoints
    walk: Buffers
    joint: Buffers
    light: Buffers


def _side(
    frame: DrawnPaths,
    criterion: Criterion,
    points: SurfacePoints,
    paths: Paths,
    bounces: int,
) -> _Side:
    uniforms = frame.numbers(paths.number)
    walk = walked(
        frame.world, criterion, points=points, uniforms=uniforms, slots=bounces + 1
    )
    table = columns(frame.world, walk)
    hit = table.pop("hit") == 1
    x = at_slot(walk, _before(paths))
    return _Side(
        hit=hit,
        ends=hit[np.arange(len(paths)), np.maximum(paths.end, 1) - 1],
        before=x,
        walk=table,
        joint=connection(frame, criterion, x, paths),
        light={"light": lights(frame.world, walk, paths, uniforms)},
    )


def _before(paths: Paths) -> Indices:
    """Index c - 1, or 1 where there is no joint."""
    index: Indices = np.maximum(paths.joint - 1, 1)
    return index


def _record(paths: Paths) -> dict[str, Any]:
    return {
        "joint": paths.joint.astype(np.int64),
        "end": paths.end.astype(np.int64),
        "technique": paths.technique.astype(np.int64),
        "incoming": paths.incoming,
        "density": paths.density,
        "pdf_light": paths.pdf_light,
    }


def _throughput(weight: Any, last: Indices) -> Any:
    """Product of the weights of x_1 to x_(last-1)."""
    used = np.arange(1, weight.shape[1] + 1) < last[:, None]
    return np.where(used[..., None], weight, 1.0).prod(axis=1)


def eventful(
    frame: DrawnPaths,
    criterion: Criterion,
    start: Indices,
    to: Indices,
    inputs: dict[str, Any],
) -> Indices:
    """The first rows of each kind of event, in order.

    Parameters
    ----------
    start, to : (N,) int; pixels whose paths are shifted, and to which

    Returns
    -------
    (K,) int; `ROWS` of each kind at most
    """
    shift = Shift(criterion, frame.numbers)
    value, _ = shift(frame.world, frame.points, to, frame.paths, start)
    joint, end, hit = inputs["joint"], inputs["end"], inputs["hit"]
    facing = inputs["joint_normal"] * (
        inputs["joint_position"] - inputs["position"][:, 0]
    )
    kinds = np.stack(
        [
            joint,
            end == joint,
            inputs["technique"],
            value.any(axis=1),
            hit.cumprod(axis=1).sum(axis=1) >= np.where(joint > 0, joint - 1, end),
            inputs["seen"],
            facing.sum(axis=1) > 0,
            inputs["left"].any(axis=1),
            inputs["delta"][:, :2] @ [1, 2],
            inputs["delta"][:, 2:].any(axis=1),
            inputs["joint_alpha"] < 1.0,
        ],
        axis=1,
    ).astype(int)
    _, kind = np.unique(kinds, axis=0, return_inverse=True)
    order = np.argsort(kind, kind="stable")
    first = np.searchsorted(kind[order], kind[order])
    return np.sort(order[np.arange(len(order)) - first < ROWS])

"""Passes of the contract by the production passes."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from reference.oracle.builtin.buffers import (
    Array,
    Arrays,
    as_real,
    bit,
    receivers_of,
    reservoirs_out,
    samples_of,
    target_of,
)
from reference.oracle.builtin.world import Known, surface_of
from reference.oracle.contract.fields import Precision
from reference.passes.entries import Donors, Entry, other_entry, own_entry
from reference.passes.history import History, past_entry
from reference.passes.initial import InitialSamples
from reference.passes.neighbors import find_neighbors
from reference.passes.receivers import Receivers
from reference.passes.resample import Competition, resample
from reference.passes.shade import shade
from reference.passes.temporal import new_entry, temporal_competition
from reference.resampling.reservoir import (
    Reservoirs,
    finalize,
    initial_candidates,
)
from reference.rng import TabledUniforms
from reference.scene.surface import VisiblePoints
from reference.settings import UNBIASED


def _initial(
    precision: Precision, pdf: Array, target: str, **buffers: Array
) -> dict[str, Array]:
    p_hat = as_real(precision, target_of(target, buffers))
    c = initial_candidates(p_hat, p_hat, pdf)
    r = finalize(c, c.M)
    return {"p_hat": p_hat, "W": as_real(precision, r.W), "M": as_real(precision, r.M)}


def _temporal(
    precision: Precision,
    new_pdf: Array,
    u: Array,
    target: str,
    cap: float,
    **buffers: Array,
) -> dict[str, Array]:
    receivers = receivers_of(buffers, target, "1/Z", cap)
    past = _donors(receivers, buffers, "past_", receivers.points)
    history = History(past, slice(0, len(u)), as_they_stand=True)
    new = InitialSamples(samples_of(buffers, "new_"), new_pdf, new_pdf)
    table = TabledUniforms(np.broadcast_to(u, (1, 4, len(u))))
    kept = resample(temporal_competition(receivers, new, history, table))
    return reservoirs_out(precision, kept.reservoirs)


def _moved(
    precision: Precision,
    new_pdf: Array,
    visible: Array,
    u: Array,
    target: str,
    cap: float,
    mis: str,
    **buffers: Array,
) -> dict[str, Array]:
    rows = np.arange(len(u))
    count = len(rows)
    samples = (buffers["new_position"], buffers["past_position"])
    # The past's points are numbered after the receivers'.
    known = [
        Known(rows + count * viewer, y, bit(visible[:, viewer], k))
        for viewer in (0, 1)
        for k, y in enumerate(samples)
    ]
    receivers = receivers_of(buffers, target, mis, cap, known)
    x_past = surface_of(
        buffers["past_visible_position"],
        buffers["past_visible_normal"],
        buffers["past_albedo"],
    )
    x_past = replace(x_past, primitive=x_past.primitive + np.int32(count))
    past = _donors(receivers, buffers, "past_", x_past)
    history = History(past, rows, as_they_stand=False)
    new = InitialSamples(samples_of(buffers, "new_"), new_pdf, new_pdf)
    entries = [
        past_entry(receivers, history, 0),
        new_entry(receivers, new, 1, None),
    ]
    kept = resample(Competition(receivers, entries, [u, u], 1, cap))
    return reservoirs_out(precision, kept.reservoirs)


def _neighbors(
    precision: Precision,
    visible_normal: Array,
    depth: Array,
    u: Array,
    width: int,
    **settings: Any,
) -> dict[str, Array]:
    surface = surface_of(visible_normal, visible_normal, visible_normal)
    draws = [
        (u[:, k, 0], u[:, k, 1], u[:, k, 0], u[:, k, 1]) for k in range(u.shape[1])
    ]
    found = find_neighbors(
        np.arange(len(depth)),
        VisiblePoints(surface, depth),
        width,
        replace(UNBIASED, **settings),
        draws,
    )
    return {"neighbors": np.stack(found, axis=1).astype(np.int32)}


def _spatial(
    precision: Precision,
    neighbors: Array,
    visible: Array,
    u_own: Array,
    u_neighbors: Array,
    target: str,
    cap: float,
    mis: str,
    **buffers: Array,
) -> dict[str, Array]:
    count = neighbors.shape[1]
    known = _known(buffers, neighbors, visible)
    receivers = receivers_of(buffers, target, mis, cap, known)
    temporal = _donors(receivers, buffers, "", receivers.points)
    past = _donors(receivers, buffers, "past_", receivers.points).reservoirs
    entries: list[Entry] = [
        own_entry(receivers, past, 0),
        own_entry(receivers, temporal.reservoirs, 1),
    ]
    for k in range(count):
        entries.append(other_entry(receivers, temporal, neighbors[:, k], 2 + k))
    decisions = [u_own, u_own, *(u_neighbors[:, k] for k in range(count))]
    kept = resample(Competition(receivers, entries, decisions, 1, cap))
    return reservoirs_out(precision, kept.reservoirs)


def _shade(
    precision: Precision,
    W: Array,
    **buffers: Array,
) -> dict[str, Array]:
    receivers = receivers_of(buffers, "scattered", "1/Z", 1.0)
    r = Reservoirs(samples_of(buffers), W, W)
    return {"color": as_real(precision, shade(receivers.world, receivers.points, r))}


def _donors(receivers: Receivers, buffers: Arrays, prefix: str, points: Any) -> Donors:
    r = Reservoirs(
        samples_of(buffers, prefix), buffers[f"{prefix}W"], buffers[f"{prefix}M"]
    )
    depth = np.ones(len(r.W), r.W.dtype)
    return Donors(receivers.world, VisiblePoints(points, depth), r)


def _known(buffers: Arrays, neighbors: Array, visible: Array) -> list[Known]:
    """Bits of pass ``spatial`` as questions and answers, of those who are there."""
    rows, count = np.arange(len(neighbors)), neighbors.shape[1]
    around = [neighbors[:, k] for k in range(count)]
    y = buffers["position"]
    samples = [(y, rows), *((y[np.maximum(row, 0)], row) for row in around)]
    past_is_there = np.where(buffers["past_M"] > 0, rows, -1)
    samples.append((buffers["past_position"], past_is_there))
    found = []
    for place, viewer in enumerate([rows, *around]):
        for k, (sample, maker) in enumerate(samples):
            asked = (viewer >= 0) & (maker >= 0)
            seen = bit(visible[:, place], k)
            found.append(Known(viewer[asked], sample[asked], seen[asked]))
    return found


PASSES: Mapping[str, Callable[..., dict[str, Array]]] = {
    "initial": _initial,
    "temporal": _temporal,
    "moved": _moved,
    "neighbors": _neighbors,
    "spatial": _spatial,
    "shade": _shade,
}

"""Passes of the contract by the production passes."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from restir_gi.reference.options.fused import spatiotemporal_resampling
from restir_gi.reference.options.neighborhood import clamped, mirrored, of_table
from restir_gi.reference.options.visibility import without_hidden
from restir_gi.reference.options.weights import Source, resample_as_asked
from restir_gi.reference.oracle.builtin.buffers import (
    Array,
    Arrays,
    as_real,
    bit,
    pixels_of,
    reservoirs_of,
    reservoirs_out,
    samples_of,
    target_of,
)
from restir_gi.reference.oracle.builtin.surfaces import (
    SurfaceFrame,
    SurfacePixels,
    surface_points,
)
from restir_gi.reference.oracle.builtin.targets import (
    Given,
    GivenFrame,
    GivenPixels,
    with_targets,
)
from restir_gi.reference.oracle.builtin.world import Known, surface_of
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.contract.passes import (
    ASKED,
    CLAMPED,
    DISK,
    MIRRORED,
    REFUSED,
    TABLE,
)
from restir_gi.reference.oracle.contract.surfaces import LAMBERTIAN
from restir_gi.reference.oracle.contract.targets import DATA
from restir_gi.reference.oracle.contract.weights import DEFENSIVE
from restir_gi.reference.passes.initial import InitialSamples
from restir_gi.reference.passes.neighbors import (
    find_neighbors,
    in_disk,
    open_border,
)
from restir_gi.reference.passes.pixels import FrameReservoirs, Pixels
from restir_gi.reference.passes.shade import shade
from restir_gi.reference.passes.spatial import spatial_resampling
from restir_gi.reference.passes.temporal import temporal_resampling
from restir_gi.reference.resampling.generalized import Mis
from restir_gi.reference.resampling.reservoir import (
    Reservoirs,
    finalize,
    initial_candidates,
)
from restir_gi.reference.scene.surface import SurfacePoints, VisiblePoints
from restir_gi.reference.settings import UNBIASED


def _initial(
    precision: Precision,
    pdf: Array,
    target: str,
    surface: str = LAMBERTIAN,
    **buffers: Array,
) -> dict[str, Array]:
    given = buffers.get("p_hat_given")
    p = target_of(target, buffers, surface) if given is None else given
    p_hat = as_real(precision, p)
    c = initial_candidates(p_hat, p_hat, pdf)
    r = finalize(c, c.M)
    return {"p_hat": p_hat, "W": as_real(precision, r.W), "M": as_real(precision, r.M)}


def _temporal(
    precision: Precision,
    new_pdf: Array,
    u: Array,
    target: str,
    cap: float,
    mis: Mis = "1/Z",
    surface: str = LAMBERTIAN,
    **buffers: Array,
) -> dict[str, Array]:
    q = pixels_of(buffers, target, surface=surface)
    if target == DATA:
        samples = (buffers["new_position"], buffers["past_position"])
        viewers = [np.arange(len(u))]
        given = buffers["p_hat_given"][:, None]
        q = with_targets(q, _given(viewers, [(y, viewers[0]) for y in samples], given))
    past, new = reservoirs_of(buffers, "past_"), _new(buffers, new_pdf)
    if mis == DEFENSIVE:
        kept = resample_as_asked(q, [(past, u), (new, u)], mis, cap)
    else:
        kept = temporal_resampling(q, new, past, u, cap=cap)
    return reservoirs_out(precision, kept)


def _moved(
    precision: Precision,
    new_pdf: Array,
    visible: Array,
    u: Array,
    target: str,
    cap: float,
    mis: Mis,
    surface: str = LAMBERTIAN,
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
    q = pixels_of(buffers, target, known, surface)
    if target == DATA:
        viewers, makers = [rows, rows + count], [(y, rows) for y in samples]
        q = with_targets(q, _given(viewers, makers, buffers["p_hat_given"]))
    x_past = _past_points(buffers, surface, count)
    past = _frame(q, x_past, reservoirs_of(buffers, "past_")).neighbors(q, rows)
    new = _new(buffers, new_pdf)
    if mis == "1/Z" or mis == "1/M":
        kept = temporal_resampling(q, new, past, u, cap=cap, mis=mis)
    else:
        kept = resample_as_asked(q, [(past, u), (new, u)], mis, cap)
    return reservoirs_out(precision, kept)


def _neighbors(
    precision: Precision,
    visible_normal: Array,
    depth: Array,
    width: int,
    u: Array | None = None,
    offsets: Array | None = None,
    search: str = DISK,
    border: str = REFUSED,
    **settings: Any,
) -> dict[str, Array]:
    surface = surface_of(visible_normal, visible_normal, visible_normal)
    given = u if offsets is None else offsets
    assert given is not None
    lanes = ((given[:, k, 0], given[:, k, 1]) for k in range(given.shape[1]))
    draws = [(*pair, *pair) for pair in lanes]
    found = find_neighbors(
        np.arange(len(depth)),
        VisiblePoints(surface, depth),
        width,
        replace(UNBIASED, **settings),
        draws,
        offset=of_table if search == TABLE else in_disk,
        border={REFUSED: open_border, CLAMPED: clamped, MIRRORED: mirrored}[border],
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
    mis: Mis,
    surface: str = LAMBERTIAN,
    **buffers: Array,
) -> dict[str, Array]:
    viewers, samples = _viewers_and_samples(buffers, neighbors)
    q = pixels_of(buffers, target, _answers(viewers, samples, visible), surface)
    if target == DATA:
        q = with_targets(q, _given(viewers, samples, buffers["p_hat_given"]))
    own, past = reservoirs_of(buffers), reservoirs_of(buffers, "past_")
    frame = _frame(q, q.points, own)
    around = [
        (frame.neighbors(q, neighbors[:, k]), u_neighbors[:, k])
        for k in range(neighbors.shape[1])
    ]
    if mis == "1/Z" or mis == "1/M":
        kept = spatial_resampling(q, past, own, around, u_own, cap=cap, mis=mis)
    else:
        sources: list[tuple[Source, Array]] = [(past, u_own), (own, u_own), *around]
        kept = resample_as_asked(q, sources, mis, cap)
    return reservoirs_out(precision, kept)


def _fused(
    precision: Precision,
    sources: Array,
    visible: Array,
    u: Array,
    target: str,
    cap: float,
    mis: Mis,
    surface: str = LAMBERTIAN,
    **buffers: Array,
) -> dict[str, Array]:
    rows, count = np.arange(len(sources)), sources.shape[1]
    own, past = reservoirs_of(buffers), reservoirs_of(buffers, "past_")
    # The past's points are numbered after the receivers'.
    there = [sources[:, k] for k in range(count)]
    viewers = [rows, *(np.where(row >= 0, row + len(rows), -1) for row in there)]
    y = past.y.position
    samples = [(own.y.position, rows)]
    samples += [(y[np.maximum(row, 0)], row) for row in there]
    q = pixels_of(buffers, target, _answers(viewers, samples, visible), surface)
    if target == DATA:
        q = with_targets(q, _given(viewers, samples, buffers["p_hat_given"]))
    frame = _frame(q, _past_points(buffers, surface, len(rows)), past)
    around = [(frame.neighbors(q, there[k]), u[:, k]) for k in range(count)]
    if mis == "1/Z" or mis == "1/M":
        kept = spatiotemporal_resampling(q, own, around, cap=cap, mis=mis)
    else:
        candidates: list[tuple[Source, Array]] = [(own, np.zeros_like(own.W)), *around]
        kept = resample_as_asked(q, candidates, mis, cap)
    return reservoirs_out(precision, kept)


def _shade(
    precision: Precision,
    W: Array,
    surface: str = LAMBERTIAN,
    visibility: str = "none",
    **buffers: Array,
) -> dict[str, Array]:
    r = Reservoirs(samples_of(buffers), W, W)
    if visibility == ASKED:
        seen = bit(buffers["visible"], 0)
        known = [Known(np.arange(len(W)), r.y.position, seen)]
        r = without_hidden(pixels_of(buffers, "scattered", known, surface), r)
    q = pixels_of(buffers, "scattered", surface=surface)
    if isinstance(q, SurfacePixels):
        return {"color": as_real(precision, q.shown(r.y, r.W))}
    return {"color": as_real(precision, shade(q.world, q.points, r))}


def _new(buffers: Arrays, pdf: Array) -> InitialSamples:
    y = samples_of(buffers, "new_")
    return InitialSamples(y, pdf, np.ones_like(pdf), np.zeros_like(y.radiance))


def _past_points(buffers: Arrays, surface: str, count: int) -> SurfacePoints:
    """Points of the past, numbered after as many receivers."""
    if surface != LAMBERTIAN:
        return surface_points(buffers, "past_", count)
    x = surface_of(
        buffers["past_visible_position"],
        buffers["past_visible_normal"],
        buffers["past_albedo"],
    )
    return replace(x, primitive=x.primitive + np.int32(count))


def _frame(q: Pixels, points: SurfacePoints, r: Reservoirs) -> FrameReservoirs:
    depth = np.ones(len(r.W), r.W.dtype)
    frame = SurfaceFrame if isinstance(q, SurfacePixels) else FrameReservoirs
    frame = GivenFrame if isinstance(q, GivenPixels) else frame
    return frame(q.world, VisiblePoints(points, depth), r)


def _viewers_and_samples(
    buffers: Arrays, neighbors: Array
) -> tuple[list[Array], list[tuple[Array, Array]]]:
    """Who looks at which samples in pass ``spatial``, as `_answers` takes them."""
    rows, count = np.arange(len(neighbors)), neighbors.shape[1]
    around = [neighbors[:, k] for k in range(count)]
    y = buffers["position"]
    samples = [(y, rows), *((y[np.maximum(row, 0)], row) for row in around)]
    past_is_there = np.where(buffers["past_M"] > 0, rows, -1)
    samples.append((buffers["past_position"], past_is_there))
    return [rows, *around], samples


def _answers(
    viewers: Sequence[Array], samples: Sequence[tuple[Array, Array]], visible: Array
) -> list[Known]:
    """What columns and bits say, of those who are there.

    Parameters
    ----------
    viewers : sequence of (N,) int; number of the point of each column, or −1
    samples : sequence of (N, 3) and (N,) int; place of each bit, and its maker, or −1
    """
    found = []
    for place, viewer in enumerate(viewers):
        for k, (sample, maker) in enumerate(samples):
            asked = (viewer >= 0) & (maker >= 0)
            seen = bit(visible[:, place], k)
            found.append(Known(viewer[asked], sample[asked], seen[asked]))
    return found


def _given(
    viewers: Sequence[Array], samples: Sequence[tuple[Array, Array]], p_hat: Array
) -> list[Given]:
    """Targets of those who are there, of samples that are.

    Parameters
    ----------
    viewers, samples : sequence of array; as of `_answers`
    p_hat : (N, V, S), radiance/sr
    """
    found = []
    for place, viewer in enumerate(viewers):
        for k, (sample, maker) in enumerate(samples):
            asked = (viewer >= 0) & (maker >= 0)
            found.append((viewer[asked], sample[asked], p_hat[asked, place, k]))
    return found


PASSES: Mapping[str, Callable[..., dict[str, Array]]] = {
    "initial": _initial,
    "temporal": _temporal,
    "moved": _moved,
    "neighbors": _neighbors,
    "spatial": _spatial,
    "fused": _fused,
    "shade": _shade,
}

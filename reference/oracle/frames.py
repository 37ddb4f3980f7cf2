"""Cases of whole frames: what the passes are given in real scenes."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars
from restir_gi.reference.numerics.records import take
from restir_gi.reference.numerics.rng import Stream
from restir_gi.reference.oracle.buffers import (
    given,
    prefixed,
    receivers,
    reservoirs,
    samples,
)
from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.contract.fields import Precision, Value
from restir_gi.reference.oracle.prepared_frame import (
    CAPS,
    NEIGHBORS,
    SIMILARITY,
    PreparedFrame,
)
from restir_gi.reference.oracle.visibility import made_it
from restir_gi.reference.passes.pixels import sees
from restir_gi.reference.resampling.reservoir import Reservoirs, Samples


def frame_cases(at: PreparedFrame, precision: Precision) -> Iterator[Case]:
    """One case of each pass of the algorithm, and of each weight of Algorithm 4."""
    size = at.world.camera.width

    def case(
        pass_name: str, variant: str, settings: dict[str, Value], inputs: Any
    ) -> Case:
        name = "-".join(word for word in (pass_name, variant, at.name) if word)
        return Case(name, pass_name, settings, given(inputs, precision), True, size)

    surface = at.last.visible.surface
    x, y = receivers(at), _with_geometry(at, at.initial.y)
    new = prefixed("new", samples(y))
    pdf = at.initial.pdf
    u = np.stack(at.uniforms(Stream.INITIAL).draw(0)[1:3], axis=1)
    for source in ("uniform", "cosine"):
        # Where nothing is seen there is no normal, and nobody draws.
        up = np.where(surface.hit[:, None], surface.normal, [0.0, 0.0, 1.0])
        inputs = {"visible_normal": up, "u": u}
        yield case("direction", source, {"source": source}, inputs)
    for kind in ("scattered", "outgoing"):
        inputs = x | samples(y) | {"pdf": pdf}
        yield case("initial", kind, {"target": kind}, inputs)

    own, spatial_past = (
        _as_a_loop_has_them(at, r, cap)
        for r, cap in (
            (at.last.temporal, CAPS["temporal"]),
            (at.last.spatial, CAPS["spatial"]),
        )
    )
    past = prefixed("past", reservoirs(own))
    decides = {"new_pdf": pdf, "u": at.uniforms(Stream.TEMPORAL).draw(0)[0]}
    settings: dict[str, Value] = {"target": "scattered", "cap": CAPS["temporal"]}
    yield case("temporal", "", settings, x | past | new | decides)

    rows = past_rows(at)
    history = prefixed("past", receivers(at, rows))
    moved = prefixed("past", reservoirs(take(own, rows)))
    visible = {"visible": _who_sees_when_moved(at, rows)}
    for mis in ("1/Z", "1/M"):
        settings = {"target": "scattered", "cap": CAPS["moved"], "mis": mis}
        inputs = x | history | moved | new | decides | visible
        yield case("moved", mis.replace("/", ""), settings, inputs)

    draws = [at.uniforms(Stream.SPATIAL).draw(s) for s in range(NEIGHBORS)]
    places = np.stack([np.stack(d[:2], axis=1) for d in draws], axis=1)
    depth = at.last.visible.depth
    inputs = {"visible_normal": x["visible_normal"], "depth": depth, "u": places}
    yield case("neighbors", "", {"width": size, **SIMILARITY}, inputs)

    spatial = x | reservoirs(own) | prefixed("past", reservoirs(spatial_past))
    spatial |= {
        "neighbors": at.neighbors,
        "visible": _who_sees(at),
        "u_own": at.uniforms(Stream.SPATIAL).draw(63)[0],
        "u_neighbors": np.stack([d[2] for d in draws], axis=1),
    }
    for mis, kind in (("1/Z", "scattered"), ("1/M", "scattered"), ("1/Z", "outgoing")):
        settings = {"target": kind, "cap": CAPS["spatial"], "mis": mis}
        yield case("spatial", f"{mis.replace('/', '')}-{kind}", settings, spatial)

    points = np.column_stack([rows, at.neighbors])
    then = rows_then(at)
    fused_past = replace(spatial_past, M=np.minimum(spatial_past.M, CAPS["fused"]))
    fused = x | _initial_reservoirs(x, y, pdf)
    held = receivers(at, then) | reservoirs(take(fused_past, then))
    fused |= prefixed("past", held) | {
        "sources": np.where(points >= 0, np.argsort(then)[points], -1),
        "visible": _who_sees_then(at, points),
        "u": np.stack([decides["u"], *(d[2] for d in draws)], axis=1),
    }
    for mis, kind in (("1/Z", "scattered"), ("1/M", "outgoing")):
        settings = {"target": kind, "cap": CAPS["fused"], "mis": mis}
        yield case("fused", f"{mis.replace('/', '')}-{kind}", settings, fused)

    kept = reservoirs(spatial_past)
    del kept["M"]
    yield case("shade", "", {}, x | kept)


def past_rows(at: PreparedFrame) -> Indices:
    """The pixel that each was before, in cases of pass ``moved``: a neighbour, (N,)."""
    first = at.neighbors[:, 0]
    return np.where(first >= 0, first, np.arange(len(first)))


def rows_then(at: PreparedFrame) -> Indices:
    """The pixel that is seen in each row of the past frame of pass ``fused``, (N,).

    As if the camera had turned by a pixel since.
    """
    return np.roll(np.arange(len(at.neighbors)), 1)


def _as_a_loop_has_them(at: PreparedFrame, r: Reservoirs, cap: float) -> Reservoirs:
    """Reservoirs under a cap, which changes M alone; nulls are somewhere."""
    return replace(r, y=_with_geometry(at, r.y), M=np.minimum(r.M, cap))


def _with_geometry(at: PreparedFrame, y: Samples) -> Samples:
    """Samples of which nulls, too, lie where a path could have met something."""
    surface = at.last.visible.surface
    null = (~y.radiance.any(axis=1) & ~y.normal.any(axis=1) & surface.hit)[:, None]
    return replace(
        y,
        position=np.where(null, surface.position + surface.normal, y.position),
        normal=np.where(null, -surface.normal, y.normal),
    )


def _sees(
    at: PreparedFrame, viewer: Indices, y: Samples, made: Masks
) -> NDArray[np.uint32]:
    x = take(at.last.visible.surface.viewpoints, np.maximum(viewer, 0))
    asked = (viewer >= 0) & ~made
    return (sees(at.world, x, y, asked) | made).astype(np.uint32)


def _who_sees(at: PreparedFrame) -> NDArray[np.uint32]:
    """Bits of pass ``spatial``."""
    rows = np.arange(len(at.neighbors))
    around = [at.neighbors[:, k] for k in range(NEIGHBORS)]
    y = at.last.temporal.y
    samples = [y, *(take(y, np.maximum(row, 0)) for row in around), at.last.spatial.y]
    makers = [rows, *around, rows]
    return _bits(at, [rows, *around], samples, makers)


def _who_sees_when_moved(at: PreparedFrame, rows: Indices) -> NDArray[np.uint32]:
    """Bits of pass ``moved``."""
    here = np.arange(len(rows))
    samples = [at.initial.y, take(at.last.temporal.y, rows)]
    return _bits(at, [here, rows], samples, [here, rows])


def _initial_reservoirs(
    x: Mapping[str, NDArray[Any]], y: Samples, pdf: Scalars
) -> dict[str, NDArray[Any]]:
    """What Algorithm 2 leaves: W = 1 / pdf of what the point reflects."""
    reflects = (x["albedo"] * y.radiance).any(axis=1) & (pdf > 0)
    W = np.divide(1.0, pdf, out=np.zeros(len(pdf)), where=reflects)
    return samples(y) | {"W": W, "M": np.ones(len(pdf))}


def _who_sees_then(at: PreparedFrame, points: Indices) -> NDArray[np.uint32]:
    """Bits of pass ``fused``.

    Parameters
    ----------
    points : (N, K) int; pixels that are the sources, or −1
    """
    viewers = [np.arange(len(points)), *points.T]
    y = at.last.spatial.y
    held = [at.initial.y, *(take(y, np.maximum(row, 0)) for row in points.T)]
    return _bits(at, viewers, held, viewers)


def _bits(
    at: PreparedFrame,
    viewers: list[Indices],
    samples: list[Samples],
    makers: list[Indices],
) -> NDArray[np.uint32]:
    words = np.zeros((len(at.neighbors), len(viewers)), np.uint32)
    places = [y.position for y in samples]
    for column, viewer in enumerate(viewers):
        for bit, y in enumerate(samples):
            seen = _sees(at, viewer, y, made_it(viewer, y.position, makers, places))
            words[:, column] |= seen << np.uint32(bit)
    return words

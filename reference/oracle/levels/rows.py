"""L3: designed rows, beside the frames of real scenes.

Each pass of the algorithms is given rows that a loop can make, drawn so that whatever
the contract says is hit by many of them: distances over decades, so that J spans 0.01
to 100; densities and weights over decades; M = 0, 1, cap − 1 and cap; nulls, black
surfaces, samples that are hidden, below a horizon or seen from their back; decisions at
both ends of u.  Samples are valid where they were stored.  Of the rows that hold
nothing a third has no geometry either, but where many are neighbours of one: those are
beyond the working range, and all who reuse them.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import (
    Indices,
    Masks,
    Scalars,
    Vec3s,
    normalize,
)
from restir_gi.reference.oracle.buffers import given, prefixed
from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.contract.fields import Precision, Value
from restir_gi.reference.oracle.levels.draws import (
    about,
    ends_of_u,
    spread,
    unit_vectors,
)
from restir_gi.reference.oracle.levels.probe import Probe
from restir_gi.reference.oracle.levels.replayed import replayed
from restir_gi.reference.oracle.parts import SEED

ROWS = 1024
"""Of a case."""


@dataclass(frozen=True, slots=True)
class Size:
    """Of a case of pass ``spatial``.

    Attributes
    ----------
    rows, cluster, neighbors : int; of the case, that lie together, and of each row
    trust : float; largest M of the reservoirs of pixels: of all together, within a byte
    bare : float; share of the rows that hold nothing which have no geometry either
    """

    rows: int
    cluster: int
    neighbors: int
    trust: float
    bare: float


BARE = 1 / 3
FEW_NEIGHBORS = Size(ROWS, 8, 3, 20.0, BARE)
MOST_NEIGHBORS = Size(192, 48, 30, 6.0, 0.0)
"""As many neighbours as renderers have, and as many as words have bits for."""

NULLS, BLACK, HIDDEN, NOWHERE, STILL = 0.15, 0.12, 0.25, 0.15, 0.1
"""Shares of nulls, of black surfaces, of samples that are not seen, of neighbours that
there are not, and of points that were there a frame ago."""

TILTED = 0.7
"""Least cosine of a patch of an image with its axis."""


def size_of(count: int) -> Size:
    """A few rows with so many neighbours each, whose M are together within a byte."""
    cluster = max(8, count + (count + 1) // 2)
    trust = float(min(20, 200 // (count + 1)))
    bare = BARE if count <= FEW_NEIGHBORS.neighbors else 0.0
    return Size(192 // cluster * cluster, cluster, count, trust, bare)


Buffer = dict[str, NDArray[Any]]


@dataclass(frozen=True, slots=True, eq=False)
class _Viewpoints:
    """Visible points, N rows."""

    position: Vec3s
    normal: Vec3s
    albedo: Vec3s

    @property
    def buffers(self) -> Buffer:
        """As the contract names them."""
        return {
            "visible_position": self.position,
            "visible_normal": self.normal,
            "albedo": self.albedo,
        }


# The same cases for every backend.
@lru_cache(maxsize=4)
def row_probes(precision: Precision, seed: int = SEED) -> tuple[Probe, ...]:
    """One probe or more of each pass of the algorithms.

    Parameters
    ----------
    seed : int; of all rows
    """
    rng = np.random.default_rng([2031, seed])
    cases = [
        initial_rows(rng, "scattered"),
        initial_rows(rng, "outgoing"),
        temporal_rows(rng, "scattered", 20.0),
        temporal_rows(rng, "outgoing", 5.5),
        moved_rows(rng, "scattered", 20.0, "1/Z"),
        moved_rows(rng, "outgoing", 8.0, "1/Z"),
        moved_rows(rng, "outgoing", 7.25, "1/M"),
        spatial_rows(rng, "scattered", 40.0, "1/Z", FEW_NEIGHBORS),
        spatial_rows(rng, "outgoing", 100.0, "1/M", FEW_NEIGHBORS),
        spatial_rows(rng, "scattered", 60.0, "1/Z", MOST_NEIGHBORS),
        *_neighbors(rng),
        # Reservoirs of another pass may have M beyond the cap of this one.
        spatial_rows(rng, "outgoing", 12.0, "1/Z", FEW_NEIGHBORS),
        fused_rows(rng, "scattered", 40.0, "1/Z", FEW_NEIGHBORS),
        fused_rows(rng, "outgoing", 12.0, "1/Z", FEW_NEIGHBORS),
        fused_rows(rng, "outgoing", 100.0, "1/M", FEW_NEIGHBORS),
        fused_rows(rng, "scattered", 60.0, "1/Z", MOST_NEIGHBORS),
    ]
    return tuple(replayed("L3", in_float32(case, precision)) for case in cases)


# The same cases for every backend that may have as many.
@lru_cache(maxsize=8)
def neighbor_row_probes(
    precision: Precision, seed: int, counts: tuple[int, ...]
) -> tuple[Probe, ...]:
    """Probes of passes ``spatial`` and ``fused`` with given numbers of neighbours.

    Parameters
    ----------
    seed : int; of all rows
    """
    rng = np.random.default_rng([2040, seed])
    cases = [
        spatial_rows(rng, kind, cap, mis, size_of(count))
        for count in counts
        for kind, cap, mis in (("scattered", 50.0, "1/Z"), ("outgoing", 30.0, "1/M"))
    ]
    sizes = map(size_of, counts)
    cases += [fused_rows(rng, "scattered", 50.0, "1/Z", size) for size in sizes]
    return tuple(replayed("L3", in_float32(case, precision)) for case in cases)


def in_float32(case: Case, precision: Precision) -> Case:
    """A case in numbers that float32 holds too, and whose u are random."""
    held = {
        n: a.astype(np.float32) if a.dtype.kind == "f" else a
        for n, a in case.inputs.items()
    }
    return Case(case.name, case.pass_name, case.settings, given(held, precision), True)


def _points(
    rng: np.random.Generator, black: float = BLACK, rows: int = ROWS
) -> _Viewpoints:
    albedo = rng.uniform(0.02, 1.0, (rows, 3)) * (rng.random((rows, 3)) < 0.9)
    albedo[rng.random(rows) < black] = 0.0
    position = 3.0 * rng.normal(size=(rows, 3))
    return _Viewpoints(position, unit_vectors(rng, rows), albedo)


def _ways(rng: np.random.Generator, x: _Viewpoints, d: Scalars) -> Vec3s:
    """Ways above the horizon of points, (N, 3) m.

    Parameters
    ----------
    d : (N,) float64, m; their lengths
    """
    return d[:, None] * about(rng, x.normal, rng.uniform(0.02, 1.0, len(d)))


def _samples(
    rng: np.random.Generator, x: _Viewpoints, way: Vec3s, bare: float = BARE
) -> Buffer:
    """Samples at the end of ways from some points, which see their front; and nulls.

    Parameters
    ----------
    way : (N, 3) float64, m
    bare : float; share of nulls without geometry
    """
    rows = len(way)
    normal = about(rng, -normalize(way), rng.uniform(0.02, 1.0, rows))
    color = rng.uniform(0.1, 1.0, (rows, 3)) * (rng.random((rows, 3)) < 0.85)
    radiance = spread(rng, -3, 3, rows)[:, None] * color
    radiance[rng.random(rows) < NULLS] = 0.0
    y = {
        "position": x.position + way,
        "normal": normal,
        "radiance": radiance,
    }
    return _without_geometry(y, ~radiance.any(axis=1) & (rng.random(rows) < bare))


def _without_geometry(y: Buffer, rows: Masks) -> Buffer:
    """Samples of which some are as a path leaves them that met nothing."""
    return y | {
        "position": np.where(rows[:, None], 0.0, y["position"]),
        "normal": np.where(rows[:, None], -0.0, y["normal"]),
    }


def _reservoirs(
    rng: np.random.Generator,
    x: _Viewpoints,
    way: Vec3s,
    kind: str,
    cap: float,
    bare: float = BARE,
) -> Buffer:
    """Reservoirs as a loop leaves them, with M up to the cap, and parts of 1 as it has.

    W of nulls may be anything, as of renderers that store 1 / pdf; it is 0 where the
    target is 0 although there is light.
    """
    y, rows = _samples(rng, x, way, bare), len(way)
    dark = (kind == "scattered") & ~(x.albedo * y["radiance"]).any(axis=1)
    ends = np.array([0.0, 1.0, 2.0, cap - 1, cap])
    parts = 1 if cap.is_integer() else 4
    M = np.where(
        rng.random(rows) < 0.6,
        rng.choice(ends, rows),
        rng.integers(parts, int(parts * cap) + 1, rows) / parts,
    )
    null = ~y["radiance"].any(axis=1)
    kept = (M > 0) & np.where(null, rng.random(rows) < 0.5, ~dark)
    y = _without_geometry(y, (M == 0) & (rng.random(rows) < bare))
    return y | {"W": spread(rng, -2, 3, rows) * kept, "M": M}


def _density(rng: np.random.Generator) -> Scalars:
    found: Scalars = spread(rng, -3, 2, ROWS) * (rng.random(ROWS) < 0.9)
    return found


def initial_rows(rng: np.random.Generator, kind: str) -> Case:
    """Case of pass ``initial``."""
    x = _points(rng)
    y = _samples(rng, x, _ways(rng, x, spread(rng, -2, 1, ROWS)))
    inputs = x.buffers | y | {"pdf": _density(rng)}
    return Case(f"rows-initial-{kind}", "initial", {"target": kind}, inputs)


def temporal_rows(
    rng: np.random.Generator, kind: str, cap: float, mis: str = ""
) -> Case:
    """Case of pass ``temporal``.

    Parameters
    ----------
    mis : str; a declared weight; empty where the case says nothing of it
    """
    x = _points(rng)
    ways = [_ways(rng, x, spread(rng, -2, 1, ROWS)) for _ in range(2)]
    past = _reservoirs(rng, x, ways[0], kind, cap)
    new = _samples(rng, x, ways[1])
    inputs = x.buffers | prefixed("past", past) | prefixed("new", new)
    inputs |= {"new_pdf": _density(rng), "u": ends_of_u(rng, ROWS)}
    settings: dict[str, Value] = {"target": kind, "cap": cap}
    settings |= {"mis": mis} if mis else {}
    name = "-".join(word for word in ("rows-temporal", mis, kind) if word)
    return Case(name, "temporal", settings, inputs)


def moved_rows(rng: np.random.Generator, kind: str, cap: float, mis: str) -> Case:
    """Case of pass ``moved``."""
    x_past = _points(rng, 3 * BLACK)
    d = spread(rng, -1, 1, ROWS)
    past = _reservoirs(rng, x_past, _ways(rng, x_past, d), kind, cap)
    x = _moved_points(rng, past, d)
    new = _samples(rng, x, _ways(rng, x, spread(rng, -1, 1, ROWS)))
    sees, is_seen = (rng.random(ROWS) > HIDDEN for _ in range(2))
    # Each sees what it drew; but a door may have closed since on what x_past stored.
    still = rng.random(ROWS) > HIDDEN if mis == "1/M" else np.ones(ROWS)
    visible = np.stack([1 + 2 * sees, 2 * still + is_seen], axis=1).astype(np.uint32)
    inputs = x.buffers | prefixed("past", x_past.buffers)
    inputs |= prefixed("past", past) | prefixed("new", new)
    inputs |= {
        "new_pdf": _density(rng),
        "visible": visible,
        "u": ends_of_u(rng, ROWS),
    }
    settings: dict[str, Value] = {"target": kind, "cap": cap, "mis": mis}
    name = f"rows-moved-{mis.replace('/', '')}-{kind}"
    return Case(name, "moved", settings, inputs)


def _moved_points(rng: np.random.Generator, y: Buffer, d: Scalars) -> _Viewpoints:
    """Where the past's samples are reused: nearer to them, or farther away.

    A tenth sees their back, and of another their light comes from below.
    """
    there: Masks = np.any(y["normal"], axis=1)
    normal = np.where(there[:, None], y["normal"], [0.0, 0.0, 1.0])
    front = np.where(rng.random(ROWS) < 0.9, 1.0, -1.0)
    omega = about(rng, normal, front * rng.uniform(0.02, 1.0, ROWS))
    above = np.where(rng.random(ROWS) < 0.9, 1.0, -1.0)
    x = _points(rng)
    reach = d * spread(rng, -1.1, 1.1, ROWS)
    position = y["position"] + reach[:, None] * omega
    return _Viewpoints(
        position, about(rng, -omega, above * rng.uniform(0.02, 1.0, ROWS)), x.albedo
    )


def spatial_rows(
    rng: np.random.Generator, kind: str, cap: float, mis: str, size: Size
) -> Case:
    """Case of pass ``spatial``."""
    x, extent = _clusters(rng, size)
    own, past = (
        _reservoirs(
            rng, x, _ways_in_cluster(rng, x, extent, size), kind, most, size.bare
        )
        for most in (size.trust, cap)
    )
    row = np.arange(size.rows)
    mates = row[:, None] // size.cluster * size.cluster
    neighbors = mates + rng.integers(0, size.cluster, (size.rows, size.neighbors))
    none = (rng.random(neighbors.shape) < NOWHERE) | (neighbors == row[:, None])
    neighbors = np.where(none, -1, neighbors)
    inputs = x.buffers | own | prefixed("past", past)
    inputs |= {
        "neighbors": neighbors,
        "visible": _who_sees(rng, neighbors),
        "u_own": ends_of_u(rng, size.rows),
        "u_neighbors": ends_of_u(rng, neighbors.size).reshape(neighbors.shape),
    }
    settings: dict[str, Value] = {"target": kind, "cap": cap, "mis": mis}
    name = f"rows-spatial-{mis.replace('/', '')}-{kind}"
    if size != FEW_NEIGHBORS:
        name += f"-{size.neighbors}-neighbor" + "s" * (size.neighbors > 1)
    return Case(name, "spatial", settings, inputs)


def fused_rows(
    rng: np.random.Generator, kind: str, cap: float, mis: str, size: Size
) -> Case:
    """Case of pass ``fused``: points of both frames lie together on a floor each."""
    rows = np.arange(size.rows)
    both = replace(size, rows=2 * size.rows, cluster=2 * size.cluster)
    x, extent = _clusters(rng, both)
    held = [
        _reservoirs(
            rng, x, _ways_in_cluster(rng, x, extent, both), kind, most, size.bare
        )
        for most in (size.trust, cap)
    ]
    # Of each cluster every other point is one of the past frame.
    own, past = (
        {name: a[frame::2] for name, a in (x.buffers | r).items()}
        for frame, r in enumerate(held)
    )
    mates = rows[:, None] // size.cluster * size.cluster
    sources = mates + rng.integers(0, size.cluster, (size.rows, size.neighbors))
    sources = np.where(rng.random(sources.shape) < NOWHERE, -1, sources)
    # Some points have not moved, and hold what they held.
    still = rng.random(size.rows) < STILL
    for name in own:
        past[name][still] = own[name][still]
    past["M"] = np.minimum(past["M"], cap)
    inputs = own | prefixed("past", past)
    inputs |= {
        "sources": sources,
        "visible": _who_sees_then(rng, sources, still),
        "u": ends_of_u(rng, sources.size).reshape(sources.shape),
    }
    settings: dict[str, Value] = {"target": kind, "cap": cap, "mis": mis}
    name = f"rows-fused-{mis.replace('/', '')}-{kind}"
    if size != FEW_NEIGHBORS:
        name += f"-{size.neighbors}-source" + "s" * (size.neighbors > 1)
    return Case(name, "fused", settings, inputs)


def _clusters(rng: np.random.Generator, size: Size) -> tuple[_Viewpoints, Scalars]:
    """Points that lie together on a floor each; and how large it is, (N,), m."""
    count, rows = size.rows // size.cluster, size.rows
    extent = np.repeat(spread(rng, -1, 0.5, count), size.cluster)
    place = np.repeat(3.0 * rng.normal(size=(count, 3)), size.cluster, axis=0)
    up = np.repeat(unit_vectors(rng, count), size.cluster, axis=0)
    aside = about(rng, up, np.zeros(rows)) * (extent * rng.random(rows))[:, None]
    normal = about(rng, up, rng.uniform(0.4, 1.0, rows))
    albedo = _points(rng, rows=rows).albedo
    return _Viewpoints(place + aside, normal, albedo), extent


def _ways_in_cluster(
    rng: np.random.Generator, x: _Viewpoints, extent: Scalars, size: Size
) -> Vec3s:
    """Ways to samples near to their maker, far away, or near to another point."""
    row = np.arange(size.rows)
    mate = row // size.cluster * size.cluster + rng.integers(0, size.cluster, size.rows)
    there = _Viewpoints(x.position[mate], x.normal[mate], x.albedo[mate])
    near = _ways(rng, there, extent * spread(rng, -2, -0.5, size.rows))
    other = there.position + near - x.position
    least = 0.02 * np.linalg.norm(other, axis=1)
    above: Masks = (x.normal * other).sum(axis=1) > least
    own = _ways(rng, x, extent * spread(rng, -1.4, 0.6, size.rows))
    return np.where(above[:, None], other, own)


def _who_sees(rng: np.random.Generator, neighbors: Indices) -> NDArray[np.uint32]:
    """Bits of pass ``spatial``: the same answer wherever the same is asked."""
    rows, count = neighbors.shape
    row = np.arange(rows)
    around = [np.maximum(neighbors[:, k], 0) for k in range(count)]
    samples = [row, *around, row + rows]  # the pasts are numbered after the others
    sees = rng.random((rows, 2 * rows)) > HIDDEN
    sees[row, row] = sees[row, row + rows] = True
    return _words(sees, [row, *around], samples)


def _who_sees_then(
    rng: np.random.Generator, sources: Indices, still: Masks
) -> NDArray[np.uint32]:
    """Bits of pass ``fused``; points and samples of the past come after the others.

    Parameters
    ----------
    still : (N,) bool; rows of which both frames have the same point and sample
    """
    rows, count = sources.shape
    row = np.arange(rows)
    points = [row, *(np.maximum(sources[:, k], 0) + rows for k in range(count))]
    sees = rng.random((2 * rows, 2 * rows)) > HIDDEN
    np.fill_diagonal(sees, True)
    same = np.flatnonzero(still)
    sees[:, rows + same] = sees[:, same]
    sees[rows + same] = sees[same]
    return _words(sees, points, points)


def _words(
    sees: Masks, viewers: list[Indices], samples: list[Indices]
) -> NDArray[np.uint32]:
    """A column for each viewer, and a bit for each sample.

    Parameters
    ----------
    sees : (V, S) bool; whether each of all viewers sees each of all samples
    viewers, samples : list of (N,) int; of these
    """
    words = np.zeros((len(viewers[0]), len(viewers)), np.uint32)
    for column, viewer in enumerate(viewers):
        for bit, sample in enumerate(samples):
            seen = sees[viewer, sample].astype(np.uint32)
            words[:, column] |= seen << np.uint32(bit)
    return words


def _neighbors(rng: np.random.Generator) -> Iterator[Case]:
    """Images of patches, of which some are alike: wide, of an odd width, of a line."""
    common: dict[str, Value] = {"max_angle": 40.0, "max_depth": 0.2}
    settings: dict[str, Value] = {"radius": 0.3, "min_radius": 1.5}
    yield image_case(rng, "", (64, 24), 8, 6, settings | common)
    # The radius begins at its least; and the whole image is in reach.
    settings = {"radius": 0.05, "min_radius": 5.0, "max_angle": 12.0, "max_depth": 0.5}
    yield image_case(rng, "odd", (27, 19), 20, 4, settings)
    settings = {"radius": 1.25, "min_radius": 0.75}
    settings |= {"max_angle": 75.0, "max_depth": 0.03}
    yield image_case(rng, "line", (201, 1), 5, 3, settings)


def image_case(
    rng: np.random.Generator,
    variant: str,
    size: tuple[int, int],
    count: int,
    patch: int,
    settings: dict[str, Value],
) -> Case:
    """Case of pass ``neighbors``: patches that are turned and far away as they like.

    Parameters
    ----------
    size : int, int; width and height, pixels
    count : int; K
    patch : int, pixels
    """
    width, height = size
    rows = width * height
    y, x = np.divmod(np.arange(rows), width)
    number = y // patch * width + x // patch
    cosine = rng.uniform(TILTED, 1.0, rows)[number]
    tilt = about(rng, np.tile([0.0, 0.0, 1.0], (rows, 1)), cosine)
    depth = spread(rng, 0, 0.2, rows)[number]
    depth = depth * (1 + 0.02 * rng.normal(size=rows))
    places = np.stack([ends_of_u(rng, count * rows) for _ in range(2)], axis=1)
    inputs = {
        "visible_normal": tilt[number],
        "depth": depth * (rng.random(rows) < 0.95),
        "u": places.reshape(-1, count, 2),
    }
    name = "-".join(word for word in ("rows-neighbors", variant) if word)
    return Case(name, "neighbors", {"width": width, **settings}, inputs)

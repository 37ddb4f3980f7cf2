"""The project's own passes of shifts: the production functions, behind the contract."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np

from restir_gi.extensions.oracle.shifts.scenes import frame_of
from restir_gi.extensions.shifting import Criterion, PathNeighbor, Paths, Shift, segment
from restir_gi.reference.numerics.arrays import Indices, Scalars, Vec3s, divide_or_zero
from restir_gi.reference.numerics.records import take
from restir_gi.reference.oracle.builtin.buffers import Array, as_real
from restir_gi.reference.oracle.builtin.world import surface_of
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.resampling.reservoir import Reservoirs
from restir_gi.reference.scene.geometry import Geometry
from restir_gi.reference.scene.materials.parameters import Kind
from restir_gi.reference.scene.surface import SurfacePoints
from restir_gi.reference.transport.world import World


@dataclass(frozen=True, slots=True, eq=False)
class _Lobes:
    """What the criterion asks of a material table."""

    kind: Indices
    alpha: Scalars


@dataclass(frozen=True, slots=True, eq=False)
class _Scene:
    """What a segment asks of a scene: its size, and surfaces that need no step."""

    materials: _Lobes
    extent: float
    triangles: int
    radius: Scalars


def _lobes(alpha: Array, single: Array) -> _Lobes:
    """Rows of a material table: every kind has its turn."""
    turn = np.arange(len(alpha)) % 2 == 0
    alone = np.where(turn, Kind.SMOOTH_CONDUCTOR, Kind.DIELECTRIC)
    rough = np.where(turn, Kind.ROUGH_CONDUCTOR, Kind.ROUGH_COATED)
    diffuse = np.where(turn, Kind.LAMBERTIAN, Kind.SMOOTH_COATED)
    kind = np.where(single == 1, alone, np.where(alpha == 1, diffuse, rough))
    width = np.where((single == 1) | (alpha == 1), 0.0, alpha)
    return _Lobes(kind.astype(np.int8), width)


def _scene(lobes: _Lobes, extent: float) -> Geometry:
    return cast(Geometry, _Scene(lobes, extent, 0, np.ones(1)))


def _joinable(
    precision: Precision,
    alpha_from: Array,
    alpha_to: Array,
    single_from: Array,
    single_to: Array,
    distance: Array,
    roughness: float,
    least_distance: float,
    extent: float,
) -> dict[str, Array]:
    """Both points on an axis."""
    size = len(distance)
    lobes = _lobes(
        np.concatenate([alpha_from, alpha_to]).astype(float),
        np.concatenate([single_from, single_to]),
    )
    there = np.zeros((size, 3))
    there[:, 2] = distance
    up = np.tile([0.0, 0.0, 1.0], (size, 1))
    row = np.arange(size)
    x_from = replace(surface_of(np.zeros((size, 3)), up, up), material=row)
    x_to = replace(surface_of(there, -up, up), material=size + row)
    criterion = Criterion(roughness, least_distance)
    _, came = segment(criterion, _scene(lobes, extent), x_from, x_to)
    return {"joinable": came.joinable.astype(np.uint32)}


def _path_jacobian(
    precision: Precision,
    x_from: Array,
    x_to: Array,
    joint_position: Array,
    joint_normal: Array,
    p_from: Array,
    p_to: Array,
    p_onward_from: Array,
    p_onward_to: Array,
) -> dict[str, Array]:
    """One segment of each path."""
    size = len(p_from)
    wide = np.ones(size)
    scene = _scene(_lobes(wide, np.zeros(size)), 1.0)
    position, normal = joint_position.astype(float), joint_normal.astype(float)
    joint = replace(surface_of(position, normal, normal), material=np.arange(size))
    density = []
    for x, p, onward in (
        (x_from, p_from, p_onward_from),
        (x_to, p_to, p_onward_to),
    ):
        at = surface_of(x.astype(float), normal, normal)
        at = replace(at, material=np.arange(size))
        _, came = segment(Criterion(), scene, at, joint)
        density.append(p.astype(float) * came.spread * onward.astype(float))
    jacobian = divide_or_zero(density[1], density[0])
    return {"jacobian": as_real(precision, jacobian)}


RECORD = ("joint", "end", "technique")
NUMBERS = ("incoming", "density", "pdf_light")


def _shift(
    precision: Precision,
    path: Array,
    pixel: Array,
    roughness: float,
    least_distance: float,
    last_joint: int,
    replays: int,
    scene: str,
    size: int,
    seed: int,
    frame: int,
    bounces: int,
    **tables: Any,
) -> dict[str, Array]:
    """Walks again, in the scene: of the tables only the record is read."""
    criterion = Criterion(roughness, least_distance, last_joint, replays == 1)
    at = frame_of(
        scene, size, seed=seed, frame=frame, bounces=bounces, criterion=criterion
    )
    base = take(at.paths, path.astype(np.int64) % (size * size))
    record = {name: tables[name].astype(np.int8) for name in RECORD}
    record |= {name: tables[name].astype(float) for name in NUMBERS}
    paths, shift = replace(base, **record), Shift(criterion, at.numbers)
    here = take(at.points, path.astype(np.int64) % (size * size))
    there = take(at.points, pixel.astype(np.int64))
    value, jacobian = _by_turns(shift, at.world, here=here, there=there, paths=paths)
    return {
        "value": as_real(precision, value),
        "jacobian": as_real(precision, jacobian),
    }


def _by_turns(
    shift: Shift,
    world: World,
    here: SurfacePoints,
    there: SurfacePoints,
    paths: Paths,
) -> tuple[Vec3s, Scalars]:
    """The shift in even rows, its inverse in odd ones; sources are in reverse order."""
    size = len(paths)
    value, jacobian = np.zeros((size, 3)), np.zeros(size)
    rows = np.arange(size)[::-1]
    forward, inverse = np.arange(0, size, 2), np.arange(1, size, 2)
    ones = np.ones(size)
    reused = Reservoirs(take(paths, rows), ones, ones)
    neighbor = PathNeighbor(
        shift,
        world,
        points=there,
        world_from=world,
        points_from=take(here, rows),
        reservoirs=reused,
        rows=rows,
    )
    value[forward], jacobian[forward] = neighbor.shifted(forward)
    neighbor = PathNeighbor(
        shift,
        world,
        points=here,
        world_from=world,
        points_from=take(there, rows),
        reservoirs=reused,
        rows=rows,
    )
    value[inverse], jacobian[inverse] = neighbor.inverse(paths, inverse)
    return value, jacobian


OWN: Mapping[str, Callable[..., dict[str, Array]]] = {
    "joinable": _joinable,
    "path_jacobian": _path_jacobian,
    "shift": _shift,
}

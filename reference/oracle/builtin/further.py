"""Further passes of the contract by the production functions."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np

from restir_gi.reference.numerics.arrays import (
    Indices,
    Masks,
    Scalars,
    Vec3s,
    cross,
    dot,
    normalize,
)
from restir_gi.reference.options.boiling import boiling_filter
from restir_gi.reference.options.checkerboard import draws_new_sample
from restir_gi.reference.options.replay import Replay
from restir_gi.reference.options.reprojection import reproject
from restir_gi.reference.options.roulette import tail_weight
from restir_gi.reference.options.validation import validated
from restir_gi.reference.oracle.builtin.buffers import Array, as_real
from restir_gi.reference.oracle.builtin.packing import pack, unpack
from restir_gi.reference.oracle.builtin.world import surface_of
from restir_gi.reference.oracle.contract.fields import Precision, dtype_of
from restir_gi.reference.resampling.reservoir import Reservoirs, Samples
from restir_gi.reference.resampling.suffix import Suffix
from restir_gi.reference.scene.camera import Camera, camera_rays, view_depth
from restir_gi.reference.scene.materials.kinds import Lambertian
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.shapes import Mesh
from restir_gi.reference.scene.surface import VisiblePoints
from restir_gi.reference.settings import UNBIASED
from restir_gi.reference.transport.world import World, build_world


def _camera(settings: Mapping[str, Any]) -> Camera:
    def vector(name: str) -> tuple[float, float, float]:
        x, y, z = (float(settings[f"{name}_{axis}"]) for axis in "xyz")
        return x, y, z

    return Camera(
        vector("eye"),
        vector("target"),
        vector("up"),
        fov=float(settings["fov_x"]),
        width=int(settings["width"]),
        height=int(settings["height"]),
    )


def _gbuffer(
    precision: Precision, pixel: Array, a: Array, b: Array, c: Array, **settings: Any
) -> dict[str, Array]:
    """Embree and its steps stay outside: the contract asks for the plane itself."""
    camera = _camera(settings)
    line, column = np.divmod(pixel, camera.width)
    eye, d = camera_rays(camera, column + 0.5, line + 0.5)
    n = cross(b - a, c - a).astype(float)
    facing = dot(n, d)
    ahead = facing != 0
    t = np.divide(dot(n, a - eye), facing, out=np.zeros(len(d)), where=ahead)
    p = eye + d * t[:, None]
    sides = [dot(n, cross(to - at, p - at)) > 0 for at, to in ((a, b), (b, c), (c, a))]
    hit = np.all([ahead, t > 0, *sides], axis=0)
    found = {
        "position": p,
        "normal": normalize(n) * np.where(facing > 0, -1.0, 1.0)[:, None],
        "depth": view_depth(camera, p)[:, None],
    }
    kept = {
        k: as_real(precision, np.where(hit[:, None], v, 0.0)) for k, v in found.items()
    }
    return {"hit": hit.astype(np.uint32), **kept, "depth": kept["depth"][:, 0]}


@dataclass(frozen=True, slots=True, eq=False)
class _OneShape:
    """Geometry that does not move."""

    shape: Indices


@dataclass(frozen=True, slots=True, eq=False)
class _Seen:
    """What reprojection asks of a world."""

    camera: Camera
    geometry: _OneShape


def _reproject(
    precision: Precision,
    position: Array,
    normal: Array,
    hit: Array,
    normal_before: Array,
    depth_before: Array,
    max_angle: float,
    max_depth: float,
    **settings: Any,
) -> dict[str, Array]:
    camera, still = _camera(settings), _OneShape(np.zeros(1, np.int32))
    before_world = cast(World, _Seen(camera, still))
    x, y, z = camera.position
    # Where this frame's camera stands is not asked.
    aside = replace(camera, position=(x + 1.0, y - 1.0, z + 1.0))
    now_world = cast(World, _Seen(aside, still))
    now = surface_of(position, normal, normal)
    now = replace(now, primitive=np.where(hit == 1, 0, -1).astype(np.int32))
    before = surface_of(normal_before, normal_before, normal_before)
    row = reproject(
        before_world,
        VisiblePoints(before, depth_before),
        now_world,
        VisiblePoints(now, depth_before),
        None,
        replace(UNBIASED, max_angle=max_angle, max_depth=max_depth),
    )
    return {"row": row.astype(dtype_of("index", precision))}


@dataclass(frozen=True, slots=True, eq=False)
class _Known:
    """Radiance that was found before."""

    now: Vec3s

    def radiance(self, world: World, suffix: Suffix, active: Masks) -> Vec3s:
        """Found again."""
        return np.where(active[:, None], self.now, self.now.dtype.type(0))


def _validation(
    precision: Precision,
    W: Array,
    M: Array,
    radiance_then: Array,
    radiance_now: Array,
    met: Array,
    null: Array,
    tolerance: float,
) -> dict[str, Array]:
    """Everybody stands above one triangle; what is met lies on it, the rest beside."""
    corners = np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 2.0, 0.0]])
    floor = Mesh(
        name="floor",
        vertices=corners,
        faces=np.array([[0, 1, 2]]),
        material=Lambertian((0.5, 0.5, 0.5)),
    )
    camera = Camera(position=(0.0, 0.0, 1.0), target=(0.0, 0.0, 0.0))
    world = build_world(Scene(name="one", camera=camera, meshes=(floor,)))
    up = np.tile([0.0, 0.0, 1.0], (len(W), 1))
    aside = np.where(met[:, None] == 1, 0.0, [9.0, 0.0, 0.0])
    points, there = surface_of(up, up, up), surface_of(aside, up, up)
    on_floor = np.where(null == 1, -1, 0).astype(np.int32)
    suffix = Suffix(np.arange(len(W)), replace(there, primitive=on_floor))
    r = Reservoirs(Samples(aside, up, radiance_then, suffix), W, M)
    points = replace(points, primitive=np.zeros(len(W), np.int32))
    replay = cast(Replay, _Known(radiance_now))
    return _weights(precision, validated(world, points, r, replay, tolerance))


def _boiling(
    precision: Precision,
    radiance: Array,
    W: Array,
    M: Array,
    width: int,
    strength: float,
) -> dict[str, Array]:
    r = Reservoirs(Samples(radiance, radiance, radiance), W, M)
    return _weights(precision, boiling_filter(r, width, strength))


def _weights(precision: Precision, r: Reservoirs) -> dict[str, Array]:
    return {"W": as_real(precision, r.W), "M": as_real(precision, r.M)}


def _checkerboard(
    precision: Precision, pixel: Array, has_history: Array, width: int, frame: int
) -> dict[str, Array]:
    draws = draws_new_sample(pixel, width, frame, has_history == 1)
    return {"draws": draws.astype(np.uint32)}


def _roulette(
    precision: Precision,
    pixel: Array,
    width: int,
    frame: int,
    seed: int,
    probability: float,
) -> dict[str, Array]:
    weight: Scalars = tail_weight(pixel, width, probability, frame, seed)
    return {"weight": as_real(precision, weight)}


FURTHER: Mapping[str, Callable[..., dict[str, Array]]] = {
    "gbuffer": _gbuffer,
    "reproject": _reproject,
    "validation": _validation,
    "boiling": _boiling,
    "checkerboard": _checkerboard,
    "roulette": _roulette,
    "pack": pack,
    "unpack": unpack,
}

"""Visible points with declared surfaces, by the production BSDF functions."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars, Vec3s, dot
from restir_gi.reference.numerics.records import take
from restir_gi.reference.oracle.builtin.world import Known, world_of
from restir_gi.reference.oracle.cases import Buffers
from restir_gi.reference.oracle.contract.surfaces import COATED, NODES
from restir_gi.reference.passes.pixels import FrameReservoirs, NeighborPixels, Pixels
from restir_gi.reference.resampling.reservoir import Samples
from restir_gi.reference.resampling.target import Target, luminance, reflected, target
from restir_gi.reference.scene.materials import conductor, lambertian
from restir_gi.reference.scene.materials.parameters import Kind, MaterialTable
from restir_gi.reference.scene.surface import SurfacePoints, direction_and_distance
from restir_gi.reference.settings import UNBIASED

Array = NDArray[Any]


@dataclass(frozen=True, slots=True, eq=False)
class SurfacePixels(Pixels):
    """Pixels that see declared surfaces.

    Attributes
    ----------
    surface : str; which of the contract's
    """

    surface: str = COATED

    def target(self, y: Samples) -> Scalars:
        """Target p̂_q(y), (K,), radiance/sr; without visibility."""
        return self.target_at(self.points, y)

    def target_at(self, points: SurfacePoints, y: Samples) -> Scalars:
        """Target of samples at other points of the same surface, (K,), radiance/sr."""
        kind: Target = self.settings.target
        if self.surface == COATED or kind == "outgoing":
            return target(kind, self.world.materials, points, y)
        return luminance(_reflected_by_ggx(self.world.materials, points, y))

    def shown(self, y: Samples, W: Scalars) -> Vec3s:
        """Radiance f(y) W that samples bring to the camera, (K, 3), W/(m² sr).

        Parameters
        ----------
        W : (K,), sr
        """
        by = reflected if self.surface == COATED else _reflected_by_ggx
        return by(self.world.materials, self.points, y) * W[:, None]


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceFrame(FrameReservoirs):
    """Reservoirs of pixels that see declared surfaces."""

    def neighbors(self, q: Pixels, rows: Indices) -> NeighborPixels:
        """Pixels of this frame beside each q; (K,) rows, or ``NONE``."""
        x = take(self.visible.surface.viewpoints, np.maximum(rows, 0))
        return SurfaceNeighbors(q, self, rows, x, self.at(rows))


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceNeighbors(NeighborPixels):
    """Pixels q_n that see declared surfaces."""

    def target(self, rows: Indices, y: Samples) -> Scalars:
        """Target of samples at pixels of this frame, (A,), whoever may hide them."""
        points = take(self.frame.visible.surface, rows)
        return cast(SurfacePixels, self.q).target_at(points, y)

    def supports(self, y: Samples) -> Masks:
        """Whether samples have a target above 0 at q_n, (K,), whoever may hide them."""
        supported: Masks = self.target(np.maximum(self.rows, 0), y) > 0
        return supported


def surface_pixels(
    buffers: Buffers, kind: Any, surface: str, known: Sequence[Known] = ()
) -> SurfacePixels:
    """Pixels among buffers; those of the past come after them in the world's table."""
    prefixes = [p for p in ("", "past_") if f"{p}view" in buffers]
    world = world_of(known, _table(buffers, prefixes))
    settings = replace(UNBIASED, target=kind)
    return SurfacePixels(world, surface_points(buffers), settings, surface=surface)


def surface_points(buffers: Buffers, prefix: str = "", first: int = 0) -> SurfacePoints:
    """Visible points of declared surfaces.

    Parameters
    ----------
    first : int; row of the material table, and number, of the first of them
    """
    normal = buffers[f"{prefix}visible_normal"]
    number = first + np.arange(len(normal), dtype=np.int32)
    return SurfacePoints(
        position=buffers[f"{prefix}visible_position"],
        normal=normal,
        smooth=None,
        wo=buffers[f"{prefix}view"],
        color=buffers[f"{prefix}albedo"],
        material=number,
        primitive=number,
        front=np.ones(len(normal), bool),
    )


def _table(buffers: Buffers, prefixes: Sequence[str]) -> MaterialTable:
    """A material for each visible point; F₀ stands where coats have their colour."""

    def column(name: str, absent: float, *shape: int) -> Array:
        alpha = [buffers[f"{prefix}alpha"] for prefix in prefixes]
        fallback = [np.full((len(a), *shape), absent, a.dtype) for a in alpha]
        given = [buffers.get(f"{prefix}{name}") for prefix in prefixes]
        pairs = zip(given, fallback, strict=True)
        return np.concatenate([b if a is None else a for a, b in pairs])

    alpha, none = column("alpha", 0.0), column("none", 0.0, 3)
    coated = f"{prefixes[0]}ior" in buffers
    kind = Kind.ROUGH_COATED if coated else Kind.ROUGH_CONDUCTOR
    everyone = np.ones(len(alpha), bool)
    return MaterialTable(
        kinds=(kind,),
        kind=np.full(len(alpha), kind, np.int8),
        textures=(),
        color=none,
        two_sided=everyone,
        alpha=alpha,
        beckmann=~everyone,
        ior=column("ior", 1.5),
        eta=none,
        k=none,
        schlick=everyone,
        specular=column("f0", 1.0, 3),
        nonlinear=column("nonlinear", 0.0) == 1,
        transmittance=column("transmittance", 0.0, NODES),
        keep=column("internal_reflectance", 0.0),
        plain=False,
    )


def _reflected_by_ggx(table: MaterialTable, points: SurfacePoints, y: Samples) -> Vec3s:
    """Integrand of a diffuse surface with a lobe as metal has it, (N, 3)."""
    omega, _ = direction_and_distance(points.position, y.position)
    diffuse = lambertian.scattering(table, points, omega)
    as_metal = replace(points, color=table.specular[points.material])
    lobe = conductor.scattering(table, as_metal, omega)
    shown = (dot(y.normal, omega) < 0) & (dot(points.normal, points.wo) > 0)
    return np.where(shown[:, None], (diffuse + lobe) * y.radiance, 0.0)

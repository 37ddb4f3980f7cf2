"""A world made of buffers: diffuse materials, and visibility that was written down."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Indices, Masks, Vec3s
from restir_gi.reference.numerics.records import take
from restir_gi.reference.scene.materials.kinds import Lambertian
from restir_gi.reference.scene.materials.parameters import MaterialTable, tabulate
from restir_gi.reference.scene.surface import SurfacePoints, Viewpoints
from restir_gi.reference.transport.world import World


@dataclass(frozen=True, slots=True, eq=False)
class Known:
    """Who sees which samples, as far as it was asked and answered before.

    Attributes
    ----------
    viewer : (Q,) int
        Number of the visible point, as ``primitive`` of its surface point says it.
    position : (Q, 3); sample point
    seen : (Q,) bool; the answer
    """

    viewer: Indices
    position: Vec3s
    seen: Masks


@dataclass(frozen=True, slots=True, eq=False)
class WrittenVisibility:
    """In place of a ray caster: looks answers up.

    Attributes
    ----------
    known : Known; all that may be asked, sorted by `point_keys`
    keys : (Q,) uint64; of the questions, rising
    """

    known: Known
    keys: NDArray[np.uint64]

    def visible(
        self,
        points: SurfacePoints | Viewpoints,
        x_to: Vec3s,
        n_to: Vec3s,
        active: Masks,
        kind: str,
    ) -> Masks:
        """Whether surface points see other points, (N,) bool; False where nobody looks.

        Parameters
        ----------
        points : SurfacePoints or Viewpoints
            N points, whose ``primitive`` is the viewer's number.
        x_to, n_to : (N, 3), m and 1; points looked at, and normals, which are not used
        active : (N,) bool; who looks
        kind : str; not used

        Raises
        ------
        KeyError
            A question to which no answer was written down.
        """
        asked = np.flatnonzero(active)
        viewer, position = points.primitive[asked], x_to[asked]
        place = np.searchsorted(self.keys, point_keys(viewer, position))
        place = np.minimum(place, max(len(self.keys) - 1, 0))
        if len(asked):
            same = (self.known.position[place] == position).all(axis=1)
            if not (same & (self.known.viewer[place] == viewer)).all():
                raise KeyError("visibility that is not among the buffers")
        seen: Masks = np.zeros(len(active), bool)
        seen[asked] = self.known.seen[place]
        return seen


def point_keys(viewer: Indices, position: Vec3s) -> NDArray[np.uint64]:
    """Hashes of viewers and points; what they find is compared in full.

    Parameters
    ----------
    viewer : (N,) int; numbers of visible points
    position : (N, 3), m; of samples

    Returns
    -------
    (N,) uint64
    """
    key = viewer.astype(np.int64).astype(np.uint64)
    for column in range(3):
        word = np.ascontiguousarray(position[:, column].astype(float) + 0.0)
        key = (key ^ word.view(np.uint64)) * np.uint64(0x9E3779B97F4A7C15)
        key ^= key >> np.uint64(29)
    return key


def diffuse_table() -> MaterialTable:
    """Materials of the contract: diffuse, of any colour."""
    return tabulate([Lambertian((0.5, 0.5, 0.5))])


@dataclass(frozen=True, slots=True, eq=False)
class _Buffers:
    """What the passes ask of a world."""

    materials: MaterialTable
    caster: WrittenVisibility
    geometry: None = None
    emitters: None = None


def world_of(
    known: Sequence[Known] = (), materials: MaterialTable | None = None
) -> World:
    """A world that answers from buffers, as far as the passes look at it.

    Parameters
    ----------
    materials : MaterialTable, optional; diffuse ones unless others are given
    """
    nothing = Known(np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros(0, bool))
    parts = [nothing, *known]
    joined = Known(
        np.concatenate([part.viewer for part in parts]),
        np.concatenate([part.position for part in parts]),
        np.concatenate([part.seen for part in parts]),
    )
    # Black points may be among the buffers: their target is asked, not their material.
    table = materials or replace(diffuse_table(), plain=False)
    keys = point_keys(joined.viewer, joined.position)
    order = np.argsort(keys, kind="stable")
    written = WrittenVisibility(take(joined, order), keys[order])
    return cast(World, _Buffers(table, written))


def surface_of(position: Vec3s, normal: Vec3s, albedo: Vec3s) -> SurfacePoints:
    """Visible points of diffuse surfaces.

    Parameters
    ----------
    position, normal, albedo : (N, 3), m, 1 and 1; buffers
    """
    rows = len(position)
    return SurfacePoints(
        position=position,
        normal=normal,
        smooth=None,
        wo=normal,
        color=albedo,
        material=np.zeros(rows, np.int32),
        primitive=np.arange(rows, dtype=np.int32),
        front=np.ones(rows, bool),
    )

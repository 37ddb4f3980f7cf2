"""A path that asks the cells it comes through how to go on."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from extensions.connection import segment
from extensions.donors import PointDonor
from extensions.ends import ended, find_lights
from extensions.frame_loop import Moment
from extensions.paths import no_paths
from extensions.walking import Leaving, arrive, leave, start
from hashgrid.cache import find
from hashgrid.cell_donor import CellDonor, in_cells
from hashgrid.path_cache import PathCache, Written, joins
from hashgrid.path_settings import CellSettings
from hashgrid.tails import Onset, behind
from hashgrid.vertex_numbers import decisions, of_vertices
from reference.arrays import Indices, divide_or_zero
from reference.records import NONE, take
from reference.resampling.generalized import resample
from reference.resampling.reservoir import Candidates, Reservoirs, finalize, merge
from reference.resampling.target import luminance
from reference.rng import Stream, Uniforms
from reference.scene.materials.table import pdf, scattering
from reference.scene.surface import SurfacePoints


@dataclass(frozen=True, slots=True)
class Tail:
    """What K paths find from x_v on.

    Attributes
    ----------
    kept : Reservoirs; of paths whose first point is x_v
    onset : Onset; how they leave it
    """

    kept: Reservoirs
    onset: Onset
    written: Written | None


@dataclass(frozen=True, slots=True, eq=False)
class Bounces:
    """Paths of K pixels, drawn from the end.

    Attributes
    ----------
    moment : Moment; the frame; its settings are `CellSettings`
    caches : mapping of int to PathCache
        Of the last frame, by the number of the vertex that asks.
    number : (K,) int64; keys of the paths
    """

    moment: Moment
    caches: Mapping[int, PathCache]
    number: Indices

    @property
    def settings(self) -> CellSettings:
        """Of the frame."""
        settings = self.moment.settings
        assert isinstance(settings, CellSettings)
        return settings

    def draw(self, points: SurfacePoints) -> Tail:
        """Paths from visible points.

        Parameters
        ----------
        points : SurfacePoints; K visible points x_1
        """
        shift = self.moment.shift
        uniforms = shift.uniforms(self.number)
        leaving = leave(self.moment.world, start(points), 1, uniforms, points.hit)
        return self._tail(points, leaving, 1, uniforms)

    def _tail(
        self, points: SurfacePoints, leaving: Leaving, v: int, uniforms: Uniforms
    ) -> Tail:
        world, criterion = self.moment.world, self.moment.shift.criterion
        # To x_(v+1), which is the second point of paths that begin at x_v.
        step = arrive(world, criterion, start(points), 1, leaving)
        is_last = v == self.moment.bounces
        onward: Leaving | None = None
        if not is_last or world.seeks_lights:
            onward = leave(world, step, v + 1, uniforms, step.points.hit)
        # Paths that end there ...
        lights = find_lights(world, step, v + 1, uniforms, onward)
        found = replace(
            lights, y=ended(step, no_paths(points, self.number), 2, lights.y)
        )
        written: Written | None = None
        if not is_last and onward is not None:
            # ... and those that go on, as the reservoir of x_(v+1) says.
            rest = self._tail(step.points, onward, v + 1, uniforms)
            y = behind(step, rest.kept.y, rest.onset)
            p_hat = luminance(y.value)
            longer = Candidates(y, p_hat, p_hat * rest.kept.W, 0 * p_hat)
            found = merge(found, longer, uniforms.draw(2 * v + 1)[3])
            written = rest.written
        ones = np.ones(len(points))
        own = finalize(replace(found, M=ones), ones)
        bsdf = leaving.bsdf
        wi = np.where(step.joinable[:, None], -step.points.wo, bsdf.wi)
        onset = Onset(wi, step.weight, step.pdf, bsdf.delta)
        kept = self._asked(points, v, own)
        if kept is not own:
            onset = self._onset(points, kept, onset)
        if self.settings.writes(v):
            W = np.where(kept.y.joint == 2, kept.W, 0.0)
            written = Written(points, replace(kept, W=W), written)
        return Tail(kept, onset, written)

    def _asked(self, points: SurfacePoints, v: int, own: Reservoirs) -> Reservoirs:
        """Resample a bounce: what it drew, and what the cell knows of going on."""
        if not self.settings.asks(v) or v not in self.caches:
            return own
        s, m, lent = self.settings, self.moment, self.caches[v]
        uniforms = self._keys(v)
        rows_in_cells = find(lent.cache, points, uniforms, s.cells, s.cell_reuse)
        able = joins(m.world, points, m.shift.criterion.roughness)
        here = np.arange(len(points))
        now, then = (m.world, points), (lent.cache.world, lent.cache.points)
        canonical = PointDonor(m.shift, *now, *now, own, here, same_domain=True)
        others = [
            CellDonor(
                in_cells(m.shift),
                *now,
                *then,
                lent.cache.reservoirs,
                np.where(able, rows, NONE),
                reach=m.bounces + 2 - v,
                reach_from=lent.reach,
            )
            for rows in rows_in_cells
        ]
        lanes = decisions(uniforms, len(others) + 1)
        kept = resample([canonical, *others], lanes, s.cell_mis, s.cell_cap)
        # What leads here is replayed from this path's numbers, not from the lender's.
        return replace(kept, y=replace(kept.y, number=self.number))

    def _onset(self, points: SurfacePoints, kept: Reservoirs, own: Onset) -> Onset:
        """How paths leave x_v that a cell may have sent elsewhere."""
        m, rows = self.moment, np.flatnonzero(kept.y.joint == 2)
        if not len(rows):
            return own
        x = take(points, rows)
        to = take(kept.y.surface, rows)
        seen, _ = segment(m.shift.criterion, m.world.geometry, x, to)
        wi, delta = own.wi.copy(), own.delta.copy()
        weight, density = own.weight.copy(), own.pdf.copy()
        table = m.world.materials
        wi[rows], delta[rows] = -seen.wo, False
        density[rows] = pdf(table, x, -seen.wo)
        value = scattering(table, x, -seen.wo)
        weight[rows] = divide_or_zero(value, density[rows, None])
        return Onset(wi, weight, density, delta)

    def _keys(self, v: int) -> Uniforms:
        m, pixel = self.moment, self.number % self.moment.pixels
        return of_vertices(pixel, m.number, v, m.seed, Stream.CELLS)

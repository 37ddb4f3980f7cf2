"""Shift mappings of paths in primary sample space, and their domains.

The random numbers of a base path are replayed from another visible point, up to the
point before its reconnection vertex; there the two are joined.  A path without
reconnection vertex is replayed whole.  What makes a path joinable, and where, is tested
on the offset path as it was on the base path: so the shift back leads to where it came
from, or does not exist.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from extensions.connection import Criterion, segment
from extensions.paths import Paths, Technique
from extensions.walking import Step, arrive, leave, start
from reference.arrays import (
    Indices,
    Masks,
    Scalars,
    Vec3s,
    divide_or_zero,
    dot,
    zero_vectors,
)
from reference.direct_light import choose_light, met_lights
from reference.light_shares import balance, share_of_chance, share_of_choice
from reference.records import scatter, take
from reference.rng import Uniforms
from reference.scene.materials.table import pdf, scattering
from reference.scene.origins import contact
from reference.scene.surface import SurfacePoints
from reference.world import World


@dataclass(frozen=True, slots=True)
class Shift:
    """How paths are shifted.

    Attributes
    ----------
    uniforms : callable; random numbers of the paths that have the given numbers
    """

    criterion: Criterion
    uniforms: Callable[[Indices], Uniforms]

    def __call__(
        self,
        world: World,
        points: SurfacePoints,
        at: Indices,
        paths: Paths,
        rows: Indices,
    ) -> tuple[Vec3s, Scalars]:
        """Shift paths to other visible points [Lin22, section 7.2].

        Parameters
        ----------
        at : (N,) int; which of them the paths go to
        rows : (N,) int; which of them are shifted

        Returns
        -------
        value : (N, 3) float64, W/(m² sr)
            f / p at the new point; 0 where the path does not exist there: out of sight,
            below a horizon, of another length, or joinable elsewhere.
        jacobian : (N,) float64
            |∂u_to / ∂u_from| in primary sample space; 0 where there is no such path.
        """
        value, density = zero_vectors(len(rows)), np.zeros(len(rows))
        joint = paths.joint[rows]
        able = (points.primitive[at] >= 0) & (paths.end[rows] > 0)
        # Wide records are gathered once, for those that need them.
        here = np.flatnonzero(able & (joint == 2))
        if len(here):
            step = start(take(points, at[here]))
            some = take(paths, rows[here])
            value[here], density[here] = self._joined(world, step, some, 1)
        going = able & (joint != 2) & self.criterion.replays
        here = np.flatnonzero(going)
        if len(here):
            step = start(take(points, at[here]))
            some = take(paths, rows[here])
            value[here], density[here] = self._replayed_until(world, step, some)
        base = np.where(joint > 0, paths.density[rows], 1.0)
        return value, divide_or_zero(density, base)

    def _replayed_until(
        self, world: World, step: Step, paths: Paths
    ) -> tuple[Vec3s, Scalars]:
        """Value and density of paths that are joined later than x_2, or never."""
        value, density = zero_vectors(len(paths)), np.zeros(len(paths))
        rows: Indices = np.arange(len(paths))
        vertex = 1
        while len(rows):
            # Replay one more direction; here, too, the base path could not be joined.
            everyone = np.ones(len(rows), bool)
            leaving = leave(world, step, vertex, self.uniforms(paths.number), everyone)
            same = ~(step.joinable & ~leaving.bsdf.delta)
            step = arrive(world, self.criterion, step, vertex, leaving)
            rows, paths, step = _kept(same & step.points.hit, rows, paths, step)
            vertex += 1
            joins = paths.joint == vertex + 1
            ends = (paths.joint == 0) & (paths.end == vertex)
            for here, finish in ((joins, self._joined), (ends, self._replayed)):
                at, part, there = _kept(here, rows, paths, step)
                if len(at):
                    value[at], density[at] = finish(world, there, part, vertex)
            rows, paths, step = _kept(~(joins | ends), rows, paths, step)
        return value, density

    def _joined(
        self, world: World, step: Step, paths: Paths, vertex: int
    ) -> tuple[Vec3s, Scalars]:
        """Value and density of paths that are joined to x_(v+1)."""
        x, table = step.points, world.materials
        there, came = segment(self.criterion, world.geometry, x, paths.surface)
        omega = -there.wo
        # Joined here as the base path was, from the same side, and not before.
        fits = came.joinable & ~step.joinable & (dot(there.normal, omega) < 0)
        left = scattering(table, x, omega)
        p_left = np.where(fits, pdf(table, x, omega), 0.0)
        onward = scattering(table, there, paths.wi)
        chosen = paths.technique == Technique.NEXT_EVENT
        last = paths.end == paths.joint
        p_onward = pdf(table, there, paths.wi)
        share = np.where(
            chosen,
            share_of_choice(world, there, paths.wi, paths.pdf_light),
            balance(p_onward, paths.pdf_light),
        )
        # The light was chosen by numbers that the joint does not touch.
        p_onward = np.where(last & chosen, 1.0, p_onward)
        weight = divide_or_zero(left, p_left[:, None])
        weight = weight * divide_or_zero(onward, p_onward[:, None])
        weight = weight * np.where(last, share, 1.0)[:, None]
        value = step.throughput * weight * paths.incoming
        value = np.where(fits[:, None], value, 0.0)
        shines: Masks = np.any(value > 0, axis=1)
        x_s = contact(world.geometry, there)
        seen = world.caster.visible(x, x_s, there.normal, shines, "reuse")
        return (
            np.where(seen[:, None], value, 0.0),
            np.where(seen & fits, p_left * came.spread * p_onward, 0.0),
        )

    def _replayed(
        self, world: World, step: Step, paths: Paths, vertex: int
    ) -> tuple[Vec3s, Scalars]:
        """Value of paths that end at x_v; in their own random numbers J is 1."""
        x, uniforms = step.points, self.uniforms(paths.number)
        chosen = paths.technique == Technique.NEXT_EVENT
        value, fits = zero_vectors(len(paths)), np.zeros(len(paths), bool)
        if chosen.any():
            active = chosen & x.hit & ~step.joinable
            light = choose_light(world, x, uniforms.draw(2 * vertex - 1), active)
            value, fits = light.value, active
        if not chosen.all():
            leaving = leave(world, step, vertex, uniforms, ~chosen & x.hit)
            bsdf = leaving.bsdf
            active = ~chosen & ~(step.joinable & ~bsdf.delta)
            rows, radiance, by_choice = met_lights(world, x, bsdf, leaving.hits)
            share = share_of_chance(bsdf.pdf[rows], bsdf.delta[rows], by_choice)
            met = scatter(rows, radiance * share[:, None], len(paths))
            value = np.where(active[:, None], bsdf.weight * met, value)
            fits = fits | active
        value = step.throughput * value
        return value, (fits & value.any(axis=1)).astype(float)


def _kept(
    mask: Masks, rows: Indices, paths: Paths, step: Step
) -> tuple[Indices, Paths, Step]:
    """Some of the rows; without a copy, if they are all."""
    if mask.all():
        return rows, paths, step
    at = np.flatnonzero(mask)
    return rows[at], take(paths, at), take(step, at)

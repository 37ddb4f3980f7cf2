"""Unbiased ReSTIR GI of a still scene, whole: Algorithms 1 to 4 on top of the kernels.

    python docs/examples/restir_gi_60_lines.py

A test holds every frame equal to the renderer's, bit for bit.
"""

from dataclasses import replace

import numpy as np

from restir_gi.reference.numerics.records import NONE, take
from restir_gi.reference.numerics.rng import KeyedUniforms, Stream
from restir_gi.reference.passes.gbuffer import visible_points
from restir_gi.reference.passes.initial import initial_samples
from restir_gi.reference.passes.neighbors import find_neighbors
from restir_gi.reference.passes.shade import shade
from restir_gi.reference.resampling import reservoir as r
from restir_gi.reference.resampling.reservoir import one_over_z
from restir_gi.reference.resampling.shift import reconnection_jacobian
from restir_gi.reference.resampling.source import source_pdf
from restir_gi.reference.resampling.target import target
from restir_gi.reference.scene.camera import pixel_centers
from restir_gi.reference.scene.catalogue.registry import find_scene
from restir_gi.reference.scene.surface import direction_and_distance
from restir_gi.reference.settings import UNBIASED
from restir_gi.reference.transport.world import build_world

s = UNBIASED


def frames(world, bounces, seed):
    """Indirect light in W/(m² sr), (N, 3), frame after frame."""
    width, table = world.camera.width, world.materials
    visible = visible_points(world, *pixel_centers(width, world.camera.height))
    q, pixel = visible.surface, np.arange(len(visible.depth))
    temporal = spatial = None
    frame = 0

    def random(stream):
        return KeyedUniforms(pixel.astype(np.uint32), frame, seed, stream)

    def p_hat(x, y):  # Equation 9
        return target(s.target, table, x, y)

    def sees(x, y, asked):
        return world.caster.visible(x, y.position, y.normal, asked, "reuse")

    while True:
        # Algorithm 2: a new sample for each pixel.
        S = initial_samples(
            world, q, s.source, s.glossy_samples, bounces,
            directions=random(Stream.INITIAL), paths=random(Stream.PATH),
            speculars=random(Stream.SPECULAR),
        )  # fmt: skip
        new = r.initial_candidates(S.y, p_hat(q, S.y), S.pdf)

        # Algorithm 3: it meets what the pixel kept; M is exact, for nothing moves.
        if temporal is not None:
            past = r.reused_candidates(temporal, p_hat(q, temporal.y))
            new = r.merge(past, new, random(Stream.TEMPORAL).draw(0)[0])
        temporal = r.cap_confidence(r.finalize(new, new.M), s.temporal_cap)

        # Algorithm 4: so do the temporal reservoirs of pixels nearby.
        u = random(Stream.SPATIAL)
        kept = r.reused_candidates(temporal, p_hat(q, temporal.y))
        M, many = [kept.M], np.ones(len(pixel), bool)
        if spatial is not None:  # the pixel's own spatial reservoir comes first
            past = r.reused_candidates(spatial, p_hat(q, spatial.y))
            kept, M = r.merge(past, kept, u.draw(63)[0]), [past.M, kept.M]
            many = s.spatial_cap / 2 > spatial.M
        slot, own = np.zeros(len(pixel), int), len(M)
        draws = [u.draw(k) for k in range(s.iterations_many)]
        around = find_neighbors(pixel, visible, width, s, draws)
        around[s.iterations_few :] = [
            np.where(many, n, NONE) for n in around[s.iterations_few :]
        ]
        for k, (n, draw) in enumerate(zip(around, draws, strict=True)):
            R_n, x_n = take(temporal, np.maximum(n, 0)), q.position[np.maximum(n, 0)]
            R_n = replace(R_n, M=np.where(n != NONE, R_n.M, 0.0))
            J = reconnection_jacobian(x_n, q.position, R_n.y.position, R_n.y.normal)
            c = r.reused_candidates(R_n, p_hat(q, R_n.y), J)
            c = replace(c, w=np.where(sees(q, R_n.y, c.w > 0), c.w, 0.0))
            slot = np.where(r.choose_second(kept.w, c.w, draw[2]), own + k, slot)
            kept, M = r.merge(kept, c, draw[2]), [*M, c.M]
        could = [np.ones(len(pixel), bool)] * own  # Z: who could have made it?
        for k, n in enumerate(around):
            x_n, made = take(q, np.maximum(n, 0)), (kept.w > 0) & (slot == own + k)
            omega, _ = direction_and_distance(x_n.position, kept.y.position)
            drawn = source_pdf(s.source, table, x_n, omega) > 0
            asked = (
                (kept.w > 0) & ~made & (n != NONE) & drawn & (p_hat(x_n, kept.y) > 0)
            )
            could.append(made | sees(x_n, kept.y, asked))
        spatial = r.cap_confidence(
            r.finalize(kept, one_over_z(M, could)), s.spatial_cap
        )

        yield shade(world, q, spatial) + S.not_reused  # Equation 8
        frame += 1


if __name__ == "__main__":
    box = find_scene("cornell-box")
    box = replace(box, camera=replace(box.camera, width=64, height=64))
    for number, color in zip(range(8), frames(build_world(box), 1, 0), strict=False):
        print(f"frame {number}: mean {color.mean():.4f}")

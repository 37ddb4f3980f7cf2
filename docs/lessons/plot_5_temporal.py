r"""
5. Reuse over time
==================

A pixel that keeps its reservoir from frame to frame chooses among the samples of all of
them: each frame adds one candidate, and the picture shows the work of many. The past
comes as one candidate of weight :math:`\hat p(y)\,W M`, and the new sample as another.

.. literalinclude:: /../reference/passes/temporal.py
   :pyobject: temporal_resampling

While nothing moves ``past`` is the pixel's own reservoir, and no sample is shifted.

Two things keep it honest. :math:`M` is capped, or the past would outweigh every new
sample and the picture would no longer follow the light; and the running sum :math:`w`
is rebuilt from :math:`W` and the capped :math:`M`, never kept:

.. literalinclude:: /../reference/resampling/reservoir.py
   :pyobject: cap_confidence
"""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

from restir_gi.reference.numerics.rng import KeyedUniforms, Stream
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.restir_gi import render_frames
from restir_gi.reference.scene.animation import Animation
from restir_gi.reference.scene.catalogue.registry import find_scene
from restir_gi.reference.settings import UNBIASED
from restir_gi.reference.transport.path_tracer import camera_radiance
from restir_gi.reference.transport.world import build_world

# %%
# The Cornell box, 32 x 32 pixels, one bounce. The truth is a path tracer's.

SIDE, FRAMES, RUNS = 32, 40, 4
box = find_scene("cornell-box")
box = replace(box, camera=replace(box.camera, width=SIDE, height=SIDE))
world = build_world(box)


def traced(samples):
    """Mean of so many path-traced samples a pixel."""
    visible = next(render_frames(world, UNBIASED, 1, 0, Schedule())).visible
    pixel = np.arange(SIDE * SIDE, dtype=np.uint32)
    total = 0.0
    for k in range(samples):
        u = KeyedUniforms(pixel, k, 77, Stream.PATH)
        total = total + camera_radiance(world, visible.surface, "indirect", 1, u)
    return total / samples


truth = traced(1500)

# %%
# Temporal reuse alone, with four limits of M. In frame 20 the lamp becomes four times
# as bright. How far is the mean of the picture, and its error at single pixels?

bright = replace(
    box,
    meshes=tuple(
        replace(m, emission=tuple(4 * e for e in m.emission)) for m in box.meshes
    ),
)
switched = Animation(lambda frame: box if frame < FRAMES // 2 else bright, "scene")


def run(cap, seed):
    """Mean light and root of the mean squared error of each frame."""
    settings = replace(UNBIASED, spatial=False, temporal_cap=cap, motion="as-stored")
    frames = render_frames(world, settings, 1, seed, Schedule(), switched)
    colors = [next(frames).color for _ in range(FRAMES)]
    level = np.where(np.arange(FRAMES) < FRAMES // 2, 1.0, 4.0)
    off = [
        np.sqrt(np.mean((c / s - truth) ** 2))
        for c, s in zip(colors, level, strict=True)
    ]
    return np.array([[c.mean() for c in colors], off])


figure, (left, right) = plt.subplots(1, 2, figsize=(10, 3.6))
for cap in (1.0, 4.0, 12.0, np.inf):
    mean, off = np.mean([run(cap, seed) for seed in range(RUNS)], axis=0)
    left.plot(mean / truth.mean(), label=f"cap {cap:g}")
    right.semilogy(off / truth.mean(), label=f"cap {cap:g}")
left.set_ylabel("mean light")
right.set_ylabel("error of a pixel, relative")
for one in (left, right):
    one.set_xlabel("frame")
    one.legend()
figure.tight_layout()
plt.show()

# %%
# Before the switch the error falls with each frame until M meets its cap, and without a
# cap it keeps falling. After it, whoever remembers most is wrong for longest: the
# reservoirs hold the radiance of a lamp that is no longer there. That lag is a bias
# too. The paper's cap is 30, and *sample validation* looks again, now and then,
# whether what is stored still holds; the unbiased form finds the radiance of what it
# keeps again.
#
# .. admonition:: Exercise
#
#    A student keeps the running sum instead of rebuilding it. The picture looks right
#    for some frames. (``python docs/lessons/exercises/exercise_5.py``)
#
# .. literalinclude:: /lessons/exercises/exercise_5.py
#    :pyobject: next_reservoir

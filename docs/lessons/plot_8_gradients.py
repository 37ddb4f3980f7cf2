r"""
8. Gradients: the difference of two pixels
==========================================

Neighbouring pixels are nearly equal, and their noise is not. Whoever samples the
*difference* of two pixels directly, with paths that run side by side, finds it with
little noise: where the pixels agree there is nothing to find. Gradient-domain rendering
measures the differences :math:`d_x, d_y` beside the image :math:`P` itself, and then
looks for the image that fits all of them best:

.. math:: I = \arg\min_I\; \alpha^2 \lVert I - P \rVert^2
   + \lVert D_x I - d_x \rVert^2 + \lVert D_y I - d_y \rVert^2 .

.. literalinclude:: /../gradient_domain/reconstruction.py
   :pyobject: differences

.. literalinclude:: /../gradient_domain/reconstruction.py
   :pyobject: least_squares

It is one linear system, a *screened Poisson equation*, which cosines make diagonal: two
transforms solve it, whatever the size.
"""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

from restir_gi.figures.gradient_domain.toy import toy
from restir_gi.gradient_domain.reconstruction import (
    Differences,
    differences,
    least_squares,
)
from restir_gi.reference.numerics.rng import KeyedUniforms, Stream
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.reports.figures.record import Work
from restir_gi.reference.restir_gi import render_frames
from restir_gi.reference.scene.catalogue.registry import find_scene
from restir_gi.reference.settings import UNBIASED
from restir_gi.reference.transport.path_tracer import camera_radiance
from restir_gi.reference.transport.world import build_world

# %%
# A picture of the Cornell box, and what is known of it: a noisy image, and differences
# with a tenth of that noise.

SIDE = 96
scene = find_scene("cornell-box")
scene = replace(scene, camera=replace(scene.camera, width=SIDE, height=SIDE))
world = build_world(scene)
surface = next(render_frames(world, UNBIASED, 1, 0, Schedule())).visible.surface
pixel = np.arange(SIDE * SIDE, dtype=np.uint32)
clean = np.mean(
    [
        camera_radiance(
            world, surface, "indirect", 1, KeyedUniforms(pixel, k, 8, Stream.PATH)
        )
        for k in range(150)
    ],
    axis=0,
)

rng = np.random.default_rng(8)
noise = 0.5 * clean.mean()
primal = clean + noise * rng.normal(size=clean.shape)
exact = differences(clean, SIDE)
column, line = pixel % SIDE, pixel // SIDE
inner = (column < SIDE - 1, line < SIDE - 1)  # the last of each has no neighbour
known = Differences(
    *(
        d + 0.1 * noise * rng.normal(size=d.shape) * there[:, None]
        for d, there in zip((exact.x, exact.y), inner, strict=True)
    )
)
made = least_squares(primal, known, SIDE, alpha=0.1)

figure, axes = plt.subplots(1, 4, figsize=(12, 3.3))
shown = {
    "image P": primal,
    "difference d_x": 0.5 * clean.max() + 3 * known.x,
    "reconstruction I": made,
    "truth": clean,
}
for one, (name, rows) in zip(axes, shown.items(), strict=True):
    one.imshow(np.clip(rows.reshape(SIDE, SIDE, 3) / clean.max(), 0, 1) ** (1 / 2.2))
    one.set_title(name)
    one.set_axis_off()
plt.show()

before, after = (np.sqrt(np.mean((a - clean) ** 2)) for a in (primal, made))
print(f"error of the image {before / noise:.2f}, after reconstruction "
      f"{after / noise:.2f}, of the noise of a pixel")  # fmt: skip
assert after < before / 3

# %%
# Resampling pairs
# ----------------
#
# Where do such differences come from? *Gradient-domain ReSTIR* resamples them: a
# reservoir holds a base path and, by a shift mapping, its offset path at the neighbour,
# with :math:`|f_1 - f_2|` as its target. What such a pair contributes is
#
# .. literalinclude:: /../gradient_domain/gradient_restir.py
#    :pyobject: difference
#
# and of what is positive and what is negative in it a frame resamples each by itself:
#
# .. literalinclude:: /../gradient_domain/gradient_restir.py
#    :pyobject: _frame
#
# Two functions that agree where they are large show what it is worth: samples of either
# are wasted there, samples of the pair are not.

figure = toy(Work(size=16, runs=2, schedule=Schedule()))
plt.figure().figimage(figure.pixels(), resize=True)
plt.show()

# %%
# .. admonition:: Exercise
#
#    The reconstruction of a slope is a slope the other way.
#    (``python docs/lessons/exercises/exercise_8.py``)
#
# .. literalinclude:: /lessons/exercises/exercise_8.py
#    :pyobject: reconstructed

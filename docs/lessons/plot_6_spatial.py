r"""
6. Reuse between pixels, and bias
=================================

Neighbours see nearly the same scene, and each has a reservoir of its own. Merging
theirs into mine multiplies the samples once more:

.. literalinclude:: /../reference/passes/spatial.py
   :pyobject: spatial_resampling

A neighbour's sample was drawn for another point. Its weight is changed by the Jacobian
of the shift, and is zero where this pixel does not see it:

.. literalinclude:: /../reference/resampling/reuse.py
   :pyobject: shifted

Now the question is who *could* have made the sample that is kept. Dividing the sum of
weights by the sum of all :math:`M_k` takes it for granted that every neighbour could.
But a neighbour below whose horizon the sample lies, or who does not see it, never
makes it: its :math:`M_k` counts candidates that were no candidates for this sample,
and the result is too dark. Unbiased is

.. math:: W = \frac{\sum_k w_k}{\hat p(y)\, Z}, \qquad
          Z = \sum_{k \,:\, y \in D_k} M_k ,

the sum over those whose domain :math:`D_k` holds the sample. For each neighbour that
costs a visibility ray.

.. literalinclude:: /../reference/resampling/reuse.py
   :pyobject: could_have_made

.. literalinclude:: /../reference/resampling/reservoir.py
   :pyobject: one_over_z
"""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.restir_gi import render_frames
from restir_gi.reference.scene.catalogue.registry import find_scene
from restir_gi.reference.settings import UNBIASED
from restir_gi.reference.transport.world import build_world

# %%
# The Cornell box: behind the edges of the blocks one pixel sees what the next does not.
# Both forms get the same random numbers, so that the noise of their difference is
# small, and what is left is bias. Beside them the same initial samples without any
# reuse, which have no bias and all the noise.

SIDE, RUNS = 48, 24
scene = find_scene("cornell-box")
scene = replace(scene, camera=replace(scene.camera, width=SIDE, height=SIDE))
world = build_world(scene)


def pictures(settings, runs, frames):
    """(runs, pixels): mean channel of the last frame of independent runs."""
    found = []
    for seed in range(runs):
        stream = render_frames(world, settings, 1, seed, Schedule())
        found.append([next(stream).color for _ in range(frames)][-1].mean(axis=1))
    return np.array(found)


def told(name, off, of):
    """Print a relative difference of the picture's mean, with its standard error."""
    each = off.mean(axis=1) / of.mean()
    print(f"{name}: {each.mean():+.2%} ± {each.std() / np.sqrt(len(each)):.2%}")


alone = pictures(replace(UNBIASED, temporal=False, spatial=False), 300, 1)
plain = pictures(replace(UNBIASED, mis="1/M"), RUNS, 5)
by_z = pictures(replace(UNBIASED, mis="1/Z"), RUNS, 5)
told("1/Z less initial samples", by_z - alone.mean(axis=0), alone)
told("1/M less 1/Z            ", plain - by_z, alone)

# %%
# The same difference in blocks of 4 x 4 pixels: blue is too dark.


def blocks(rows):
    """Means of 4 x 4 pixels."""
    return rows.reshape(SIDE // 4, 4, SIDE // 4, 4).mean(axis=(1, 3))


figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.6))
left.imshow(np.sqrt(by_z.mean(axis=0)).reshape(SIDE, SIDE), cmap="gray")
left.set_title("1/Z, mean of the runs")
shown = right.imshow(
    blocks((plain - by_z).mean(axis=0)) / alone.mean(),
    cmap="RdBu_r", vmin=-0.15, vmax=0.15,
)  # fmt: skip
right.set_title("1/M less 1/Z")
for one in (left, right):
    one.set_axis_off()
figure.colorbar(shown, ax=right, label="of the mean light")
plt.show()

# %%
# The plain form is dark where neighbours differ, around outlines and contact shadows,
# and no number of samples heals it. The other scatters about the truth.
#
# .. admonition:: Exercise
#
#    Whose M belongs into Z? (``python docs/lessons/exercises/exercise_6.py``)
#
# .. literalinclude:: /lessons/exercises/exercise_6.py
#    :pyobject: divisor
#
# Look for it in single pixels: in the `inspector <../inspector.html>`__, whose two runs
# choose with the same random numbers, `n` goes to a pixel where they part. What was it
# divided by, and which neighbour could not have made the sample?

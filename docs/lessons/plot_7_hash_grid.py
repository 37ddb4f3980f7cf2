r"""
7. The hash grid: reuse in the world
====================================

Pixels are neighbours only where the camera looks. The second and third vertices of a
path lie anywhere. To reuse samples *there*, their neighbours in the world have to be
found. A grid does it: space is cut into cells, and the cell's coordinates are hashed to
a slot in a table of fixed size.

The width of a cell depends on its distance to the eye, so that it covers some 16
pixels:

.. math:: \mathrm{level} = \left\lfloor \log_2 \frac{d \cdot b}{\ell} \right\rfloor,
          \qquad \text{edge} = \ell\, 2^{\mathrm{level}},

with the angle :math:`b` of 16 pixels and the least edge :math:`\ell` of a millimetre.
The level is part of the key, beside the three coordinates:

.. literalinclude:: /../hashgrid/grid.py
   :pyobject: levels

.. literalinclude:: /../hashgrid/grid.py
   :pyobject: keys_of
"""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

from restir_gi.hashgrid.grid import build_grid, jittered, keys_of, lattice_of
from restir_gi.reference.passes.gbuffer import visible_points
from restir_gi.reference.scene.camera import pixel_centers
from restir_gi.reference.scene.catalogue.registry import find_scene
from restir_gi.reference.transport.world import build_world

# %%
# Cells of the visible points of a hall, each in a colour of its own. They double in
# size, in the world, with each doubling of the distance, and stay about as large in the
# picture. At the right the points are *jittered* in their tangent plane by a random
# share of a cell before they are looked up: the borders, which would show in the
# picture, dissolve into noise.

SIDE = 192
scene = find_scene("many-lights")
scene = replace(scene, camera=replace(scene.camera, width=SIDE, height=SIDE))
world = build_world(scene)
seen = visible_points(world, *pixel_centers(SIDE, SIDE)).surface
lattice = lattice_of(world.camera)


def colors_of(keys):
    """A colour for each cell, by its hash; white where nothing is seen."""
    bits = keys.hashes.astype(np.uint32)
    rgb = np.stack([(bits >> s) & 0xFF for s in (0, 8, 16)], axis=1) / 255
    return np.where(seen.hit[:, None], rgb, 1.0).reshape(SIDE, SIDE, 3)


keys = keys_of(lattice, seen.position, seen.normal)
u = tuple(np.random.default_rng(7).random((4, SIDE * SIDE)))
moved = jittered(lattice, seen.position, seen.normal, u)

figure, axes = plt.subplots(1, 3, figsize=(11, 3.6))
axes[0].imshow(np.where(seen.hit, keys.level, np.nan).reshape(SIDE, SIDE))
axes[0].set_title("level")
axes[1].imshow(colors_of(keys))
axes[1].set_title("cells")
axes[2].imshow(colors_of(keys_of(lattice, moved, seen.normal)))
axes[2].set_title("cells of jittered points")
for one in axes:
    one.set_axis_off()
plt.show()

# %%
# The table has buckets of 16 slots. A cell takes the first free slot of its bucket; if
# there is none, its vertices are lost, and counted. The vertices of all cells are one
# list, into which a prefix sum over the counters points. These are the lines of
# Algorithm 2 [Boisse21], counted from its first loop; vertices that a GPU would take in
# the order of a race are taken in the order of their numbers:
#
# .. literalinclude:: /../hashgrid/grid.py
#    :pyobject: build_grid
#
# The look-up finds the cell of a point, and walks through its list with strides:
#
# .. literalinclude:: /../hashgrid/grid.py
#    :pyobject: look_up
#
# How full do buckets get? Some thousand cells in tables of 2, 8 and 512 buckets:

for buckets in (2, 8, 64, 512):
    grid = build_grid(keys, seen.hit, buckets)
    print(
        f"{buckets:4} buckets: {len(grid):5} cells are kept,"
        f" {grid.lost:6} of {seen.hit.sum()} vertices lost"
    )

# %%
# Two cells of one bucket *and* one checksum would be mixed up by a backend that
# compares no more. In the paper's cells of lights that costs a sample from another
# place; if one relies on its being rare, one should know how rare. Here cells are
# compared whole.
#
# .. admonition:: Exercise
#
#    Two points on two floors of a house share a cell. Why?
#    (``python docs/lessons/exercises/exercise_7.py``)
#
# .. literalinclude:: /lessons/exercises/exercise_7.py
#    :pyobject: key_of

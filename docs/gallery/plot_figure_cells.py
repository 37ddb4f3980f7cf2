"""
Cells of the grid
=================

Which cell of the world a point lies in hangs on its distance to the eye: a cell is some
16 pixels wide, rounded down to a power of two. Points are jittered in their tangent
plane before they are put in and looked up, so that no border shows. At the right is
whose light sample each path shows at its second point: a colour is a cell whose
vertices it comes from, black what the vertex drew itself.

Measured by ``restir figures cells`` at 192 x 192, two bounces:

============  ========  ====  =====  ===============  ====  ======  ======
scene         vertices  lost  cells  vertices a cell  most  probes  shared
============  ========  ====  =====  ===============  ====  ======  ======
many-lights   58127     0     5218   11.1             112   1.01    0
night-market  25038     0     6245   4.01             78    1.01    0
cornell-box   47990     0     1801   26.6             195   1.01    0
============  ========  ====  =====  ===============  ====  ======  ======
"""

import matplotlib.pyplot as plt
from rich.console import Console

from restir_gi.figures.hashgrid.cells import cells
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.reports.figures.record import Work
from restir_gi.reference.reports.figures.table import table

figure = cells(Work(size=96, runs=2, schedule=Schedule()))
plt.figure().figimage(figure.pixels(), resize=True)
plt.show()

# %%
# The numbers of this smaller run:

console = Console(width=120, markup=False, highlight=False)
console.print(table(figure))
console.print(*figure.remarks, sep="\n\n")

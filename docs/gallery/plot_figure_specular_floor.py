"""
Shifts on a polished floor
==========================

A shaded lamp lights a spot of a dark polished floor, and nothing else. The ceiling has
its light from that spot, and what the floor mirrors of it is light that few paths find:
by way of the mirror to the ceiling, and from there to the spot. A path that begins with
a mirror cannot be joined at its second point, so that pure reconnection takes over
nothing on the floor. Random replay draws the path again from the same numbers, and
loses it where these lead elsewhere. The hybrid shift replays the mirror, and joins the
path from the ceiling on.

Measured at full size, by ``restir figures specular-floor`` (128 x 128, 16 runs of 32
frames, two bounces, as many samples for each shift):

==============  ============  =====================  ==================
where           shift         MSE                    times smaller
==============  ============  =====================  ==================
whole picture   reconnection  7.4e-5 [7.2, 7.7]e-5   1
whole picture   replay        9.7e-5 [9.2, 10.3]e-5  0.77 [0.71, 0.82]
whole picture   hybrid        2.7e-5 [2.5, 3.0]e-5   2.7 [2.5, 2.9]
floor           reconnection  8.0e-5 [7.6, 8.4]e-5   1
floor           replay        1.8e-5 [1.7, 1.9]e-5   4.5 [4.2, 4.8]
floor           hybrid        9.4e-6 [8.7, 10.2]e-6  8.5 [7.6, 9.4]
==============  ============  =====================  ==================

Intervals are of 95 %, by bootstrap over the runs.

The picture below is made while this page is built, smaller and from fewer runs: its
numbers have wider intervals, and those above are the ones to quote.
"""

import matplotlib.pyplot as plt
from rich.console import Console

from restir_gi.figures.specular_floor import specular_floor
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.reports.figures.record import Work
from restir_gi.reference.reports.figures.table import table

figure = specular_floor(Work(size=48, runs=4, schedule=Schedule()))
plt.figure().figimage(figure.pixels(), resize=True)
plt.show()

# %%
# The numbers of this smaller run:

console = Console(width=120, markup=False, highlight=False)
console.print(table(figure))
console.print(*figure.remarks, sep="\n\n")

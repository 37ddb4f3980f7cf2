"""
Figure 14: density of initial directions
========================================

All light comes from a low wall at the far end of a long floor. Cosine-weighted
directions seldom go where the light is, and the paper finds that uniform ones are much
better. How much depends on how close to the horizon the light is.

Measured at full size, by ``restir figures source`` (128 x 128, 32 runs):

========================  ===============================
distance from the wall    MSE, cosine-weighted to uniform
========================  ===============================
0 to 0.5 m                0.53 [0.38, 0.67]
0.5 to 1 m                0.93 [0.90, 0.95]
1 to 1.5 m                1.31 [1.27, 1.36]
1.5 to 2 m                1.70 [1.64, 1.75]
2 to 3 m                  2.32 [2.28, 2.36]
3 to 4 m                  2.98 [2.91, 3.05]
whole picture             0.99 [0.84, 1.09]
========================  ===============================

Intervals are of 95 %, by bootstrap over the runs. Close to the wall its light comes
from high up, and cosine-weighted directions are the better ones; in the mean over the
picture, which the brightest pixels dominate, the two are alike.

The picture below is made while this page is built, smaller and from fewer runs: its
numbers have wider intervals, and those above are the ones to quote.
"""

import matplotlib.pyplot as plt
from rich.console import Console

from restir_gi.figures.source import source
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.reports.figures.record import Work
from restir_gi.reference.reports.figures.table import table

figure = source(Work(size=64, runs=8, schedule=Schedule()))
plt.figure().figimage(figure.pixels(), resize=True)
plt.show()

# %%
# The numbers of this smaller run:

console = Console(width=120, markup=False, highlight=False)
console.print(table(figure))
console.print(*figure.remarks, sep="\n\n")

"""
Figure 8: one and two bounces
=============================

More bounces, more light: and what they cost. The second bounce makes only the initial
samples more expensive, and less so where it is followed in a quarter of the tiles of
64 x 32 pixels.

Measured at full size, by ``restir figures bounces`` (128 x 128,
8 runs, one thread of a shared machine):

==============================  =============  =============  ========================
part                            one bounce     two bounces    two in 25 % of the tiles
==============================  =============  =============  ========================
initial samples                 13.3 ms        19.8 ms        16.7 ms
beside those of one bounce      1              1.49           1.26
the paper's                     3.2 ms: 1                     4.2 ms: 1.32
reuse                           16.7 ms        16.9 ms        16.6 ms
the paper's                     4.6 ms                        4.6 ms
==============================  =============  =============  ========================

Two-bounce path tracing takes 17.7 ms a sample, in the paper 6.9 ms.

The picture below is made while this page is built, smaller and from fewer runs: its
numbers have wider intervals, and those above are the ones to quote.
"""

import matplotlib.pyplot as plt
from rich.console import Console

from restir_gi.figures.bounces import bounces
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.reports.figures.record import Work
from restir_gi.reference.reports.figures.table import table

figure = bounces(Work(size=96, runs=2, schedule=Schedule()))
plt.figure().figimage(figure.pixels(), resize=True)
plt.show()

# %%
# The numbers of this smaller run:

console = Console(width=120, markup=False, highlight=False)
console.print(table(figure))
console.print(*figure.remarks, sep="\n\n")

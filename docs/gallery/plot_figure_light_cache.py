"""
Light reservoirs in equal time
==============================

Each vertex of a path draws eight points on lights and keeps one; from the cell that it
lies in it takes over what vertices of the last frame kept. Next-event estimation draws
one. In a market of 900 stalls a lamp of the stall at hand is drawn once in 900 times;
in the hall every vertex sees all 30,000, and what is left is the noise of the way to
the vertex, for which light reservoirs do nothing.

Measured at full size, by ``restir figures light-cache`` (128 x 128, 16 runs, frames 9
to 16): mean squared errors in the same time, how many times smaller than those of
next-event estimation with one light by power, and than those of the path tracer, which
weights it against BSDF sampling.

======  =======  ================  ====  ===============  ==============  ==========
scene   bounces  variant           ms    next event       paths           bias
======  =======  ================  ====  ===============  ==============  ==========
market  1        next event        12.9  1                0.4 [0.3, 0.6]  +12 % ± 9
market  1        8 candidates      24.4  4.7 [3.3, 6.5]   1.8 [1.4, 2.4]  +2 % ± 3
market  1        balance           35.1  7.1 [4.7, 11]    2.8 [1.9, 4.4]  -0 % ± 4
market  1        2 cells, cap 100  42.6  12.9 [8.5, 21]   5.1 [3.6, 7.7]  +6 % ± 6
market  1        1/M               32.7  12.3 [9.1, 17]   4.8 [4.0, 5.9]  -6 % ± 3
market  2        balance           65.0  7.5 [4.9, 11]    3.0 [2.3, 4.0]  +1 % ± 2
market  2        2 cells, cap 100  80.6  17.2 [11.8, 25]  7.1 [5.8, 8.7]  +3 % ± 4
market  2        1/M               59.0  13.8 [10.2, 18]  5.6 [4.9, 6.5]  -7 % ± 2
market  3        balance           80.2  7.7 [5.2, 11]    3.2 [2.5, 4.0]  -1 % ± 2
market  3        2 cells, cap 100  102   17.9 [12.4, 26]  7.5 [6.2, 9.1]  -1 % ± 3
market  3        1/M               72.6  15.4 [11.4, 20]  6.4 [5.7, 7.2]  -9 % ± 2
hall    1        8 candidates      50.1  2.8 [2.0, 3.9]   0.9 [0.8, 1.0]  -0 % ± 0.1
hall    1        balance           74.1  2.1 [1.5, 2.9]   0.7 [0.6, 0.8]  +0 % ± 0.3
hall    1        2 cells, cap 100  92.7  1.4 [0.9, 2.0]   0.4 [0.4, 0.6]  -0 % ± 0.4
hall    1        1/M               67.6  2.2 [1.1, 4.3]   0.7 [0.4, 1.2]  -8 % ± 0.2
======  =======  ================  ====  ===============  ==============  ==========

Weights 1/Z have 10.2, 8.5 and 11.2 times smaller errors in the market, where "balance"
has 7; but in the hall a few of their pixels are so bright that the error of a frame
is 0.7 [0.07, 2.0] where that of eight candidates alone is 0.03.

The picture below is made while this page is built, smaller and from fewer runs: its
numbers have wider intervals, and those above are the ones to quote.
"""

import matplotlib.pyplot as plt
from rich.console import Console

from restir_gi.figures.hashgrid.light_cache import light_cache
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.reports.figures.record import Work
from restir_gi.reference.reports.figures.table import table

figure = light_cache(Work(size=32, runs=2, schedule=Schedule()))
plt.figure().figimage(figure.pixels(), resize=True)
plt.show()

# %%
# The numbers of this smaller run:

console = Console(width=120, markup=False, highlight=False)
console.print(table(figure))
console.print(*figure.remarks, sep="\n\n")

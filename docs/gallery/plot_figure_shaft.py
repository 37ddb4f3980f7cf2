"""
Light that comes by few ways
============================

In the first scene a lamp at the top of a tall, sooty shaft lights a spot of one room's
floor, and the camera is in the next room: of two bounces all light comes by way of that
spot. In the second the camera sees it in a polished floor. Where a path has come to its
second point it asks a cell of the world how others went on from there.

Measured at full size, by ``restir figures shaft`` (128 x 128, 12 runs of 32 frames, two
bounces; times smaller than ReSTIR GI with weights 1/Z, in one frame and in the same
time):

==============  =============  ====  ===============  =================  =============
scene           variant        ms    in a frame       in the same time   bias
==============  =============  ====  ===============  =================  =============
shaft           ReSTIR GI      42.5  1                1                  -3 % ± 3
shaft           ReSTIR PT      72.6  15.5 [12.8, 19]  9.1 [7.5, 11.1]    -3 % ± 6
shaft           ReGIR GI       119   21.3 [15.4, 31]  7.6 [5.5, 10.9]    -6 % ± 9
shaft           the article's  134   0.06             0.02               +2577 % ± 437
polished floor  ReSTIR GI      86.8  1                1                  -0 % ± 4
polished floor  ReSTIR PT      118   916 [715, 1170]  671 [524, 854]     -2 % ± 3
polished floor  ReGIR GI       188   908 [664, 1290]  419 [306, 597]     -1 % ± 3
polished floor  the article's  177   26 [21, 32]      12.7 [10.3, 15.6]  +833 % ± 26
==============  =============  ====  ===============  =================  =============

Cells make a frame of the shaft a third better than ReSTIR PT alone does, and take the
time that they save: whole paths that are reused over the screen are most of the gain.
The article's form forgets the paths that found nothing. Where few find something, that
is nearly all of them: its picture is 27 times too bright.

The picture below is made while this page is built, smaller and from fewer runs: its
numbers have wider intervals, and those above are the ones to quote.
"""

import matplotlib.pyplot as plt
from rich.console import Console

from restir_gi.figures.hashgrid.shaft import shaft
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.reports.figures.record import Work
from restir_gi.reference.reports.figures.table import table

figure = shaft(Work(size=32, runs=2, schedule=Schedule()))
plt.figure().figimage(figure.pixels(), resize=True)
plt.show()

# %%
# The numbers of this smaller run:

console = Console(width=120, markup=False, highlight=False)
console.print(table(figure))
console.print(*figure.remarks, sep="\n\n")

"""
Differences of pixels
=====================

Figure 7 of the article on gradient-domain ReSTIR: differences to the right neighbour,
by path tracing, from the paths that Area ReSTIR keeps, and from pairs of paths that are
reused together.

Measured at full size, by ``restir figures gradients`` (128 x 128, frame 16 of 8 runs,
two bounces; times smaller than after ReSTIR, in one frame and in the same time):

=============  ===========  ====  =================  =================
scene          method       ms    in a frame         in the same time
=============  ===========  ====  =================  =================
cornell-box    Gradient-PT  75    0.47 [0.43, 0.51]  0.87 [0.79, 0.95]
cornell-box    after        139   1                  1
cornell-box    with         241   3.83 [3.59, 4.05]  2.20 [2.07, 2.33]
checker        Gradient-PT  65    0.21 [0.19, 0.22]  0.44 [0.42, 0.47]
checker        with         240   2.30 [2.13, 2.46]  1.33 [1.23, 1.42]
glossy-floor   Gradient-PT  132   0.35 [0.33, 0.38]  0.63 [0.58, 0.68]
glossy-floor   with         354   3.92 [3.67, 4.19]  2.63 [2.46, 2.81]
door-ajar      Gradient-PT  49    0.30 [0.25, 0.35]  0.79 [0.66, 0.93]
door-ajar      with         193   2.74 [2.22, 3.33]  1.83 [1.48, 2.23]
moving-camera  Gradient-PT  79    0.72 [0.68, 0.76]  1.65 [1.56, 1.74]
moving-camera  with         599   1.26 [1.15, 1.36]  0.38 [0.35, 0.42]
=============  ===========  ====  =================  =================

Where the camera stands still pairs are best, in all four scenes. Where it moves, each
asks four pairs of the last frame by two shifts there and back, and the time is better
spent on new paths.

The picture below is made while this page is built, smaller and from fewer runs: its
numbers have wider intervals, and those above are the ones to quote.
"""

import matplotlib.pyplot as plt
from rich.console import Console

from restir_gi.figures.gradient_domain.gradients import gradients
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.reports.figures.record import Work
from restir_gi.reference.reports.figures.table import table

figure = gradients(Work(size=32, runs=3, schedule=Schedule()))
plt.figure().figimage(figure.pixels(), resize=True)
plt.show()

# %%
# The numbers of this smaller run:

console = Console(width=120, markup=False, highlight=False)
console.print(table(figure))
console.print(*figure.remarks, sep="\n\n")

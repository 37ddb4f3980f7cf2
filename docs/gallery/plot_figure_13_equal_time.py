"""
Figures 1 and 13: error in equal time
=====================================

One frame of ReSTIR GI after 32 frames, and path tracing that takes the same time, both
with two bounces of indirect light.

Measured at full size, by ``restir figures equal-time`` (128 x 128, here with
``--runs 6`` on a busy machine):

=============  =================  =================  ===============  ===============
scene          biased: MSE        unbiased: MSE      biased: bias     unbiased: bias
               times smaller      times smaller      of the mean      of the mean
=============  =================  =================  ===============  ===============
door-ajar      19.1 [16.7, 22.3]  16.9 [14.8, 19.6]  -7.1 % ± 0.4 %   -1.3 % ± 0.5 %
cornell-box    1.4 [0.6, 5.3]     1.2 [0.5, 4.5]     -0.8 % ± 0.6 %   +0.4 % ± 0.6 %
glossy-floor   1.5 [0.7, 3.5]     0.2 [0.2, 0.2]     -2.4 % ± 0.3 %   +0.3 % ± 0.9 %
many-lights    2.2 [0.8, 13.7]    2.0 [0.7, 11.5]    -2.9 % ± 0.7 %   +0.1 % ± 0.7 %
grazing-light  59.6 [54.9, 62.9]  49.3 [45.4, 52.0]  -0.2 % ± 0.6 %   +0.2 % ± 0.6 %
the paper      14.6 to 141        9.3 to 166
=============  =================  =================  ===============  ===============

Intervals are of 95 %, by bootstrap over the runs. They are wide where a few bright
pixels of a few runs make up most of the error. Resampling gains most where light is
hard to find, and nothing where it is everywhere: the paper's scenes are of the first
kind. On the glossy floor the unbiased form reuses no light of sample points that are
not Lambertian, and pays for the rest.

The picture below is made while this page is built, smaller and from fewer runs: its
numbers have wider intervals, and those above are the ones to quote.
"""

import matplotlib.pyplot as plt
from rich.console import Console

from reference.figures.equal_time import equal_time
from reference.figures.record import Plan
from reference.figures.table import table
from reference.schedule import Schedule

figure = equal_time(Plan(size=64, runs=2, schedule=Schedule()))
plt.figure().figimage(figure.pixels(), resize=True)
plt.show()

# %%
# The numbers of this smaller run:

console = Console(width=120, markup=False, highlight=False)
console.print(table(figure))
console.print(*figure.remarks, sep="\n\n")

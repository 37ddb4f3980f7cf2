"""
Figure 11: sample validation
============================

The sun turns at once. Stored samples still tell of the old light, unless they are
traced again: every six frames in the paper's biased form, or always, where a sample is
reused, in the unbiased one.

Measured at full size, by ``restir figures validation`` (128 x 128, 8 runs):

=====================  ====================  ==================  ==================
after the change       without validation    every 6 frames      unbiased form
=====================  ====================  ==================  ==================
mean, at once          +3.3 % ± 0.9 %        +3.8 % ± 1.0 %      +3.3 % ± 4.1 %
mean, 2 frames later   +3.4 % ± 0.9 %        -87.2 % ± 0.5 %     +3.2 % ± 3.9 %
mean, 12 frames later  +3.2 % ± 0.7 %        -62.6 % ± 0.4 %     +2.3 % ± 2.7 %
mean, 31 frames later  +1.5 % ± 0.5 %        -29.8 % ± 0.5 %     +0.9 % ± 1.5 %
tiles, at once         1.24                  1.23                0.25
tiles, 12 later        0.93                  0.97                0.18
tiles, 31 later        0.49                  0.46                0.09
=====================  ====================  ==================  ==================

The mean is that of the whole picture over the truth's, less 1; tiles are the root mean
square deviation of 8 x 8 pixels. Old and new light are about equal in the mean of this
scene, so that stale samples show in the tiles alone. Validation takes the stale light
away at once; but M still counts the nulls that were found under the old light, of which
only the last is traced again, and the picture stays too dark for as long as it takes to
outgrow them. The paper reports the opposite for its scene: too much light for a while,
which is what happens where few samples are nulls.

The picture below is made while this page is built, smaller and from fewer runs: its
numbers have wider intervals, and those above are the ones to quote.
"""

import matplotlib.pyplot as plt
from rich.console import Console

from restir_gi.figures.validation import validation
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.reports.figures.record import Work
from restir_gi.reference.reports.figures.table import table

figure = validation(Work(size=48, runs=4, schedule=Schedule()))
plt.figure().figimage(figure.pixels(), resize=True)
plt.show()

# %%
# The numbers of this smaller run:

console = Console(width=120, markup=False, highlight=False)
console.print(table(figure))
console.print(*figure.remarks, sep="\n\n")

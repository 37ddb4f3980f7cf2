"""
Figure 7: the Jacobian
======================

A sunlit wall lights the floor before it. A sample that another pixel made has to be
weighted by the Jacobian of Equation 11. The paper shows what happens without it, and
its Algorithm 4 prints a division where a *weight* has to be multiplied. Here the light
of the floor is known in closed form, so that all three can be held against it.

Measured at full size, by ``restir figures jacobian`` (128 x 128, 16 runs):

=============  ==============  ==============  ================  ===================
before wall    left out        multiplied      divided           multiplied, balance
=============  ==============  ==============  ================  ===================
0 to 0.1 m     -7.0 % ± 0.8 %  -6.4 % ± 2.1 %  +382 % ± 15 %     -1.5 % ± 2.0 %
0.1 to 0.2 m   -9.1 % ± 0.6 %  -0.3 % ± 0.9 %  +56.1 % ± 2.4 %   -0.1 % ± 1.3 %
0.2 to 0.3 m   -7.9 % ± 0.4 %  -1.4 % ± 0.5 %  +21.7 % ± 1.2 %   -1.7 % ± 1.1 %
0.3 to 0.5 m   -3.4 % ± 0.6 %  -0.4 % ± 0.6 %  +4.2 % ± 0.6 %    -0.3 % ± 0.6 %
1 to 1.5 m     -0.1 % ± 0.7 %  +0.2 % ± 0.7 %  +0.3 % ± 0.7 %    +0.2 % ± 0.7 %
=============  ==============  ==============  ================  ===================

The paper says that without the Jacobian the base of the wall is too bright. Here, with
the weights 1/Z, leaving it out makes the floor there too dark, and dividing makes it
too bright. In the first 0.1 m the exact form has a heavy tail, which the standard
error of 16 runs does not show; the balance heuristic has none.

The picture below is made while this page is built, smaller and from fewer runs: its
numbers have wider intervals, and those above are the ones to quote.
"""

import matplotlib.pyplot as plt
from rich.console import Console

from restir_gi.figures.jacobian import jacobian
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.reports.figures.record import Work
from restir_gi.reference.reports.figures.table import table

figure = jacobian(Work(size=64, runs=4, schedule=Schedule()))
plt.figure().figimage(figure.pixels(), resize=True)
plt.show()

# %%
# The numbers of this smaller run:

console = Console(width=120, markup=False, highlight=False)
console.print(table(figure))
console.print(*figure.remarks, sep="\n\n")

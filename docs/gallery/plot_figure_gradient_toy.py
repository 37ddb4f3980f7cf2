"""
The difference of two functions
===============================

Figure 3 of the article on gradient-domain ReSTIR: two functions agree where they are
large, and differ where they are small. Samples that are kept for the one or the other
gather at the common peak, and say nothing of the difference; samples that are kept for
what they say of it gather beside the peak.

Measured, by ``restir figures gradient-toy`` (64 runs of 500 repeats):

==========================  ========================  =================
variant                     MSE                       times smaller
==========================  ========================  =================
after ReSTIR                1.04 [1.00, 1.08]         1
with ReSTIR, one reservoir  0.149 [0.148, 0.150]      6.97 [6.69, 7.26]
with ReSTIR, one a sign     0.0171 [0.0169, 0.0174]   60.8 [58.1, 63.5]
==========================  ========================  =================
"""

import matplotlib.pyplot as plt
from rich.console import Console

from restir_gi.figures.gradient_domain.toy import toy
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.reports.figures.record import Work
from restir_gi.reference.reports.figures.table import table

figure = toy(Work(size=16, runs=16, schedule=Schedule()))
plt.figure().figimage(figure.pixels(), resize=True)
plt.show()

# %%
# The numbers of this smaller run:

console = Console(width=120, markup=False, highlight=False)
console.print(table(figure))
console.print(*figure.remarks, sep="\n\n")

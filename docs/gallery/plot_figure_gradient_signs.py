"""
A reservoir for each sign
=========================

Figure 9 of the article on gradient-domain ReSTIR: reservoirs of the positive and of the
negative part of a difference, of which each asks its own kind (``within``), or both
kinds (``across``), beside one reservoir of its magnitude.

Measured by ``restir figures gradient-signs --size 64 --runs 6``: two reservoirs have a
fourth to a sixth of the error of one where the camera stands still, and a little over
half of it where it moves; asking across signs costs more, and is worse at edges.

The picture below is made while this page is built, of one scene, smaller and from fewer
runs: its numbers have wider intervals.
"""

import matplotlib.pyplot as plt
from rich.console import Console

from restir_gi.figures.gradient_domain.ablations import signs
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.reports.figures.record import Work
from restir_gi.reference.reports.figures.table import table

figure = signs(Work(size=32, runs=3, schedule=Schedule()), ["checker"])
plt.figure().figimage(figure.pixels(), resize=True)
plt.show()

# %%
# The numbers of this smaller run:

console = Console(width=120, markup=False, highlight=False)
console.print(table(figure))
console.print(*figure.remarks, sep="\n\n")

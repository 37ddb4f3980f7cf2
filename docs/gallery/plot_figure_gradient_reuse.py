"""
Pairs around
============

Figures 6 and 10 of the article on gradient-domain ReSTIR: whose samples a pair takes
over. ``edges`` looks for pairs that look alike, across an edge of the scene; ``random``
takes any pair around; ``nobody`` only the pair's own past.

Measured by ``restir figures gradient-reuse --size 64 --runs 6``: where the camera
moves, edges have 0.57 of the error that they have with nobody around, and with random
pairs 0.93. After sixteen frames of a still camera the past knows as much, and pairs
around only cost.

The picture below is made while this page is built, of one scene, smaller and from fewer
runs: its numbers have wider intervals.
"""

import matplotlib.pyplot as plt
from rich.console import Console

from restir_gi.figures.gradient_domain.ablations import reuse
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.reports.figures.record import Work
from restir_gi.reference.reports.figures.table import table

figure = reuse(Work(size=32, runs=2, schedule=Schedule()), ["checker"])
plt.figure().figimage(figure.pixels(), resize=True)
plt.show()

# %%
# The numbers of this smaller run:

console = Console(width=120, markup=False, highlight=False)
console.print(table(figure))
console.print(*figure.remarks, sep="\n\n")

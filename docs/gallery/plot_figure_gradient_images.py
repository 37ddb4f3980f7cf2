"""
Images from pixels and their differences
========================================

Figures 8 and 12 of the article on gradient-domain ReSTIR: images made from the pixels
and the differences of each method, by least squares and by least absolute values,
beside as many copies of Area ReSTIR as take the same time. :doc:`The page on
differences </explanation/gradient_domain>` has the numbers at full size.

The picture below is made while this page is built, of one scene, smaller and from few
runs: the numbers on that page are the ones to quote.
"""

import matplotlib.pyplot as plt
from rich.console import Console

from restir_gi.figures.gradient_domain.images import of_scenes
from restir_gi.figures.gradient_domain.variants import scene_of
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.reports.figures.record import Work
from restir_gi.reference.reports.figures.table import table

SIZE = 32

work = Work(size=SIZE, runs=2, schedule=Schedule())
figure = of_scenes([scene_of("cornell-box", SIZE)], work)
plt.figure().figimage(figure.pixels(), resize=True)
plt.show()

# %%
# The numbers of this smaller run:

console = Console(width=140, markup=False, highlight=False)
console.print(table(figure))
console.print(*figure.remarks, sep="\n\n")

"""
The Jacobian at its extremes
============================

How exact Equation 11 is in 16, 32 and 64 bits: beside arithmetic in 50 digits, on the
very numbers that the kernel was given. At grazing angles the error grows as the cosine
falls, since a small difference of large numbers is taken; as a share of what the
numbers' own rounding allows it stays the same.

Far from the origin the kernel is as good as ever, and still the picture is wrong: in
single precision the places of points lie an eighth of a metre apart at a distance of
a thousand kilometres.
A renderer that works in float32 had better put the camera into the origin.
"""

import matplotlib.pyplot as plt
from rich.console import Console

from restir_gi.figures.extremes import extremes
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.reports.figures.record import Work
from restir_gi.reference.reports.figures.table import table

figure = extremes(Work(size=16, runs=16, schedule=Schedule()))
plt.figure().figimage(figure.pixels(), resize=True)
plt.show()

# %%
# The numbers:

console = Console(width=140, markup=False, highlight=False)
console.print(table(figure))
console.print(*figure.remarks, sep="\n\n")

"""
Every kernel at every extreme
=============================

Each row is a function of the reference, each column an end of what a scene may hold.
The upper maps show how far the result is from the exact one, in units in the last place
of half, single and double precision: hundreds of them where a small difference of large
numbers is taken. The lower maps show the same as a share of what the rounding of the
numbers themselves explains; it stays below 1 everywhere, and a fault would not.

White: a kernel that cannot meet that extreme.
"""

import matplotlib.pyplot as plt

from restir_gi.figures.kernels import kernels_at_extremes
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.reports.figures.record import Work

figure = kernels_at_extremes(Work(size=16, runs=24, schedule=Schedule()))
plt.figure().figimage(figure.pixels(), resize=True)
plt.show()

# %%
# The worst of them:

worst = sorted(figure.rows, key=lambda row: -row["largest share of the bound"])
for row in worst[:12]:
    print(
        f"{row['kernel']}, {row['extreme']}, {row['type']}:"
        f" {row['largest error, ulp']:.3g} ulp,"
        f" {row['largest share of the bound']:.2f} of the bound"
    )
print(*figure.remarks, sep="\n\n")

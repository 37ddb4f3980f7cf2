r"""
3. Reservoirs: choosing without keeping
=======================================

To choose among :math:`M` candidates nobody has to store them. A *reservoir* holds the
sample that is kept so far, the sum :math:`w` of all weights, and the count :math:`M`.
The next candidate, of weight :math:`w_b`, takes its place with probability

.. math:: \frac{w_b}{w_a + w_b} .

After the last one each has been kept in proportion to its weight. So two reservoirs can
be merged as if they were candidates, and nothing remembers how many stood behind each:

.. literalinclude:: /../reference/resampling/reservoir.py
   :pyobject: merge

.. literalinclude:: /../reference/resampling/reservoir.py
   :pyobject: choose_second
"""

from fractions import Fraction
from itertools import product

import matplotlib.pyplot as plt
import numpy as np

from restir_gi.reference.resampling.reservoir import (
    Candidates,
    Reservoirs,
    finalize,
    merge,
    reused_candidates,
)

# %%
# Five candidates of weights 1 to 5, streamed in three orders, 100,000 times each: what
# is kept does not know the order.

weights = np.array([1.0, 2.0, 3.0, 4.0, 5.0])


def streamed(order, repeats=100_000):
    """How often each candidate is kept at the end."""
    rng, ones = np.random.default_rng(3), np.ones(repeats)
    kept = None
    for i in order:
        new = Candidates(i * ones, weights[i] * ones, weights[i] * ones, ones)
        kept = merge(kept, new, rng.random(repeats)) if kept else new
    return np.bincount(kept.y.astype(int), minlength=5) / repeats


for number, order in enumerate(([0, 1, 2, 3, 4], [4, 3, 2, 1, 0], [2, 4, 0, 3, 1])):
    plt.bar(np.arange(5) + 0.25 * number, streamed(order), 0.2, label=f"order {order}")
plt.plot(np.arange(5) + 0.25, weights / weights.sum(), "k_", markersize=24)
plt.xlabel("candidate")
plt.ylabel("share of the runs that keep it")
plt.legend()
plt.show()

# %%
# Reuse
# -----
#
# A closed reservoir competes again, at another pixel or in another frame, with the
# weight :math:`w = \hat p(y)\, W M`: its sample stands for the :math:`M` candidates
# that it was chosen from, and :math:`W` remembers how good they were.
#
# .. literalinclude:: /../reference/resampling/reservoir.py
#    :pyobject: reused_candidates
#
# Proof by counting
# -----------------
#
# A domain of three points can be enumerated: all candidates, all choices, each with its
# probability, in fractions. The kernels above run on fractions too, so that this is a
# proof about the very code, with nothing rounded and nothing left to chance. Two pixels
# draw a candidate each; one reuses the other's reservoir.

Q = [Fraction(1, 2), Fraction(1, 4), Fraction(1, 4)]
P_SOURCE = [Fraction(1), Fraction(2), Fraction(3)]
P_HERE = [Fraction(4), Fraction(1), Fraction(2)]
F_HERE = [Fraction(3), Fraction(2), Fraction(5)]


def rows(*values):
    """Fractions as rows of an array."""
    return np.array(values, dtype=object)


def expectation():
    """E[f(y) W] at the pixel that borrows, over all that can happen."""
    total = Fraction(0)
    for own, reused in product(range(3), repeat=2):
        # The other's reservoir: one candidate, W = 1 / q.
        source = Reservoirs(rows(reused), rows(1 / Q[reused]), rows(Fraction(1)))
        theirs = reused_candidates(source, rows(P_HERE[reused]))
        w_own = P_HERE[own] / Q[own]
        mine = Candidates(rows(own), rows(P_HERE[own]), rows(w_own), rows(Fraction(1)))
        share = theirs.w[0] / (w_own + theirs.w[0])
        # u just below and just above the share: both outcomes, with their chances.
        for u, chance in ((share / 2, share), ((1 + share) / 2, 1 - share)):
            r = finalize(merged := merge(mine, theirs, rows(u)), merged.M)
            total += Q[own] * Q[reused] * chance * F_HERE[r.y[0]] * r.W[0]
    return total


print("expectation", expectation(), "and the sum of f", sum(F_HERE))
assert expectation() == sum(F_HERE)

# %%
# Equal, and not only to sixteen digits. The tests in ``tests/exact`` do this for every
# pass.
#
# .. admonition:: Exercise
#
#    Two reservoirs are merged, and all is right as long as each has seen one
#    candidate. (``python docs/lessons/exercises/exercise_3.py``)
#
# .. literalinclude:: /lessons/exercises/exercise_3.py
#    :pyobject: combined

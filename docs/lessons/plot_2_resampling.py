r"""
2. Resampling: good samples from bad ones
=========================================

The best density would be in proportion to :math:`f` itself, and nobody can draw from
that. *Resampled importance sampling* comes near it. Draw :math:`M` candidates
:math:`x_1, \dots, x_M` from a density :math:`q` that is easy, give each the weight

.. math:: w_i = \frac{\hat p(x_i)}{q(x_i)} ,

keep one of them, :math:`y`, in proportion to its weight, and count it with

.. math:: W = \frac{1}{\hat p(y)} \cdot \frac1M \sum_{i=1}^M w_i .

Then :math:`E[f(y)\,W] = \int f`, for any *target* :math:`\hat p \ge 0` that is positive
where :math:`f` is not 0; it need not be normalized. :math:`W` stands where
:math:`1 / p(y)` stood: it estimates it.

In the renderer these are two short functions:

.. literalinclude:: /../reference/resampling/reservoir.py
   :pyobject: initial_candidates

.. literalinclude:: /../reference/resampling/reservoir.py
   :pyobject: finalize
"""

import matplotlib.pyplot as plt
import numpy as np

from restir_gi.reference.resampling.reservoir import finalize, initial_candidates, merge

# %%
# An integrand with a narrow peak on [0, 1), as a lamp seen from a floor:

STEPS = np.linspace(0, 1, 2001)


def f(x):
    """A peak of width 0.05 on a faint slope."""
    return np.exp(-0.5 * ((x - 0.7) / 0.05) ** 2) + 0.1 * x


TRUTH = np.sqrt(2 * np.pi) * 0.05 + 0.05


def resampled(target, candidates, repeats, seed=2):
    """Kept samples and their W, of as many independent choices."""
    rng = np.random.default_rng(seed)
    kept = None
    for _ in range(candidates):
        x = rng.random(repeats)
        new = initial_candidates(x, target(x), np.ones(repeats))
        kept = merge(kept, new, rng.random(repeats)) if kept else new
    r = finalize(kept, kept.M)
    return r.y, r.W


# %%
# With more candidates the kept samples come nearer to the target, although every
# candidate was drawn uniformly:

figure, axes = plt.subplots(1, 3, figsize=(10, 3), sharey=True)
for one, count in zip(axes, (1, 4, 32), strict=True):
    y, _ = resampled(f, count, 20000)
    one.hist(y, bins=60, density=True, color="#9ec5d8")
    one.plot(STEPS, f(STEPS) / TRUTH, color="#c8553d")
    one.set_title(f"M = {count}")
plt.show()

# %%
# What is that worth? The error of *one* kept sample, for three targets: the integrand
# itself, a smooth guess at it, and nothing known at all.

TARGETS = {
    "p̂ = f": f,
    "a wide guess": lambda x: np.exp(-0.5 * ((x - 0.65) / 0.15) ** 2) + 0.05,
    "p̂ = 1": np.ones_like,
}
counts = 2 ** np.arange(8)
for name, target in TARGETS.items():
    errors = []
    for count in counts:
        y, W = resampled(target, count, 4000)
        errors.append(np.sqrt(np.mean((f(y) * W - TRUTH) ** 2)) / TRUTH)
        bias = (f(y) * W).mean() / TRUTH - 1
        assert abs(bias) < 5 * (f(y) * W).std() / np.sqrt(4000) / TRUTH
    plt.loglog(counts, errors, "o-", label=name)
plt.xlabel("candidates M")
plt.ylabel("relative error of one kept sample")
plt.legend()
plt.tight_layout()
plt.show()

# %%
# With :math:`\hat p = f` the error falls as :math:`1/\sqrt M`, although only one sample
# is looked at: the others live on in :math:`W`. With :math:`\hat p = 1` resampling is
# for nothing. ReSTIR GI's target is the light that a sample sends through the pixel
# [Ouyang21, Eq. 9], without visibility: that would cost a ray for each candidate.
#
# .. admonition:: Exercise
#
#    This :math:`W` is of the right size, and wrong. Which of its factors should be
#    another? (``python docs/lessons/exercises/exercise_2.py``)
#
# .. literalinclude:: /lessons/exercises/exercise_2.py
#    :pyobject: contribution_weight

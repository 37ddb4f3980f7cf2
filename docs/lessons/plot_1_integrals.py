r"""
1. An integral, by sampling
===========================

The light that a point scatters towards the camera is an integral over the hemisphere
above it,

.. math:: L = \int f(\omega)\,\mathrm{d}\omega, \qquad
          f(\omega) = \frac{\rho}{\pi}\, L_i(\omega) \cos\theta .

Nobody can solve it for a real scene. But whoever draws directions
:math:`\omega_1, \dots, \omega_N` with a density :math:`p` may average

.. math:: \langle L \rangle = \frac1N \sum_{i=1}^{N} \frac{f(\omega_i)}{p(\omega_i)} ,

whose expectation is :math:`L`, whatever :math:`p`, as long as :math:`p > 0` wherever
:math:`f \neq 0`. That is what *unbiased* means. How fast it comes near :math:`L` is
another matter, and the density decides on it.

Two densities
-------------

These are the functions that the renderer calls. Each turns two numbers in [0, 1) into a
direction about the *z* axis; beside each stands its density.

.. literalinclude:: /../reference/numerics/sampling.py
   :pyobject: sample_uniform_hemisphere

.. literalinclude:: /../reference/numerics/sampling.py
   :pyobject: sample_cosine_hemisphere
"""

import matplotlib.pyplot as plt
import numpy as np

from restir_gi.reference.numerics.sampling import (
    pdf_cosine_hemisphere,
    pdf_uniform_hemisphere,
    sample_cosine_hemisphere,
    sample_uniform_hemisphere,
)

# %%
# A sky that is brighter towards the zenith, :math:`L_i = (1 + 3 \cos\theta) / 2`, over
# a white diffuse surface: the integral is
# :math:`\int (1 + 3\cos\theta)/2 \cdot \cos\theta / \pi \,\mathrm{d}\omega = 3/2`.

TRUTH = 1.5


def integrand(direction):
    """A white diffuse surface under that sky."""
    cosine = direction[:, 2]
    return (1 + 3 * cosine) / 2 * cosine / np.pi


def estimates(sample, pdf, count, repeats, seed=1):
    """Independent estimates, each of so many samples."""
    u1, u2 = np.random.default_rng(seed).random((2, repeats * count))
    direction = sample(u1, u2)
    ratio = integrand(direction) / pdf(direction[:, 2])
    return ratio.reshape(repeats, count).mean(axis=1)


DENSITIES = {
    "uniform": (sample_uniform_hemisphere, pdf_uniform_hemisphere),
    "cosine": (sample_cosine_hemisphere, pdf_cosine_hemisphere),
}
for name, (sample, pdf) in DENSITIES.items():
    found = estimates(sample, pdf, 64, 4000)
    error = found.std() / np.sqrt(len(found))
    print(f"{name:8} mean {found.mean():.4f} ± {error:.4f}, truth {TRUTH}")

# %%
# Both are right, and one of them needs fewer samples. The error of each falls with the
# square root of their number: for a tenth of the error, a hundred times the time.

counts = 4 ** np.arange(7)
for name, (sample, pdf) in DENSITIES.items():
    errors = [
        np.sqrt(np.mean((estimates(sample, pdf, n, 400) - TRUTH) ** 2)) for n in counts
    ]
    plt.loglog(counts, errors, "o-", label=name)
plt.loglog(counts, 0.9 / np.sqrt(counts), "k:", label=r"$\propto 1/\sqrt{N}$")
plt.xlabel("samples N")
plt.ylabel("root of the mean squared error")
plt.legend()
plt.show()

# %%
# Where it goes wrong
# -------------------
#
# A direction and its density have to belong together. If they do not, the average
# converges all the same, and to something else: nothing looks wrong but the brightness.
# In the contract for backends the pass ``direction`` holds both.
#
# .. admonition:: Exercise
#
#    One line of this function is wrong; ``python docs/lessons/exercises/exercise_1.py``
#    says what comes of it. :doc:`The answers </lessons/answers>` have their own page.
#
# .. literalinclude:: /lessons/exercises/exercise_1.py
#    :pyobject: sample_disk_up

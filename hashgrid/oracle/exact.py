"""L1: the light that is kept of two that were drawn, over every outcome.

Three lights are drawn with their probabilities, one of which does not reach the surface
point.  The decision is asked twice, in the middle of either side of its threshold, and
each answer counts with the length of its side.  What must come out for each light that
is reflected, E[W 1{y = x}] = 1 / density, knows nothing of how one is kept.
"""

from itertools import product

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Scalars
from restir_gi.reference.oracle.buffers import given
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.levels.probe import Examine, Finding, Probe
from restir_gi.reference.oracle.levels.replayed import replayed

CHOICE = np.array([0.5, 0.3125, 0.1875])
TARGETS = (np.array([2.0, 0.75, 0.0]), np.array([0.0, 3.0, 0.25]))
DENSITY = np.array([4.0, 0.5, 2.0])

ROUNDINGS = 128
"""Of an expectation, in half units of eps: sums of positive numbers in any order."""


def drawn_light_probes(precision: Precision) -> list[Probe]:
    """Expectations of pass ``light_candidates``, of level L1: no false alarm."""
    return [_probe(k, p_hat, precision) for k, p_hat in enumerate(TARGETS)]


def _probe(k: int, p_hat: Scalars, precision: Precision) -> Probe:
    drawn = np.repeat(list(product(range(len(CHOICE)), repeat=2)), 2, axis=0)
    w = p_hat[drawn] / (CHOICE * DENSITY)[drawn]
    total = w.sum(axis=1)
    threshold = np.divide(w[:, 1], total, out=np.zeros_like(total), where=total > 0)
    below = np.arange(len(drawn)) % 2 == 0
    share = np.where(below, threshold, 1 - threshold) * CHOICE[drawn].prod(axis=1)
    u = np.zeros(drawn.shape)
    u[:, 1] = np.where(below, threshold / 2, (1 + threshold) / 2)
    inputs = {
        "p_hat": p_hat[drawn],
        "choice": CHOICE[drawn],
        "density": DENSITY[drawn],
        "u": np.minimum(u, 1 - 2.0**-24),
    }
    name = f"grid-drawn-lattice-{k}"
    case = Case(name, "light_candidates", {}, given(inputs, precision))
    return Probe("L1", case, _expectation(drawn, share, p_hat))


def _expectation(drawn: Indices, share: Scalars, p_hat: Scalars) -> Examine:
    def examine(case: Case, out: Buffers, precision: Precision) -> Finding:
        W, slot = out["W"].astype(float), out["slot"].astype(int)
        bad = (W > 0) & ((slot < 0) | (slot >= 2))
        if bad.any():
            return Finding(False, f"{case.name}: slot {slot[bad][0]} does not exist")
        kept = drawn[np.arange(len(W)), np.clip(slot, 0, 1)]
        room = ROUNDINGS * float(np.finfo(precision).eps) / 2
        for light in np.flatnonzero(p_hat > 0):
            found = float((share * W * (kept == light)).sum())
            truth = 1 / DENSITY[light]
            if abs(found - truth) > room * truth:
                replay = replayed("L1", case).examine(case, out, precision)
                text = f"E[W] of light {light} is {found:g} instead of {truth:g}"
                ours = Finding(False, f"{case.name}: {text}")
                return ours if replay.passed else replay
        return Finding(True)

    return examine

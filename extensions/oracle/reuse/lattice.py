"""L1: reuse integrated over every outcome of three sources, and every decision.

Each source draws each of four cells, or nothing, with probability 1/5, so that a sample
of cell x has W = 5 mu_k(x).  A decision between the weights of the contract's stream is
asked twice, in the middle of either side of its threshold, and each answer counts with
the length of its side.  What must come out, E[W 1{z = x}] = mu(x) of the receiver, for
each cell of its domain, knows nothing of what the weights are divided by.  Where the
sum is another one the thresholds may be others too, so that it is no expectation: then
the rows are judged as a replay judges them.
"""

from itertools import product

import numpy as np

from restir_gi.extensions.oracle.reuse.cases import WEIGHTS
from restir_gi.reference.numerics.arrays import Indices, Scalars
from restir_gi.reference.oracle.buffers import given
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision, Value
from restir_gi.reference.oracle.levels.probe import Examine, Finding, Probe
from restir_gi.reference.oracle.levels.replayed import replayed

PIXELS, CELLS = 3, 4
NOTHING = CELLS
TRUST = np.array([1.0, 3.0, 2.0])
MU = np.array([[1.0, 2, 4, 3, 1], [3.0, 1, 2, 5, 1], [0.5, 6, 1, 2, 1]])
"""Measures of the cells at the pixels; the last column stands for nothing."""

TARGET = np.array([[2.0, 1, 3, 0.5, 0], [1.0, 4, 0, 2, 0], [5.0, 0, 2, 1, 0]])
"""p̂; 0 where a pixel cannot use a cell, and so never draws it."""

ROUNDINGS = 256
"""Of one contribution, in units of half an eps: W and its parts have some 60
operations of sums of positive numbers, in any order."""


def lattice_probes(precision: Precision) -> list[Probe]:
    """Expectations of all unbiased weights, at all three receivers, of level L1.

    They are exact, so that a right backend cannot fail.
    """
    unbiased = [mis for mis in WEIGHTS if mis != "1/M"]
    return [_probe(mis, c, precision) for mis in unbiased for c in range(PIXELS)]


def _probe(mis: str, c: int, precision: Precision) -> Probe:
    cells = np.array(list(product(range(CELLS + 1), repeat=PIXELS)))
    # A draw of what a pixel cannot use is a null.
    k = np.arange(PIXELS)
    cells = np.where(TARGET[k, cells] > 0, cells, NOTHING)
    tables = _tables(cells, c)
    line, u, share = sides(stream_weights(tables, mis, c))
    inputs = {name: table[line] for name, table in tables.items()}
    inputs["u"] = u
    settings: dict[str, Value] = {"mis": mis, "canonical": c, "cap": 99.0}
    name = f"lattice-path-reuse-{mis.replace('/', '-over-')}-{c}"
    case = Case(name, "path_reuse", settings, given(inputs, precision))
    probability = share / (CELLS + 1) ** PIXELS
    return Probe("L1", case, _expectation(cells[line], probability, c))


def _tables(cells: Indices, c: int) -> dict[str, Scalars]:
    """What each pixel brings to pixel c, and could have made of the others' samples."""
    k = np.arange(PIXELS)
    base, mu = TARGET[k, cells], MU[k, cells]
    full = base > 0
    usable = full & (TARGET[c, cells] > 0)
    at_others = TARGET.T[cells] * (MU / MU[c]).T[cells]
    return {
        "W": np.where(full, (CELLS + 1) * mu, 0.0),
        "M": np.broadcast_to(TRUST, cells.shape),
        "there": np.ones(cells.shape, np.uint32),
        "target_base": base,
        "target_here": np.where(usable, TARGET[c, cells], 0.0),
        "jacobian": np.where(usable, MU[c, cells] / mu, 0.0),
        "target_at": np.where(usable[:, :, None], at_others, 0.0),
    }


def stream_weights(t: dict[str, Scalars], mis: str, c: int) -> Scalars:
    """Weights w_k of the contract's stream, of sources with the same M in all rows.

    Parameters
    ----------
    t : dict of str to (R, K) or (R, K, K) array; tables of pass ``path_reuse``

    Returns
    -------
    (R, K) float64
    """
    m = np.array(t["M"])
    if mis in ("pairwise", "defensive"):
        trust = m[0]
        S = trust.sum() - trust[c]
        T = S + trust[c] * (mis == "defensive")
        made = _ratio(t["target_base"], t["jacobian"])
        m = trust / T * _ratio(S * made, S * made + trust[c] * t["target_here"])
        own = trust[c] * t["target_here"][:, c, None]
        shares = trust / T * _ratio(own, own + S * t["target_at"][:, c])
        shares[:, c] = trust[c] / T * (mis == "defensive")
        m[:, c] = shares.sum(axis=1)
    found: Scalars = m * t["target_here"] * t["W"] * t["jacobian"]
    return found


def _ratio(above: Scalars, below: Scalars) -> Scalars:
    above, below = np.broadcast_arrays(above, below)
    found: Scalars = np.divide(above, below, out=np.zeros(below.shape), where=below > 0)
    return found


def sides(w: Scalars) -> tuple[Indices, Scalars, Scalars]:
    """Both sides of each decision of a stream.

    Parameters
    ----------
    w : (R, K) float64; weights

    Returns
    -------
    (L,) int, (L, K) float64, (L,) float64
        Row that each line belongs to, its numbers u, and its share of the row.
    """
    sums = np.cumsum(w, axis=1)[:, 1:]
    threshold = _ratio(w[:, 1:], sums)
    lines, numbers, shares = [], [], []
    for below in product((True, False), repeat=w.shape[1] - 1):
        side = np.array(below)
        length = np.where(side, threshold, 1 - threshold)
        middle = np.where(side, threshold / 2, (1 + threshold) / 2)
        share = length.prod(axis=1)
        row = np.flatnonzero(share > 0)
        lines.append(row)
        numbers.append(np.concatenate([np.zeros((len(row), 1)), middle[row]], axis=1))
        shares.append(share[row])
    return np.concatenate(lines), np.concatenate(numbers), np.concatenate(shares)


def _expectation(cells: Indices, probability: Scalars, c: int) -> Examine:
    def examine(case: Case, out: Buffers, precision: Precision) -> Finding:
        W, slot = out["W"].astype(float), out["slot"].astype(int)
        bad = (W > 0) & ((slot < 0) | (slot >= PIXELS))
        if bad.any():
            return Finding(False, f"{case.name}: slot {slot[bad][0]} does not exist")
        z = cells[np.arange(len(W)), np.clip(slot, 0, PIXELS - 1)]
        room = ROUNDINGS * float(np.finfo(precision).eps) / 2
        for x in np.flatnonzero(TARGET[c] > 0):
            found, truth = float((probability * W * (z == x)).sum()), MU[c, x]
            if abs(found - truth) > room * truth:
                return replayed("L1", case).examine(case, out, precision)
        wrong = out["M"] != TRUST.sum()
        if wrong.any():
            value = out["M"][wrong][0]
            return Finding(
                False, f"{case.name}: M is {value:g} instead of {TRUST.sum():g}"
            )
        return Finding(True)

    return examine

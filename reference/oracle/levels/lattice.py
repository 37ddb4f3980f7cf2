"""L1: passes integrated exactly, over every outcome and on a lattice of decisions.

A pixel q and others look at four patches whose solid angles are known.  Each draws each
patch, or nothing, with probability 1/5, so that a reservoir of patch x has W = 5 mu(x).
The radiances are such that p̂_q(x) · 5 mu_q(x) is a whole number: then so are all
weights that arrive at q, whoever drew them, and a decision between whole numbers w of S
is integrated by the midpoints of S cells, each at least 1 / 2S away from the threshold:
no rounding flips one.  What must come out, E[W 1{y = x}] = mu_q(x), knows nothing
of what the weights are divided by: any division that is unbiased passes, and no other.
With another target or another order of the stream the weights are not whole, and the
sums are not the expectation: such a backend fails although its distribution may be
right.
"""

from itertools import product

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Indices, Scalars
from restir_gi.reference.oracle.buffers import given, prefixed
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision, Value
from restir_gi.reference.oracle.levels.patches import (
    NOTHING,
    OUTCOMES,
    PLACE,
    TRUST,
    eye,
    patch_reservoirs,
    theory,
    visible_bits,
    whole_weight,
)
from restir_gi.reference.oracle.levels.probe import Examine, Finding, Probe

ROUNDINGS = 256
"""Of one contribution, in units of half an eps: W and J have some 20 operations, whose
errors cosines of at least 0.15 magnify; a term with its neighbour's J has two."""


def lattice_probes(precision: Precision) -> list[Probe]:
    """Expectations of the passes that choose, of level L1.

    They are exact, so that a right backend cannot fail.
    """
    return [
        _merge(precision),
        _temporal(precision),
        _moved(precision),
        _spatial(precision, with_past=False),
        _spatial(precision, with_past=True),
    ]


def _grid(weights: Indices) -> tuple[Indices, Scalars, Scalars]:
    """For rows of whole weights of a stream: all decisions on their lattices.

    Returns the row that each line belongs to, (L, K − 1) numbers u, and its share.
    """
    lines, numbers, shares = [], [], []
    for row, w in enumerate(weights):
        sums = np.maximum(np.cumsum(w)[1:], 1)
        lattice = [(np.arange(s) + 0.5) / s for s in sums]
        points = np.array(list(product(*lattice)))
        lines.append(np.full(len(points), row))
        numbers.append(points)
        shares.append(np.full(len(points), 1 / len(points)))
    return np.concatenate(lines), np.concatenate(numbers), np.concatenate(shares)


def _expectation(probability: Scalars, rows: Indices, M: float) -> Examine:
    def examine(case: Case, out: Buffers, precision: Precision) -> Finding:
        W, y = out["W"][rows].astype(float), out["position"][rows].astype(float)
        truth = theory().mu[0]
        room = ROUNDINGS * float(np.finfo(precision).eps) / 2
        for x in range(NOTHING):
            here = (np.abs(y - PLACE[x]) < 1e-3).all(axis=1)
            found = float((probability * W * here).sum())
            if abs(found - truth[x]) > room * truth[x]:
                off = 100 * (found / truth[x] - 1)
                return Finding(
                    False,
                    f"{case.name}: E[W 1(y = x)] of patch {x} is {found:.6g} instead of"
                    f" {truth[x]:.6g} ({off:+.3g} %), summed over all outcomes and"
                    " decisions of the contract's stream",
                )
        wrong = out["M"][rows] != M
        if wrong.any():
            value = out["M"][rows][wrong][0]
            return Finding(False, f"{case.name}: M is {value:g} instead of {M:g}")
        return Finding(True)

    return examine


def _merge(precision: Precision) -> Probe:
    weights = np.array(list(product(range(4), repeat=2)))
    line, u, share = _grid(weights)
    a, b = weights[line].T.astype(float)
    inputs = {"w_a": a, "M_a": a * 0 + 1, "w_b": b, "M_b": b * 0 + 2, "u": u[:, 0]}

    def examine(case: Case, out: Buffers, precision: Precision) -> Finding:
        kept = np.bincount(line, share * out["second"])
        S = weights.sum(axis=1)
        wanted = np.where(S > 0, weights[:, 1] / np.maximum(S, 1), 0)
        bad = np.abs(kept - wanted) > 1e-12  # counts over at most 6 cells
        if bad.any():
            row = int(np.flatnonzero(bad)[0])
            w_a, w_b = weights[row]
            return Finding(
                False,
                f"{case.name}: of weights {w_a} and {w_b} the second is kept with"
                f" probability {kept[row]:.6g} instead of {wanted[row]:.6g}",
            )
        return Finding(True)

    case = Case("lattice-merge", "merge", {}, given(inputs, precision))
    return Probe("L1", case, examine)


def _outcomes(count: int) -> Indices:
    return np.array(list(product(range(OUTCOMES), repeat=count)))


def _temporal(precision: Precision) -> Probe:
    cells = _outcomes(2)
    w = np.stack(
        [2 * whole_weight(0, cells[:, 0]), whole_weight(0, cells[:, 1])], axis=1
    )
    line, u, share = _grid(w)
    past = patch_reservoirs(0, cells[line, 0]) | {"M": np.full(len(line), 2.0)}
    inputs = (
        eye(0, len(line))
        | prefixed("past", past)
        | _new(cells[line, 1])
        | {"u": u[:, 0]}
    )
    settings: dict[str, Value] = {"target": "scattered", "cap": 2.0}
    case = Case("lattice-temporal", "temporal", settings, given(inputs, precision))
    probability = share / OUTCOMES**2
    return Probe("L1", case, _expectation(probability, np.arange(len(line)), 2.0))


def _new(cells: Indices) -> dict[str, NDArray[np.float64]]:
    found = patch_reservoirs(0, cells)
    W = found.pop("W")
    del found["M"]
    pdf = np.divide(1.0, W, out=np.zeros_like(W), where=W > 0)
    return prefixed("new", found) | {"new_pdf": pdf}


def _moved(precision: Precision) -> Probe:
    cells = _outcomes(2)
    who = 1
    w = np.stack(
        [TRUST[who] * whole_weight(who, cells[:, 0]), whole_weight(0, cells[:, 1])],
        axis=1,
    )
    line, u, share = _grid(w)
    old, new = cells[line, 0], cells[line, 1]
    inputs = (
        eye(0, len(line))
        | prefixed("past", eye(who, len(line)) | patch_reservoirs(who, old))
        | _new(new)
        | {"u": u[:, 0], "visible": visible_bits(np.array([0, who]), [new, old])}
    )
    settings: dict[str, Value] = {"target": "scattered", "cap": 9.0, "mis": "1/Z"}
    case = Case("lattice-moved", "moved", settings, given(inputs, precision))
    probability = share / OUTCOMES**2
    M = 1.0 + TRUST[who]
    return Probe("L1", case, _expectation(probability, np.arange(len(line)), M))


def _spatial(precision: Precision, with_past: bool) -> Probe:
    """Rows in threes: q, and the two neighbours that only q looks at."""
    around = [1] if with_past else [1, 2]
    cells = _outcomes(1 + with_past + len(around))
    past = cells[:, -1] if with_past else np.full(len(cells), NOTHING)
    arriving = [whole_weight(0, past), whole_weight(0, cells[:, 0])]
    arriving += [TRUST[k] * whole_weight(k, cells[:, k]) for k in around]
    line, u, share = _grid(np.stack(arriving, axis=1))
    count, pixels = len(line), 1 + len(around)
    row = np.arange(count) * pixels

    def interleaved(parts: list[dict[str, Scalars]]) -> dict[str, Scalars]:
        return {
            name: np.stack([part[name] for part in parts], axis=1).reshape(
                count * pixels, *parts[0][name].shape[1:]
            )
            for name in parts[0]
        }

    everyone = [0, *around]
    inputs = interleaved([eye(k, count) for k in everyone])
    inputs |= interleaved([patch_reservoirs(k, cells[line, k]) for k in everyone])
    before = patch_reservoirs(0, past[line])
    if not with_past:
        before |= {"M": np.zeros(count)}
    nothing = patch_reservoirs(0, np.full(count, NOTHING)) | {"M": np.zeros(count)}
    inputs |= prefixed("past", interleaved([before, *[nothing] * len(around)]))
    neighbors = np.full((count * pixels, len(around)), -1)
    neighbors[row] = row[:, None] + np.arange(1, pixels)
    visible = np.zeros((count * pixels, pixels), np.uint32)
    samples = [*(cells[line, k] for k in everyone), past[line]]
    visible[row] = visible_bits(np.array(everyone), samples)
    for k, cell in zip(everyone[1:], samples[1:-1], strict=True):
        visible[row + everyone.index(k), :1] = visible_bits(np.array([k]), [cell])
    numbers = np.repeat(u, pixels, axis=0)
    inputs |= {
        "neighbors": neighbors,
        "visible": visible,
        "u_own": numbers[:, 0],
        "u_neighbors": numbers[:, 1:],
    }
    settings: dict[str, Value] = {"target": "scattered", "cap": 99.0, "mis": "1/Z"}
    name = "lattice-spatial" + "-with-past" * with_past
    case = Case(name, "spatial", settings, given(inputs, precision))
    M = float(sum(TRUST[k] for k in everyone) + (TRUST[0] if with_past else 0))
    probability = share / len(cells)
    return Probe("L1", case, _expectation(probability, row, M))

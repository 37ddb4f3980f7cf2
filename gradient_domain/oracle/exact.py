"""L1: pairs integrated over every outcome, on four pixels that see four cells.

Pixels 0 and 1 are a pair, 2 and 3 another.  A cell has an f in each pixel, or is not
there at all, and a measure; shifts lead to the same cell, where the other pixel has it,
so that they are bijections between parts of the pixels' domains, and fail elsewhere, on
one side or the other.  A pixel draws each of its n cells, or nothing, with probability
1 / (n + 1), so that a path of a cell has W = (n + 1) measure.  Decisions are asked on
both sides of their threshold, and each counts with the length of its side.

What must come out knows nothing of weights: E[W 1{y = (x, k)}] is the measure of x in
the pixel of k, and E[Δ] = F_i − F_j, which is a sum over the cells of either pixel.
"""

from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from restir_gi.extensions.oracle.reuse.lattice import sides, stream_weights
from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars, Vec3s
from restir_gi.reference.oracle.buffers import given
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision, Value
from restir_gi.reference.oracle.levels.probe import Examine, Finding, Probe
from restir_gi.reference.oracle.levels.replayed import replayed
from restir_gi.reference.oracle.replay.geometry import LUMINANCE

F = np.array(
    [
        [[5.0, 3, 1], [4, 1, 2], [3, 2, 1], [0, 0, 0]],
        [[0.5, 1, 0.125], [1, 3, 2], [0, 0, 0], [2, 5, 1]],
        [[1.0, 2, 0], [2, 2, 3], [0, 0, 0], [1, 4, 2]],
        [[0.0, 0, 0], [3, 1, 0], [6, 1, 1], [1, 0, 2]],
    ]
)
"""f of the cells at the pixels; all 0 where a pixel does not have a cell."""

MU = np.array([[0.5, 2, 1, 0], [3, 0.5, 0, 1], [1, 0.25, 0, 1.5], [0, 1, 2, 0.75]])
"""Their measures."""

PAIRS = np.array([[0, 1], [2, 3]])
CELLS, NOTHING = 4, 4
TRUST = np.array([3.0, 2.0])
UNBIASED = ("1/Z", "balance", "pairwise", "defensive")
SIGNS = {"plus": 1, "minus": -1, "both": 0}

ROUNDINGS = 256
"""Of one contribution, in units of half an eps: W and its parts have some 60
operations in any order, and no difference is below a sixth of what it is made of."""


@dataclass(frozen=True, slots=True, eq=False)
class CellSamples:
    """Samples (x, k) of a pair.

    Attributes
    ----------
    pair : int; which of `PAIRS`
    k, cell : (N,) int; the cell of x, or `NOTHING`
    """

    pair: int
    k: Indices
    cell: Indices

    @property
    def pixel(self) -> Indices:
        """Where the base path is, (N,)."""
        found: Indices = PAIRS[self.pair][self.k]
        return found

    @property
    def lit(self) -> Masks:
        """Whether there is a base path, (N,) bool."""
        found: Masks = (self.cell != NOTHING) & (self.measure > 0)
        return found

    @property
    def measure(self) -> Scalars:
        """Of the base path in its pixel, (N,)."""
        return _padded(MU)[self.pixel, self.cell]

    @property
    def values(self) -> dict[str, Scalars]:
        """Base and offset paths, and inner Jacobians; all 0 without a base path."""
        other = PAIRS[self.pair][1 - self.k]
        f, mu = _padded(F), _padded(MU)
        inner = ratio(mu[other, self.cell], self.measure)
        exists = (inner > 0)[:, None]
        return {
            "base": f[self.pixel, self.cell],
            "offset": np.where(exists, f[other, self.cell], 0.0),
            "inner": inner,
        }

    def contribution(self, sign: int) -> Vec3s:
        """What they add for a sign, (N, 3)."""
        v = self.values
        G = v["base"] - v["offset"] * v["inner"][:, None]
        H = np.where((self.k == 0)[:, None], G, -G) / (1 + v["inner"][:, None])
        found: Vec3s = sign * np.maximum(sign * H, 0) if sign else H
        return found

    def target(self, sign: int) -> Scalars:
        """Luminance of its magnitude, (N,)."""
        found: Scalars = np.abs(self.contribution(sign)) @ np.array(LUMINANCE)
        return found

    def at(self, pair: int) -> "CellSamples":
        """The same cells as samples of another pair; nothing where it has none."""
        there = CellSamples(pair, self.k, self.cell)
        cell = np.where(self.lit & there.lit, self.cell, NOTHING)
        return CellSamples(pair, self.k, cell)


def _padded(table: Scalars) -> Scalars:
    """With a last column of zeros, for nothing."""
    return np.concatenate([table, np.zeros_like(table[:, :1])], axis=1)


def ratio(above: Scalars, below: Scalars) -> Scalars:
    """Quotient, and 0 where the divisor is.

    Parameters
    ----------
    above, below : (N,) or (N, K)

    Returns
    -------
    (N,) or (N, K)
    """
    found: Scalars = np.divide(above, below, out=np.zeros(below.shape), where=below > 0)
    return found


def difference_of(pair: int) -> Vec3s:
    """F_i − F_j, from its definition, (3,)."""
    i, j = PAIRS[pair]
    found: Vec3s = MU[i] @ F[i] - MU[j] @ F[j]
    return found


def exact_probes(precision: Precision) -> list[Probe]:
    """Expectations of new samples, of reuse and of estimates, of level L1."""
    found = [
        _initial(pair, sign, precision) for pair in (0, 1) for sign in ("plus", "minus")
    ]
    found.append(_initial(0, "both", precision))
    found += [_estimate(pair, "two", precision) for pair in (0, 1)]
    found.append(_estimate(1, "one", precision))
    found += [_after(pair, precision) for pair in (0, 1)]
    for mis, c in product(UNBIASED, (0, 1)):
        found += [_reuse(mis, c, sign, precision) for sign in ("plus", "minus")]
    return found


# ------------------------------------------------ new samples


@dataclass(frozen=True, slots=True, eq=False)
class _Drawn:
    """Every outcome of a candidate of each pixel of a pair, R rows.

    Attributes
    ----------
    samples : pair of CellSamples; with k = 0 and 1
    W : (R, 2)
    probability : (R,)
    """

    samples: tuple[CellSamples, CellSamples]
    W: Scalars
    probability: Scalars

    def columns(self) -> dict[str, Scalars]:
        """Buffers with a column for each k."""
        parts = [s.values for s in self.samples]
        return {n: np.stack([p[n] for p in parts], axis=1) for n in parts[0]}


def _drawn(pair: int) -> _Drawn:
    cells = [[*np.flatnonzero(MU[pixel] > 0), NOTHING] for pixel in PAIRS[pair]]
    outcomes = np.array(list(product(*cells)))
    one = np.ones(len(outcomes), int)
    samples = tuple(CellSamples(pair, k * one, outcomes[:, k]) for k in (0, 1))
    W = np.stack(
        [s.measure * len(c) for s, c in zip(samples, cells, strict=True)], axis=1
    )
    return _Drawn((samples[0], samples[1]), W, one / len(outcomes))


def _initial(pair: int, sign: str, precision: Precision) -> Probe:
    drawn = _drawn(pair)
    p_hat = [s.target(SIGNS[sign]) for s in drawn.samples]
    line, u, share = sides(np.stack(p_hat, axis=1) * drawn.W)
    columns = drawn.columns() | {"W": drawn.W}
    inputs = {name: table[line] for name, table in columns.items()}
    inputs["u"] = u[:, 1]
    case = _case(
        f"pair-initial-{sign}-{pair}",
        "pair_initial",
        {"sign": sign},
        inputs,
        precision,
    )
    cells = np.stack([s.cell for s in drawn.samples], axis=1)[line]
    row, weight = np.arange(len(line)), drawn.probability[line] * share

    def examine(case: Case, out: Buffers, precision: Precision) -> Finding:
        k = np.clip(out["k"].astype(int), 0, 1)
        kept = CellSamples(pair, k, cells[row, k])
        W = weight * out["W"].astype(float)
        return _measures(case, out, precision, kept, W, sign)

    return Probe("L1", case, examine)


def _measures(
    case: Case,
    out: Buffers,
    precision: Precision,
    kept: CellSamples,
    weighted: Scalars,
    sign: str,
) -> Finding:
    """Whether E[W 1{y = (x, k)}] is the measure of x, for all that the sign has.

    Where it is not the thresholds may be others, so that it is no expectation: then the
    rows are judged as a replay judges them.
    """
    room = ROUNDINGS * float(np.finfo(precision).eps) / 2
    for k, cell in product((0, 1), range(CELLS)):
        one = CellSamples(kept.pair, np.array([k]), np.array([cell]))
        at = (kept.k == k) & (kept.cell == cell)
        found, truth = float(weighted[at].sum()), float(one.measure[0])
        has = bool(one.lit[0]) and one.target(SIGNS[sign])[0] > 0
        if abs(found - truth * has) > room * truth:
            return replayed("L1", case).examine(case, out, precision)
    return Finding(True)


# ------------------------------------------------ estimates


def _estimate(pair: int, reservoirs: str, precision: Precision) -> Probe:
    """Both reservoirs of a pair, from the candidates that they share."""
    drawn = _drawn(pair)
    signs = (1, -1) if reservoirs == "two" else (0, 0)
    size, probability = len(drawn.W), drawn.probability
    line = np.arange(size)
    kept: list[Indices] = []
    W: list[Scalars] = []
    for sign in signs:
        w = np.stack([s.target(sign) for s in drawn.samples], axis=1) * drawn.W
        share = ratio(w, np.broadcast_to(w.sum(axis=1, keepdims=True), w.shape))
        share[w.sum(axis=1) == 0, 0] = 1.0
        probability = np.concatenate([probability * share[line, k] for k in (0, 1)])
        k_now = np.repeat((0, 1), len(line))
        line, kept = np.tile(line, 2), [np.tile(k, 2) for k in kept]
        W = [np.tile(each, 2) for each in W]
        p = np.stack([s.target(sign) for s in drawn.samples], axis=1)[line, k_now]
        kept.append(k_now)
        W.append(ratio(w[line].sum(axis=1), p))
        some = probability > 0
        line, probability = line[some], probability[some]
        kept, W = [k[some] for k in kept], [each[some] for each in W]
    columns = drawn.columns()
    inputs = {
        name: np.stack([table[line, k] for k in kept], axis=1)
        for name, table in columns.items()
    }
    inputs |= {
        "k": np.stack(kept, axis=1).astype(np.uint32),
        "W": np.stack(W, axis=1),
    }
    settings: dict[str, Value] = {"reservoirs": reservoirs}
    name = f"pair-estimate-{reservoirs}-{pair}"
    case = _case(name, "pair_estimate", settings, inputs, precision)
    return Probe("L1", case, _difference(pair, probability))


def _after(pair: int, precision: Precision) -> Probe:
    drawn = _drawn(pair)
    inputs = drawn.columns() | {"W": drawn.W}
    name = f"after-estimate-{pair}"
    case = _case(name, "after_estimate", {}, inputs, precision)
    return Probe("L1", case, _difference(pair, drawn.probability))


def _difference(pair: int, probability: Scalars) -> Examine:
    """Whether E[Δ] = F_i − F_j."""

    def examine(case: Case, out: Buffers, precision: Precision) -> Finding:
        delta = out["delta"].astype(float)
        found, truth = probability @ delta, difference_of(pair)
        size = probability @ _made_of(case)
        room = ROUNDINGS * float(np.finfo(precision).eps) / 2 * size
        bad = np.flatnonzero(np.abs(found - truth) > room)
        if len(bad) == 0:
            return Finding(True)
        c = bad[0]
        text = f"{case.name}: the mean of delta is {found[c]:.9g} in channel {c}"
        told = f"{text} instead of F_i − F_j = {truth[c]:.9g}"
        # A sum of rows that are right would be: what replays the rows can name it.
        by_row = replayed("L1", case).examine(case, out, precision)
        return replace(by_row, passed=False, text=told)

    return examine


def _made_of(case: Case) -> Vec3s:
    """Sum of the magnitudes that the difference of each row is made of, (N, 3)."""
    i = {n: case.inputs[n].astype(float) for n in ("base", "offset", "inner", "W")}
    both = i["base"] + i["offset"] * i["inner"][..., None]
    found: Vec3s = (both * i["W"][..., None]).sum(axis=1)
    return found


# ------------------------------------------------ reuse


def _reuse(mis: str, c: int, sign: str, precision: Precision) -> Probe:
    """Two pairs whose reservoirs hold any sample of the sign, or nothing."""
    domains = [_domain(pair, SIGNS[sign]) for pair in (0, 1)]
    chosen = list(product(*(range(len(d) + 1) for d in domains)))
    made = []
    for pair, domain in enumerate(domains):
        some = [([*domain, (0, NOTHING)])[each[pair]] for each in chosen]
        k, cell = np.array(some).T
        made.append(CellSamples(pair, k, cell))
    W = np.stack(
        [s.measure * (len(d) + 1) for s, d in zip(made, domains, strict=True)], axis=1
    )
    tables = _tables(made, W, c)
    line, u, share = sides(stream_weights(_targets(made, W, c, SIGNS[sign]), mis, c))
    inputs = {name: table[line] for name, table in tables.items()}
    inputs["u"] = u
    settings: dict[str, Value] = {"sign": sign, "mis": mis, "canonical": c, "cap": 99.0}
    name = f"pair-reuse-{mis.replace('/', '-over-')}-{sign}-{c}"
    case = _case(name, "pair_reuse", settings, inputs, precision)
    weight, row = share / len(chosen), np.arange(len(line))
    here = [s.at(c) for s in made]
    ks, cells = (
        np.stack([getattr(s, n) for s in here], axis=1)[line] for n in ("k", "cell")
    )

    def examine(case: Case, out: Buffers, precision: Precision) -> Finding:
        slot = np.clip(out["slot"].astype(int), 0, 1)
        kept = CellSamples(c, ks[row, slot], cells[row, slot])
        W = weight * out["W"].astype(float)
        return _measures(case, out, precision, kept, W, sign)

    return Probe("L1", case, examine)


def _domain(pair: int, sign: int) -> list[tuple[int, int]]:
    """Samples (k, cell) that a reservoir of a sign can hold."""
    found = []
    for k, cell in product((0, 1), range(CELLS)):
        one = CellSamples(pair, np.array([k]), np.array([cell]))
        if one.lit[0] and one.target(sign)[0] > 0:
            found.append((k, cell))
    return found


def _tables(made: list[CellSamples], W: Scalars, c: int) -> dict[str, Scalars]:
    """What each pair brings to pair c, and could have made of the other's samples."""
    here = [s.at(c) for s in made]
    stacked = {
        "": [s.values for s in here],
        "_from": [s.values for s in made],
    }
    found = {
        f"{name}{suffix}": np.stack([part[name] for part in parts], axis=1)
        for suffix, parts in stacked.items()
        for name in ("base", "offset", "inner")
    }
    at = [[s.at(q) for q in range(len(made))] for s in here]
    for name in ("base", "offset", "inner"):
        rows = [np.stack([a.values[name] for a in of_s], axis=1) for of_s in at]
        found[f"{name}_at"] = np.stack(rows, axis=1)
    return found | {
        "W": W,
        "M": np.broadcast_to(TRUST, W.shape),
        "there": np.ones(W.shape, np.uint32),
        "k_from": np.stack([s.k for s in made], axis=1).astype(np.uint32),
        "jacobian": _jacobians(made, here),
        "jacobian_at": np.stack(
            [
                _jacobians([s] * len(made), of_s)
                for s, of_s in zip(here, at, strict=True)
            ],
            axis=1,
        ),
    }


def _jacobians(of: list[CellSamples], to: list[CellSamples]) -> Scalars:
    """Of shifts that take samples to others, 0 where they lead to nothing."""
    pairs = zip(of, to, strict=True)
    return np.stack([ratio(b.measure, a.measure) for a, b in pairs], axis=1)


def _targets(
    made: list[CellSamples], W: Scalars, c: int, sign: int
) -> dict[str, Scalars]:
    """The tables of pass path_reuse."""
    here = [s.at(c) for s in made]
    at = [[s.at(q) for q in range(len(made))] for s in here]
    target_at = [
        np.stack([a.target(sign) for a in of_s], axis=1)
        * _jacobians([s] * len(made), of_s)
        for s, of_s in zip(here, at, strict=True)
    ]
    return {
        "W": W,
        "M": np.broadcast_to(TRUST, W.shape),
        "target_base": np.stack([s.target(sign) for s in made], axis=1),
        "target_here": np.stack([s.target(sign) for s in here], axis=1),
        "jacobian": _jacobians(made, here),
        "target_at": np.stack(target_at, axis=1),
    }


def _case(
    name: str,
    pass_name: str,
    settings: dict[str, Value],
    inputs: dict[str, Scalars],
    precision: Precision,
) -> Case:
    return Case(f"lattice-{name}", pass_name, settings, given(inputs, precision))

"""The pass of reuse: who is right passes, whoever they are; others do not."""

import numpy as np
import pytest

from restir_gi.extensions.oracle.reuse.part import PART
from restir_gi.extensions.oracle.reuse.rules import ReuseRules
from restir_gi.reference.oracle.builtin.backend import BuiltIn
from restir_gi.reference.oracle.contract.fields import dtype_of
from restir_gi.reference.oracle.levels.probe import examined
from restir_gi.reference.oracle.parts import parts

PASSES = {p.name: p for p in PART.passes}
both_precisions = pytest.mark.parametrize("precision", ["float32", "float64"])


def found_in(precision, backend):
    """What is wrong with each answer; empty where nothing is."""
    texts = []
    for probe in PART.probes(precision):
        out = backend(precision, **probe.case.inputs, **probe.case.settings)
        texts.append(examined(PASSES, precision, probe, out).finding.text)
    return texts


def test_the_part_is_registered():
    assert PART in parts()


@both_precisions
def test_the_project_itself_passes(precision):
    def own(precision, **given):
        return BuiltIn(precision).path_reuse(**given)

    assert not any(found_in(precision, own))


def row_by_row(precision, mis, canonical, cap, **tables):
    """Written from the contract, in plain numbers, for one row at a time."""
    count = len(tables["W"])
    rows = [
        of_row({n: a[i].tolist() for n, a in tables.items()}, mis, canonical, cap)
        for i in range(count)
    ]
    slot, p_hat, W, M = (np.array(column) for column in zip(*rows, strict=True))
    real = dtype_of("real", precision)
    return {
        "slot": slot.astype(np.int32),
        "p_hat": p_hat.astype(real),
        "W": W.astype(real),
        "M": M.astype(real),
    }


def of_row(t, mis, c, cap):
    slots = range(len(t["W"]))
    M = [t["M"][k] if t["there"][k] else 0.0 for k in slots]
    here, J = t["target_here"], t["jacobian"]
    made = [b / j if j > 0 else 0.0 for b, j in zip(t["target_base"], J, strict=True)]
    m = in_pairs(t, mis, c, M, made) if mis in ("pairwise", "defensive") else M
    total, kept = 0.0, 0
    for k in slots:
        w = m[k] * here[k] * t["W"][k] * J[k] if t["there"][k] else 0.0
        total += w
        if w > 0 and (k == 0 or total == w or t["u"][k] * total < w):
            kept = k
    if total == 0:
        return kept, 0.0, 0.0, min(sum(M), cap)
    p = [t["target_at"][kept][k] for k in slots]
    p[c], p[kept] = here[kept], here[kept] if kept == c else made[kept]
    Z = {
        "1/M": sum(M),
        "1/Z": sum(M[k] for k in slots if p[k] > 0),
        "balance": sum(M[k] * p[k] for k in slots) / p[kept],
    }.get(mis, 1.0)
    return kept, here[kept], total / Z / here[kept], min(sum(M), cap)


def in_pairs(t, mis, c, M, made):
    others = [k for k in range(len(M)) if k != c]
    S, here = sum(M[k] for k in others), t["target_here"]
    T = S + M[c] if mis == "defensive" else S

    def share(a, b):
        return a / (a + b) if a > 0 else 0.0

    m = [0.0] * len(M)
    for k in others:
        m[k] = M[k] / T * share(S * made[k], M[c] * here[k]) if T > 0 else 0.0
        at = t["target_at"][c][k]
        m[c] += M[k] / T * share(M[c] * here[c], S * at) if T > 0 else 0.0
    if mis == "defensive":
        m[c] += M[c] / T
    return m if S > 0 else [float(k == c) for k in range(len(M))]


@both_precisions
def test_another_backend_passes(precision):
    assert not any(found_in(precision, row_by_row))


@pytest.mark.parametrize(
    "spoil",
    [
        lambda out, t: out | {"W": out["W"] * 1.001},
        lambda out, t: out | {"M": out["M"] + 1},
        lambda out, t: out | {"p_hat": out["p_hat"] * 1.001},
        lambda out, t: out | {"slot": (out["slot"] + 1) % t["W"].shape[1]},
        lambda out, t: out | {"slot": out["slot"] * 0 - 7},
    ],
    ids=["W", "M", "p_hat", "another slot", "no slot"],
)
def test_control_small_faults_are_seen(spoil):
    def backend(precision, **given):
        return spoil(row_by_row(precision, **given), given)

    texts = found_in("float64", backend)
    assert sum(map(bool, texts)) > len(texts) / 3


def test_every_known_mistake_changes_the_rules():
    """Each is another rule, and no two are alike."""
    rules = [h.rules.part for h in PART.hypotheses]
    assert ReuseRules() not in rules
    assert len(set(map(repr, rules))) == len(rules)

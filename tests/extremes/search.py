"""Hypothesis searches for the rows on which a kernel is worst.

``python -m tests.extremes.search`` searches long, and writes what it found to the
vectors that the package keeps.
"""

import json

import numpy as np
from hypothesis import HealthCheck, Phase, given, settings, target
from hypothesis import strategies as st

from restir_gi.reference.oracle.exact.draws import Draws
from restir_gi.reference.oracle.exact.extremes import EXTREMES
from restir_gi.reference.oracle.exact.matrix import TYPES, judged_cell, reads
from restir_gi.reference.oracle.exact.registry import kernels
from restir_gi.reference.oracle.exact.worst import PATH, Worst, plain

STEPS = 24
"""Numbers of a row that are moved one by one; the others move with them."""


def toward_0(inputs, steps):
    """Each number some places nearer to 0: it stays in its domain."""
    moved, at = {}, 0
    for name, a in inputs.items():
        count = a.size
        k = np.resize(np.roll(steps, -at), count).reshape(a.shape)
        moved[name] = a * (1 - k * np.finfo(a.dtype).eps).astype(a.dtype)
        at += count
    return moved


def search(kernel, dtype, examples, database=None):
    """Climb; the worst row of each extreme, or a failure where a kernel is wrong."""
    met = [extreme for extreme in EXTREMES if reads(kernel, extreme)]
    found, name = [], np.dtype(dtype).name

    @settings(
        max_examples=examples,
        deadline=None,
        database=database,
        derandomize=True,
        phases=(Phase.generate, Phase.target),
        suppress_health_check=list(HealthCheck),
    )
    @given(
        st.sampled_from(met),
        st.integers(0, 2**16),
        st.lists(st.integers(0, 64), min_size=STEPS, max_size=STEPS),
    )
    def search(extreme, seed, steps):
        draws = Draws(np.random.default_rng(seed), 1, np.finfo(dtype), extreme)
        inputs = {k: draws.in_type(v) for k, v in kernel.draw(draws).items()}
        cell = judged_cell(kernel, extreme.name, toward_0(inputs, steps))
        share, ulp = float(cell.judged.share[0]), float(cell.judged.ulp[0])
        assert cell.passed, (kernel.name, extreme.name, name, cell.fault, cell.inputs)
        target(share, label="share of the bound")
        given_ = {k: plain(a[0]) for k, a in cell.inputs.items()}
        found.append(Worst(kernel.name, name, extreme.name, ulp, share, given_))

    search()
    worst = {}
    for row in sorted(found, key=lambda row: row.share):
        worst[row.extreme] = row
    return sorted(worst.values(), key=lambda row: -row.share)


def main(examples=1000):
    """Write the vectors anew."""
    rows = [
        row.as_plain()
        for kernel in kernels()
        for dtype in TYPES
        for row in search(kernel, dtype, examples)
    ]
    lines = ",\n".join(json.dumps(row, ensure_ascii=False) for row in rows)
    PATH.write_text(f"[\n{lines}\n]\n", encoding="utf-8")


if __name__ == "__main__":
    main()

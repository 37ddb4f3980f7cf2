"""Cases of reservoirs in 48 bytes."""

from collections.abc import Iterator
from itertools import product

import numpy as np

from restir_gi.reference.numerics.arrays import normalize
from restir_gi.reference.oracle.levels.draws import unit_vectors
from restir_gi.reference.oracle.levels.further_views import ROWS, Parts
from restir_gi.reference.resampling.packing import paper
from restir_gi.reference.resampling.reservoir import Reservoirs, Samples


def packing_cases(rng: np.random.Generator) -> Iterator[Parts]:
    """Reservoirs in the paper's layout, written and read: all decades, then ends."""
    inputs = {
        "visible_position": rng.normal(size=(ROWS, 3)) * 100,
        "visible_normal": unit_vectors(rng, ROWS),
        "position": rng.normal(size=(ROWS, 3)) * 100,
        "normal": unit_vectors(rng, ROWS),
        "radiance": 10.0 ** rng.uniform(-6.5, 6, (ROWS, 3)),
        "W": 10.0 ** rng.uniform(-6, 6, ROWS) * (rng.random(ROWS) < 0.9),
        "M": np.where(
            rng.random(ROWS) < 0.8,
            rng.integers(0, 500, ROWS),
            rng.choice([0.25, 0.4, 1.5, 65534.7, 65535.0, 65536.0, 9e4], ROWS),
        ),
        "seed": rng.integers(0, 2**32, ROWS, np.uint32),
    }
    yield "pack", {}, inputs
    axes = np.array(list(product((-1.0, 0.0, 1.0), repeat=3)))  # also 0: a null
    some = axes[np.arange(ROWS) % len(axes)]
    ends = [0.0, 2.0**-25, 6e-8, 6.2e-5, 1.0, 65504.0, 65519.0, 65520.0, 1e6, 1e30]
    counts = [0.0, 0.25, 1.0, 1.5, 499.7, 65534.7, 65535.0, 65536.0, 1e9]
    extremes = inputs | {
        "visible_normal": normalize(some),
        "normal": normalize(some + 1e-5 * rng.normal(size=some.shape)),
        "radiance": rng.choice(ends, (ROWS, 3)),
        "W": rng.choice([0.0, 1e-37, 1.0, 3.4e38], ROWS),
        "M": rng.choice(counts, ROWS),
    }
    yield "pack-extremes", {}, extremes

    r = Reservoirs(
        Samples(inputs["position"], inputs["normal"], inputs["radiance"]),
        inputs["W"],
        inputs["M"],
    )
    at = (inputs["visible_position"], inputs["visible_normal"])
    codes = paper.pack(*at, r, inputs["seed"])
    yield "unpack", {}, {"words": codes.view("<u4").reshape(-1, 12)}
    # All codes of normals and of halves; no infinite numbers.
    wild = codes.copy()
    ends16 = [-32768, -32767, -20000, -1, 0, 1, 12767, 32767]
    wild["n_v"], wild["n_s"] = rng.choice(ends16, (2, ROWS, 2))
    wild["M"] = rng.integers(0, 2**16, ROWS)
    halves = rng.integers(0, 2**16, (ROWS, 3), np.uint16).view(np.float16)
    wild["L_o"] = np.where(np.isfinite(halves), halves, 0)
    yield "unpack-extremes", {}, {"words": wild.view("<u4").reshape(-1, 12)}
    # Infinity and NaN, which `pack` does not write and others do.
    wild["L_o"] = rng.choice(np.array([np.inf, -np.inf, np.nan, 1], "f2"), (ROWS, 3))
    wild["W"] = rng.choice(np.array([np.inf, np.nan, 1], "f4"), ROWS)
    yield "unpack-infinite", {}, {"words": wild.view("<u4").reshape(-1, 12)}

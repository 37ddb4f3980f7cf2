"""Sizes of biases by design: what is summed exactly beside what is drawn.

The renderers of `tests.foreign` share no code with the sums.  They are given the small
worlds that are summed, with random numbers that are drawn, and the light that they show
on average is held against the sum.
"""

import numpy as np
import pytest

from restir_gi.reference.oracle.backends.inside import InsideBackend
from restir_gi.reference.oracle.declaration.read import read_declaration
from restir_gi.reference.oracle.diagnosis.innocence import (
    PLACE,
    SITUATIONS,
    bias_in,
    case_of,
    light_of,
    outcomes_of,
    world,
)
from restir_gi.reference.oracle.ladder import statistical_levels
from restir_gi.reference.oracle.levels.means import replicates, truth
from restir_gi.reference.oracle.parts import whole_contract
from restir_gi.reference.oracle.steps import Asker
from tests.foreign import mistakes as wrong
from tests.foreign.backends import Only

DRAWS = {"moved": 2048, "spatial": 32}
"""Times that every outcome of a world is decided on, of 16 and of 256."""

ROUNDING = 2e-5
"""Of float32, relative: a dozen operations of 6e-8, magnified by at most 25 in J."""

WORLDS = [s for s in SITUATIONS if s.mis == "1/Z"]

BIASED = {
    "jacobian.clamped": (wrong.ClampedJacobian, {"jacobian": {"clamped": ["1/3", 3]}}),
    "both": (
        wrong.RefusedThenClamped,
        {"jacobian": {"refused": [0.1, 10], "clamped": ["1/3", 3]}},
    ),
    "1/M": (wrong.OneOverM, {"mis": "1/M"}),
    "domain": (wrong.BlindDomain, {"visibility_in_domain": False}),
}
"""Renderers, and what they would declare."""

TESTS = len(BIASED) * 2 * len(WORLDS)
LOG = float(np.log(2 * TESTS / 1e-6))
"""Of Bernstein's inequality: any of these tests fails with probability 1e-6 at most, if
the sums are right, however rare a decision is."""


def rules_of(choices, pass_name):
    schema = {"schema": "restir-declaration 1"}
    return read_declaration(schema | {"choices": choices}).rules_of(pass_name)


def shown_by(patch, W, situation):
    """Light of kept patches over the truth; patch 3 is nothing."""
    f, mu = light_of(situation), world(situation.eyes, situation.hidden).mu[0][:3]
    return W * np.append(f, 0.0)[patch] / float(f @ mu)


def patch_of(place):
    here = (np.abs(np.asarray(place, float)[:, None] - PLACE) < 1e-3).all(axis=2)
    return np.where(here.any(axis=1), here.argmax(axis=1), 3)


def room_of(pass_name, rules, situation):
    """What the mean of the draws may be off by: variance and range are summed, too."""
    _, rows = case_of(pass_name, situation)
    found, _ = outcomes_of(pass_name, rules, situation)
    light = [shown_by(patch_of(k.place), k.W, situation)[rows] for k in found]
    chance = [np.broadcast_to(k.chance, k.W.shape)[rows] for k in found]
    mean = sum(c * x for c, x in zip(chance, light, strict=True))
    squares = sum(c * x**2 for c, x in zip(chance, light, strict=True))
    count = DRAWS[pass_name] * len(rows)
    variance = np.maximum(squares - mean**2, 0).mean() / count
    possible = [np.where(c > 0, x, 0) for c, x in zip(chance, light, strict=True)]
    b = np.max(possible) * LOG / count / 3
    return b + np.sqrt(b**2 + 2 * variance * LOG)


def drawn(renderer, pass_name, situation):
    """Light that q shows, relative to the truth, minus 1."""
    case, rows = case_of(pass_name, situation)
    rng, total = np.random.default_rng(7), 0.0
    inputs = {
        n: a.astype("f4") if a.dtype.kind == "f" else a for n, a in case.inputs.items()
    }
    if pass_name == "moved":  # whose rows do not look at each other
        times, copies = 1, DRAWS[pass_name]
        inputs = {n: np.concatenate([a] * copies) for n, a in inputs.items()}
        rows = np.arange(copies * len(rows))
    else:
        times = DRAWS[pass_name]
    for _ in range(times):
        for name, array in inputs.items():
            if name == "u" or name.startswith("u_"):
                inputs[name] = rng.random(array.shape, "f4")
        out = getattr(renderer, pass_name)(**inputs, **case.settings)
        patch = patch_of(out["position"][rows])
        total += shown_by(patch, out["W"][rows].astype(float), situation).mean()
    return total / times - 1


def quick_and_slow():
    """All biases in both passes, most of them slow."""
    for name in BIASED:
        for pass_name in DRAWS:
            quick = name == "jacobian.clamped"
            marks = () if quick else pytest.mark.slow
            yield pytest.param(name, pass_name, marks=marks)


@pytest.mark.parametrize(("name", "pass_name"), [*quick_and_slow()])
def test_the_sum_is_what_is_drawn(name, pass_name):
    mistake, choices = BIASED[name]
    rules, none = rules_of(choices, pass_name), rules_of({}, pass_name)
    seen = []
    for situation in WORLDS:
        off = drawn(mistake(), pass_name, situation)
        room = room_of(pass_name, rules, situation) + ROUNDING * (1 + abs(off))
        assert abs(off - bias_in(pass_name, rules, situation)) <= room, situation
        seen.append(abs(off - bias_in(pass_name, none, situation)) > room)
    assert any(seen)  # control: of the contract they are not


def test_control_another_clamp_has_another_size():
    other = rules_of({"jacobian": {"clamped": ["1/2", 2]}}, "moved")
    for situation in WORLDS[:2]:
        off = drawn(wrong.ClampedJacobian(), "moved", situation)
        room = room_of("moved", other, situation) + ROUNDING * (1 + abs(off))
        assert abs(off - bias_in("moved", other, situation)) > 10 * room


def measured(backend):
    """Bias of the mean over whole runs, as a check measures it."""
    levels = statistical_levels(whole_contract(), InsideBackend(backend), lambda: 0.0)
    _, _, take = next(levels)
    return take().measured


def test_the_measured_bias_is_that_of_other_runs():
    """Of a clamp; the two estimates have independent runs: 5.3 sigma is p = 1e-7."""
    backend = Only(wrong.ClampedJacobian(), ("moved", "spatial"))
    found = measured(backend)
    ask = Asker(whole_contract(), InsideBackend(backend))
    y = replicates(ask, "float32", 77)[:, 0] / truth() - 1
    off, error = y.mean(), y.std(ddof=1) / len(y) ** 0.5
    assert abs(found.relative - off) <= 5.3 * np.hypot(found.error, error)
    assert off > 5.3 * error  # control: there is a bias to be measured


def test_control_where_there_is_none_none_is_measured():
    found = measured(Only(wrong.ForeignRenderer(), ("moved", "spatial")))
    assert found.error > 0
    assert abs(found.relative) <= 5.3 * found.error

"""Levels without statistics: what is right passes, what is planted does not."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from restir_gi.reference.oracle.backends.inside import InsideBackend
from restir_gi.reference.oracle.builtin.backend import FLOAT32, FLOAT64
from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.contract.registry import CONTRACT
from restir_gi.reference.oracle.frames import frame_cases
from restir_gi.reference.oracle.levels.lattice import lattice_step
from restir_gi.reference.oracle.levels.patches import (
    CLOSE_NEIGHBORS,
    FAR_NEIGHBORS,
    NEAR,
    PLACE,
    theory,
)
from restir_gi.reference.oracle.levels.relations import relations_of
from restir_gi.reference.oracle.levels.spheres import (
    furnace,
    half_lit,
    long_furnace,
    long_half_lit,
    long_run,
)
from restir_gi.reference.oracle.prepared_frame import prepare_frame
from restir_gi.reference.passes import pixels
from restir_gi.reference.scene.catalogue.registry import find_scene

BACKENDS = {"float32": FLOAT32, "float64": FLOAT64}


def call(backend, case):
    return getattr(backend, case.pass_name)(**case.inputs, **case.settings)


def changed(precision, pass_name, change):
    """Ask a backend of which one pass is changed."""

    def ask(case):
        outputs = dict(call(BACKENDS[precision], case))
        return change(case, outputs) if case.pass_name == pass_name else outputs

    return ask


def right(precision):
    return changed(precision, None, None)


@pytest.fixture(params=BACKENDS)
def precision(request):
    return request.param


# ---------------------------------------------------------------- lattices


class RecordedCalls:
    """A backend of the passes that choose, from what answers their cases."""

    def __init__(self, precision, ask):
        self.precision, self._ask = precision, ask

    def __getattr__(self, name):
        if name not in ("merge", "temporal", "moved", "spatial"):
            raise AttributeError(name)
        passed = CONTRACT[name]

        def answer(**given):
            known = [s.name for s in passed.settings if s.name in given]
            settings = {name: given.pop(name) for name in known}
            return self._ask(Case("asked", name, settings, given))

        return answer


def lattice_findings(precision, ask):
    step = lattice_step(CONTRACT, InsideBackend(RecordedCalls(precision, ask)))
    return {a.probe.case.name: a.finding for a in step.answers if a.finding}


def test_lattices_pass_what_is_right(precision):
    found = lattice_findings(precision, right(precision))
    assert [f.text for f in found.values() if not f.passed] == []


def test_the_solid_angles_are_those_of_small_patches():
    """By the definition, with vectors of Python's own."""
    for world in (NEAR, FAR_NEIGHBORS, CLOSE_NEIGHBORS):
        known = theory(world)
        for i, x in np.argwhere(known.mu > 0):
            v = PLACE[x] - world.eye[i]
            d2 = sum(c * c for c in v)
            facing = -sum(a * b for a, b in zip(v, known.normal[x], strict=True))
            wanted = 0.05 * facing / d2**1.5
            assert known.mu[i, x] == pytest.approx(wanted, rel=1e-12)
            assert sum(a * b for a, b in zip(v, world.up[i], strict=True)) > 0


@pytest.mark.parametrize("factor", [1 + 1e-4, 1 - 1e-4])
@pytest.mark.parametrize("name", ["temporal", "moved", "spatial"])
def test_lattices_see_a_bias_of_a_hundredth_of_a_percent(precision, name, factor):
    def change(case, out):
        return out | {"W": (out["W"] * factor).astype(out["W"].dtype)}

    found = lattice_findings(precision, changed(precision, name, change))
    bad = [case for case, finding in found.items() if not finding.passed]
    assert bad
    assert all(name in case for case in bad)


def test_lattices_see_1_over_m(precision):
    """Nobody asked for it, and it is no bias of a formula: supports differ."""

    def change(case, out):
        biased = replace(case, settings={**case.settings, "mis": "1/M"})
        return call(BACKENDS[precision], biased)

    found = lattice_findings(precision, changed(precision, "spatial", change))
    assert not found["lattice-spatial"].passed
    assert "-" in found["lattice-spatial"].text


def test_lattices_do_not_care_which_side_of_u_is_taken(precision):
    """1 - u: the replay calls it wrong, the expectation does not."""

    def change(case, out):
        u = {n: 1 - a for n, a in case.inputs.items() if n in ("u", "u_neighbors")}
        return call(BACKENDS[precision], replace(case, inputs={**case.inputs, **u}))

    ask = changed(precision, "temporal", change)
    assert lattice_findings(precision, ask)["lattice-temporal"].passed


def test_the_merge_lattice_counts():
    def change(case, out):
        w_a, w_b, u = (case.inputs[name] for name in ("w_a", "w_b", "u"))
        return out | {"second": (u * w_a < w_b).astype(np.uint32)}

    found = lattice_findings("float32", changed("float32", "merge", change))
    assert "instead of" in found["lattice-merge"].text


# ---------------------------------------------------------------- spheres

SPHERE_MISTAKES = {
    "W without 1/M": (
        "temporal",
        lambda case, out: out | {"W": out["W"] * np.float32(2)},
    ),
    "wrong density": (
        "direction",
        lambda case, out: out | {"pdf": out["pdf"] * np.float32(np.pi)},
    ),
    "albedo twice": (
        "shade",
        lambda case, out: {"color": out["color"] * case.inputs["albedo"]},
    ),
}


def test_spheres_pass_what_is_right(precision):
    for test in (furnace, half_lit):
        assert test(right(precision), precision).text == ""


@pytest.mark.parametrize("name", SPHERE_MISTAKES)
def test_spheres_see_what_is_planted(name):
    pass_name, change = SPHERE_MISTAKES[name]
    ask = changed("float32", pass_name, change)
    assert not furnace(ask, "float32").passed


def test_spheres_see_a_jacobian_that_is_left_out(monkeypatch):
    """In the production pass itself."""

    def one(x_from, x_to, x_sample, n_sample):
        return np.ones(len(x_to), x_to.dtype)

    monkeypatch.setattr(pixels, "reconnection_jacobian", one)
    assert not furnace(right("float32"), "float32").passed


def test_the_half_lit_sphere_counts_misses():
    def change(case, out):
        null = ~case.inputs["new_radiance"].any(axis=1)
        return out | {"M": out["M"] - null.astype(np.float32)}

    ask = changed("float32", "temporal", change)
    assert "misses count" in half_lit(ask, "float32").text


def test_confidences_that_are_wrong_for_another_reason_are_told_as_seen():
    def change(case, out):
        return out | {"M": out["M"] * np.float32(0.75)}

    text = half_lit(changed("float32", "spatial", change), "float32").text
    assert "M is 2.25 instead of 3 in 512 of 512 pixels" in text
    assert "misses" not in text


# ---------------------------------------------------------------- 40 frames


def long_findings(ask, precision="float32"):
    frames = long_run(ask, precision)
    return long_furnace(frames, precision), long_half_lit(frames, precision)


def with_cap(case, out, cap):
    return call(FLOAT32, replace(case, settings={**case.settings, "cap": cap}))


def never_capped(case, out):
    return with_cap(case, out, 1e9)


def capped_twice(case, out):
    past = np.minimum(case.inputs["past_M"], np.float32(4))
    return call(FLOAT32, replace(case, inputs={**case.inputs, "past_M": past}))


def weight_kept(case, out):
    """M is capped, and W stays that of the sum of weights over the capped M."""
    M = with_cap(case, out, 1e9)["M"]
    return out | {"W": out["W"] * M / out["M"]}


def test_long_runs_pass_what_is_right(precision):
    asked = []

    def ask(case):
        asked.append(case.rows)
        return call(BACKENDS[precision], case)

    assert [f.text for f in long_findings(ask, precision)] == ["", ""]
    assert len(asked) <= 160
    assert max(asked) <= 128


@pytest.mark.parametrize("change", [never_capped, capped_twice])
def test_the_furnace_does_not_hang_on_where_m_is_capped(change):
    """And the half-lit sphere does, of which the other is a control."""
    whole, half = long_findings(changed("float32", "temporal", change))
    assert whole.passed
    assert not half.passed


def test_a_weight_that_outlives_its_cap_shows_in_the_long_furnace_alone():
    ask = changed("float32", "temporal", weight_kept)
    assert furnace(ask, "float32").passed
    whole, _ = long_findings(ask)
    assert "frame 8" in whole.text  # the first in which the cap is passed


# ---------------------------------------------------------------- relations


@pytest.fixture(scope="module")
def cases():
    return list(frame_cases(prepare_frame(find_scene("cornell-box"), 16, 1), "float32"))


def all_relations(ask, cases):
    return [test(ask) for case in cases for test in relations_of(case)]


def test_relations_pass_what_is_right(cases):
    found = all_relations(right("float32"), cases)
    assert [f.text for f in found if not f.passed] == []
    assert len(found) > 20


@pytest.mark.parametrize(
    ("pass_name", "change", "words"),
    [
        (
            "initial",
            lambda case, out: {
                **out,
                "W": out["p_hat"] / np.maximum(out["p_hat"], np.float32(1e-4)),
            },
            "light times",
        ),
        (
            "shade",
            lambda case, out: {"color": np.minimum(out["color"], np.float32(1))},
            "light times",
        ),
        (
            "shade",
            lambda case, out: {
                "color": out["color"] * np.float32([1, 1 + 2.0**-20, 1])
            },
            "coloured",
        ),
        (
            "shade",
            lambda case, out: {"color": out["color"] + np.float32(1e-6)},
            "not black",
        ),
        (
            "shade",
            lambda case, out: {
                "color": out["color"] * (case.inputs["position"][:, :1] > 0)
            },
            "in a mirror",
        ),
        (
            "temporal",
            lambda case, out: out | {"W": np.minimum(out["W"], np.float32(4))},
            "W times",
        ),
        (
            "spatial",
            lambda case, out: out | {"M": np.minimum(out["M"], np.float32(20))},
            "confidences times 2",
        ),
        (
            "shade",
            lambda case, out: {
                "color": out["color"] * (out["color"][:, :1] >= out["color"][:, 1:2])
            },
            "hangs on the others",
        ),
        (
            "spatial",
            lambda case, out: out | {"M": out["M"] * (out["W"] > 0)},
            "without light M is 0",
        ),
    ],
    ids=[
        "epsilon",
        "clamp",
        "channels",
        "ambient",
        "one side",
        "cap on W",
        "cap on M",
        "brightest channel",
        "nulls",
    ],
)
def test_relations_see_what_has_a_scale_of_its_own(cases, pass_name, change, words):
    found = all_relations(changed("float32", pass_name, change), cases)
    text = [f.text for f in found if not f.passed]
    assert any(words in line for line in text), text


# ---------------------------------------------------------------- who sees what


def test_a_copy_of_a_sample_is_seen_by_whom_the_sample_is():
    """Here a ray back to a sample fails, at an edge, for the one who made it."""
    found = 0
    for case in frame_cases(
        prepare_frame(find_scene("many-lights"), 48, 639), "float32"
    ):
        if case.pass_name != "spatial":
            continue
        rows, given = np.arange(case.rows), case.inputs
        around = list(given["neighbors"].T)
        samples = [given["position"][np.maximum(row, 0)] for row in [rows, *around]]
        samples.append(given["past_position"])
        for column, viewer in enumerate([rows, *around]):
            words = given["visible"][:, column]
            bits = [
                words >> np.uint32(bit) & np.uint32(1) for bit in range(len(samples))
            ]
            for i, j in combinations(range(len(samples)), 2):
                same = (viewer >= 0) & (samples[i] == samples[j]).all(axis=1)
                found += int(same.sum())
                np.testing.assert_array_equal(bits[i][same], bits[j][same])
    assert found > 100

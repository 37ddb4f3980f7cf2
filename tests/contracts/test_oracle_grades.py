"""Two grades: wrong where scenes are, and wrong beyond them alone."""

from dataclasses import replace

import numpy as np
import pytest

from restir_gi.reference.oracle.builtin.backend import BuiltIn
from restir_gi.reference.oracle.checking import judge
from restir_gi.reference.oracle.levels.kernels import kernel_probes
from restir_gi.reference.oracle.levels.probe import examined
from restir_gi.reference.oracle.levels.rows import row_probes
from restir_gi.reference.oracle.parts import whole_contract
from restir_gi.reference.oracle.working_range import beyond_range, where_beyond

CONTRACT = whole_contract()
Y = np.array([0.2126, 0.7152, 0.0722], np.float32)


class NormalizeFirst:
    """Pass ``target`` as every shader writes it: a unit vector, then dot products."""

    precision = "float32"

    def target(
        self,
        visible_position,
        visible_normal,
        albedo,
        position,
        normal,
        radiance,
        target,
    ):
        """Right in float32."""
        v = position - visible_position
        with np.errstate(all="ignore"):
            omega = v / np.sqrt((v * v).sum(axis=1))[:, None]
            cosine = (visible_normal * omega).sum(axis=1)
            lit = (normal * omega).sum(axis=1) < 0
        color = albedo * radiance if target == "scattered" else radiance
        factor = cosine / np.float32(np.pi) if target == "scattered" else 1
        p_hat = np.where((cosine > 0) & lit, (color * Y).sum(axis=1) * factor, 0)
        return {"p_hat": p_hat.astype(np.float32)}


class NotANumber(NormalizeFirst):
    """The same, where points that touch are not asked for."""

    def target(self, visible_position, position, **buffers):
        """Right, or NaN."""
        found = super().target(
            visible_position=visible_position, position=position, **buffers
        )
        touching = (visible_position == position).all(axis=1)
        return {"p_hat": np.where(touching, np.float32(np.nan), found["p_hat"])}


def test_what_is_wrong_at_extremes_alone_is_told_and_passes():
    verdict = judge(NormalizeFirst(), 60.0, statistics=False)
    assert verdict.status == "PASS"
    assert [f for timed in verdict.steps for f in timed.step.faults] == []
    (line,) = verdict.at_extremes
    assert line == (
        "kernel-target-extremes-outgoing: at extremes alone: p_hat is 0 instead of"
        " 0.3914 where points lie 1.25e-25 m apart, 18 of 714 such rows"
    )


@pytest.mark.parametrize("backend", [NormalizeFirst(), NotANumber()])
def test_it_fails_where_extremes_are_asked_for(backend):
    verdict = judge(backend, 60.0, statistics=False, extremes=True)
    assert verdict.status == "FAIL"


def test_what_is_no_number_beyond_is_told():
    verdict = judge(NotANumber(), 60.0, statistics=False)
    assert verdict.status == "PASS"
    assert any(
        "p_hat is NaN where points lie 0 m apart" in t for t in verdict.at_extremes
    )


@pytest.mark.parametrize("number", [np.nan, np.inf])
def test_what_is_no_number_within_fails(number):
    probe = next(p for p in row_probes("float32") if p.case.pass_name == "moved")
    right = BuiltIn("float32").moved(**probe.case.inputs, **probe.case.settings)
    for rows, passes in ((probe.case.within, False), (~probe.case.within, True)):
        W = right["W"].copy()
        W[np.flatnonzero(rows)[0]] = number
        found = examined(CONTRACT, "float32", probe, right | {"W": W}).finding
        assert found.passed == passes
        assert bool(found.at_extremes) == passes


def test_a_mistake_within_is_no_extreme():
    probe = next(p for p in kernel_probes("float32") if p.case.pass_name == "target")
    right = BuiltIn("float32").target(**probe.case.inputs, **probe.case.settings)
    wrong = {"p_hat": right["p_hat"] * np.float32(1.01)}
    found = examined(CONTRACT, "float32", probe, wrong).finding
    assert not found.passed
    assert found.at_extremes == ""


# ------------------------------------------------ the working range

ROW = {
    "visible_position": [0.0, 0.0, 0.0],
    "visible_normal": [0.0, 1.0, 0.0],
    "albedo": [0.5, 0.5, 0.5],
    "position": [1.0, 1.0, 0.0],
    "normal": [-1.0, 0.0, 0.0],
    "radiance": [1.0, 0.0, 1.0],
    "pdf": 0.5,
}
INSIDE = [
    {},
    {"radiance": [0.0, 0.0, 0.0], "pdf": 0.0},
    {"radiance": [1.01e-7, 0.99e7, 0.0]},
    {"pdf": 1.01e-7},
    {"position": [2e-6, 2e-6, 0.0]},
    {"position": [7e5, 7e5, 0.0]},
    {"visible_position": [1.0, 0.0, 0.0], "position": [1.0, 1.1e-6, 0.0]},
    {"position": [1.0, 0.0, 0.0]},  # edge-on, to the last bit
    {"position": [1.0, 1.01e-4, 0.0]},
]
OUTSIDE = [
    ({"radiance": [1.0, 0.99e-7, 1.0]}, "a radiance is 9.9e-08"),
    ({"radiance": [1.0, 1.01e7, 1.0]}, "a radiance is 1.01e+07"),
    ({"pdf": 0.99e-7}, "a density is 9.9e-08"),
    ({"position": [0.0, 0.9e-6, 0.0]}, "points lie 9e-07 m apart"),
    ({"position": [0.0, 1.1e6, 0.0]}, "points lie 1.1e+06 m apart"),
    (
        {"visible_position": [90.0, 0.0, 0.0], "position": [90.0, 5e-5, 0.0]},
        "points lie 5e-05 m apart",
    ),
    ({"position": [1.0, 0.9e-4, 0.0]}, "a cosine is 9e-05"),
    ({"normal": [0.0, 0.0, 0.0]}, "a normal has length 0"),
]


def given(changes):
    return {n: np.array([v], float) for n, v in {**ROW, **changes}.items()}


@pytest.mark.parametrize("changes", INSIDE)
def test_rows_of_scenes_are_within(changes):
    assert beyond_range(CONTRACT["initial"], given(changes)) is None


@pytest.mark.parametrize(("changes", "words"), OUTSIDE)
def test_rows_of_no_scene_are_beyond(changes, words):
    inputs = given(changes)
    assert beyond_range(CONTRACT["initial"], inputs).tolist() == [True]
    assert where_beyond(CONTRACT["initial"], inputs, 0) == words


def test_who_reuses_what_is_beyond_is_beyond():
    probe = next(p for p in row_probes("float32") if p.case.pass_name == "spatial")
    inputs = dict(probe.case.inputs)
    radiance = inputs["radiance"].copy()
    row = int(np.flatnonzero(probe.case.within)[0])
    radiance[row] = 1e30
    beyond = beyond_range(CONTRACT["spatial"], {**inputs, "radiance": radiance})
    users = (inputs["neighbors"] == row).any(axis=1)
    users[row] = True
    assert (beyond == (probe.case.beyond | users)).all()


def test_most_rows_of_the_ladder_are_within():
    for probe in (*kernel_probes("float32"), *row_probes("float32")):
        designed = {"extremes", "worst"} & set(probe.case.name.split("-"))
        assert designed or probe.case.within.mean() > 0.6


# ------------------------------------------------ what nobody looks at


class LessOrEqual:
    """Pass ``merge`` that keeps the second of two that have no weight."""

    precision = "float32"

    def merge(self, w_a, M_a, w_b, M_b, u):
        """Right, but for weights of 0."""
        second = (u * (w_a + w_b) < w_b) | (w_a == 0)
        second |= self.more(w_a, w_b, u)
        return {"second": second.astype("u4"), "w": w_a + w_b, "M": M_a + M_b}

    def more(self, w_a, w_b, u):
        """What else is kept."""
        return False


class Harmful(LessOrEqual):
    """One that keeps a weight of 0 beside another, where u is 0."""

    def more(self, w_a, w_b, u):
        """What else is kept."""
        return (u == 0) & (w_b == 0)


def test_of_two_without_weight_any_may_be_kept():
    assert judge(LessOrEqual(), 60.0, statistics=False).status == "PASS"


def test_a_weight_of_0_beside_another_is_never_kept():
    assert judge(Harmful(), 60.0, statistics=False).status == "FAIL"


class InverseDensity:
    """Pass ``initial`` with W = 1 / pdf for nulls, or for all that is dark."""

    precision = "float32"

    def __init__(self, which):
        self.which = which

    def initial(self, pdf, radiance, **buffers):
        """Right where p̂ is above 0."""
        right = BuiltIn("float32").initial(pdf=pdf, radiance=radiance, **buffers)
        dark = right["p_hat"] == 0
        if self.which == "nulls":
            dark &= ~radiance.any(axis=1)
        inverse = np.divide(1, pdf, out=np.zeros_like(pdf), where=pdf > 0)
        return right | {"W": np.where(dark, inverse, right["W"])}


@pytest.mark.parametrize(("which", "status"), [("nulls", "PASS"), ("dark", "FAIL")])
def test_the_weight_of_a_null_is_not_looked_at(which, status):
    """Another receiver may reflect what a black surface does not."""
    assert judge(InverseDensity(which), 60.0, statistics=False).status == status


@pytest.mark.parametrize("pass_name", ["temporal", "moved", "spatial"])
def test_the_weight_of_a_null_changes_nothing(pass_name):
    """Whatever it is, nothing of what is kept hangs on it."""
    for probe in row_probes("float32"):
        if probe.case.pass_name != pass_name:
            continue
        inputs = dict(probe.case.inputs)
        for prefix in ("", "past_"):
            if prefix + "W" in inputs:
                null = ~inputs[prefix + "radiance"].any(axis=1)
                W = inputs[prefix + "W"]
                inputs[prefix + "W"] = np.where(null & (W > 0), W * 8, W)
        backend = getattr(BuiltIn("float32"), pass_name)
        one, two = (
            backend(**case.inputs, **case.settings)
            for case in (probe.case, replace(probe.case, inputs=inputs))
        )
        for name in one:
            assert np.array_equal(one[name], two[name])

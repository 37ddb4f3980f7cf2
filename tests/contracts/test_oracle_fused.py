"""Pass ``fused``: right code of another hand passes, and mistakes fail by their names.

The renderer here is written from the contract's page alone, in single precision, all
reservoirs of a pixel at once: arrays (N, K + 1), in which column 0 is the pixel's own.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest

from restir_gi.reference.oracle.builtin.backend import BuiltIn
from restir_gi.reference.oracle.checking import judge
from restir_gi.reference.oracle.declaration.read import read_declaration
from restir_gi.reference.oracle.diagnosis.diagnose import diagnose
from restir_gi.reference.oracle.levels.enumeration import enumerations
from restir_gi.reference.oracle.levels.probe import examined
from restir_gi.reference.oracle.levels.rows import row_probes
from restir_gi.reference.oracle.parts import whole_contract
from restir_gi.reference.oracle.verdict import departs

CONTRACT = whole_contract()
F = np.float32
LUMINANCE = np.array([0.2126, 0.7152, 0.0722], F)
PI = F(np.pi)
SAMPLE = ("position", "normal", "radiance")


def dot(a, b):
    """Of vectors in the last axis."""
    return (a * b).sum(axis=-1)


def over(a, b):
    """A quotient, 0 where the divisor is."""
    return np.divide(
        a, b, out=np.zeros(np.broadcast_shapes(a.shape, b.shape), F), where=b != 0
    )


def p_hat(kind, x, y):
    """Target of samples y at points x, which are broadcast."""
    v = y["position"] - x["position"]
    w = v * over(F(1), np.sqrt(dot(v, v)))[..., None]
    cosine = dot(x["normal"], w)
    light = dot(y["radiance"], LUMINANCE)
    if kind == "scattered":
        light = dot(x["albedo"] * y["radiance"], LUMINANCE) * cosine / PI
    return np.where((cosine > 0) & (dot(y["normal"], w) < 0), light, F(0))


def jacobian(x_from, x_to, y):
    """Equation 11."""
    a, b = (x["position"] - y["position"] for x in (x_from, x_to))
    aa, bb = dot(a, a), dot(b, b)
    cosines = over(
        abs(dot(y["normal"], b)) * np.sqrt(aa), abs(dot(y["normal"], a)) * np.sqrt(bb)
    )
    return np.where(cosines > 0, cosines * over(aa, bb), F(0))


@dataclass
class Fused:
    """A renderer of one pass; the words are what it does otherwise.

    Attributes
    ----------
    mistake : str; empty for a right one
    order : str; 'own-last', or as the contract has it
    cap_first : bool; M of all is capped as it arrives, and not when it is stored
    """

    mistake: str = ""
    order: str = ""
    cap_first: bool = False
    declaration: object = None
    precision: str = "float32"

    def fused(self, sources, visible, u, target, cap, mis, **given):
        """The pass."""
        with np.errstate(all="ignore"):
            return self._fused(sources, visible, u, target, F(cap), mis, given)

    def _fused(self, sources, visible, u, target, cap, mis, given):
        there, row = sources >= 0, np.maximum(sources, 0)
        K = sources.shape[1]

        def column(name, past=None):
            own = given[name][:, None]
            return np.concatenate([own, given[past or f"past_{name}"][row]], axis=1)

        y = {name: column(name) for name in SAMPLE}
        points = ("visible_position", "visible_normal", "albedo")
        if self.mistake == "G-buffer of this frame":
            x = [column(name, name) for name in points]
        else:
            x = [column(name) for name in points]
        x = dict(zip(("position", "normal", "albedo"), x, strict=True))
        here = {name: a[:, :1] for name, a in x.items()}
        everyone = np.concatenate([np.ones_like(there[:, :1]), there], axis=1)
        W, M = (np.where(everyone, column(name), F(0)) for name in ("W", "M"))
        if self.cap_first:
            M = np.minimum(M, cap)
        bit = (visible[:, :, None] >> np.arange(K + 1, dtype=np.uint32)) & 1 == 1
        sees = bit[:, 0].copy()
        sees[:, 0] = True
        if self.mistake == "no visibility in the weight":
            sees[:] = True
        J = jacobian(x, here, y)
        J[:, 0] = 1
        if self.mistake == "history without Jacobian":
            J[:, 1] = 1
        if self.mistake == "no Jacobian":
            J[:] = 1
        p = p_hat(target, here, y)
        w = np.where(sees & (W > 0), p * W * M * J, F(0))
        order = [*range(1, K + 1), 0] if self.order else range(K + 1)
        kept = np.full(len(w), order[0])
        total = w[:, order[0]]
        for k in list(order)[1:]:
            total = total + w[:, k]
            number = u[:, k - 1] if k else u[:, 0]
            taken = (number * total < w[:, k]) & (w[:, k] > 0)
            kept = np.where(taken, k, kept)
        rows = np.arange(len(kept))
        found = {name: a[rows, kept] for name, a in y.items()}
        one = {name: a[rows, kept][:, None] for name, a in y.items()}
        holds = (p_hat(target, x, one) > 0) & bit[rows, :, kept] & everyone
        if self.mistake == "Z knows no visibility":
            holds = (p_hat(target, x, one) > 0) & everyone
        holds[:, 0] = True
        holds[rows, kept] = True
        counted = M.copy()
        if self.mistake == "own does not count" and mis == "1/Z":
            counted[:, 0] = 0
        Z = (counted * (holds | (mis == "1/M"))).sum(axis=1, dtype=F)
        found["W"] = over(total, p[rows, kept] * Z)
        found["M"] = M.sum(axis=1, dtype=F)
        if not self.cap_first:
            found["M"] = np.minimum(found["M"], cap)
        return {name: a.astype(F) for name, a in found.items()}


def verdict_on(backend):
    return judge(backend, 600, statistics=False)


@cache
def probes():
    """Designed rows of the pass."""
    return [p for p in row_probes("float32") if p.case.pass_name == "fused"]


def answers(backend):
    """To designed rows, each examined."""
    return [
        examined(
            CONTRACT, "float32", p, backend.fused(**p.case.inputs, **p.case.settings)
        )
        for p in probes()
    ]


def names_of(diagnosis):
    """Names of all sets that explain a pass."""
    return {h.name for one in diagnosis.explanations for h in one.hypotheses}


def test_right_code_of_another_hand_is_right():
    found = [a.finding for a in answers(Fused())]
    assert [f.text for f in found if not f.passed or f.at_extremes] == []


@pytest.mark.slow
def test_a_right_renderer_of_this_pass_alone_passes():
    verdict = verdict_on(Fused())
    assert verdict.status == "PASS", [f for t in verdict.steps for f in t.step.faults]
    assert verdict.judged == {"fused"}
    assert verdict.at_extremes == []


MISTAKES = {
    "no Jacobian": "jacobian-omitted",
    "G-buffer of this frame": "sources-of-this-frame",
    "no visibility in the weight": "visibility-missing-in-weight",
    "Z knows no visibility": "visibility-missing-in-z",
    "own does not count": "canonical-missing-in-z",
    "history without Jacobian": "",
}


QUICK = ("no Jacobian", "G-buffer of this frame", "no visibility in the weight")


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_wrong(mistake):
    assert not all(a.finding.passed for a in answers(Fused(mistake)))


@pytest.mark.parametrize(
    "mistake",
    [
        pytest.param(one, marks=() if one in QUICK else pytest.mark.slow)
        for one, name in MISTAKES.items()
        if name
    ],
)
def test_a_mistake_is_named(mistake):
    diagnosis = diagnose("fused", answers(Fused(mistake)), "float32")
    assert not departs(diagnosis)
    assert MISTAKES[mistake] in names_of(diagnosis)


@pytest.mark.slow
@pytest.mark.parametrize("mistake", MISTAKES)
def test_the_verdict_on_a_mistake(mistake):
    assert verdict_on(Fused(mistake)).status == "FAIL"


@pytest.mark.slow
def test_what_it_departs_in_passes_and_is_named():
    verdict = verdict_on(Fused(order="own-last", cap_first=True))
    assert verdict.status == "PASS", [f for t in verdict.steps for f in t.step.faults]
    (diagnosis,) = verdict.departures
    assert {"own-last", "capped-everywhere-on-arrival"} <= names_of(diagnosis)


def declaration(**choices):
    """A table for this pass alone."""
    return {"schema": "restir-declaration 1", "choices": {"fused": choices}}


DEPARTS = declaration(order="own-last", cap="on arrival, neighbors too")


def test_a_declaration_has_a_table_for_it():
    assert {h.passes for h in read_declaration(DEPARTS).hypotheses} == {("fused",)}


@pytest.mark.slow
def test_what_is_declared_is_followed():
    backend = Fused(order="own-last", cap_first=True, declaration=DEPARTS)
    verdict = verdict_on(backend)
    assert verdict.status == "PASS"
    assert [one.state for one in verdict.followed] == ["followed"]


@pytest.mark.slow
def test_what_is_the_same_where_there_is_no_past_is_not_held_against_it():
    """``order = "own-first"`` is what the pass does anyway."""
    said = {"schema": "restir-declaration 1", "choices": {"order": "own-first"}}
    verdict = verdict_on(Fused(declaration=said))
    assert verdict.status == "PASS"
    assert {one.state for one in verdict.followed} <= {"not shown"}


def test_who_does_not_have_it_is_not_asked():
    class Initial:
        precision = "float32"

        def initial(self, **given):
            return BuiltIn("float32").initial(**given)

    assert verdict_on(Initial()).judged == {"initial"}


# ---------------------------------------------------------------- what is asked


def test_a_past_of_its_own_stands_behind_each_source():
    """Points of the past are others, but for some; and each row reads several."""
    for probe in probes():
        i = probe.case.inputs
        same = (i["visible_position"] == i["past_visible_position"]).all(axis=1)
        assert 0.02 < same.mean() < 0.2
        assert (i["sources"] == np.arange(len(same))[:, None]).any()
        assert (i["sources"] < 0).any()


def test_expectations_are_exact_for_both_weights():
    found = [e for e in enumerations() if e.pass_name == "fused"]
    assert len(found) == 4
    assert {e.settings["mis"] for e in found} == {"1/Z", "1/M"}
    assert all(e.decisions == 2 for e in found)

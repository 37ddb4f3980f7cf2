"""Layouts of reservoirs that have to be declared: asked, judged, and their mistakes.

The other backend calculates in its own type and in a shader's order.  Nothing here is
by chance: where rounding leaves a code open, either is right.
"""

from dataclasses import dataclass, field
from functools import cache

import numpy as np
import pytest

from restir_gi.reference.oracle.backends.selected import Selection
from restir_gi.reference.oracle.builtin.backend import FLOAT32
from restir_gi.reference.oracle.builtin.further import FURTHER
from restir_gi.reference.oracle.cases import pass_of
from restir_gi.reference.oracle.checking import judge
from restir_gi.reference.oracle.contract.fields import dtype_of
from restir_gi.reference.oracle.contract.packing import LAYOUT, LAYOUTS
from restir_gi.reference.oracle.diagnosis.at_fault import at_fault
from restir_gi.reference.oracle.diagnosis.diagnose import diagnose
from restir_gi.reference.oracle.diagnosis.further_layouts import LAYOUT_MISTAKES
from restir_gi.reference.oracle.diagnosis.terms import (
    first_wrong_place,
    first_wrong_term,
)
from restir_gi.reference.oracle.golden import expected, write_golden
from restir_gi.reference.oracle.levels.further import declared_cases, further_cases
from restir_gi.reference.oracle.levels.probe import examined
from restir_gi.reference.oracle.levels.replayed import replayed
from restir_gi.reference.oracle.parts import whole_contract
from restir_gi.reference.oracle.raw import read_cases, read_outputs
from restir_gi.reference.oracle.replay.further.judges import FURTHER_JUDGES
from restir_gi.reference.oracle.replay.rules import CONTRACT_RULES
from restir_gi.reference.resampling.packing.log_luv import RGB_TO_XYZ
from tests.contracts.other_layouts import TO_XYZ, pack_layout, unpack_layout

CONTRACT = whole_contract()
OTHERS = {"pack": pack_layout, "unpack": unpack_layout}
DECLARED = LAYOUT.more
PAIRS = [(name, layout) for name in OTHERS for layout in DECLARED]

EVERYTHING = frozenset(("pack", "layout", layout) for layout in DECLARED) | frozenset(
    ("unpack", "layout", layout) for layout in DECLARED
)

both_precisions = pytest.mark.parametrize("precision", ["float32", "float64"])
every_layout = pytest.mark.parametrize(("name", "layout"), PAIRS)


@cache
def cases(precision, name, layout):
    """Cases of a pass in one layout."""
    every = (*further_cases(precision), *declared_cases(precision))
    found = [c for c in every if c.pass_name == name]
    return [c for c in found if c.settings.get("layout", "paper") == layout]


def typed(precision, case, raw):
    """Outputs in the types of the contract."""
    fields = pass_of(CONTRACT, case).outputs
    return {
        f.name: np.ascontiguousarray(raw[f.name], dtype_of(f.kind, precision))
        for f in fields
    }


def by_the_other(precision, mistake=None):
    """Answers of the other backend, perhaps with a mistake."""
    real = {"float32": np.float32, "float64": np.float64}[precision]

    def answer(case):
        with np.errstate(all="ignore"):
            other = OTHERS[case.pass_name]
            raw = other(real, mistake, **case.inputs, **case.settings)
        return typed(precision, case, raw)

    return answer


def answered(precision, name, layouts, answer):
    return [
        examined(CONTRACT, precision, replayed("L0", case), answer(case))
        for layout in layouts
        for case in cases(precision, name, layout)
    ]


def named(precision, name, answers):
    """Whether anything is wrong, and which mistakes explain it."""
    shows = not all(a.finding.passed for a in answers)
    wrong = [a for group in at_fault(name, answers) for a in group]
    return shows, [h.name for h in diagnose(name, wrong, precision).matches]


# ------------------------------------------------ who is right passes


@both_precisions
@every_layout
def test_the_production_code_passes(precision, name, layout):
    def answer(case):
        return FURTHER[name](precision, **case.inputs, **case.settings)

    found = answered(precision, name, [layout], answer)
    assert len(found) >= 2
    assert all(a.finding.passed for a in found)


@both_precisions
@every_layout
def test_another_order_of_operations_passes(precision, name, layout):
    found = answered(precision, name, [layout], by_the_other(precision))
    assert [a.finding.text for a in found if not a.finding.passed] == []


def test_the_other_matrix_is_that_of_the_formula():
    """Made from primaries in another way."""
    np.testing.assert_allclose(TO_XYZ, RGB_TO_XYZ, rtol=1e-12)


def test_levels_at_edges_of_cells_are_open():
    """There the float32 backend writes other codes than ours, and is not accused."""
    (case,) = (c for c in cases("float32", "pack", "rtxdi") if "edges" in c.name)
    ours = FURTHER["pack"]("float32", **case.inputs, **case.settings)["words"][:, 4]
    theirs = by_the_other("float32")(case)["words"][:, 4]
    level = (ours >> np.uint32(18)).astype(int) - (theirs >> np.uint32(18)).astype(int)
    assert (abs(level) == 1).sum() >= 20
    assert abs(level).max() == 1
    black = (ours == 0) != (theirs == 0)
    assert black.any()


def test_most_codes_are_not_open():
    """Else any code would pass."""
    for case in cases("float32", "pack", "rtxdi"):
        lit = case.inputs["radiance"].any(axis=1)
        out = FURTHER["pack"]("float32", **case.inputs, **case.settings)
        found = FURTHER_JUDGES["pack"](case, out, CONTRACT_RULES, "float32").compared
        cells = [c for c in found if "of radiance" in c.name]
        assert len(cells) == 3
        most = 0.4 if "edges" in case.name else 0.05
        for cell in cells:
            assert (cell.allowed[lit] > 0).mean() < most
            assert (cell.allowed[lit & (out["words"][:, 4] > 0)] <= 0.5).all()


@every_layout
def test_cases_have_the_buffers_of_their_layout(name, layout):
    for precision in ("float32", "float64"):
        for case in cases(precision, name, layout):
            asked = pass_of(CONTRACT, case)
            assert dict(case.settings) == {"layout": layout}
            assert set(case.inputs) == {f.name for f in asked.inputs}
            for one in asked.inputs:
                array = case.inputs[one.name]
                assert array.shape == (case.rows, *one.columns)
                assert array.dtype == dtype_of(one.kind, precision)


def test_buffers_differ_with_the_layout():
    """Nothing of the visible point in RTXDI's; an age in all but the paper's."""
    names = {
        layout: {f.name for f in CONTRACT["pack"].given_with({"layout": layout}).inputs}
        for layout in LAYOUTS
    }
    assert {n for n in LAYOUTS if "visible_normal" in names[n]} == {
        "paper",
        "restir_pt",
    }
    assert {n for n in LAYOUTS if "age" in names[n]} == {*DECLARED}
    assert {n for n in LAYOUTS if "misc" in names[n]} == {"rtxdi"}
    assert CONTRACT["pack"].given_with({}) == CONTRACT["pack"].given_with(
        {"layout": "paper"}
    )
    words = {
        layout: CONTRACT["pack"].given_with({"layout": layout}).outputs
        for layout in LAYOUTS
    }
    sizes = {layout: [f.columns for f in found] for layout, found in words.items()}
    assert sizes == {
        "paper": [(12,)],
        "restir_pt": [(12,)],
        "rtxdi": [(8,)],
        "rtxdi_path": [(16,)],
    }


# ------------------------------------------------ mistakes

SHARED = {
    "pack": {
        "not folded": "octahedron-not-folded",
        "not divided": "octahedron-not-divided",
        "sign of 0 is 0": "sign-of-0-is-0",
        "normals truncated": "pack-normals-toward-0",
        "v first": "v-before-u",
        "sign extended": "pack-sign-runs-over",
        "by 32768": "octahedron-by-32768",
    },
    "unpack": {
        "not folded": "octahedron-not-folded",
        "not normalized": "unpack-not-normalized",
        "by 32768": "octahedron-by-32768",
    },
}
"""Of all layouts with octahedral normals."""

OF_48_BYTES = {
    "infinite halves": "pack-halves-overflow",
    "halves truncated": "pack-halves-toward-0",
    "M wraps around": "pack-m-wraps",
    "age before W": "seed-before-w",
}

PLACES_OF_RTXDI = {
    "age below M": "rtxdi-m-and-age-exchanged",
    "misc below": "rtxdi-misc-below",
    "W before radiance": "rtxdi-w-before-radiance",
    "normal last": "rtxdi-normal-last",
    "natural logarithm": "log-luv-natural",
    "v′ above u′": "log-luv-v-first",
}
PLACES_OF_PATH = {
    "M below z": "rtxdi-path-m-below-z",
    "density first": "rtxdi-path-density-before-jacobian",
    "target before radiance": "rtxdi-path-target-before-radiance",
    "lengths exchanged": "rtxdi-path-lengths-exchanged",
    "age above": "rtxdi-path-age-above",
    "flag above the age": "rtxdi-path-boosts-in-bit-5",
    "components with a sign": "rtxdi-path-normal-with-sign",
    "M is a count": "rtxdi-path-m-is-a-count",
    "no light": "rtxdi-path-light-not-marked",
}

THE_SAME = {
    ("pack", "restir_pt"): SHARED["pack"] | OF_48_BYTES,
    ("unpack", "restir_pt"): SHARED["unpack"] | {"age before W": "seed-before-w"},
    ("pack", "rtxdi"): SHARED["pack"]
    | PLACES_OF_RTXDI
    | {
        "M runs over": "rtxdi-m-runs-over",
        "M wraps": "rtxdi-m-wraps",
        "age runs over": "rtxdi-age-runs-over",
        "age wraps": "rtxdi-age-wraps",
        "no misc": "rtxdi-misc-left-out",
        "cells rounded": "log-luv-rounded",
    },
    ("unpack", "rtxdi"): SHARED["unpack"]
    | PLACES_OF_RTXDI
    | {"no half": "log-luv-without-half", "channels below 0": "log-luv-negative"},
    ("pack", "rtxdi_path"): PLACES_OF_PATH
    | {
        "age runs over": "rtxdi-path-age-runs-over",
        "age stops": "rtxdi-path-age-stops",
        "components cut": "rtxdi-path-normals-cut",
        "M overflows": "rtxdi-path-m-overflows",
    },
    ("unpack", "rtxdi_path"): PLACES_OF_PATH
    | {
        "age not masked": "rtxdi-path-age-not-masked",
        "not normalized": "rtxdi-path-normals-not-normalized",
    },
}
"""Mistakes of the other backend, and what they are called."""

NAMED = [
    (name, layout, mistake, called)
    for (name, layout), of in THE_SAME.items()
    for mistake, called in of.items()
]


@cache
def right_beside(precision, name):
    """Answers in the layout of the paper."""
    return answered(precision, name, ["paper"], by_the_other(precision))


@pytest.mark.parametrize(
    "precision", ["float32", pytest.param("float64", marks=pytest.mark.slow)]
)
@pytest.mark.parametrize(("name", "layout", "mistake", "called"), NAMED)
def test_a_mistake_is_called_by_its_name(precision, name, layout, mistake, called):
    """Beside a layout that is right, in which the same mistake would show, too."""
    wrong = answered(precision, name, [layout], by_the_other(precision, mistake))
    beside = [*right_beside(precision, name), *wrong]
    assert named(precision, name, beside) == (True, [called])


def test_control_answers_to_a_layout_that_is_right_would_hide_the_name():
    wrong = by_the_other("float32", "normals truncated")
    found = [*right_beside("float32", "pack")]
    found += answered("float32", "pack", ["rtxdi"], wrong)
    assert diagnose("pack", found, "float32").matches == ()


def test_every_mistake_of_a_layout_is_planted():
    planted = {(name, called) for name, _, _, called in NAMED}
    assert {(name, h.name) for h in LAYOUT_MISTAKES for name in h.passes} <= planted


def test_a_mistake_in_every_layout_is_one():
    answer = by_the_other("float32", "normals truncated")
    found = answered("float32", "pack", ("paper", "restir_pt", "rtxdi"), answer)
    assert named("float32", "pack", found) == (True, ["pack-normals-toward-0"])


def test_two_mistakes_in_two_layouts_have_no_name():
    found = answered("float32", "pack", ["rtxdi"], by_the_other("float32", "M wraps"))
    cut = by_the_other("float32", "components cut")
    found += answered("float32", "pack", ["rtxdi_path"], cut)
    assert named("float32", "pack", found) == (True, [])


@every_layout
def test_what_is_right_has_no_name(name, layout):
    found = answered("float32", name, [layout], by_the_other("float32"))
    assert named("float32", name, found) == (False, [])


def test_a_mistake_that_nobody_knows_is_found_and_placed():
    answer = by_the_other("float32", "level of 410 steps")
    found = answered("float32", "pack", ["rtxdi"], answer)
    assert named("float32", "pack", found) == (True, [])
    term = first_wrong_term(found, "float32")
    text = term.sentence if term else first_wrong_place(found, "float32")
    assert "words: L of radiance" in text


# ------------------------------------------------ whole checks


@dataclass(frozen=True)
class OtherBackend:
    """The other backend; it remembers what it was asked."""

    mistake: str | None = None
    asked: list = field(default_factory=list)

    def pack(self, layout="paper", **buffers):
        """The pass in any layout."""
        self.asked.append((layout, *sorted(buffers)))
        with np.errstate(all="ignore"):
            return typed_of("pack", layout, pack_layout, self.mistake, buffers)

    def unpack(self, words, layout="paper"):
        """The pass in any layout."""
        self.asked.append((layout, words.shape[1]))
        with np.errstate(all="ignore"):
            mistake = self.mistake
            return typed_of("unpack", layout, unpack_layout, mistake, {"words": words})


def typed_of(name, layout, own, mistake, buffers):
    raw = own(np.float32, mistake, layout=layout, **buffers)
    fields = CONTRACT[name].given_with({"layout": layout}).outputs
    return {
        f.name: np.ascontiguousarray(raw[f.name], dtype_of(f.kind, "float32"))
        for f in fields
    }


def checked(mistake=None, more=frozenset()):
    """Verdict, and the layouts that were asked, in their order."""
    backend = OtherBackend(mistake)
    selection = Selection(more=more)
    verdict = judge(backend, 60, statistics=False, selection=selection)
    return verdict, list(dict.fromkeys(layout for layout, *_ in backend.asked))


def test_who_declares_nothing_is_asked_for_the_paper_alone():
    verdict, layouts = checked()
    assert (verdict.status, layouts) == ("PASS", ["paper"])


def test_who_declares_one_is_asked_for_it_in_that_pass_alone():
    verdict, layouts = checked(more=frozenset([("pack", "layout", "rtxdi")]))
    assert (verdict.status, layouts) == ("PASS", ["paper", "rtxdi"])


def test_who_declares_all_is_asked_for_all():
    verdict, layouts = checked(more=EVERYTHING)
    assert verdict.status == "PASS"
    assert layouts == list(LAYOUTS)


def test_who_has_no_other_layout_is_asked_for_its_own_alone():
    """By a declaration: what a renderer of RTXDI has."""
    backend = OtherBackend()
    has = {"schema": "restir-declaration 1", "has": {"layout": ["rtxdi"]}}
    verdict = judge(backend, 60, statistics=False, declaration=has)
    assert verdict.status == "PASS"
    assert {layout for layout, *_ in backend.asked} == {"rtxdi"}


def test_a_check_names_the_mistake_of_one_layout():
    verdict, _ = checked("M runs over", more=EVERYTHING)
    assert verdict.status == "FAIL"
    (found,) = verdict.diagnoses
    assert [h.name for h in found.matches] == ["rtxdi-m-runs-over"]


def test_the_calls_of_who_declares_nothing_are_those_of_the_cases():
    """The same buffers, in the same order, and no setting more."""
    backend = OtherBackend()
    judge(backend, 60, statistics=False)
    given = [c for name in OTHERS for c in cases("float32", name, "paper")]
    assert len(backend.asked) == len(given)
    assert all(dict(c.settings) == {} for c in given)


def test_cases_of_layouts_go_through_files(tmp_path):
    """Written for a program, and read again: shapes are those of the layout."""
    probes = [replayed("L0", case) for case in declared_cases("float32")]
    write_golden(tmp_path, CONTRACT, "float32", probes, {}, lambda *_: None)
    for case in read_cases(tmp_path)[1]:
        right = expected(case, "float32")
        folder = tmp_path / case.name / "out"
        for name, array in right.items():
            (folder / f"{name}.raw").write_bytes(array.tobytes())
        found = read_outputs(tmp_path, CONTRACT, "float32", case)
        assert set(found) == set(right)
        for name, array in right.items():
            np.testing.assert_array_equal(found[name], array)


def test_the_built_in_backend_takes_the_layout_by_its_name():
    (case, *_) = cases("float32", "pack", "rtxdi_path")
    assert FLOAT32.pack(**case.inputs, **case.settings)["words"].shape[1] == 16

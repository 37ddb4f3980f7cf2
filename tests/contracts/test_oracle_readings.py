"""What would be right if something else had been read, or rounded: true, or not said.

The mistakes are those of the port, which were planted before anything told of them; and
inputs that are exchanged here.
"""

from dataclasses import replace

import numpy as np
import pytest

from restir_gi.reference.oracle.builtin.backend import BuiltIn
from restir_gi.reference.oracle.cases import with_numbers
from restir_gi.reference.oracle.diagnosis.naming.landings import misplaced
from restir_gi.reference.oracle.diagnosis.naming.misreadings import misread
from restir_gi.reference.oracle.diagnosis.subsets import whole
from restir_gi.reference.oracle.diagnosis.terms import (
    first_wrong_place,
    first_wrong_term,
)
from restir_gi.reference.oracle.levels.kernels import kernel_probes
from restir_gi.reference.oracle.levels.probe import examined
from restir_gi.reference.oracle.levels.rows import row_probes
from restir_gi.reference.oracle.parts import parts, whole_contract
from tests.mutants import blind
from tests.mutants.blind_port import Port

CONTRACT = whole_contract()
PRECISION = "float32"


@pytest.fixture(scope="module")
def probes():
    found = [*kernel_probes(PRECISION), *row_probes(PRECISION)]
    for part in parts():
        found += [p for p in part.probes(PRECISION) if p.level == "L0"]
    return found


def answered(probes, pass_name, answer):
    """Answers to the designed rows of a pass: a function of the case gives them."""
    chosen = [p for p in probes if p.case.pass_name == pass_name]
    return [examined(CONTRACT, PRECISION, p, answer(p.case)) for p in chosen]


def by(backend):
    """Answers of a backend."""
    return lambda case: getattr(backend, case.pass_name)(**case.inputs, **case.settings)


def reading(case, **inputs):
    """Right answers, where other inputs are read."""
    changed = {name: change(case.inputs) for name, change in inputs.items()}
    return by(Port())(replace(case, inputs={**case.inputs, **changed}))


def given(answers):
    return [whole(a.probe.case, a.outputs) for a in answers]


SAID = [
    ("WordsDividedByTheirRange", "random", "its word times 2^-32"),
    ("DegreesTakenForRadians", "similar", "max_angle were 180/π times as large"),
    ("DegreesTakenForRadians", "neighbors", "max_angle were 180/π times as large"),
    ("DegreesTakenForRadians", "reproject", "max_angle were 180/π times as large"),
    ("PastSeenFromThePast", "moved", "column 0 of visible were column 1"),
    ("DomainWithTheNormalOfNow", "moved", "past_visible_normal were visible_normal"),
    ("OffsetsAreCutOff", "neighbors", "offsets were rounded toward 0"),
    ("NeighboursAroundTheEdge", "neighbors", "lines went on into the next"),
    ("RadiusFallsBelowItsLeast", "neighbors", "the radius fell below its least"),
    ("MissingNeighbourIsTheLastRow", "spatial", "−1 in neighbors were the last row"),
    (
        "NeighbourSeenByTheBitBefore",
        "spatial",
        "each bit of column 0 of visible were the one below it",
    ),
    (
        "BitsInTheOrderOfTheStream",
        "spatial",
        "each bit of the columns of visible after the first were the one above it",
    ),
    (
        "NormalOfTheOwnSample",
        "spatial",
        "right times J with the normal of the pixel's own sample / J",
    ),
    (
        "OwnAndFirstNeighbourShareANumber",
        "spatial",
        "u_own were column 0 of u_neighbors",
    ),
    ("NearestPixelCorner", "reproject", "places were rounded to the nearest, not down"),
    ("ReprojectionIgnoresDepth", "reproject", "max_depth were without limit"),
]


@pytest.mark.parametrize(("mistake", "pass_name", "words"), SAID)
@pytest.mark.few(6)
def test_what_was_read_or_rounded_otherwise_is_told(probes, mistake, pass_name, words):
    answers = answered(probes, pass_name, by(getattr(blind, mistake)()))
    told = first_wrong_term(answers, PRECISION)
    assert words in told.sentence
    assert told.share >= 0.9


@pytest.mark.parametrize("pass_name", ["pack", "unpack"])
def test_where_a_term_is_wrong_is_told_though_not_how(probes, pass_name):
    answers = answered(probes, pass_name, by(blind.FoldUsesWhatItHasChanged()))
    assert first_wrong_term(answers, PRECISION) is None
    said = first_wrong_place(answers, PRECISION)
    assert "visible_normal, in " in said
    assert said.endswith("rows where z of visible_normal is below 0, nowhere else")


EXCHANGED = {
    "past_albedo were albedo": {"past_albedo": lambda i: i["albedo"]},
    "past_W were that of the row before": {"past_W": lambda i: np.roll(i["past_W"], 1)},
}


@pytest.mark.parametrize("text", EXCHANGED)
def test_a_buffer_or_row_that_was_exchanged_is_told(probes, text):
    answers = answered(probes, "moved", lambda case: reading(case, **EXCHANGED[text]))
    assert text in misread(given(answers), PRECISION).text


def test_two_inputs_that_were_exchanged_are_not_one(probes):
    answers = answered(
        probes,
        "moved",
        lambda case: reading(
            case,
            new_pdf=lambda i: np.roll(i["new_pdf"], 1),
            past_W=lambda i: np.roll(i["past_W"], 1),
        ),
    )
    assert misread(given(answers), PRECISION) is None


def test_a_wrong_slot_that_stands_is_no_error(probes):
    """A number of a slot times 1e30 is none, and is not tried."""

    def first(case):
        settings = case.settings | {"canonical": 0}
        return BuiltIn(PRECISION).path_reuse(**with_numbers(case), **settings)

    answers = answered(probes, "path_reuse", first)
    assert misread(given(answers), PRECISION) is None


def test_what_leaves_everything_open_explains_nothing(probes):
    """An angle of view without limit: no place is known, and any row may be right."""

    def anywhere(case):
        row = np.random.default_rng(13).permutation(case.rows)
        return {"row": row.astype(np.int32)}

    answers = answered(probes, "reproject", anywhere)
    assert misread(given(answers), PRECISION) is None
    assert misplaced(given(answers), PRECISION) is None


def stepping(steps):
    """The port with other steps: functions of a number, and what they give."""

    class Stepping(Port):
        def _whole(self, offset):
            whole = steps.get("whole", np.rint)
            return whole(offset).astype(np.int64)

        def _smaller(self, r, min_radius):
            return np.maximum(steps.get("smaller", lambda r: r / 2)(r), min_radius)

    return Stepping()


LANDINGS = [
    ({"whole": np.floor}, "offsets were rounded down"),
    ({"whole": np.ceil}, "offsets were rounded up"),
    ({"whole": lambda v: np.rint(v) + 1}, "pixels lay +1 aside in x and +1 in y"),
    ({"whole": lambda v: np.rint(v / 2)}, "offsets (dx, dy) were (0.5 dx, 0.5 dy)"),
    (
        {"smaller": lambda r: r / 4},
        "the radius were 1/4 of what it was after a failure",
    ),
]


@pytest.mark.parametrize(("steps", "words"), LANDINGS)
def test_where_neighbours_are_found_is_told_in_numbers(probes, steps, words):
    answers = answered(probes, "neighbors", by(stepping(steps)))
    assert words in misplaced(given(answers), PRECISION).text


def test_right_neighbours_are_nowhere_else(probes):
    answers = answered(probes, "neighbors", by(stepping({})))
    assert misplaced(given(answers), PRECISION) is None

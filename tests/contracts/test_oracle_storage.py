"""Reservoirs in fewer bits are no mistake within the range of their format.

Beyond it a renderer may hold the largest number or infinity.  What is packed wrongly
shows within.
"""

import numpy as np
import pytest

from restir_gi.reference.oracle.builtin.backend import FLOAT32
from restir_gi.reference.oracle.diagnosis.diagnose import HYPOTHESES, diagnose
from restir_gi.reference.oracle.levels.probe import examined
from restir_gi.reference.oracle.levels.rows import row_probes
from restir_gi.reference.oracle.parts import whole_contract
from restir_gi.reference.oracle.replay.bounded import exact, rounding_of
from restir_gi.reference.oracle.replay.judges import JUDGES
from restir_gi.reference.oracle.replay.points import SamplePoint
from restir_gi.reference.oracle.replay.rules import CONTRACT_RULES
from restir_gi.reference.oracle.replay.storage import (
    STORAGES,
    in_format,
    stored_sample,
    stored_W,
)
from restir_gi.reference.oracle.verdict import departs
from tests.contracts.rules_backend import answered_by, stored

CONTRACT = whole_contract()
FORMATS = [h for h in HYPOTHESES if h.departure == "storage"]
PROBES = [p for p in row_probes("float32") if p.case.pass_name == "temporal"]
ROUNDING = rounding_of("float32")


def found_of(answer):
    """What is said of pass ``temporal`` with these outputs."""
    answers = [examined(CONTRACT, "float32", p, answer(p.case)) for p in PROBES]
    assert not all(a.finding.passed for a in answers)
    return diagnose("temporal", answers, "float32"), answers


@pytest.mark.parametrize("overflows", [False, True])
@pytest.mark.parametrize("h", FORMATS, ids=[h.name for h in FORMATS])
def test_a_format_is_not_accused(h, overflows):
    found, answers = found_of(lambda case: answered_by(h.rules, case, overflows))
    assert departs(found), found.text
    assert h in found.matches
    form = STORAGES[h.rules.storage]
    if overflows and form.half_weight:
        assert any("W holds infinity" in a.finding.text for a in answers)


def test_infinity_is_no_number_of_float32():
    """The same W in rows that no format explains."""

    def answer(case):
        out = answered_by(CONTRACT_RULES, case)
        out["W"] = np.where(out["W"] > 65504, np.float32(np.inf), out["W"])
        return out

    found, answers = found_of(answer)
    assert not departs(found)
    assert any("W holds infinity" in a.finding.text for a in answers)


def too_small_a_largest(out):
    out["W"] = np.minimum(out["W"], np.float32(1024))


def too_large_a_least(out):
    out["radiance"] = np.where(
        out["radiance"] < 2.0**-8, np.float32(0), out["radiance"]
    )


def an_exponent_too_far(out):
    out["radiance"] = out["radiance"] * np.float32(2)


def a_sign_lost(out):
    out["normal"] = np.abs(out["normal"])


def green_for_blue(out):
    out["radiance"] = out["radiance"][:, [0, 2, 1]]


@pytest.mark.parametrize(
    "name", ["stored-as-packed-half", "stored-as-rgb9e5", "stored-as-rtxdi"]
)
@pytest.mark.parametrize(
    "wrong",
    [
        too_small_a_largest,
        too_large_a_least,
        an_exponent_too_far,
        a_sign_lost,
        green_for_blue,
    ],
)
@pytest.mark.few(4)
def test_a_mistake_in_packing_is_found(name, wrong):
    h = next(h for h in FORMATS if h.name == name)

    def answer(case):
        out = answered_by(h.rules, case)
        wrong(out)
        return out

    assert not departs(found_of(answer)[0])


@pytest.mark.parametrize("name", STORAGES)
def test_what_comes_out_is_what_is_expected(name):
    """Numbers over the whole range of a renderer, which leaves float16 at both ends."""
    rng = np.random.default_rng(5)
    count = 4096
    light = 10.0 ** rng.uniform(-9, 7, (count, 1)) * rng.random((count, 3))
    out = {
        "radiance": np.float32(light),
        "W": np.float32(10.0 ** rng.uniform(-9, 7, count)),
        "normal": np.tile(np.float32([0, 0, 1]), (count, 1)),
    }
    normal, radiance = (exact(out[n], ROUNDING) for n in ("normal", "radiance"))
    y = SamplePoint(normal, normal, radiance)
    held, W = stored_sample(y, name), stored_W(exact(out["W"], ROUNDING), name)
    for overflows in (False, True):
        given = stored(dict(out), name, overflows)
        bounds = {"radiance": held.radiance, "normal": held.normal, "W": W}
        for buffer, x in bounds.items():
            given[buffer] = np.minimum(given[buffer], np.finfo(np.float32).max)
            assert (np.abs(given[buffer] - x.value) <= x.error).all(), buffer
        assert all((c.excess <= 1).all() for c in in_format(given, name))


def test_halves_may_be_cut():
    """As some devices convert them."""
    x = np.float32(10.0 ** np.random.default_rng(6).uniform(-6, 4.8, 4096))
    half = x.astype(np.float16)
    half = np.where(half > x, np.nextafter(half, np.float16(0)), half)
    expected = stored_W(exact(x, ROUNDING), "half")
    assert (np.abs(half - expected.value) <= expected.error).all()


@pytest.mark.parametrize("h", FORMATS, ids=[h.name for h in FORMATS])
def test_few_rows_are_beyond_a_format(h):
    """Else a format would explain anything."""
    for probe in PROBES:
        case = probe.case
        out = FLOAT32.temporal(**case.inputs, **case.settings)
        judgement = JUDGES["temporal"](case, out, h.rules, "float32")
        (W,) = (c for c in judgement.compared if c.name == "W")
        lit = case.within & (W.expected > 0)
        known = np.isfinite(W.allowed) & (W.allowed < 0.1 * W.expected)
        assert known[lit].mean() > 0.9

"""The passes of pairs and images: who is right passes, and nobody else does."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from restir_gi.gradient_domain.oracle import exact
from restir_gi.gradient_domain.oracle.images import least_sum_of, problem_of
from restir_gi.gradient_domain.oracle.part import PART
from restir_gi.gradient_domain.oracle.rules import PairRules
from restir_gi.reference.oracle.backends.inside import InsideBackend
from restir_gi.reference.oracle.builtin.backend import BuiltIn
from restir_gi.reference.oracle.checking import judge
from restir_gi.reference.oracle.levels.probe import examined
from restir_gi.reference.oracle.parts import parts
from restir_gi.reference.oracle.replay.rules import CONTRACT_RULES
from tests.mutants.pairs_by_hand import by_hand

PASSES = {p.name: p for p in PART.passes}
both_precisions = pytest.mark.parametrize("precision", ["float32", "float64"])


@cache
def probes(precision):
    return PART.probes(precision)


def own(case, precision):
    return getattr(BuiltIn(precision), case.pass_name)(**case.inputs, **case.settings)


def found_in(precision, answer):
    """What is wrong with each answer that is wrong."""
    found = []
    for probe in probes(precision):
        with np.errstate(all="ignore"):
            out = answer(probe.case)
        text = examined(PASSES, precision, probe, out).finding.text
        found += [text] if text else []
    return found


def case_of(name, precision="float32"):
    every = [*probes(precision), *PART.more(precision)]
    return next(p.case for p in every if p.case.name.startswith(name))


def judged(case, outputs, precision="float32"):
    return PART.judges[case.pass_name](case, outputs, CONTRACT_RULES, precision)


# ------------------------------------------------ who is right


def test_the_part_is_registered():
    assert PART in parts()


@both_precisions
def test_the_project_itself_passes(precision):
    assert found_in(precision, lambda case: own(case, precision)) == []


@both_precisions
def test_another_backend_passes(precision):
    """Other orders of operations, conjugate gradients, and weights that are adapted."""
    assert found_in(precision, by_hand) == []


def test_a_backend_that_rounds_less_often_passes():
    """As with fused operations: all in double precision, and rounded at the end."""

    def wide(case):
        inputs = {
            name: a.astype(float) if a.dtype.kind == "f" else a
            for name, a in case.inputs.items()
        }
        found = by_hand(replace(case, inputs=inputs))
        return {
            name: a.astype(np.float32) if a.dtype.kind == "f" else a
            for name, a in found.items()
        }

    assert found_in("float32", wide) == []


@both_precisions
def test_who_declares_settings_passes(precision):
    """The project itself, and another backend."""
    for answer in (lambda case: own(case, precision), by_hand):
        for probe in PART.more(precision):
            with np.errstate(all="ignore"):
                out = answer(probe.case)
            assert examined(PASSES, precision, probe, out).finding.passed


def test_few_rows_are_left_open():
    """Mistakes could hide there."""
    shares = {}
    for probe in probes("float32"):
        found = judged(probe.case, own(probe.case, "float32")).terms
        if "open" in found:
            shares[probe.case.name] = found["open"].mean()
    thresholds = shares.pop("edge-pair-thresholds")
    assert 0.2 < thresholds < 0.45  # a third of its rows is on one
    assert max(shares.values()) < 0.05
    assert np.mean([s for name, s in shares.items() if "reuse" in name]) < 1e-3


# ------------------------------------------------ choices that leave the mean alone


def backend_with(mistakes):
    """A backend of these passes alone, with a mistake in each of them."""
    found = {}
    for probe in probes("float32"):
        name = probe.case.pass_name

        def answer(probe=probe, name=name, **given):
            settings = {s.name for s in PASSES[name].settings}
            held = {k: v for k, v in given.items() if k not in settings}
            asked = {k: v for k, v in given.items() if k in settings}
            case = replace(probe.case, pass_name=name, inputs=held, settings=asked)
            with np.errstate(all="ignore"):
                return by_hand(case, mistakes.get(name, ""))

        found[name] = answer
    return InsideBackend(SimpleNamespace(**found))


DEPARTURES = [h for h in PART.hypotheses if h.departure]


@pytest.mark.parametrize("h", DEPARTURES, ids=[h.name for h in DEPARTURES])
@pytest.mark.few(2)
def test_a_departure_passes(h):
    also = dict([h.needs]) if h.needs else {}
    backend = backend_with(dict.fromkeys(h.passes, h.name) | also)
    verdict = judge(backend, 60.0, statistics=False)
    assert verdict.status == "PASS"
    assert h in {m for d in verdict.diagnoses for m in d.matches}


@pytest.mark.parametrize("where", ["pair_initial", "pair_reuse"])
@pytest.mark.few(1)
def test_samples_of_one_sign_of_luminance_have_to_be_shown_whole(where):
    """Else what their channels have of the other sign is lost."""
    backend = backend_with({where: "pair-split-by-luminance"})
    assert judge(backend, 60.0, statistics=False).status == "FAIL"
    both = {
        where: "pair-split-by-luminance",
        "pair_estimate": "pair-shown-by-luminance",
    }
    assert judge(backend_with(both), 60.0, statistics=False).status == "PASS"


# ------------------------------------------------ what has to be declared


def verdict_of(name, declaration=None, **fixed):
    """Verdict on a backend of one pass, which has some settings fixed, or given."""

    def answer(**given):
        held = {k: v for k, v in given.items() if isinstance(v, np.ndarray)}
        asked = {k: v for k, v in given.items() if k not in held}
        case = replace(
            case_of(NAMES[name]), pass_name=name, inputs=held, settings=asked | fixed
        )
        with np.errstate(all="ignore"):
            return by_hand(case)

    backend = InsideBackend(SimpleNamespace(**{name: answer}))
    said = None
    if declaration is not None:
        said = {"schema": "restir-declaration 1", "has": {name: declaration}}
    return judge(backend, 60.0, statistics=False, declaration=said).status


NAMES = {
    "edge_pair": "edge-pair",
    "pair_search": "pair-search",
    "poisson_l1": "poisson-l1",
}
GIVEN = {"thresholds": ["given"]}
EITHER = {"normals": ["either-side"]}
AUTHORS = {"most_albedo": 0.05, "least_cosine": 0.7, "most_depth": 0.01}


@pytest.mark.parametrize("name", ["edge_pair", "pair_search"])
@pytest.mark.parametrize(
    ("declaration", "fixed", "status"),
    [
        (None, AUTHORS, "FAIL"),
        (GIVEN, {}, "PASS"),
        (GIVEN, AUTHORS, "FAIL"),
        (GIVEN, {"least_cosine": 0.7}, "FAIL"),
        (GIVEN, {"most_albedo": 0.05}, "FAIL"),
        (GIVEN, {"most_depth": 0.01}, "FAIL"),
        (GIVEN | EITHER, {}, "PASS"),
        (GIVEN | EITHER, {"normals": "facing"}, "FAIL"),
        (GIVEN, {"normals": "either-side"}, "FAIL"),
        (EITHER, {}, "PASS"),
    ],
)
@pytest.mark.few(4)
def test_thresholds_are_declared_and_then_asked_for(name, declaration, fixed, status):
    assert verdict_of(name, declaration, **fixed) == status


@pytest.mark.parametrize("where", ["edge_pair", "pair_search"])
def test_thresholds_a_little_off_are_seen(where):
    """By a hundredth of each, in any of the cases of a pass."""
    for name in AUTHORS:
        some = [
            p.case
            for p in PART.more("float32")
            if p.case.pass_name == where and name in p.case.settings
        ]
        off = [
            replace(c, settings=c.settings | {name: 1.01 * c.settings[name]})
            for c in some
        ]
        assert where == "pair_search" or not all(
            judged(c, by_hand(o)).passed for c, o in zip(some, off, strict=True)
        )


@pytest.mark.parametrize(
    ("declaration", "fixed", "status"),
    [
        (None, {"norm": "channels"}, "FAIL"),
        ({"norm": ["channels"]}, {}, "PASS"),
        ({"norm": ["channels"]}, {"norm": "length"}, "FAIL"),
        ({"norm": ["length", "channels"]}, {}, "PASS"),
    ],
)
def test_the_norm_is_declared_and_then_asked_for(declaration, fixed, status):
    assert verdict_of("poisson_l1", declaration, **fixed) == status


# ------------------------------------------------ whom no name fits


def scaled(case):
    out = own(case, "float32")
    return {
        n: a * np.float32(1.5) if a.dtype.kind == "f" else a + a.dtype.type(1)
        for n, a in out.items()
    }


@pytest.mark.slow
@pytest.mark.parametrize("name", PASSES)
def test_what_is_no_known_mistake_is_judged_all_the_same(name):
    """Whatever its settings and inputs may have been taken for."""

    def answer(**given):
        settings = {s.name for s in PASSES[name].settings}
        held = {k: v for k, v in given.items() if k not in settings}
        asked = {k: v for k, v in given.items() if k in settings}
        some = next(p.case for p in probes("float32") if p.case.pass_name == name)
        return scaled(replace(some, inputs=held, settings=asked))

    verdict = judge(
        InsideBackend(SimpleNamespace(**{name: answer})), 60.0, statistics=False
    )
    assert verdict.status == "FAIL"


# ------------------------------------------------ exact sums


@pytest.mark.parametrize("pair", [0, 1])
def test_the_truth_of_the_lattice_is_the_integral(pair):
    """Of H over both parts of the domain, and of the parts of both signs."""
    total = np.zeros(3)
    for k in (0, 1):
        cells = np.arange(exact.CELLS)
        s = exact.CellSamples(pair, np.full(exact.CELLS, k), cells)
        total += s.measure @ s.contribution(0)
        parts_of = s.contribution(1) + s.contribution(-1)
        np.testing.assert_allclose(parts_of, s.contribution(0), atol=1e-15)
    np.testing.assert_allclose(total, exact.difference_of(pair), rtol=1e-13)


def test_the_lattice_has_what_it_is_to_have():
    """Differences of both signs, and shifts of both kinds that fail on either side."""
    signs = np.sign([exact.difference_of(pair) for pair in (0, 1)])
    assert {1.0, -1.0} <= set(signs.ravel())
    lit = exact.MU > 0
    for i, j in exact.PAIRS:
        assert (lit[i] & ~lit[j]).any()
        assert (lit[j] & ~lit[i]).any()
    for k in (0, 1):
        a, b = lit[exact.PAIRS[:, k]]
        assert (a != b).any()
    s = exact.CellSamples(0, np.zeros(exact.CELLS, int), np.arange(exact.CELLS))
    H = s.contribution(0)
    assert ((H > 0).any(axis=1) & (H < 0).any(axis=1)).any()


IN_L1 = {
    "pair_initial": ["pair-candidates-halved", "pair-target-of-the-first"],
    "pair_estimate": [
        "pair-inner-jacobian-left-out",
        "pair-alone-dropped",
        "pair-alone-halved",
        "pair-negative-part-added",
        "pair-whole-in-each-sign",
        "pair-weight-of-plus-for-both",
    ],
    "after_estimate": ["pair-second-left-out", "pair-second-sign-not-turned"],
    "pair_reuse": ["pair-reuse-one-over-m", "outer-jacobian-left-out"],
}


@pytest.mark.parametrize(
    ("name", "mistake"), [(n, m) for n, all in IN_L1.items() for m in all]
)
def test_exact_sums_alone_see_it(name, mistake):
    found = [
        examined(PASSES, "float32", p, by_hand(p.case, mistake)).finding.passed
        for p in probes("float32")
        if p.level == "L1" and p.case.pass_name == name
    ]
    assert not all(found)


WEIGHTS = [h.name for h in PART.hypotheses if h.departure == "mis"]


@pytest.mark.parametrize("mistake", WEIGHTS)
def test_weights_that_sum_to_one_are_right_in_the_mean(mistake):
    """One half, a Jacobian less or the other way round: more noise, and no bias."""
    some = [
        p
        for p in probes("float32")
        if p.level == "L1" and p.case.pass_name in ("pair_estimate", "after_estimate")
    ]
    found = [
        examined(PASSES, "float32", p, by_hand(p.case, mistake)).finding.passed
        for p in some
    ]
    assert len(found) > 4
    assert all(found)


# ------------------------------------------------ solvers

L2 = "poisson-l2-16x13"


def test_any_image_within_the_residual_is_right_and_none_beyond():
    case = case_of(L2, "float64")
    image = own(case, "float64")["color"]
    p = problem_of(case, PairRules())
    right = p.A.T @ p.b
    direction = np.random.default_rng(1).normal(size=image.shape)
    left = p.A.T @ (p.A @ direction)
    unit = case.settings["residual"] * np.sqrt((right**2).sum(0) / (left**2).sum(0))
    for factor, passed in ((0.99, True), (1.01, False)):
        found = {"color": image + factor * unit * direction}
        assert judged(case, found, "float64").passed == passed


def test_one_channel_alone_is_seen():
    case = case_of(L2)
    image = own(case, "float32")["color"].copy()
    image[:, 2] *= np.float32(1.01)
    assert not judged(case, {"color": image}).passed


@pytest.mark.parametrize("solver", ["begins from nothing", "darker by 1 %"])
def test_solvers_that_stop_early_are_seen(solver):
    case = case_of(L2)
    image = own(case, "float32")["color"]
    if solver == "darker by 1 %":
        image = image * np.float32(0.99)
    else:
        p = problem_of(case, PairRules())
        normal, right = p.A.T @ p.A, p.A.T @ p.b
        image = np.zeros_like(image)
        for _ in range(30):  # steps of Jacobi, which the longest waves hardly notice
            image = image + 0.9 * (right - normal @ image) / normal.diagonal()[:, None]
        image = image.astype(np.float32)
    assert not judged(case, {"color": image}).passed


L1 = (
    "poisson-l1-14x11",
    "poisson-l1-8x15",
    "poisson-l1-channels-14x11",
    "poisson-l1-channels-8x15",
)


def energy(case, image):
    """E, from its definition."""
    p = problem_of(case, PairRules())
    channels = case.settings.get("norm") == "channels"
    return np.linalg.norm(p.A @ image - p.b, axis=1, ord=1 if channels else 2).sum()


@pytest.mark.parametrize("name", L1)
def test_the_least_sum_is_proved(name):
    """A dual bound is as near as a twentieth of what is allowed."""
    case = case_of(name, "float64")
    least = least_sum_of(case, PairRules())
    assert least.bound <= least.total
    assert least.total - least.bound < case.settings["ratio"] / 20 * least.bound
    rng = np.random.default_rng(2)
    for scale in (1e-3, 1e-1, 1.0):
        image = least.image + scale * rng.normal(size=least.image.shape)
        assert energy(case, image) >= least.bound


@pytest.mark.parametrize("name", L1)
def test_the_sum_decides_within_the_ratio(name):
    case = case_of(name, "float64")
    least = least_sum_of(case, PairRules())
    direction = np.random.default_rng(3).normal(size=least.image.shape)

    def excess(step):
        image = least.image + step * direction
        return energy(case, image) / least.total - 1

    low, high = 0.0, 1.0
    for _ in range(60):
        middle = (low + high) / 2
        wider = excess(middle) < case.settings["ratio"]
        low, high = (middle, high) if wider else (low, middle)
    for step, passed in ((0.98 * low, True), (1.02 * high, False)):
        image = least.image + step * direction
        assert judged(case, {"color": image}, "float64").passed == passed


def test_every_known_mistake_changes_the_rules():
    """Each is another rule, and no two of a pass are alike."""
    rules = [(name, h.rules.part) for h in PART.hypotheses for name in h.passes]
    assert PairRules() not in [part for _, part in rules]
    assert len(set(rules)) == len(rules)

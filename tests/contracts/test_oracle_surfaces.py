"""Declared surfaces: who is right passes, who is not is told in what."""

from dataclasses import replace
from functools import cache
from itertools import chain, product

import numpy as np
import pytest

from restir_gi.reference.oracle.backends.selected import Selection
from restir_gi.reference.oracle.builtin.backend import FLOAT32, FLOAT64, BuiltIn
from restir_gi.reference.oracle.builtin.surfaces import SurfacePixels
from restir_gi.reference.oracle.capture.cases import RecordedFrames, captured_cases
from restir_gi.reference.oracle.capture.frames import CapturedBuffers, CapturedFrame
from restir_gi.reference.oracle.cases import pass_of
from restir_gi.reference.oracle.checking import judge
from restir_gi.reference.oracle.contract.surfaces import SURFACE
from restir_gi.reference.oracle.diagnosis.diagnose import (
    Diagnosis,
    Explanation,
    diagnose,
)
from restir_gi.reference.oracle.diagnosis.innocence import bias_of_light
from restir_gi.reference.oracle.diagnosis.surfaces import CHANGES, SURFACES
from restir_gi.reference.oracle.diagnosis.terms import first_wrong_term
from restir_gi.reference.oracle.golden import write_failing
from restir_gi.reference.oracle.levels.kernels import kernel_probes
from restir_gi.reference.oracle.levels.probe import examined
from restir_gi.reference.oracle.levels.rows import row_probes
from restir_gi.reference.oracle.levels.surfaces import (
    surface_kernel_probes,
    surface_row_probes,
    surface_scene_probes,
)
from restir_gi.reference.oracle.parts import whole_contract
from restir_gi.reference.oracle.replay.judges import JUDGES
from restir_gi.reference.oracle.replay.rules import CONTRACT_RULES
from restir_gi.reference.oracle.working_range import EDGE_ON, SHARP
from tests.mutants import surfaces_by_hand as by_hand

CONTRACT = whole_contract()
PASSES = tuple(name for name, one in CONTRACT.items() if SURFACE in one.settings)
OURS = frozenset(PASSES)
NOTHING = Selection(only=OURS)
BOTH = replace(NOTHING, more=frozenset(product(PASSES, ["surface"], SURFACE.more)))
BY_NAME = {h.name: h for h in SURFACES}


class RememberingBackend:
    """A right backend that remembers what it was asked."""

    precision = "float32"

    def __init__(self):
        self.calls = []

    def __getattr__(self, name):
        """A pass."""
        own = getattr(FLOAT32, name)

        def call(**given):
            words = {k: v for k, v in given.items() if isinstance(v, str)}
            self.calls.append((name, tuple(given), tuple(words.items())))
            return own(**given)

        return call


@cache
def recorded(selection):
    """What a right backend was asked, and the verdict."""
    backend = RememberingBackend()
    return backend.calls, judge(backend, 600, statistics=False, selection=selection)


# ---------------------------------------------------------------- who declares


def test_who_declares_nothing_sees_nothing_of_it():
    """The same calls, without those of declared surfaces among them."""
    before, with_them = (recorded(chosen)[0] for chosen in (NOTHING, BOTH))
    fields = {
        f.name
        for p in PASSES
        for f in CONTRACT[p].inputs
        if f.only and f.only[0] == SURFACE.name
    }
    assert not fields & {name for _, names, _ in before for name in names}
    assert "surface" not in {name for _, names, _ in before for name in names}
    assert [c for c in with_them if "surface" not in c[1]] == before
    declared = {
        (n, dict(w)["surface"]) for n, _, w in with_them if "surface" in dict(w)
    }
    assert declared == set(product(PASSES, SURFACE.more))


def test_what_is_declared_of_one_pass_is_asked_of_that_alone():
    selection = Selection(
        only=frozenset({"target", "shade"}),
        more=frozenset({("target", "surface", "ggx")}),
    )
    calls, _ = recorded(selection)
    words = {(name, dict(words).get("surface")) for name, _, words in calls}
    assert words == {("target", None), ("target", "ggx"), ("shade", None)}


def test_the_project_itself_passes():
    _, verdict = recorded(BOTH)
    assert verdict.status == "PASS", [f for t in verdict.steps for f in t.step.faults]
    titles = [t.step.title for t in verdict.steps if t.step.answers]
    assert titles.count("declared surfaces") == 2
    assert "glossy-floor" in titles


# ---------------------------------------------------------------- what is asked


@cache
def probes(precision="float32"):
    return [
        *surface_kernel_probes(precision),
        *surface_row_probes(precision),
        *surface_scene_probes(precision),
    ]


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_cases_have_the_buffers_of_their_surface(precision):
    for probe in probes(precision):
        case = probe.case
        given = {f.name for f in pass_of(CONTRACT, case).inputs}
        assert given == set(case.inputs), case.name


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_the_project_itself_is_right(precision):
    for probe in probes(precision):
        case = probe.case
        own = getattr(BuiltIn(precision), case.pass_name)
        out = own(**case.inputs, **case.settings)
        found = examined(CONTRACT, precision, probe, out).finding
        assert found.passed, found.text
        assert not found.at_extremes


def test_views_go_below_the_horizon_and_lobes_are_met_at_every_width():
    for probe in surface_kernel_probes("float32"):
        i = {k: a.astype(float) for k, a in probe.case.inputs.items()}
        up = by_hand.dot(i["visible_normal"], i["view"])
        assert 0.01 < (up < 0).mean() < 0.15
        assert not (np.abs(up) < EDGE_ON).any()
        w = by_hand.unit(i["position"] - i["visible_position"])
        h = by_hand.unit(w + i["view"])
        c = by_hand.dot(i["visible_normal"], h)
        tangent = np.sqrt(1 - np.minimum(c * c, 1)) / c
        peak = (by_hand.dot(i["visible_normal"], w) > 0) & (up > 0) & (c > 0)
        peak &= tangent < i["alpha"]
        for least in (SHARP, 0.05, 0.2):
            assert (peak & (i["alpha"] > least) & (i["alpha"] < 3 * least)).sum() >= 5


def test_alpha_and_view_have_a_working_range():
    case = next(p.case for p in surface_kernel_probes("float32") if p.case.beyond.any())
    beyond = case.inputs["alpha"] < np.float32(SHARP)
    assert beyond.any()
    assert case.beyond[beyond].all()


# ---------------------------------------------------------------- other writings

# Single precision throughout, in the words of several engines.

F = np.float32


def density_of_shaders(c, a):
    a2 = a * a
    d = (c * a2 - c) * c + F(1)
    return a2 / (F(np.pi) * d * d)


def density_of_filament(c, a):
    k = a / (F(1) - c * c + (a * c) * (a * c))
    return k * k * F(1 / np.pi)


def density_in_words(c, a):
    return a * a * F(1 / np.pi) / (c * c * (a * a - F(1)) + F(1)) ** 2


def g1_of_shaders(c, a):
    return F(2) * c / (c + np.sqrt(a * a + (F(1) - a * a) * c * c))


def g1_in_words(c, a):
    return F(2) / (F(1) + np.sqrt(F(1) + a * a * (F(1) - c * c) / (c * c)))


def each(g1):
    return lambda c_i, c_o, a: g1(c_i, a) * g1(c_o, a)


def half_by_reciprocal(v, w):
    h = w + v
    length2 = h[:, 2] * h[:, 2] + (h[:, 1] * h[:, 1] + h[:, 0] * h[:, 0])
    return h * (F(1) / np.sqrt(length2))[:, None]


DENSITIES = (
    density_of_shaders, density_of_filament, density_in_words, by_hand.tangent_density,
)  # fmt: skip
MASKINGS = (each(g1_of_shaders), each(g1_in_words), by_hand.separable)
HALVES = (lambda v, w: by_hand.unit(v + w), half_by_reciprocal)
WRITINGS = [
    {"density": d, "masking": m, "half": h}
    for d, m, h in product(DENSITIES, MASKINGS, HALVES)
]


def answered(writing, case):
    """Answers of a shader, in single precision throughout."""
    p = SurfacePixels
    hand = by_hand.ByHand(writing)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(p, "target_at", lambda q, *a: hand.target_at(q, *a))
        patch.setattr(p, "shown", lambda q, *a: hand.shown(q, *a))
        return dict(getattr(FLOAT32, case.pass_name)(**case.inputs, **case.settings))


KERNELS = [p.case for p in surface_kernel_probes("float32", 7)]


@pytest.mark.parametrize("writing", WRITINGS)
def test_no_order_of_operations_is_accused(writing):
    """No chance in it: bounds hold for every row, or are wrong."""
    for case in KERNELS:
        out = answered(writing, case)
        assert all(a.dtype == np.float32 for a in out.values())
        found = JUDGES[case.pass_name](case, out, CONTRACT_RULES, "float32")
        assert not (found.wrong & case.within).any(), case.name


@pytest.mark.parametrize("writing", WRITINGS[::5])
def test_control_a_thousandth_is_found(writing):
    """Most rows show it; at peaks of narrow lobes rounding takes as much."""
    for case in KERNELS:
        if case.settings.get("target") == "outgoing":
            continue
        (name, value), *_ = answered(writing, case).items()
        lit = value.reshape(case.rows, -1).any(axis=1) & case.within
        out = {name: value * F(1.001)}
        found = JUDGES[case.pass_name](case, out, CONTRACT_RULES, "float32")
        shown = found.wrong[lit]
        assert shown.mean() > 0.6
        assert shown[case.inputs["alpha"][lit] > 0.3].mean() > 0.95


# ---------------------------------------------------------------- mistakes


def shown_in(hypothesis, pass_name):
    """Answers of the built-in passes to all cases of a pass, as they are planted."""
    lambertian = chain(kernel_probes("float32"), row_probes("float32"))
    ours = [p for p in probes() if hypothesis.shows_in(p.case)]
    asked = [p for p in (*lambertian, *ours) if p.case.pass_name == pass_name]
    own = getattr(BuiltIn("float32"), pass_name)
    return [
        examined(CONTRACT, "float32", p, own(**p.case.inputs, **p.case.settings))
        for p in asked
    ]


def check_the_name(hypothesis, pass_name):
    answers = shown_in(hypothesis, pass_name)
    assert any(not a.finding.passed for a in answers)
    found = diagnose(pass_name, answers, "float32")
    assert found.matches == (hypothesis,)
    assert found.explanations[0].innocent == bool(hypothesis.departure)


PLANTS = [
    (f"{where}-{change.name}", by_hand.MISTAKES[change.name])
    for change, where in product(CHANGES, ("target", "shade"))
]
PLANTS.append(("target-white-and-lambertian", by_hand.WHITE))
IDS = [name for name, _ in PLANTS]


def test_every_hypothesis_is_planted_here():
    elsewhere = {h.name for h in SURFACES} - set(IDS)
    assert elsewhere == {
        "target-without-albedo-and-surface",
        "view-of-the-receiver-in-the-domain",
        "view-of-the-source-at-the-receiver",
    }


@pytest.mark.parametrize(("name", "changes"), PLANTS, ids=IDS)
def test_a_mistake_is_named(monkeypatch, name, changes):
    by_hand.plant(monkeypatch, name, changes)
    check_the_name(BY_NAME[name], BY_NAME[name].passes[0])


@pytest.mark.slow
@pytest.mark.parametrize(("name", "changes"), PLANTS, ids=IDS)
def test_a_mistake_is_named_in_every_pass(monkeypatch, name, changes):
    by_hand.plant(monkeypatch, name, changes)
    for pass_name in BY_NAME[name].passes[1:]:
        check_the_name(BY_NAME[name], pass_name)


# ---------------------------------------------------------------- views


def moved_by_hand(case, asked="past_view", reused="view"):
    """Pass moved with the target of Equation 9, in plain sums.

    Parameters
    ----------
    asked, reused : str
        Whose view the source has in the domain test, and the receiver for the past's
        sample.
    """
    i, settings = case.inputs, case.settings
    past = {k.removeprefix("past_"): a for k, a in i.items() if k.startswith("past_")}

    def target(x, sample, view):
        y = {n: i[f"{sample}_{n}"] for n in ("position", "normal", "radiance")}
        names = {f.name for f in CONTRACT["target"].inputs} - y.keys() - {"view"}
        at = {n: x[n] for n in names if n in x}
        words = {n: settings[n] for n in ("target", "surface")}
        return FLOAT64.target(**wide(at | y), view=i[view].astype(float), **words)[
            "p_hat"
        ]

    J = FLOAT64.jacobian(
        **wide(
            {
                "x_from": i["past_visible_position"],
                "x_to": i["visible_position"],
                "position": i["past_position"],
                "normal": i["past_normal"],
            }
        )
    )["jacobian"]
    p0, p1 = target(i, "past", reused), target(i, "new", "view")
    M0 = i["past_M"].astype(float)
    w0 = p0 * i["past_W"] * M0 * J * (i["visible"][:, 0] & 2 > 0)
    w1 = np.divide(p1, i["new_pdf"], out=np.zeros_like(p1), where=i["new_pdf"] > 0)
    new = (i["u"] * (w0 + w1) < w1) | ((w0 == 0) & (w1 > 0))
    Z = M0 + 1
    if settings["mis"] == "1/Z":
        held = [target(past, s, asked) > 0 for s in ("past", "new")]
        sees = [i["visible"][:, 1] & bit > 0 for bit in (2, 1)]
        could = np.where(new, held[1] & sees[1], held[0] & sees[0])
        Z = np.where(could, M0 + 1, 1)
    p = np.where(new, p1, p0)
    W = np.divide(w0 + w1, p * Z, out=np.zeros_like(p), where=p * Z > 0)
    out = {"W": W, "M": np.minimum(M0 + 1, settings["cap"])}
    for n in ("position", "normal", "radiance"):
        out[n] = np.where(new[:, None], i[f"new_{n}"], i[f"past_{n}"])
    return {n: a.astype(np.float32) for n, a in out.items()}


def wide(buffers):
    """Reals in double precision."""
    return {
        n: a.astype(float) if a.dtype.kind == "f" else a for n, a in buffers.items()
    }


def moved_answers(**views):
    asked = [
        p
        for p in surface_row_probes("float32")
        if p.case.pass_name == "moved" and p.case.settings["target"] == "scattered"
    ]
    return [
        examined(CONTRACT, "float32", p, moved_by_hand(p.case, **views)) for p in asked
    ]


@pytest.mark.parametrize(
    ("name", "views"),
    [
        ("view-of-the-receiver-in-the-domain", {"asked": "view"}),
        ("view-of-the-source-at-the-receiver", {"reused": "past_view"}),
    ],
)
def test_a_view_of_another_point_is_named(name, views):
    found = diagnose("moved", moved_answers(**views), "float32")
    assert found.matches == (BY_NAME[name],)


def test_control_the_pass_by_hand_is_right():
    assert all(a.finding.passed for a in moved_answers())


def test_a_view_that_is_read_from_another_buffer_is_told():
    """By exchanging buffers: no list knows of it."""
    probe = surface_kernel_probes("float32")[2]
    case = probe.case
    assert case.pass_name == "shade"
    wrong = {**case.inputs, "view": case.inputs["visible_normal"]}
    out = FLOAT32.shade(**wrong, **case.settings)
    told = first_wrong_term([examined(CONTRACT, "float32", probe, out)], "float32")
    assert "view were visible_normal" in told.sentence


# ---------------------------------------------------------------- captures


def captured(settings):
    """Pass shade of a GGX capture whose manifest says this, and whether it is right."""
    probe = next(
        p
        for p in surface_kernel_probes("float32")
        if p.case.pass_name == "shade" and p.case.settings["surface"] == "ggx"
    )
    i = probe.case.inputs
    seen = {f.name: i[f.name] for f in CONTRACT["shade"].inputs if f.name in i}
    roles = {name: CapturedBuffers(seen) for name in ("gbuffer", "initial")}
    color = FLOAT32.shade(**i, **probe.case.settings)
    frame = CapturedFrame(0, {**roles, "shade": CapturedBuffers(color)})
    (answered,) = captured_cases(RecordedFrames(1, (frame,), {"shade": settings}))
    judged = JUDGES["shade"](answered.case, answered.outputs, CONTRACT_RULES, "float32")
    return answered.case, not (judged.wrong & answered.case.within).any()


def test_a_capture_with_a_surface_is_judged_with_its_materials():
    case, right = captured({"surface": "ggx"})
    assert case.settings["surface"] == "ggx"
    assert right


def test_a_capture_without_a_surface_is_lambertian_whatever_it_holds():
    case, right = captured({})
    assert "surface" not in case.settings
    assert not right


# ---------------------------------------------------------------- verdicts


def test_who_takes_everything_for_white_is_not_accused():
    """Lambertian points and declared surfaces alike: any target above 0 will do."""

    def p_hat(case):
        given = {n: a for n, a in case.inputs.items() if n in LAMBERTIAN_INPUTS}
        given["albedo"] = np.ones_like(given["albedo"])
        return FLOAT32.target(**given, target=case.settings["target"])

    asked = [*kernel_probes("float32"), *surface_kernel_probes("float32")]
    answers = [
        examined(CONTRACT, "float32", p, p_hat(p.case))
        for p in asked
        if p.case.pass_name == "target"
    ]
    found = diagnose("target", answers, "float32")
    assert found.matches == (BY_NAME["target-without-albedo-and-surface"],)
    assert found.explanations[0].innocent


LAMBERTIAN_INPUTS = {f.name for f in CONTRACT["target"].inputs if f.only is None}


def test_a_target_of_surfaces_alone_leaves_the_other_tests_binding():
    """The spheres are Lambertian, where such a renderer is as the contract is."""
    of_surfaces, of_all = (
        Diagnosis("target", (Explanation((BY_NAME[name],), (), 1, 1),))
        for name in (
            "target-white-and-lambertian",
            "target-without-albedo-and-surface",
        )
    )
    assert of_surfaces.kinds == set()
    assert of_all.kinds == {"target"}


@pytest.mark.parametrize(
    ("name", "status"),
    [
        ("target-masking-height-correlated", "PASS"),
        ("shade-masking-height-correlated", "FAIL"),
        ("target-lobe-left-out", "FAIL"),
    ],
)
def test_the_verdict_names_it(monkeypatch, name, status):
    where, _, change = name.partition("-")
    by_hand.plant(monkeypatch, name, by_hand.MISTAKES[change])
    selection = replace(BOTH, only=frozenset({where}))
    verdict = judge(FLOAT32, 600, statistics=False, selection=selection)
    assert verdict.status == status
    assert [d.matches for d in verdict.diagnoses] == [(BY_NAME[name],)]


def test_a_declaration_says_which_surfaces_there_are_and_accepts_a_bias(monkeypatch):
    """Who leaves metals black on purpose says so, and is told how much it is."""
    name = "target-lobe-left-out"
    by_hand.plant(monkeypatch, name, by_hand.MISTAKES["lobe-left-out"])
    has = {"surface": ["ggx"]}
    table = {"schema": "restir-declaration 1", "has": has}
    given = {"statistics": False, "selection": Selection(only=frozenset({"moved"}))}
    verdict = judge(FLOAT32, 600, declaration=table, **given)
    assert verdict.status == "FAIL"
    asked = {
        a.probe.case.settings.get("surface")
        for t in verdict.steps
        for a in t.step.answers
        if a.outputs is not None
    }
    assert asked == {"ggx"}
    verdict = judge(
        FLOAT32, 600, declaration=table, declared=[name], accept=[name], **given
    )
    assert verdict.status == "PASS", verdict.diagnoses
    assert bias_of_light("moved", BY_NAME[name].rules).least == -1


def test_cases_that_fail_are_kept_and_judged_again(monkeypatch, tmp_path):
    by_hand.plant(monkeypatch, "shade-", by_hand.MISTAKES["lobe-left-out"])
    selection = replace(BOTH, only=frozenset({"shade"}))
    verdict = judge(FLOAT32, 600, statistics=False, selection=selection)
    kept = write_failing(tmp_path / "failed", CONTRACT, verdict, "planted")
    assert {"kernel-shade-ggx", "shade-glossy-floor-coated"} <= set(kept)
    again = judge(FLOAT32, 600, against=tmp_path / "failed", selection=selection)
    assert again.status == "FAIL"
    assert [d.matches for d in again.diagnoses] == [(BY_NAME["shade-lobe-left-out"],)]
    monkeypatch.undo()
    right = judge(FLOAT32, 600, against=tmp_path / "failed", selection=selection)
    assert right.status == "PASS"
    assert len([a for t in right.steps for a in t.step.answers]) == len(kept)


def test_control_the_hand_is_right(monkeypatch):
    by_hand.plant(monkeypatch, "target-", {})
    by_hand.plant(monkeypatch, "shade-", {})
    for name in ("target", "shade", "moved"):
        answers = shown_in(BY_NAME["shade-lobe-left-out"], name)
        assert all(a.finding.passed for a in answers)

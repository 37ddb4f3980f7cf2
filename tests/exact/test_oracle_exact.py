"""Exact values of the kernels: closed forms, the replay's bounds, and controls."""

from dataclasses import replace
from fractions import Fraction
from math import isqrt

import mpmath
import numpy as np
import pytest

from restir_gi.reference.oracle.builtin.backend import FLOAT32, FLOAT64
from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.contract.registry import CONTRACT
from restir_gi.reference.oracle.diagnosis.diagnose import diagnose
from restir_gi.reference.oracle.exact.geometry import cosine_of_degrees
from restir_gi.reference.oracle.levels.exact import exact_outputs, examined_exactly
from restir_gi.reference.oracle.levels.kernels import kernel_probes
from restir_gi.reference.oracle.levels.probe import examined
from restir_gi.reference.oracle.replay import formulas, sources
from restir_gi.reference.oracle.replay.bounded import Bounded
from restir_gi.reference.oracle.replay.judges import JUDGES
from restir_gi.reference.oracle.replay.rules import CONTRACT_RULES

BACKENDS = {"float32": FLOAT32, "float64": FLOAT64}
CASES = {
    (precision, probe.case.name): probe.case
    for precision in BACKENDS
    for probe in kernel_probes(precision)
    if probe.examine is examined_exactly
}

PI = Fraction("3.14159265358979323846264338327950288419716939937510582")
DIGITS = 10**60


def root(x):
    """Square root of a rational to 60 digits."""
    return Fraction(isqrt(x.numerator * DIGITS**2 // x.denominator), DIGITS)


def case_of(pass_name, settings=None, **rows):
    """A case in double precision, from the rows of its buffers."""
    inputs = {name: np.array(values, np.float64) for name, values in rows.items()}
    return Case("by-hand", pass_name, settings or {}, inputs)


def exact(*args, **rows):
    return {
        name: a.tolist() for name, a in exact_outputs(case_of(*args, **rows)).items()
    }


def nearest(values):
    return [float(Fraction(value)) for value in values]


# ---------------------------------------------------------------- closed forms


def test_jacobian():
    """The patch lies at the origin and looks up the y axis."""
    rows = [
        ((0, 2, 0), (0, 1, 0), 4),
        ((3, 4, 0), (0, 1, 0), Fraction(125, 4)),
        ((0, 1, 0), (3, 4, 0), Fraction(4, 125)),
        ((1, 1, 0), (0, 1, 0), 2 * root(Fraction(2))),
        ((0, -3, 0), (1, 2, 2), Fraction(2, 3)),
        ((5, 0, 0), (0, 1, 0), 0),  # edge-on
        ((0, 1, 0), (5, 0, 0), 0),
        ((0, 0, 0), (0, 1, 0), 0),  # touching
        ((0, 1, 0), (0, 0, 0), 0),
    ]
    x_from, x_to, J = zip(*rows, strict=True)
    zeros, up = ([axis] * len(rows) for axis in ((0, 0, 0), (0, 1, 0)))
    found = exact("jacobian", x_from=x_from, x_to=x_to, position=zeros, normal=up)
    assert found["jacobian"] == nearest(J)


TINY = 2.0**-30
POINTS = {
    "visible_position": [[1, 1, 1]] * 6,
    "position": [
        [4, 5, 1],
        [2, 2, 1],
        [1, 1, 1],
        [4, 1, 1],
        [4, 5, 1],
        # n·ω is 2⁻⁶⁰: in double precision it is 0.
        [TINY, 2, 1],
    ],
    "visible_normal": [*[[0, 1, 0]] * 5, [1 + TINY, 1, 0]],
    "normal": [*[[0, -1, 0]] * 4, [0, 1, 0], [1, 0, 0]],
    "albedo": [[0.5, 0.25, 1.0]] * 6,
    "radiance": [[1, 2, 0.5]] * 6,
}
"""Lit at 3 : 4 : 5; at 45 degrees; touching; grazing; from behind; nearly grazing."""
SMALL = Fraction(TINY) ** 2 / root(1 + (1 - Fraction(TINY)) ** 2)
COSINES = [Fraction(4, 5), root(Fraction(1, 2)), 0, 0, 0, SMALL]


def test_target():
    Y = Fraction("0.2126") / 2 + Fraction("0.7152") / 2 + Fraction("0.0722") / 2
    found = exact("target", {"target": "scattered"}, **POINTS)
    assert found["p_hat"] == nearest(Y / PI * c for c in COSINES)
    Y = Fraction("0.2126") + 2 * Fraction("0.7152") + Fraction("0.0722") / 2
    found = exact("target", {"target": "outgoing"}, **POINTS)
    assert found["p_hat"] == nearest(Y * (c > 0) for c in COSINES)


def test_shade():
    W = [3.0, 0.5, 1.0, 1.0, 1.0, 1.0]
    light = [Fraction(1, 2), Fraction(1, 2), Fraction(1, 2)]
    found = exact("shade", **POINTS, W=W)
    assert found["color"] == [
        nearest(c / PI * v * Fraction(w) for v in light)
        for c, w in zip(COSINES, W, strict=True)
    ]


def test_direction():
    """The origin of the azimuths is the first row, at u₁ = 1/8; a zero has no sign."""
    u = [[0.75, 0.125], [0.75, 0.375], [0.5, 0.625], [0.5, 0.25], [0.0, 0.5]]
    normal = [[0, 0, 1], [0, 0, 1], [0, -0.0, 1], [0, 0, 1], [0, 0, 1]]
    given = {"visible_normal": normal, "u": u}
    half = root(Fraction(1, 2))
    found = exact("direction", {"source": "cosine"}, **given)
    cosines = [Fraction(1, 2), Fraction(1, 2), half, half, 1]
    assert found["cos θ"] == nearest(cosines)
    assert found["pdf"] == nearest(c / PI for c in cosines)
    assert found["azimuth"] == nearest([1, 0, -1, half, 0])
    assert found["length"] == [1.0] * 5
    found = exact("direction", {"source": "uniform"}, **given)
    assert found["cos θ"] == [0.75, 0.75, 0.5, 0.5, 0.0]
    assert found["pdf"] == nearest([1 / (2 * PI)] * 5)
    assert found["azimuth"] == nearest([1, 0, -1, half, -half])


def test_merge():
    """The last row is decided below the last bit of double precision."""
    last = 2.0**-52
    found = exact(
        "merge",
        w_a=[1, 1, 0, 0, 1],
        M_a=[1, 2, 3, 4, 5],
        w_b=[1, 1, 2, 0, 1 + 3 * last],
        M_b=[1, 0, 1, 0, 1],
        u=[0.5, 0.5 - last, 1 - last, 0, 0.5 + last / 2],
    )
    assert found["second"] == [0, 1, 1, 0, 1]
    assert found["w"] == nearest([2, 2, 2, 0, 2 + 3 * Fraction(last)])
    assert found["M"] == [2, 2, 4, 4, 6]


def test_finalize():
    given = {"w": [1, 1, 1, 1e300], "p_hat": [3, 0, 1, 1e-9], "Z": [7, 1, 0, 1]}
    most = float(np.finfo(np.float64).max)
    assert exact("finalize", **given)["W"] == [*nearest([Fraction(1, 21), 0, 0]), most]


@pytest.mark.parametrize(("angle", "dots"), [(60, [0.5]), (90, [0.0]), (180, [-1.0])])
def test_similar_at_the_limit_of_the_angle(angle, dots):
    """Where the cosine is rational equality is similar, and the next number is not."""
    dots = [*dots, np.nextafter(dots[0], -2)]
    one = [1.0, 1.0]
    a, b = [[1, 0, 0]] * 2, [[dot, 0.1, 0] for dot in dots]
    settings = {"max_angle": angle, "max_depth": 0.1}
    found = exact("similar", settings, normal_a=a, depth_a=one, normal_b=b, depth_b=one)
    assert found["similar"] == [1, 0]


def test_similar_at_the_limit_of_the_depth():
    next_one = np.nextafter(16, 17)
    z_a, z_b = [16.0, 15.0, next_one, 0, 0, 1], [15.0, 16.0, 15.0, 0, 1, 0]
    normals = {"normal_a": [[1, 0, 0]] * 6, "normal_b": [[1, 0, 0]] * 6}
    settings = {"max_angle": 25.0, "max_depth": 0.0625}
    found = exact("similar", settings, **normals, depth_a=z_a, depth_b=z_b)
    assert found["similar"] == [1, 1, 0, 0, 0, 0]


def test_cosines_of_degrees():
    """25 degrees by the triple angle: 4c³ − 3c is the cosine of 75 degrees."""
    c = cosine_of_degrees(25.0)
    quarter = (mpmath.mpf(6).sqrt() - mpmath.mpf(2).sqrt()) / 4
    assert float(4 * c**3 - 3 * c) == pytest.approx(float(quarter), rel=1e-15)
    assert cosine_of_degrees(60.0) == Fraction(1, 2)
    assert cosine_of_degrees(59.99999999999999) > Fraction(1, 2)


def test_nobodys_precision_is_used():
    case = CASES["float32", "kernel-direction-cosine"]
    with mpmath.workdps(3):
        found = exact_outputs.__wrapped__(case)
    for name, values in exact_outputs(case).items():
        assert np.array_equal(found[name], values)


# ---------------------------------------------------------------- replay

every_case = pytest.mark.parametrize(
    ("precision", "name"), CASES, ids=[f"{name}-{p}" for p, name in CASES]
)


def answer(precision, case):
    backend = BACKENDS[precision]
    return dict(getattr(backend, case.pass_name)(**case.inputs, **case.settings))


def outside(precision, case, rules):
    """Rows of which the replay is surer than it is right, by what is compared."""
    judged = JUDGES[case.pass_name](case, answer(precision, case), rules, precision)
    found = exact_outputs(case)
    assert set(found) == {c.name for c in judged.compared}
    return {
        c.name: int((np.abs(found[c.name] - c.expected) > c.allowed).sum())
        for c in judged.compared
    }


@every_case
def test_the_replay_bounds_the_exact_value(precision, name):
    found = outside(precision, CASES[precision, name], CONTRACT_RULES)
    assert set(found.values()) == {0}


def off(formula):
    """A formula whose value is off by one part in 2000, and whose bound is not."""

    def planted(*args):
        x = formula(*args)
        return Bounded(x.value * (1 + 2.0**-11), x.error, x.rounding)

    return planted


def old_sum(u, w_before, w):
    return w - u * w_before


PLANTED = {
    "target": {"target": off(formulas.target)},
    "shade": {"reflected": off(formulas.reflected)},
    "jacobian": {"jacobian": off(formulas.jacobian)},
    "finalize": {"finalized": off(formulas.finalized)},
    "direction": {"density": off(sources.density)},
    "merge": {"preference": old_sum},
    "similar": {"depth_test": "own"},
}


@every_case
def test_control_a_wrong_formula_of_the_replay_is_found(precision, name):
    case = CASES[precision, name]
    rules = replace(CONTRACT_RULES, **PLANTED[case.pass_name])
    assert sum(outside(precision, case, rules).values()) > 0


# ---------------------------------------------------------------- backends


@every_case
def test_what_is_right_passes_beside_exact_values(precision, name):
    case = CASES[precision, name]
    finding = examined_exactly(case, answer(precision, case), precision)
    assert finding.text == ""
    assert finding.passed
    for one in finding.judgement.compared:
        assert np.array_equal(one.expected, exact_outputs(case)[one.name])


@pytest.mark.parametrize("side", [-1, 1])
@every_case
def test_one_bound_off_fails_and_within_it_passes(precision, name, side):
    case = CASES[precision, name]
    right = answer(precision, case)
    compared = examined_exactly(case, right, precision).judgement.compared
    reals = [c for c in compared if c.name in right and c.found.dtype.kind == "f"]
    for one in reals:
        place = narrowest(one)
        for value, passed in zip(
            about_the_bound(one, place, side), [1, 0], strict=True
        ):
            out = {**right, one.name: right[one.name].copy()}
            out[one.name][place] = value
            finding = examined_exactly(case, out, precision)
            told = finding.text + finding.at_extremes
            assert (told == "") == passed
            assert finding.passed == (passed or not case.within[place[0]])
            assert passed or f"{one.name} is" in told
            assert finding.passed or f"row {place[0]} {one.name} is" in told
    assert reals or case.pass_name == "similar"


def narrowest(one):
    """Place with the least bound for its size."""
    size = np.abs(one.expected)
    known = (one.allowed > 0) & (size > 1e-30) & (size < 1e30)
    share = np.where(known, one.allowed / np.maximum(size, 1e-30), np.inf)
    return np.unravel_index(share.argmin(), share.shape)


def about_the_bound(one, place, side):
    """The last number of the type that is allowed, and the first that is not."""
    expected, allowed = one.expected[place], one.allowed[place]
    within = one.found.dtype.type(expected + side * allowed)
    if abs(float(within) - expected) > allowed:
        within = np.nextafter(within, one.found.dtype.type(expected))
    beyond = np.nextafter(within, within.dtype.type(side * np.inf))
    assert abs(float(within) - expected) <= allowed < abs(float(beyond) - expected)
    return within, beyond


FLAGS = {
    "kernel-merge": "second",
    "kernel-merge-extremes": "second",
    "kernel-similar": "similar",
    "kernel-similar-extremes": "similar",
}


@pytest.mark.parametrize("precision", BACKENDS)
@pytest.mark.parametrize(("name", "flag"), FLAGS.items())
def test_a_forced_decision_is_forced_and_a_free_one_is_free(precision, name, flag):
    case = CASES[precision, name]
    right = answer(precision, case)
    finding = examined_exactly(case, right, precision)
    (one,) = (c for c in finding.judgement.compared if c.name == flag)
    forced = one.allowed == 0
    assert forced.mean() > 0.8
    assert np.array_equal(right[flag][forced], one.expected[forced])
    free = ~forced & ~uncounted(case)
    for rows, passed in ((forced & case.within, False), (free, not case.random)):
        if rows.any():
            flipped = np.where(rows, 1 - right[flag], right[flag]).astype(np.uint32)
            out = {**right, flag: flipped}
            assert examined_exactly(case, out, precision).passed == passed


def uncounted(case):
    """Rows of two without weight, and of u at an end, (N,) bool: nobody counts them."""
    if case.pass_name != "merge":
        return np.zeros(case.rows, bool)
    u, w = case.inputs["u"], case.inputs["w_a"] + case.inputs["w_b"]
    return (u == 0) | (u >= 1 - 2.0**-24) | (w == 0)


def test_at_the_limits_of_similarity_either_answer_is_right():
    case = CASES["float32", "kernel-similar-extremes"]
    judgement = examined_exactly(case, answer("float32", case), "float32").judgement
    (one,) = judgement.compared
    given = case.inputs
    dots = (given["normal_a"] * given["normal_b"]).sum(axis=1)
    near, far = (
        f(given["depth_a"], given["depth_b"]) for f in (np.minimum, np.maximum)
    )
    met = (far > 0) & ((dots == 0.5) | (16 * near == 15 * far))
    assert met.sum() == 3 * 7
    assert (one.allowed[met] == 1).all()
    assert (one.expected[met] == 1).all()
    assert (one.expected[near == 0] == 0).all()
    assert (one.allowed[near == 0] == 0).all()


def test_diagnosis_names_what_exact_values_have_found():
    probes = [p for p in kernel_probes("float32") if p.case.pass_name == "jacobian"]
    swap = {"x_from": "x_to", "x_to": "x_from"}

    def inverted(case):
        given = {swap.get(name, name): a for name, a in case.inputs.items()}
        return FLOAT32.jacobian(**given)

    probes = [p for p in probes if p.examine is examined_exactly]
    answers = [examined(CONTRACT, "float32", p, inverted(p.case)) for p in probes]
    assert [a.finding.passed for a in answers] == [False] * len(answers)
    assert "instead of" in answers[0].finding.text
    named = diagnose("jacobian", answers, "float32").matches
    assert [h.name for h in named] == ["jacobian-inverted"]

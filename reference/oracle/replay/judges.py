"""A judge for each pass: the backend's outputs beside the contract's."""

from collections.abc import Callable, Mapping
from math import cos, radians

import numpy as np

from restir_gi.reference.numerics.rng import pcg4d, to_unit_interval
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.replay.bounded import (
    Bounded,
    constant,
    exact,
    rounding_of,
)
from restir_gi.reference.oracle.replay.cached import target_by
from restir_gi.reference.oracle.replay.direction import judge_direction
from restir_gi.reference.oracle.replay.judgement import (
    Decisions,
    Judgement,
    beside,
    either,
    exactly,
    of_light,
)
from restir_gi.reference.oracle.replay.neighbors import judge_neighbors, similarity
from restir_gi.reference.oracle.replay.points import (
    ReceiverPoint,
    point_of,
    receiver_of,
    receiver_read,
    sample_read,
    with_given,
)
from restir_gi.reference.oracle.replay.reuse import judge_reuse
from restir_gi.reference.oracle.replay.rules import Rules
from restir_gi.reference.oracle.replay.stream import at_an_end
from restir_gi.reference.oracle.replay.verbs import choose, inner

Judge = Callable[[Case, Buffers, Rules, Precision], Judgement]


def _random(case: Case, out: Buffers, rules: Rules, precision: Precision) -> Judgement:
    key = case.inputs["key"].copy()
    key[:, list(rules.ignored_words)] = 0
    words = np.stack(pcg4d(key[:, 0], key[:, 1], key[:, 2], key[:, 3]), axis=1)
    u = to_unit_interval(words)
    return Judgement((exactly("words", out["words"], words), exactly("u", out["u"], u)))


def _target(case: Case, out: Buffers, rules: Rules, precision: Precision) -> Judgement:
    rounding = rounding_of(precision)
    x, y = receiver_of(case.inputs, rounding), point_of(case.inputs, rounding)
    p_hat = rules.target(case.settings["target"], x, y)
    return Judgement((beside("p_hat", out["p_hat"], p_hat),))


def _jacobian(
    case: Case, out: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    rounding = rounding_of(precision)
    places = {name: exact(array, rounding) for name, array in case.inputs.items()}
    none = places["normal"]
    x_from = ReceiverPoint(places["x_from"], none, none)
    x_to = ReceiverPoint(places["x_to"], none, none)
    y = point_of({**case.inputs, "radiance": case.inputs["normal"]}, rounding)
    J = rules.shift_jacobian(x_from, x_to, y)
    return Judgement((beside("jacobian", out["jacobian"], J),))


def _merge(case: Case, out: Buffers, rules: Rules, precision: Precision) -> Judgement:
    given = {n: exact(a, rounding_of(precision)) for n, a in case.inputs.items()}
    w_a, w_b = given["w_a"], given["w_b"]
    prefers = rules.preference(given["u"], w_a, w_b)
    second = either("second", out["second"], _decided(prefers, w_a, w_b))
    looked_at = ((w_a.value > 0) | (w_b.value > 0)) & ~at_an_end(given["u"].value)
    flipped = (second.found != second.expected) & (second.excess <= 1) & looked_at
    differing, mean = int(flipped.sum()), _open_merges(given)
    return Judgement(
        (
            second,
            beside("w", out["w"], rules.merged_weight(w_a, w_b)),
            beside("M", out["M"], rules.merged_confidence(given["M_a"], given["M_b"])),
        ),
        {"u (w_a + w_b)": given["u"].value * (w_a + w_b).value, "w_b": w_b.value},
        Decisions(np.zeros(case.rows, bool), differing, mean),
        case.random,
    )


def _decided(prefers: Bounded, w_a: Bounded, w_b: Bounded) -> Bounded:
    """A preference that never keeps a weight of 0 beside another, and any beside 0."""
    never = (w_b.value == 0) & (prefers.value <= 0)
    value = np.where(never, -1.0, prefers.value)
    error = np.where(never, 0.0, prefers.error)
    # Where both are 0 nothing is kept, and nobody looks.
    either_way = (w_a.value == 0) & (w_b.value == 0)
    return Bounded(value, np.where(either_way, np.inf, error), prefers.rounding)


def _open_merges(given: Mapping[str, Bounded]) -> float:
    S = given["w_a"] + given["w_b"]
    margin = given["w_b"] - given["u"] * S
    return float(
        np.divide(
            2 * margin.error,
            S.value,
            where=(S.value > 0) & ~at_an_end(given["u"].value),
            out=np.zeros_like(S.value),
        ).sum()
    )


def _finalize(
    case: Case, out: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    given = {n: exact(a, rounding_of(precision)) for n, a in case.inputs.items()}
    W = rules.closed(given["w"], given["p_hat"], given["Z"])
    return Judgement((beside("W", out["W"], saturated(W, precision)),))


def saturated(x: Bounded, precision: Precision) -> Bounded:
    """Numbers that a backend may only hold up to the largest of its type.

    Parameters
    ----------
    x : Bounded; not negative

    Returns
    -------
    Bounded; beyond a quarter of the largest number anything above that is allowed
    """
    most = float(np.finfo(precision).max)
    beyond = x.value + x.error > most / 4
    value = np.where(beyond, most, x.value)
    return Bounded(value, np.where(beyond, most * 0.75, x.error), x.rounding)


def _similar(case: Case, out: Buffers, rules: Rules, precision: Precision) -> Judgement:
    given = {n: exact(a, rounding_of(precision)) for n, a in case.inputs.items()}
    alike = similarity(
        given["normal_a"],
        given["depth_a"],
        given["normal_b"],
        given["depth_b"],
        cos(radians(float(case.settings["max_angle"]))),
        float(case.settings["max_depth"]),
        rules,
    )
    return Judgement((either("similar", out["similar"], alike),))


def _initial(case: Case, out: Buffers, rules: Rules, precision: Precision) -> Judgement:
    rounding = rounding_of(precision)
    x, y = receiver_of(case.inputs, rounding), point_of(case.inputs, rounding)
    pdf = exact(case.inputs["pdf"], rounding)
    p_hat = target_by(rules.target, case.settings["target"], x, with_given(y, case, 0))
    w = rules.fresh_weight(p_hat, pdf)
    M = rules.fresh_confidence(w)
    W = rules.closed(w, p_hat, M)
    if rules.null_weight == "1/pdf":
        some = (p_hat.value > 0) | (p_hat.error > 0)
        W = choose(some, W, constant(1.0, pdf) / pdf)
    found = beside("p_hat", out["p_hat"], p_hat)
    # A target that rounding cannot tell from 0 may be 0, and then W is.
    unsure = ~np.isfinite(W.error)
    W = choose(unsure, Bounded(W.value, np.abs(W.value) * 2, rounding), W)
    weights = of_light(beside("W", out["W"], W), case.inputs["radiance"])
    return Judgement(
        (found, weights, beside("M", out["M"], M)),
        {"p_hat": p_hat.value, "pdf": pdf.value},
    )


def _shade(case: Case, out: Buffers, rules: Rules, precision: Precision) -> Judgement:
    rounding = rounding_of(precision)
    x, y = receiver_read(case, rounding), sample_read(case, rounding)
    W = exact(case.inputs["W"], rounding)
    f = rules.reflected(x, y)
    color = _seen(case, rules.shaded(f, W), rules)
    cosine = inner(x.normal, y.position - x.position)
    return Judgement(
        (beside("color", out["color"], color),),
        {"f": f.value, "W": W.value, "n·(x_s − x)": cosine.value},
    )


def _seen(case: Case, color: Bounded, rules: Rules) -> Bounded:
    """Light of samples that visible points see, where that is asked, (N, 3)."""
    visible = case.inputs.get("visible")
    if visible is None or rules.shading_sees == "never":
        return color
    seen = (visible != 0) ^ (rules.shading_sees == "turned")
    return choose(seen, color, constant(0.0, color))


JUDGES: Mapping[str, Judge] = {
    "random": _random,
    "direction": judge_direction,
    "target": _target,
    "jacobian": _jacobian,
    "merge": _merge,
    "finalize": _finalize,
    "similar": _similar,
    "initial": _initial,
    "temporal": judge_reuse,
    "moved": judge_reuse,
    "neighbors": judge_neighbors,
    "spatial": judge_reuse,
    "fused": judge_reuse,
    "shade": _shade,
}

"""Replay of what cells are looked up for: light reservoirs, and suffixes of paths."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import pi

import numpy as np

from restir_gi.extensions.oracle.reuse.replay import judge_path_reuse
from restir_gi.extensions.oracle.reuse.weights import of_kept
from restir_gi.hashgrid.oracle.rules import LightRules, gridded, whole_setting
from restir_gi.reference.numerics.arrays import Indices, Masks
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.replay.bounded import (
    Bounded,
    constant,
    exact,
    rounding_of,
)
from restir_gi.reference.oracle.replay.formulas import preference
from restir_gi.reference.oracle.replay.geometry import luminance
from restir_gi.reference.oracle.replay.halves import (
    beside_halves,
    counted_in_half,
    held_in_half,
    up_to_the_largest,
)
from restir_gi.reference.oracle.replay.judgement import (
    Compared,
    Decisions,
    Judgement,
    beside,
    either,
    exactly,
    in_rows,
)
from restir_gi.reference.oracle.replay.rules import Rules
from restir_gi.reference.oracle.replay.slots import nothing
from restir_gi.reference.oracle.replay.stream import (
    Weighted,
    by_chance,
    choices_of,
    left_open,
    sums_of,
)
from restir_gi.reference.oracle.replay.verbs import (
    choose,
    inner,
    square_root,
    times,
    where_positive,
)


def judge_cell_similar(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``cell_similar``."""
    rounding, kind = rounding_of(precision), gridded(rules).light.similar
    a, b = (exact(case.inputs[f"normal_{k}"], rounding) for k in "ab")
    cosine = inner(a, b)
    if kind == "both sides":
        cosine = abs(cosine)
    powers = {"cosine": cosine, "square": cosine * cosine}
    power = powers.get(kind, cosine * cosine * cosine * cosine)
    slack = power - constant(0.5, power)
    # The root of the threshold, as a literal, and a power by logarithms.
    slack = Bounded(slack.value, slack.error + 8 * rounding.unit, rounding)
    least = constant(-1.0, slack)
    slack = choose(cosine.surely_not_positive, least, slack)
    if kind == "inverted":
        slack = -slack
    return Judgement((either("similar", outputs["similar"], slack),))


def judge_light_target(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``light_target``."""
    rounding, part = rounding_of(precision), gridded(rules).light
    given = {n: exact(array, rounding) for n, array in case.inputs.items()}
    v = given["light_position"] - given["visible_position"]
    squared = inner(v, v)
    d = square_root(squared)
    one = constant(1.0, d)
    theta, phi = inner(given["visible_normal"], v), -inner(given["light_normal"], v)
    scale = one
    for _ in range(part.distances):
        scale = scale / d
    for side, kind in ((theta, part.surface_cosine), (phi, part.light_cosine)):
        cosine = abs(side) / d if kind == "absolute" else side / d
        scale = scale if kind == "left out" else scale * cosine
    if part.area:
        scale = scale * given["area"]
    if part.pi:
        scale = scale / constant(pi, scale)
    color = given["radiance"]
    if part.albedo:
        color = color * given["albedo"]
    value = times(color, scale)
    for side, kind in ((theta, part.surface_cosine), (phi, part.light_cosine)):
        if kind != "absolute":
            value = where_positive(side, value)
    return Judgement(
        (beside("value", outputs["value"], value),),
        {"d · cos θ": theta.value, "d · cos φ": phi.value, "d²": squared.value},
    )


@dataclass(frozen=True, slots=True, eq=False)
class _DrawnLight:
    """A candidate in a stream."""

    w: Bounded
    u: Bounded


def _preference(kind: str) -> Callable[[Bounded, Bounded, Bounded], Bounded]:
    """Positive where a candidate is kept."""

    def sum_before(u: Bounded, w_before: Bounded, w: Bounded) -> Bounded:
        return w - u * w_before

    def turned(u: Bounded, w_before: Bounded, w: Bounded) -> Bounded:
        return preference(constant(1.0, u) - u, w_before, w)

    return {"sum": preference, "sum before": sum_before, "turned": turned}[kind]


@dataclass(frozen=True, slots=True, eq=False)
class _Kept:
    """Of a stream, N rows: what the backend keeps, and whether it may."""

    slot: Indices
    surely: Indices
    illegal: Masks
    empty: Masks
    S: Bounded
    decisions: Decisions


def _kept(stream: list[Weighted], found: Indices, rules: Rules) -> _Kept:
    """Where the backend's choice is one that rounding allows it is gone on with."""
    sums = sums_of(stream, rules)
    S = sums[-1]
    empty = (S.value == 0) & (S.error == 0)
    allowed, surely = choices_of(stream, sums, rules)
    row = np.arange(len(found))
    known = (found >= 0) & (found < len(stream))
    kept = np.where(known & ~empty, found, surely)
    illegal = ~empty & ~(known & allowed[kept, row])
    by_luck = (kept != surely) & ~illegal & ~empty & by_chance(stream)
    decisions = Decisions(illegal, int(by_luck.sum()), left_open(stream, sums))
    return _Kept(kept, surely, illegal, empty, S, decisions)


def judge_light_candidates(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``light_candidates``."""
    rounding, part = rounding_of(precision), gridded(rules).light
    given = {n: exact(array, rounding) for n, array in case.inputs.items()}
    count = given["p_hat"].value.shape[1]
    p_hat = [given["p_hat"][:, k] for k in range(count)]
    w = [_drawn_weight(case, given, k, part) for k in range(count)]
    stream: list[Weighted] = [_DrawnLight(w[k], given["u"][:, k]) for k in range(count)]
    rules = replace(rules, preference=_preference(part.kept_by))
    kept = _kept(stream, outputs["slot"].astype(np.int64), rules)
    every = constant(float(count), kept.S)
    useful = exact(np.sum([each.value > 0 for each in w], axis=0), rounding)
    counted = every if part.nulls_count else useful
    here = p_hat[0] if part.first_target else of_kept(p_hat, kept.slot)
    divisor = {"K": counted, "1": constant(1.0, every)}[part.counted]
    W = choose(kept.empty, nothing(kept.S), kept.S / here / divisor)
    M = counted if part.confidence == "K" else constant(1.0, every)
    free = np.where(kept.illegal, 0.0, np.inf)
    terms = {f"w of slot {k}": each.value for k, each in enumerate(w)}
    return Judgement(
        (
            Compared("slot", kept.slot, kept.surely, free),
            *_stored(outputs, W, M, part.held),
        ),
        terms | {"sum of w": kept.S.value, "p_hat": here.value},
        kept.decisions,
        case.random,
    )


def _stored(outputs: Buffers, W: Bounded, M: Bounded, how: str) -> list[Compared]:
    """W and M beside what is kept of them."""
    W_found = up_to_the_largest(outputs["W"])
    return [
        beside("W", W_found, held_in_half(W, how)),
        beside("M", outputs["M"], counted_in_half(M, how)),
        *beside_halves("W", outputs["W"], how),
        *beside_halves("M", outputs["M"], how),
    ]


def _drawn_weight(
    case: Case, given: Mapping[str, Bounded], k: int, part: LightRules
) -> Bounded:
    w = given["p_hat"][:, k]
    possible = np.ones(case.rows, bool)
    for name, asked in (("choice", part.choice), ("density", part.density)):
        factor = given[name][:, k]
        possible &= factor.value > 0
        if asked:
            w = w * factor if part.times_pdf else w / factor
    return choose(possible, w, nothing(w))


def judge_light_reuse(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``light_reuse``: as pass ``path_reuse``, whose Jacobians are 1."""
    jacobian = np.ones_like(case.inputs["W"])
    as_paths = replace(
        case,
        pass_name="path_reuse",
        settings={**case.settings, "canonical": 0},
        inputs={**case.inputs, "jacobian": jacobian},
    )
    part = replace(rules, part=gridded(rules).light.reuse)
    return judge_path_reuse(as_paths, outputs, part, precision)


# ---------------------------------------------------------------- suffixes of paths


def judge_bounce_reservoir(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``bounce_reservoir``."""
    rounding, part = rounding_of(precision), gridded(rules).suffix
    given = {n: exact(array, rounding) for n, array in case.inputs.items()}
    longer = given["value_suffix"]
    if part.step_weight:
        longer = given["weight"] * longer
    values = [given["value_end"], longer]
    p_hat = [luminance(value) for value in values]
    target = luminance(given["value_suffix"]) if part.target_of_suffix else p_hat[1]
    W_suffix = given["W_suffix"]
    w_longer = target * W_suffix
    if not part.suffix_weight:
        w_longer = choose(W_suffix.value > 0, target, nothing(target))
    w_end = given["w_end"] if part.ends_compete else nothing(given["w_end"])
    u = given["u"]
    stream: list[Weighted] = [_DrawnLight(w_end, u), _DrawnLight(w_longer, u)]
    rules = replace(rules, preference=_preference(part.kept_by))
    kept = _kept(stream, outputs["longer"].astype(np.int64), rules)
    one = constant(1.0, kept.S)
    M = one if part.nulls_count else choose(kept.empty, nothing(one), one)
    W = kept.S / of_kept(p_hat, kept.slot)
    if part.averaged:
        M = constant(2.0, one)
        W = W / M
    W = choose(kept.empty, nothing(kept.S), W)
    value = choose(kept.slot == 1, values[1], values[0])
    free = np.where(kept.illegal, 0.0, np.inf)
    return Judgement(
        (
            Compared("longer", kept.slot, kept.surely, free),
            in_rows(~kept.empty, beside("value", outputs["value"], value)),
            beside("W", outputs["W"], W),
            beside("M", outputs["M"], M),
        ),
        {"w_longer": w_longer.value, "sum of w": kept.S.value},
        kept.decisions,
        case.random,
    )


def judge_path_cache(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``path_cache``."""
    rounding, part = rounding_of(precision), gridded(rules).suffix
    inputs = case.inputs
    joined = (inputs["joint"] == 2) | (not part.joint_asked)
    W = np.where(joined, inputs["W"], 0.0)
    M = np.where((W > 0) | part.null_confidence, inputs["M"], 0.0)
    rough = inputs["rough"] == 1
    stored = {
        "all": rough,
        "useful": rough & (W > 0),
        "joined": rough & (inputs["joint"] == 2),
        "any roughness": np.ones(case.rows, bool),
    }[part.stored]
    held = _stored(outputs, exact(W, rounding), exact(M, rounding), part.held)
    return Judgement(
        (
            exactly("stored", outputs["stored"], stored),
            *(in_rows(stored, one) for one in held),
        )
    )


def judge_suffix_reach(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``suffix_reach``."""
    part, inputs = gridded(rules).suffix, case.inputs
    v = inputs["v"].astype(np.int64) if part.from_v else 1
    most = whole_setting(case, "bounces", 2**20) + 2 - v
    end = inputs["end"].astype(np.int64)
    everyone = np.ones(case.rows, bool)
    fits = {"at most": end <= most, "below": end < most, "any": everyone}[part.reach]
    value = np.where(fits[:, None], inputs["value"], 0.0)
    jacobian = np.where(fits, inputs["jacobian"], 0.0)
    return Judgement(
        (
            exactly("value", outputs["value"], value),
            exactly("jacobian", outputs["jacobian"], jacobian),
        )
    )


LIGHT_JUDGES: Mapping[str, Callable[[Case, Buffers, Rules, Precision], Judgement]] = {
    "cell_similar": judge_cell_similar,
    "light_target": judge_light_target,
    "light_candidates": judge_light_candidates,
    "light_reuse": judge_light_reuse,
    "bounce_reservoir": judge_bounce_reservoir,
    "path_cache": judge_path_cache,
    "suffix_reach": judge_suffix_reach,
}

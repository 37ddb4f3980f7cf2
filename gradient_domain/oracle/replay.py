"""Replay of pairs: values, weights, targets, shifts and reservoirs."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from restir_gi.extensions.oracle.reuse.tables import ReuseTables
from restir_gi.extensions.oracle.reuse.weights import arriving, divisor, of_kept, total
from restir_gi.gradient_domain.oracle.rules import PairRules, pairing
from restir_gi.gradient_domain.oracle.samples import (
    SIGNS,
    BoundedSample,
    added_by,
    differing,
    integrand_of,
    sample_in,
    share_of,
    target_of,
    zero_like,
)
from restir_gi.reference.numerics.arrays import Indices, Masks
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.replay.bounded import (
    Bounded,
    Rounding,
    constant,
    exact,
    rounding_of,
)
from restir_gi.reference.oracle.replay.formulas import capped
from restir_gi.reference.oracle.replay.geometry import luminance
from restir_gi.reference.oracle.replay.judgement import (
    Compared,
    Decisions,
    Judgement,
    beside,
    exactly,
    in_rows,
)
from restir_gi.reference.oracle.replay.rules import Rules
from restir_gi.reference.oracle.replay.stream import (
    by_chance,
    choices_of,
    left_open,
    sums_of,
)
from restir_gi.reference.oracle.replay.verbs import choose, times


def _given(case: Case, rounding: Rounding) -> dict[str, Bounded]:
    return {name: exact(array, rounding) for name, array in case.inputs.items()}


def judge_pair_value(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``pair_value``."""
    s = sample_in(case.inputs, rounding_of(precision))
    G = differing(s, pairing(rules), None)
    return Judgement((beside("G", outputs["G"], G),))


def judge_pair_weight(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``pair_weight``."""
    given = _given(case, rounding_of(precision))
    omega = share_of(given["p_base"], given["p_offset"], given["inner"], pairing(rules))
    return Judgement((beside("omega", outputs["omega"], omega),))


def judge_pair_target(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``pair_target``."""
    part, sign = pairing(rules), SIGNS[str(case.settings["sign"])]
    s = sample_in(case.inputs, rounding_of(precision))
    H = integrand_of(s, part)
    return Judgement(
        (
            beside("contribution", outputs["contribution"], added_by(s, sign, part)),
            beside("p_hat", outputs["p_hat"], target_of(s, sign, part)),
        ),
        {"H": H.value},
    )


# ------------------------------------------------ estimates


def _columns(case: Case, rounding: Rounding) -> list[BoundedSample]:
    """Samples in columns 0 and 1, with k by the column where there is none."""
    found = []
    for c in (0, 1):
        s = sample_in(case.inputs, rounding, (c,))
        k_is_told = "k" in case.inputs
        second = s.second if k_is_told else np.full(case.rows, c == 1)
        found.append(replace(s, second=second))
    return found


def judge_pair_estimate(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``pair_estimate``."""
    rounding, part = rounding_of(precision), pairing(rules)
    W = exact(case.inputs["W"], rounding)
    s = _columns(case, rounding)
    two = case.settings["reservoirs"] == "two"
    signs = (1, -1) if two or not part.one_is_both else (0,)
    if part.plus_alone:
        signs = signs[:1]
    terms = [
        times(added_by(s[c], sign, part), W[:, c if part.own_weight else 0])
        for c, sign in enumerate(signs)
    ]
    delta = total(terms)
    return Judgement(
        (beside("delta", outputs["delta"], delta),),
        {f"part {c}": term.value for c, term in enumerate(terms)},
    )


def judge_after_estimate(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``after_estimate``."""
    rounding, part = rounding_of(precision), pairing(rules)
    W, terms = exact(case.inputs["W"], rounding), []
    for c, s in enumerate(_columns(case, rounding)):
        p, q = luminance(s.base), luminance(s.offset)
        if part.densities:
            p = q = constant(1.0, s.inner)
        share = share_of(p, q, s.inner, part)
        own = W[:, c if part.own_weight else 0]
        terms.append(times(differing(s, part, share), own))
    delta = total(terms[:1] if part.plus_alone else terms)
    return Judgement(
        (beside("delta", outputs["delta"], delta),),
        {f"part {c}": term.value for c, term in enumerate(terms)},
    )


# ------------------------------------------------ new samples


@dataclass(frozen=True, slots=True, eq=False)
class _PairStream:
    w: Bounded
    u: Bounded


def judge_pair_initial(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``pair_initial``."""
    rounding, part = rounding_of(precision), pairing(rules)
    sign, given = SIGNS[str(case.settings["sign"])], _given(case, rounding)
    u = given["u"]
    u = constant(1.0, u) - u if part.u_turned else u
    p_hat = [target_of(s, sign, part) for s in _columns(case, rounding)]
    m = constant(part.candidate, u)
    slots = [_PairStream(m * p * given["W"][:, c], u) for c, p in enumerate(p_hat)]
    sums = sums_of(slots, rules)
    S = sums[-1]
    allowed, surely = choices_of(slots, sums, rules)
    row, found = np.arange(case.rows), outputs["k"].astype(np.int64)
    empty, some = S.value == 0, S.surely_positive
    known = (found >= 0) & (found < 2)
    kept = np.where(known & ~empty, found, surely)
    illegal = some & ~(known & allowed[kept, row])
    here = of_kept(p_hat, kept)
    W = S / (p_hat[0] if part.first_target else here)
    W = W / constant(2.0, W) if part.divided else W
    W = choose(empty & (S.error == 0), zero_like(W), W)
    M = constant(float(part.candidates), W)
    if not part.nulls_count:
        M = choose(empty, zero_like(M), M)
    differs = int(((kept != surely) & ~illegal & ~empty & by_chance(slots)).sum())
    return Judgement(
        (
            Compared("k", found, surely, np.where(illegal, 0.0, np.inf)),
            in_rows(~empty, beside("p_hat", outputs["p_hat"], here)),
            beside("W", outputs["W"], W),
            beside("M", outputs["M"], M),
        ),
        {
            "w of k = 0": slots[0].w.value,
            "w of k = 1": slots[1].w.value,
            "sum of w": S.value,
        },
        Decisions(illegal, differs, left_open(slots, sums), "k that was kept"),
        case.random,
    )


# ------------------------------------------------ shifts


def _pixel(case: Case, second: Masks) -> Indices:
    found: Indices = np.where(second, case.inputs["second"], case.inputs["first"])
    return found


def judge_inner_shift(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``inner_shift``."""
    part, given = pairing(rules), _given(case, rounding_of(precision))
    second = case.inputs["k"] == 1
    leads = second if part.offset_pixel == "own" else ~second
    row, column = np.arange(case.rows), leads.astype(int)
    back = second if part.step == "onward" else np.zeros_like(second)
    found = [exactly("pixel", outputs["pixel"], _pixel(case, leads))]
    for axis in ("x", "y"):
        x, step = given[axis], given[f"d{axis}"]
        to = x + choose(back, -step, step) if part.step != "none" else x
        found.append(beside(f"{axis}_to", outputs[f"{axis}_to"], to))
    J = given["jacobian_at"][row, column]
    f = given["value_at"][row, column]
    if part.refused:
        f = choose(J.value > 0, f, zero_like(f))
    found += [
        beside("offset", outputs["offset"], f),
        beside("inner", outputs["inner"], J),
    ]
    return Judgement(tuple(found))


def judge_outer_shift(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``outer_shift``."""
    part, given = pairing(rules), _given(case, rounding_of(precision))
    second = (case.inputs["k"] == 1) == part.k_kept
    row, column = np.arange(case.rows), second.astype(int)
    J, base = (given[name][row, column] for name in ("jacobian_at", "value_at"))
    offset, inner = (given[name][row, column] for name in ("rebuilt_at", "inner_at"))
    if part.rebuilt in ("jacobian", "nothing"):
        offset = given["offset_from"]
    if part.rebuilt in ("value", "nothing"):
        inner = given["inner_from"]
    there, none = J.value > 0, zero_like(J)
    outer = {
        "base": J,
        "times inner": choose(inner.value > 0, J * inner, J),
        "none": constant(1.0, J),
        "over": constant(1.0, J) / J,
    }[part.outer]
    if part.refused:
        base, offset = (choose(there, f, zero_like(f)) for f in (base, offset))
        inner = choose(there, inner, none)
    return Judgement(
        (
            exactly("pixel", outputs["pixel"], _pixel(case, second)),
            beside("base", outputs["base"], base),
            beside("offset", outputs["offset"], offset),
            beside("inner", outputs["inner"], inner),
            beside("jacobian", outputs["jacobian"], choose(there, outer, none)),
        )
    )


# ------------------------------------------------ reuse


@dataclass(frozen=True, slots=True, eq=False)
class _ReuseStream:
    w: Bounded
    u: Bounded


def judge_pair_reuse(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``pair_reuse``.

    Rows in which rounding leaves open whether a target is 0 are not looked at: who
    could have made a sample hangs on it.
    """
    rounding, part = rounding_of(precision), pairing(rules)
    t, unsure = _tables(case, part, rounding)
    reuse = part.reuse
    w = arriving(t, reuse)
    numbers = [t.one - u for u in t.u] if part.u_turned else t.u
    slots = [_ReuseStream(*each) for each in zip(w, numbers, strict=True)]
    sums = sums_of(slots, rules)
    S = sums[-1]
    allowed, surely = choices_of(slots, sums, rules)
    row, found = np.arange(case.rows), outputs["slot"].astype(np.int64)
    known, empty = (found >= 0) & (found < len(slots)), S.value == 0
    kept = np.where(known & ~empty, found, surely)
    illegal = ~empty & ~(known & allowed[kept, row]) & ~unsure
    Z, here, M = divisor(t, kept, reuse), of_kept(t.here, kept), total(t.M)
    W = choose(empty, zero_like(S), S / here / Z)
    M = M if reuse.capped == "never" else capped(M, t.cap)
    differs = (kept != surely) & ~illegal & ~empty & by_chance(slots)
    looked_at = ~unsure
    return Judgement(
        (
            Compared("slot", found, surely, np.where(illegal, 0.0, np.inf)),
            in_rows(looked_at & ~empty, beside("p_hat", outputs["p_hat"], here)),
            in_rows(looked_at, beside("W", outputs["W"], W)),
            beside("M", outputs["M"], M),
        ),
        {"sum of w": S.value, "Z": Z.value, "open": unsure.astype(float)},
        Decisions(illegal, int((differs & looked_at).sum()), left_open(slots, sums)),
        case.random,
    )


def _tables(
    case: Case, part: PairRules, rounding: Rounding
) -> tuple[ReuseTables, Masks]:
    """Tables of targets, and rows in which one may be 0 or not."""
    sign, inputs, rules = SIGNS[str(case.settings["sign"])], case.inputs, part.reuse
    size = inputs["W"].shape[1]
    given = {n: exact(inputs[n], rounding) for n in ("W", "M", "u", "jacobian")}
    there = [inputs["there"][:, k] == 1 for k in range(size)]
    none = zero_like(given["W"][:, 0])
    W, M = (
        [choose(there[k], given[n][:, k], none) for k in range(size)]
        for n in ("W", "M")
    )
    if rules.empty_count:
        M = [given["M"][:, k] for k in range(size)]
    if not rules.nulls_count:
        M = [choose(W[k].value > 0, M[k], none) for k in range(size)]
    at_source = [sample_in(inputs, rounding, (k,), "_from") for k in range(size)]
    at_here = [
        replace(sample_in(inputs, rounding, (k,)), second=at_source[k].second)
        for k in range(size)
    ]
    if part.rebuilt != "all":
        at_here = [
            _carried(h, s, part) for h, s in zip(at_here, at_source, strict=True)
        ]
    J = [given["jacobian"][:, k] for k in range(size)]
    base = [target_of(s, sign, part) for s in at_source]
    here = [
        choose(j.value > 0, target_of(s, sign, part), none)
        for s, j in zip(at_here, J, strict=True)
    ]
    c = int(min(float(case.settings["canonical"]), size - 1))
    if part.outer == "times inner":
        J = [
            choose(s.inner.value > 0, j * s.inner, j)
            for s, j in zip(at_here, J, strict=True)
        ]
    at = _at_others(case, at_here, sign, part, rounding)
    made = [choose(j.value > 0, b / j, none) for b, j in zip(base, J, strict=True)]
    if rules.made == "none":
        made = [choose(j.value > 0, b, none) for b, j in zip(base, J, strict=True)]
    tables = ReuseTables(
        W,
        M,
        u=[given["u"][:, k] for k in range(size)],
        here=base if rules.target_base else here,
        jacobian=J,
        made=made,
        at_others=at,
        canonical=c,
        mis=str(case.settings["mis"]),
        cap=float(case.settings["cap"]),
    )
    filled = [w.value > 0 for w in W]
    unsure = np.zeros(case.rows, bool)
    for k in range(size):
        unsure |= filled[k] & (_open(here[k]) | _open(base[k]))
        unsure |= filled[k] & np.any(_open(at[:, k]), axis=1)
    return tables, unsure


def _open(p: Bounded) -> Masks:
    """Whether rounding leaves open that a target is 0."""
    found: Masks = (p.error > 0) & (p.value <= p.error)
    return found


def _carried(
    here: BoundedSample, made: BoundedSample, part: PairRules
) -> BoundedSample:
    """Samples with what is not rebuilt from where they come from."""
    offset = here.offset if part.rebuilt == "value" else made.offset
    inner = here.inner if part.rebuilt == "jacobian" else made.inner
    return replace(here, offset=offset, inner=inner)


def _at_others(
    case: Case,
    at_here: list[BoundedSample],
    sign: int,
    part: PairRules,
    rounding: Rounding,
) -> Bounded:
    """Target of each slot's sample at each source, times the Jacobian, (N, K, K)."""
    shape = case.inputs["jacobian_at"].shape
    flat = {
        name: case.inputs[name].reshape(-1, *case.inputs[name].shape[3:])
        for name in ("base_at", "offset_at", "inner_at", "jacobian_at")
    }
    there = sample_in(flat, rounding, (), "_at")
    second = np.stack([s.second for s in at_here], axis=1)
    there = replace(there, second=np.repeat(second.ravel(), shape[2]))
    if part.carried_at_others:
        there = replace(
            there,
            offset=_repeated([s.offset for s in at_here], shape[2]),
            inner=_repeated([s.inner for s in at_here], shape[2]),
        )
    p = target_of(there, sign if part.inverse_signed else 0, part)
    J = exact(flat["jacobian_at"], rounding)
    found = choose(J.value > 0, p * J, zero_like(p))
    return Bounded(found.value.reshape(shape), found.error.reshape(shape), rounding)


def _repeated(slots: list[Bounded], times: int) -> Bounded:
    """Numbers of each slot, as often as there are sources, row after row."""

    def flat(arrays: list[Any]) -> Any:
        each = np.stack(arrays, axis=1)
        return np.repeat(each.reshape(-1, *each.shape[2:]), times, axis=0)

    value, error = flat([s.value for s in slots]), flat([s.error for s in slots])
    return Bounded(value, error, slots[0].rounding)

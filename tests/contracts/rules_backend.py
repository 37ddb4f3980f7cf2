"""Backends made of the replay's own rules: what it expects is what they answer."""

import numpy as np

from restir_gi.reference.oracle.builtin.backend import FLOAT32
from restir_gi.reference.oracle.replay.chain import (
    first_of_chain,
    merge_weights,
    merged_with,
)
from restir_gi.reference.oracle.replay.judges import JUDGES
from restir_gi.reference.oracle.replay.mis import CHAINED, with_mis_weights
from restir_gi.reference.oracle.replay.resampling import (
    closed,
    closed_confidence,
    of_kept,
)
from restir_gi.reference.oracle.replay.reuse import STREAMS, stream_of
from restir_gi.reference.oracle.replay.storage import HALF_MOST, STORAGES
from restir_gi.reference.oracle.replay.stream import choices_of, sums_of
from tests.contracts.other_layouts import colors_of, log_luv_words
from tests.mutants.reuse_by_hand import octahedral

LARGEST = 3e38


def answered_by(rules, case, overflows=False):
    """Outputs of a case under some rules, rounded to float32."""
    if case.pass_name in STREAMS:
        return stored(resampled(rules, case), rules.storage, overflows)
    out = dict(getattr(FLOAT32, case.pass_name)(**case.inputs, **case.settings))
    judgement = JUDGES[case.pass_name](case, out, rules, "float32")
    for one in judgement.compared:
        wanted = np.clip(one.expected, -LARGEST, LARGEST)
        out[one.name] = wanted.astype(out[one.name].dtype)
    return out


def resampled(rules, case):
    """Reservoirs of a pass that reuses samples."""
    slots, closing = stream_of(case, rules, "float32")
    follow = chained if rules.normalization in CHAINED else streamed
    kept, total, W, M = follow(rules, slots, closing)
    y, _ = of_kept(slots, kept)
    W = np.where(total == 0, 0.0, np.minimum(W, LARGEST))
    out = {name: getattr(y, name).value for name in ("position", "normal", "radiance")}
    return {n: np.float32(a) for n, a in (out | {"W": W, "M": M}).items()}


def streamed(rules, slots, closing):
    """Slot that is kept, sum of weights, W and M."""
    slots = with_mis_weights(slots, closing, rules)
    sums = sums_of(slots, rules)
    _, kept = choices_of(slots, sums, rules)
    parts, M = closed(slots, kept, sums[-1], closing, rules)
    return kept, sums[-1].value, parts["W"].value, M.value


def chained(rules, slots, closing):
    """The same of merges that are closed one by one."""
    chain, total = first_of_chain(slots), slots[0].w.value
    for k in range(1, len(slots)):
        weights = merge_weights(chain, slots, closing, rules)
        prefers = rules.preference(slots[k].u, *weights).value > 0
        prefers |= (weights[0].value == 0) & (weights[1].value > 0)
        chain = merged_with(chain, weights, prefers, slots, closing, rules)
        total = (weights[0] + weights[1]).value
    _, p_hat = of_kept(slots, chain.kept)
    W = rules.closed(chain.held, p_hat, p_hat / p_hat).value
    return chain.kept, total, W, closed_confidence(chain.M, closing, rules).value


def stored(out, name, overflows=False):
    """Outputs as they come out of storage: its largest number, or infinity beyond."""
    if name == "exact":
        return out
    form = STORAGES[name]
    largest = np.inf if overflows else HALF_MOST
    for buffer, is_half in (("radiance", form.half_radiance), ("W", form.half_weight)):
        if is_half:
            with np.errstate(over="ignore"):
                small = np.minimum(out[buffer], largest).astype(np.float16)
            out[buffer] = small.astype(np.float32)
    if form.shared is not None:
        out["radiance"] = with_shared_exponent(out["radiance"], form.shared)
    if form.log_luv:
        out["radiance"] = through_log_luv(out["radiance"])
    if form.normal_error:
        out["normal"] = np.float32(octahedral(out["normal"].astype(float)))
    return out


def through_log_luv(radiance):
    """Colours as they come out of LogLuv, in single precision."""
    with np.errstate(all="ignore"):
        words = log_luv_words(np.float32, None, np.float32(radiance))
        return np.float32(colors_of(np.float32, None, words))


def with_shared_exponent(radiance, form):
    """Channels of few bits; a largest one that rounds up has the exponent above."""
    radiance = np.minimum(radiance.astype(float), form.most)
    most = np.maximum(radiance.max(axis=1, keepdims=True), 2.0**-120)
    exponent = np.frexp(most)[1]
    exponent += np.rint(np.ldexp(most, form.bits - exponent)) == 2**form.bits
    step = np.maximum(np.ldexp(1.0, exponent - form.bits), form.least_step)
    return np.float32(np.rint(radiance / step) * step)

"""Replay of the passes that look at a pixel's place and time alone."""

import numpy as np

from restir_gi.reference.numerics.rng import pcg4d, to_unit_interval
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.replay.bounded import exact, rounding_of
from restir_gi.reference.oracle.replay.further.numbers import Choice, setting
from restir_gi.reference.oracle.replay.further.rules import further
from restir_gi.reference.oracle.replay.judgement import Judgement, beside, exactly
from restir_gi.reference.oracle.replay.rules import Rules
from restir_gi.reference.oracle.replay.verbs import choose

STREAM = 7 * 64
"""As the contract says."""


def judge_checkerboard(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``checkerboard``."""
    s, part = case.settings, further(rules)
    width, frame = int(s["width"]), int(s["frame"])
    line, column = np.divmod(case.inputs["pixel"].astype(np.int64), width)
    parity = part.parity(column, line, width, frame) % 2
    draws = parity == 0
    if part.history_asked:
        draws |= case.inputs["has_history"] == 0
    terms = {"(x + y + frame) mod 2": parity}
    return Judgement((exactly("draws", outputs["draws"], draws),), terms)


def judge_roulette(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``roulette``.

    The random numbers are exact; a probability that float32 does not hold may be
    rounded to either side of one, and its reciprocal is rounded.
    """
    s, part, rounding = case.settings, further(rules), rounding_of(precision)
    width = int(s["width"])
    line, column = np.divmod(case.inputs["pixel"].astype(np.int64), width)
    tile = part.roulette_tile(column, line, width).astype(np.uint32)
    words = [int(word) for word in (s["frame"], s["seed"], STREAM)]
    key = [tile, *(np.full(case.rows, word, np.uint32) for word in words)]
    for place in rules.ignored_words:
        key[place] = np.zeros(case.rows, np.uint32)
    u = to_unit_interval(pcg4d(*key)[0])
    p = setting(s["probability"], rounding)
    slack = p.value - u
    goes_on = Choice(slack > 0, (np.abs(slack) > p.error) | (p.error == 0))
    found = outputs["weight"] != 0
    none = exact(np.zeros(case.rows), rounding)
    weight = choose(goes_on.settled(found), none + part.tail_weight(p), none)
    return Judgement(
        (beside("weight", outputs["weight"], weight),),
        {"tile": tile, "u": u},
        goes_on.decisions(found),
        case.random,
    )

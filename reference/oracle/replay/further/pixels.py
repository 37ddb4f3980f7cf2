"""Replay of the passes that look at a pixel's place and time alone."""

import numpy as np

from reference.oracle.cases import Buffers, Case
from reference.oracle.contract.fields import Precision
from reference.oracle.replay.bounded import constant, exact, rounding_of
from reference.oracle.replay.further.numbers import Choice, setting
from reference.oracle.replay.judgement import Judgement, beside, exactly
from reference.oracle.replay.rules import Rules
from reference.oracle.replay.verbs import choose
from reference.rng import pcg4d, to_unit_interval

TILE_WIDTH, TILE_HEIGHT = 64, 32
STREAM = 7 * 64
"""As the contract says."""


def judge_checkerboard(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``checkerboard``.

    Parameters
    ----------
    case : Case
        The call.
    outputs : mapping of str to array
        By the backend.
    rules : Rules
        What is calculated with.
    precision : 'float32' or 'float64'
        Of the backend.

    Returns
    -------
    Judgement
        N rows, exact.
    """
    s = case.settings
    line, column = np.divmod(case.inputs["pixel"].astype(np.int64), int(s["width"]))
    parity = (line + column + int(s["frame"])) % 2
    draws = (parity == 0) | (case.inputs["has_history"] == 0)
    terms = {"(x + y + frame) mod 2": parity}
    return Judgement((exactly("draws", outputs["draws"], draws),), terms)


def judge_roulette(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``roulette``.

    Parameters
    ----------
    case : Case
        The call.
    outputs : mapping of str to array
        By the backend.
    rules : Rules
        What is calculated with.
    precision : 'float32' or 'float64'
        Of the backend.

    Returns
    -------
    Judgement
        N rows.  The random numbers are exact; a probability that float32 does not hold
        may be rounded to either side of one, and its reciprocal is rounded.
    """
    s, rounding = case.settings, rounding_of(precision)
    width = int(s["width"])
    line, column = np.divmod(case.inputs["pixel"].astype(np.int64), width)
    across = -(-width // TILE_WIDTH)
    tile = (line // TILE_HEIGHT * across + column // TILE_WIDTH).astype(np.uint32)
    frame, seed, stream = (
        np.full(case.rows, int(word), np.uint32)
        for word in (s["frame"], s["seed"], STREAM)
    )
    u = to_unit_interval(pcg4d(tile, frame, seed, stream)[0])
    p = setting(s["probability"], rounding)
    slack = p.value - u
    goes_on = Choice(slack > 0, (np.abs(slack) > p.error) | (p.error == 0))
    found = outputs["weight"] != 0
    none = exact(np.zeros(case.rows), rounding)
    weight = choose(goes_on.settled(found), none + constant(1.0, p) / p, none)
    return Judgement(
        (beside("weight", outputs["weight"], weight),),
        {"tile": tile, "u": u},
        goes_on.decisions(found),
        case.random,
    )

"""Replay of the passes that empty reservoirs: validation and the boiling filter."""

import numpy as np

from reference.arrays import Indices, Scalars
from reference.oracle.cases import Buffers, Case
from reference.oracle.contract.fields import Precision
from reference.oracle.replay.bounded import Bounded, constant, exact, rounding_of
from reference.oracle.replay.further.numbers import (
    Choice,
    bounded_somehow,
    larger,
    setting,
    where_not_negative,
)
from reference.oracle.replay.geometry import luminance
from reference.oracle.replay.judgement import Judgement, exactly
from reference.oracle.replay.rules import Rules

TILE = 16
"""Pixels on a side, as the contract says."""


def judge_validation(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``validation``.

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
        N rows.  The same radiance is the same in any order of operations.
    """
    rounding, given = rounding_of(precision), case.inputs
    then, now = given["radiance_then"], given["radiance_now"]
    a, b = (luminance(exact(color, rounding)) for color in (then, now))
    tolerance = setting(case.settings["tolerance"], rounding)
    slack = tolerance * larger(a, b) - abs(a - b)
    alike = where_not_negative(slack)
    same = (then == now).all(axis=1)
    null, met = given["null"] == 1, given["met"] == 1
    stays = Choice(
        null | (met & (alike.own | same)), null | ~met | same | alike.certain
    )
    terms = {"Y then": a.value, "Y now": b.value, "room left": slack.value}
    return _emptied(case, outputs, stays, terms)


def judge_boiling(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``boiling``.

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
        N rows.  Whoever is within the bounds of the limit may stay or go.
    """
    rounding, given = rounding_of(precision), case.inputs
    light = luminance(exact(given["radiance"], rounding)) * exact(given["W"], rounding)
    tile = _tiles(case.rows, int(case.settings["width"]))
    with np.errstate(invalid="ignore", over="ignore"):
        mean = _means(light, tile, precision)
        strength = setting(case.settings["strength"], rounding)
        reach = constant(10.0, strength) - constant(9.0, strength) * strength
        slack = bounded_somehow(mean * reach - light * strength)
    calm = where_not_negative(slack)
    # No mean is below 0: who has no light has not too much of it.
    dark = (light.value == 0) & (light.error == 0)
    stays = Choice(calm.own | dark, calm.certain | dark)
    return _emptied(case, outputs, stays, {"light": light.value, "mean": mean.value})


def _tiles(pixels: int, width: int) -> Indices:
    line, column = np.divmod(np.arange(pixels), width)
    tiles: Indices = line // TILE * width + column // TILE
    return tiles


def _means(light: Bounded, tile: Indices, precision: Precision) -> Bounded:
    """Mean light of each row's tile, summed in any order.

    A sum of n numbers rounds n − 1 times by a part of what has been summed, which is no
    more than the whole [Higham02, section 4.2]; one that divides before it sums rounds
    once more.
    """

    def total(values: Scalars) -> Scalars:
        sums: Scalars = np.bincount(tile, values)[tile]
        return sums

    positive = light.value > 0
    unsure = positive & ~light.surely_positive
    count = total(positive.astype(float))
    summed = total(light.value)
    error = total(light.error) + (count + 1) * light.rounding.unit * summed
    # A sum that may overflow can be anything.
    error = np.where(summed > float(np.finfo(precision).max) / 4, np.inf, error)
    how_many = Bounded(count, total(unsure.astype(float)), light.rounding)
    return bounded_somehow(Bounded(summed, error, light.rounding) / how_many)


def _emptied(
    case: Case, outputs: Buffers, stays: Choice, terms: dict[str, Scalars]
) -> Judgement:
    """W and M as they were, or both 0."""
    there = (outputs["W"] != 0) | (outputs["M"] != 0)
    kept = stays.settled(there)
    compared = tuple(
        exactly(name, outputs[name], np.where(kept, case.inputs[name], 0))
        for name in ("W", "M")
    )
    empty = (case.inputs["W"] == 0) & (case.inputs["M"] == 0)
    decisions = stays.decisions(np.where(empty, stays.own, there))
    return Judgement(compared, terms, decisions, case.random)

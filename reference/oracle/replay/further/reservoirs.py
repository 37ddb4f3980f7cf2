"""Replay of the passes that empty reservoirs: validation and the boiling filter."""

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Scalars
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.replay.bounded import Bounded, exact, rounding_of
from restir_gi.reference.oracle.replay.further.numbers import (
    Choice,
    bounded_somehow,
    setting,
    where_none_negative,
    where_not_negative,
)
from restir_gi.reference.oracle.replay.further.rules import FurtherRules, further
from restir_gi.reference.oracle.replay.judgement import Judgement, exactly
from restir_gi.reference.oracle.replay.rules import Rules


def judge_validation(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``validation``.

    The same radiance is the same in any order of operations.
    """
    rounding, part, given = rounding_of(precision), further(rules), case.inputs
    then, now = given["radiance_then"], given["radiance_now"]
    a, b = (exact(color, rounding) for color in (then, now))
    if not part.by_channels:
        a, b = part.luminance(a), part.luminance(b)
    slack = part.room(setting(case.settings["tolerance"], rounding), a, b)
    alike = where_none_negative(slack)
    same = (then == now).all(axis=1)
    null = (given["null"] == 1) & (part.nulls == "stay")
    met = (given["met"] == 1) | (not part.ray_asked)
    if part.nulls == "cleared":
        met &= given["null"] != 1
    stays = Choice(
        null | (met & (alike.own | same)), null | ~met | same | alike.certain
    )
    terms = {"Y then": a.value, "Y now": b.value, "room left": slack.value}
    return _emptied(case, outputs, stays, terms, part)


def judge_boiling(
    case: Case, outputs: Buffers, rules: Rules, precision: Precision
) -> Judgement:
    """Judge pass ``boiling``.

    Whoever is within the bounds of the limit may stay or go.
    """
    rounding, part, given = rounding_of(precision), further(rules), case.inputs
    brightness = part.luminance(exact(given["radiance"], rounding))
    light = part.light(brightness, exact(given["W"], rounding))
    width = int(case.settings["width"])
    line, column = np.divmod(np.arange(case.rows), width)
    tile = part.boiling_tile(column, line, width)
    with np.errstate(invalid="ignore", over="ignore"):
        mean = _means(light, tile, part.dark_counts, precision)
        strength = setting(case.settings["strength"], rounding)
        slack = bounded_somehow(part.calm(light, mean, strength))
    calm = where_not_negative(slack)
    # No mean is below 0: who has no light has not too much of it.
    dark = (light.value == 0) & (light.error == 0)
    stays = Choice(calm.own | dark, calm.certain | dark)
    terms = {"light": light.value, "mean": mean.value}
    return _emptied(case, outputs, stays, terms, part)


def _means(
    light: Bounded, tile: Indices, dark_counts: bool, precision: Precision
) -> Bounded:
    """Mean light of each row's tile, summed in any order.

    A sum of n numbers rounds n − 1 times by a part of what has been summed, which is no
    more than the whole [Higham02, section 4.2]; one that divides before it sums rounds
    once more.
    """

    def total(values: Scalars) -> Scalars:
        sums: Scalars = np.bincount(tile, values)[tile]
        return sums

    positive = (light.value > 0) | dark_counts
    unsure = positive & ~light.surely_positive & (not dark_counts)
    count = total(positive.astype(float))
    summed = total(light.value)
    error = total(light.error) + (count + 1) * light.rounding.unit * summed
    # A sum that may overflow can be anything.
    error = np.where(summed > float(np.finfo(precision).max) / 4, np.inf, error)
    how_many = Bounded(count, total(unsure.astype(float)), light.rounding)
    return bounded_somehow(Bounded(summed, error, light.rounding) / how_many)


def _emptied(
    case: Case,
    outputs: Buffers,
    stays: Choice,
    terms: dict[str, Scalars],
    part: FurtherRules,
) -> Judgement:
    """W and M as they were, or both 0."""
    telling = ("W",) if part.keeps_confidence else ("W", "M")
    there = np.any([outputs[name] != 0 for name in telling], axis=0)
    kept = stays.settled(there)
    compared = tuple(
        exactly(
            name,
            outputs[name],
            np.where(kept | (name not in telling), case.inputs[name], 0),
        )
        for name in ("W", "M")
    )
    empty = np.all([case.inputs[name] == 0 for name in telling], axis=0)
    decisions = stays.decisions(np.where(empty, stays.own, there))
    return Judgement(compared, terms, decisions, case.random)

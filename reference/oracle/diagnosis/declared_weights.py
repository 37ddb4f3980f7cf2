"""What may be taken for a declared MIS weight: other weights, and mistakes in it."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from restir_gi.reference.oracle.contract.weights import (
    BALANCE,
    DEFENSIVE,
    MIS,
    PAIRWISE,
)
from restir_gi.reference.oracle.diagnosis.hypothesis import (
    REUSE,
    SHIFTED,
    SPATIAL,
    Departure,
    Hypothesis,
    mistake,
)

OTHERS = (
    "1/Z",
    BALANCE,
    "balance-in-weights",
    PAIRWISE,
    DEFENSIVE,
    "pairwise-of-k",
    "defensive-of-k",
)
"""Weights that sum to 1, each once."""

AT_REST = ("1/Z", "pairwise-of-k", "defensive-of-k")
"""Those that differ from the defensive one and from each other where nothing moves."""


def _taken(
    asked: str,
    done: str,
    name: str,
    what: str,
    passes: tuple[str, ...] = SHIFTED,
    departure: Departure = "",
) -> Hypothesis:
    found = mistake(
        name,
        what,
        f"m of {done}",
        f"m of {asked}",
        passes,
        departure=departure,
    )
    heard: dict[str, Any] = {f"{asked}_as": done}
    rules = replace(found.rules, **heard)
    return replace(found, rules=rules, only=(MIS.name, (asked,)))


def _where(asked: str, done: str) -> tuple[str, ...]:
    """Passes in which one is not the other."""
    if asked == PAIRWISE and done in ("balance-in-weights", "pairwise-of-k"):
        return SPATIAL  # the same of two
    return REUSE if asked == DEFENSIVE and done in AT_REST else SHIFTED


def _others() -> Iterator[Hypothesis]:
    for asked in MIS.more:
        for done in OTHERS:
            if done == asked:
                continue
            word = done.replace("1/Z", "one-over-z")
            yield _taken(
                asked,
                done,
                f"{word}-where-{asked}",
                f"{done} where {asked} is asked for: right in mean",
                _where(asked, done),
                "mis",
            )
        what = f"1/M where {asked} is asked for"
        yield _taken(asked, "1/M", f"one-over-m-where-{asked}", what)


DECLARED_WEIGHTS: tuple[Hypothesis, ...] = (
    *_others(),
    _taken(
        BALANCE,
        "balance-of-ones",
        "balance-without-confidence",
        "w has M, and the balance heuristic compares densities without it",
    ),
    _taken(
        BALANCE,
        "balance-of-full",
        "balance-without-confidence-unless-empty",
        "w has M, and the balance heuristic compares densities of those with M > 0",
    ),
    _taken(
        DEFENSIVE,
        "defensive-without-share",
        "defensive-without-share",
        "the canonical sample has no share of its own, and those of pairs are smaller",
        REUSE,
    ),
    *(
        _taken(
            asked,
            f"{asked}-own-whole",
            f"{asked}-own-whole",
            "the canonical sample is weighed as if it were alone",
            REUSE if asked == DEFENSIVE else SHIFTED,
        )
        for asked in (PAIRWISE, DEFENSIVE)
    ),
    replace(
        mistake(
            "mis-weights-without-jacobian",
            "MIS weights compare densities each in its own measure: right in mean",
            "m of targets without their Jacobians",
            "m of densities in the receiver's measure",
            SHIFTED,
            departure="mis",
            mis_jacobian=False,
        ),
        only=(MIS.name, MIS.more),
    ),
)

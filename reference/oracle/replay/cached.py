"""What many replays of the same rows share.

A search replays the same case under hundreds of rules, of which few change these.
"""

from collections.abc import Callable
from functools import lru_cache, wraps
from typing import Any, TypeVar, cast

from restir_gi.reference.oracle.contract.fields import Value
from restir_gi.reference.oracle.replay.bounded import Bounded
from restir_gi.reference.oracle.replay.points import ReceiverPoint, SamplePoint
from restir_gi.reference.oracle.replay.rules import JacobianFormula, TargetFormula

MANY = 2**14
"""Rows from which few results are kept: no search replays these often."""

KEPT = 8
"""Of these."""

Function = TypeVar("Function", bound=Callable[..., Any])


def kept_by(count: int, rows: Callable[..., int]) -> Callable[[Function], Function]:
    """Keep the last results of a function, but few of those that are large.

    Parameters
    ----------
    rows : callable; how many rows a result has, from the same arguments
    """

    def keeping(function: Function) -> Function:
        small, large = lru_cache(count)(function), lru_cache(KEPT)(function)

        @wraps(function)
        def kept(*given: Any) -> Any:
            return (small if rows(*given) < MANY else large)(*given)

        return cast(Function, kept)

    return keeping


@kept_by(1024, lambda formula, kind, x, y: len(y.position.value))
def target_by(
    formula: TargetFormula, kind: Value, x: ReceiverPoint, y: SamplePoint
) -> Bounded:
    """Target of N sample points at as many visible points, (N,).

    By the formula, or as it is given.
    """
    if y.given is not None:
        return y.given[:, x.number]
    return formula(kind, x, y)


@kept_by(512, lambda formula, x_from, x, y: len(y.position.value))
def jacobian_by(
    formula: JacobianFormula, x_from: ReceiverPoint, x: ReceiverPoint, y: SamplePoint
) -> Bounded:
    """Jacobian of N shifts, (N,)."""
    return formula(x_from, x, y)

"""Targets and Jacobians that many replays of the same rows share.

A search replays the same case under hundreds of rules, of which few change these.
"""

from functools import lru_cache

from restir_gi.reference.oracle.contract.fields import Value
from restir_gi.reference.oracle.replay.bounded import Bounded
from restir_gi.reference.oracle.replay.points import ReceiverPoint, SamplePoint
from restir_gi.reference.oracle.replay.rules import JacobianFormula, TargetFormula


@lru_cache(maxsize=1024)
def target_by(
    formula: TargetFormula, kind: Value, x: ReceiverPoint, y: SamplePoint
) -> Bounded:
    """Target of N sample points at as many visible points, (N,)."""
    return formula(kind, x, y)


@lru_cache(maxsize=512)
def jacobian_by(
    formula: JacobianFormula, x_from: ReceiverPoint, x: ReceiverPoint, y: SamplePoint
) -> Bounded:
    """Jacobian of N shifts, (N,)."""
    return formula(x_from, x, y)

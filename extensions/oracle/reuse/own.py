"""The project's own reuse behind the contract: sources that look everything up."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Scalars, Vec3s
from restir_gi.reference.numerics.records import NONE
from restir_gi.reference.oracle.builtin.buffers import Array, as_real
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.resampling.generalized import resample
from restir_gi.reference.resampling.reservoir import Reservoirs


@dataclass(frozen=True, slots=True)
class _Sample:
    """Who made it, and p̂ where it is, (N, 1)."""

    slot: Indices
    value: Vec3s

    def moved(self, value: Vec3s, jacobian: Scalars) -> "_Sample":
        return replace(self, value=value)


@dataclass(frozen=True, slots=True, eq=False)
class _TableSlot:
    """Slot k of every row."""

    k: int
    here: Array
    jacobian: Array
    at_others: Array
    reservoirs: Reservoirs
    rows: Indices
    same_domain: bool

    def unshifted(self, at: Indices) -> Any:
        return self.reservoirs.y.value[self.rows[at]]

    def shifted(self, at: Indices) -> tuple[Vec3s, Scalars]:
        return self.here[at, self.k, None], self.jacobian[at, self.k]

    def inverse(self, samples: Any, at: Indices) -> tuple[Vec3s, Scalars]:
        p = self.at_others[at, samples.slot[at], self.k]
        return p[:, None], (p > 0).astype(p.dtype)


def _target(value: Vec3s) -> Scalars:
    return value[:, 0]


def _path_reuse(
    precision: Precision,
    W: Array,
    M: Array,
    there: Array,
    target_base: Array,
    target_here: Array,
    jacobian: Array,
    target_at: Array,
    u: Array,
    mis: Any,
    canonical: int,
    cap: float,
) -> dict[str, Array]:
    rows, slots = W.shape
    here = np.arange(rows)
    sources = [
        _TableSlot(
            k,
            target_here,
            jacobian,
            target_at,
            Reservoirs(
                _Sample(np.full(rows, k), target_base[:, k, None]), W[:, k], M[:, k]
            ),
            np.where(there[:, k] == 1, here, NONE),
            k == canonical,
        )
        for k in range(slots)
    ]
    decisions = [u[:, k] for k in range(slots)]
    kept = resample(sources, decisions, mis, float(cap), _target)
    return {
        "slot": kept.y.slot.astype(np.int32),
        "p_hat": as_real(precision, _target(kept.y.value)),
        "W": as_real(precision, kept.W),
        "M": as_real(precision, kept.M),
    }


OWN: Mapping[str, Any] = {"path_reuse": _path_reuse}
"""The passes of this part."""

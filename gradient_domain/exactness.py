"""The kernel of paired paths in the matrix of extremes."""

from typing import Any

from restir_gi.gradient_domain.gradient_restir import share_of_base
from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.oracle.exact.draws import Draws
from restir_gi.reference.oracle.exact.kernel import Inputs, Kernel, Row


def _draw(draws: Draws) -> dict[str, Any]:
    return {name: draws("weight") for name in ("p_base", "p_offset", "jacobian")}


def _run(given: Inputs) -> Scalars:
    return share_of_base(**given)


def _share(row: Row) -> Any:
    p, q, J = (row[name] for name in ("p_base", "p_offset", "jacobian"))
    if J.value == 0:
        return J + int(p.value > 0)
    return p / (p + q * J)


SHARE_OF_BASE = Kernel(
    "share-of-base", "", _draw, _run, _share,
    {
        "weights at their limits": "0 where p is 0, 1 where p is not and there is no"
        " offset path; else 0 to 1",
    },
)  # fmt: skip
"""Weight of a base path beside its offset path."""

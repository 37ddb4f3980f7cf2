"""Kernels of what the sum of weights is divided by, and of limits on Jacobians."""

from typing import Any

from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.oracle.exact.draws import Draws, weights
from restir_gi.reference.oracle.exact.kernel import Inputs, Kernel, Row
from restir_gi.reference.oracle.exact.numbers import Exact, exact
from restir_gi.reference.resampling.jacobian_limits import clamp_jacobian, within_limit
from restir_gi.reference.resampling.pairwise import (
    pairwise_canonical,
    pairwise_neighbor,
)
from restir_gi.reference.resampling.reservoir import (
    balance_heuristic,
    one_over_m,
    one_over_z,
)
from restir_gi.reference.transport.direct_light import balance

SOURCES = 8
LIMIT, CAP = 10.0, 30.0

_LIMITS = "weights at their limits"


# ------------------------------------------------------------------ divisors


def _draw_sources(draws: Draws) -> dict[str, Scalars]:
    M = {f"M_{k}": draws("confidence") for k in range(SOURCES)}
    return M | {f"p_{k}": draws("weight") for k in range(SOURCES)}


def _columns(given: Inputs) -> tuple[list[Scalars], list[Scalars]]:
    columns = [[given[f"{name}_{k}"] for k in range(SOURCES)] for name in "Mp"]
    return columns[0], columns[1]


def _total(terms: list[Exact]) -> Exact:
    total = terms[0]
    for term in terms[1:]:
        total = total + term
    return total


_SUM = "exact up to 2¹¹, 2²⁴, 2⁵³; rounded beyond; 0 for none"

ONE_OVER_M = Kernel(
    "divisor of 1/M", "temporal", _draw_sources,
    lambda given: one_over_m(_columns(given)[0]),
    lambda row: _total([row[f"M_{k}"] for k in range(SOURCES)]),
    {"confidence": _SUM, _LIMITS: "does not look at them"},
    saturates=True,
)  # fmt: skip


def _run_z(given: Inputs) -> Scalars:
    M, p = _columns(given)
    return one_over_z(M, [p_k > 0 for p_k in p])


ONE_OVER_Z = Kernel(
    "divisor of 1/Z", "spatial", _draw_sources, _run_z,
    lambda row: _total(
        [row[f"M_{k}"] * int(row[f"p_{k}"].value > 0) for k in range(SOURCES)]
    ),
    {"confidence": _SUM, _LIMITS: "counts those with p̂ > 0, also subnormal ones"},
    saturates=True,
)  # fmt: skip


def _run_balance_of_sources(given: Inputs) -> Scalars:
    M, p = _columns(given)
    return balance_heuristic(M, p, p[0])


BALANCE_OF_SOURCES = Kernel(
    "divisor of the balance heuristic", "", _draw_sources, _run_balance_of_sources,
    lambda row: _total([row[f"M_{k}"] * row[f"p_{k}"] for k in range(SOURCES)])
    / row["p_0"],
    {
        "confidence": "0 for none",
        _LIMITS: "0 where the kept sample has p̂ = 0; any finite number where a term"
        " is too large for the type",
    },
)  # fmt: skip


def _share(M_a: Exact, p_a: Exact, M_b: Exact, p_b: Exact) -> Exact:
    larger = p_a if p_a.value > p_b.value else p_b
    a, b = M_a * (p_a / larger), M_b * (p_b / larger)
    return a / (a + b)


def _draw_pairwise(draws: Draws) -> dict[str, Scalars]:
    M_k, M_c = draws("confidence"), draws("confidence")
    # The sources' sum holds the source's own confidence.
    S = M_k + draws("confidence")
    p_k, p_c = draws("weight"), draws("weight")
    return {"M_k": M_k, "p_k": p_k, "M_c": M_c, "p_c": p_c, "S": S}


def _run_pairwise(given: Inputs) -> Scalars:
    return pairwise_neighbor(**given, defensive=True)


PAIRWISE = Kernel(
    "pairwise share of a source", "", _draw_pairwise, _run_pairwise,
    lambda row: row["M_k"]
    * _share(row["S"], row["p_k"], row["M_c"], row["p_c"])
    / (row["S"] + row["M_c"]),
    {"confidence": "0 without a source", _LIMITS: "0 to 1; 0 where both targets are"},
)  # fmt: skip


def _run_canonical(given: Inputs) -> Scalars:
    M, p = _columns(given)
    return pairwise_canonical(M[1:], p[1:], M[0], p[0], defensive=True)


def _canonical(row: Row) -> Any:
    M, p = ([row[f"{name}_{k}"] for k in range(SOURCES)] for name in "Mp")
    S = _total(M[1:])
    shares = [M[k] * _share(M[0], p[0], S, p[k]) for k in range(1, SOURCES)]
    return (_total(shares) + M[0]) / (S + M[0])


CANONICAL = Kernel(
    "pairwise share of one's own", "", _draw_sources, _run_canonical, _canonical,
    {"confidence": "0 for none at all", _LIMITS: "0 to 1; 0 where all targets are"},
)  # fmt: skip


def _run_light_balance(given: Inputs) -> Scalars:
    return balance(given["p"], given["p_other"])


LIGHT_BALANCE = Kernel(
    "share of one way to a light", "", weights("p", "p_other"), _run_light_balance,
    lambda row: row["p"] / (row["p"] + row["p_other"])
    if row["p"].value > 0
    else row["p"] * 0 + 1,
    {_LIMITS: "1 where p is 0, which means a delta lobe; else 0 to 1"},
)  # fmt: skip

# ------------------------------------------------------------------ limits


def _run_clamp(given: Inputs) -> Scalars:
    return clamp_jacobian(given["J"], LIMIT)


def _clamp(row: Row) -> Any:
    J = row["J"]
    if J.value == 0:
        return J
    limit = exact(LIMIT, J.type)
    low = 1 / limit
    if J.value < low.value:
        return low
    return J if J.value <= LIMIT else limit


CLAMP = Kernel(
    "Jacobian, clamped", "", weights("J"), _run_clamp, _clamp,
    {_LIMITS: "1/limit to limit, and 0 stays 0"},
)  # fmt: skip


def _run_within(given: Inputs) -> NDArray[Any]:
    return within_limit(given["J"], LIMIT)


def _within(row: Row) -> Any:
    J = row["J"]
    limit = exact(LIMIT, J.type)
    low = 1 / limit
    return bool(J.value > 0) and low <= J <= limit


WITHIN = Kernel(
    "Jacobian within its limit", "", weights("J"), _run_within, _within,
    {_LIMITS: "false for 0"},
)  # fmt: skip

DIVISORS = (
    ONE_OVER_M, ONE_OVER_Z, BALANCE_OF_SOURCES, PAIRWISE, CANONICAL, LIGHT_BALANCE,
    CLAMP, WITHIN,
)  # fmt: skip

"""Kernels of weights and confidences."""

from typing import Any

from restir_gi.reference.numerics.arrays import Masks, Scalars
from restir_gi.reference.oracle.exact.draws import Draws, weights
from restir_gi.reference.oracle.exact.kernel import Inputs, Kernel, Row
from restir_gi.reference.oracle.exact.numbers import exact
from restir_gi.reference.resampling.reservoir import (
    Candidates,
    Reservoirs,
    cap_confidence,
    choose_second,
    finalize,
    initial_candidates,
    merge,
    reused_candidates,
)

CAP = 30.0

_LIMITS = "weights at their limits"
_TOO_LARGE = "what is too large for the type becomes its largest number"


# ------------------------------------------------------------------ candidates


def _run_initial(given: Inputs) -> Scalars:
    return initial_candidates(given["p_hat"], given["p_hat"], given["pdf"]).w


INITIAL = Kernel(
    "weight of a new sample", "initial", weights("p_hat", "pdf"), _run_initial,
    lambda row: row["p_hat"] / row["pdf"],
    {_LIMITS: f"0 where p̂ or pdf is 0; {_TOO_LARGE}"},
    saturates=True,
)  # fmt: skip


def _draw_reused(draws: Draws) -> dict[str, Scalars]:
    return {**weights("p_hat", "W", "J")(draws), "M": draws("confidence")}


def _run_reused(given: Inputs) -> Scalars:
    r = Reservoirs(given["W"], given["W"], given["M"])
    return reused_candidates(r, given["p_hat"], given["J"]).w


REUSED = Kernel(
    "weight of a reused sample", "spatial", _draw_reused, _run_reused,
    lambda row: row["p_hat"] * row["W"] * row["M"] * row["J"],
    {
        _LIMITS: f"0 where a factor is 0 or the product underflows; {_TOO_LARGE}",
        "confidence": "0 where M is 0",
    },
    saturates=True,
)  # fmt: skip

# ------------------------------------------------------------------ merging


def _draw_pair(draws: Draws) -> dict[str, Scalars]:
    return {"w_a": draws("weight"), "w_b": draws("weight"), "u": draws("u")}


def _run_choice(given: Inputs) -> Masks:
    return choose_second(given["w_a"], given["w_b"], given["u"])


def _choice(row: Row) -> Any:
    w_a, w_b = row["w_a"], row["w_b"]
    if w_a.value == 0:
        return bool(w_b.value > 0)
    return w_b > row["u"] * (w_a + w_b)


CHOICE = Kernel(
    "which of two is kept", "merge", _draw_pair, _run_choice, _choice,
    {
        _LIMITS: "never a weight of 0; a positive one always, beside 0; either where"
        " w_a + w_b is too large for the type",
        "random numbers": "u = 0 keeps the second where it has weight; u < 1 never"
        " keeps it where it has none",
    },
)  # fmt: skip


def _run_confidence(given: Inputs) -> Scalars:
    a, b = (Candidates(m, m, m, m) for m in (given["M_a"], given["M_b"]))
    return merge(a, b, given["M_a"] * 0).M


CONFIDENCE = Kernel(
    "sum of confidences", "merge",
    lambda draws: {"M_a": draws("confidence"), "M_b": draws("confidence")},
    _run_confidence, lambda row: row["M_a"] + row["M_b"],
    {"confidence": "exact up to 2¹¹, 2²⁴, 2⁵³ by type; then rounded"},
    saturates=True,
)  # fmt: skip


def _run_cap(given: Inputs) -> Scalars:
    return cap_confidence(Reservoirs(given["M"], given["M"], given["M"]), CAP).M


CAPPED = Kernel(
    "confidence, capped", "spatial", lambda draws: {"M": draws("confidence")},
    _run_cap,
    lambda row: row["M"] if row["M"].value <= CAP else exact(CAP, row["M"].type),
    {"confidence": "exact"},
)  # fmt: skip

# ------------------------------------------------------------------ closing


def _draw_closing(draws: Draws) -> dict[str, Scalars]:
    Z = draws("confidence")
    return {"w": draws("weight"), "p_hat": draws("weight"), "Z": Z}


def _run_finalize(given: Inputs) -> Scalars:
    w, Z = given["w"], given["Z"]
    return finalize(Candidates(w, given["p_hat"], w, Z), Z).W


FINALIZE = Kernel(
    "closing: W", "finalize", _draw_closing, _run_finalize,
    lambda row: row["w"] / row["p_hat"] / row["Z"],
    {
        _LIMITS: "0 where w or p̂ is 0; the largest number where W is larger",
        "confidence": "0 where Z is 0",
    },
    saturates=True,
)  # fmt: skip

WEIGHTS = (INITIAL, REUSED, CHOICE, CONFIDENCE, CAPPED, FINALIZE)

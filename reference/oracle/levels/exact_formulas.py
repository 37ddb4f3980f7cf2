"""The kernels of the contract in exact numbers, from its words alone.

Nothing here is shared with the passes that are judged, nor with the replay that says
how far rounding may take them: what one of those has wrong, the other two show.
"""

from collections.abc import Callable, Mapping

import numpy as np

from reference.arrays import Masks, Vec3s
from reference.oracle.cases import Buffers
from reference.oracle.contract.fields import Value
from reference.oracle.levels.exact_numbers import (
    DIGITS,
    Exact,
    cosine_of_degrees,
    cosine_of_turns,
    digits,
    exactly,
    inner,
    luminance,
    quotient,
    root,
    zero_but,
)

Settings = Mapping[str, Value]
Formula = Callable[[Buffers, Settings], dict[str, Exact]]


def _direction(inputs: Buffers, settings: Settings) -> dict[str, Exact]:
    u, rows = exactly(inputs["u"]), len(inputs["u"])
    if settings["source"] == "uniform":
        cosine, pdf = digits(u[:, 0]), np.full(rows, 1 / (2 * DIGITS.pi))
    else:
        cosine = root(1 - u[:, 0])
        pdf = cosine / DIGITS.pi
    origin = _first_of_each(inputs["visible_normal"])
    azimuth = cosine_of_turns(u[:, 1] - u[origin, 1])
    leans = cosine < 1
    return {
        "cos θ": cosine,
        "length": np.full(rows, DIGITS.one),
        # The normal itself has none: 0 is as far from -1 as from 1.
        "azimuth": zero_but(leans, azimuth[leans]),
        "pdf": pdf,
    }


def _first_of_each(normal: Vec3s) -> list[int]:
    """First row that has the normal of each row."""
    first: dict[tuple[float, ...], int] = {}
    return [first.setdefault(tuple(n), row) for row, n in enumerate(normal.tolist())]


def _target(inputs: Buffers, settings: Settings) -> dict[str, Exact]:
    lit, cosine = _lit_cosine(inputs)
    radiance = exactly(inputs["radiance"][lit])
    if settings["target"] == "outgoing":
        return {"p_hat": zero_but(lit, luminance(radiance))}
    light = luminance(exactly(inputs["albedo"][lit]) * radiance) / DIGITS.pi
    return {"p_hat": zero_but(lit, light * cosine)}


def _shade(inputs: Buffers, settings: Settings) -> dict[str, Exact]:
    lit, cosine = _lit_cosine(inputs)
    albedo, radiance, W = (
        exactly(inputs[name][lit]) for name in ("albedo", "radiance", "W")
    )
    light = digits(albedo * radiance * W[:, None])
    return {"color": zero_but(lit, light * (cosine / DIGITS.pi)[:, None])}


def _lit_cosine(inputs: Buffers) -> tuple[Masks, Exact]:
    """Rows with n·ω > 0 and n_s·ω < 0, and n·ω of those K rows.

    Neither sign depends on the length of x_s − x; where it is 0 there is no ω.
    """
    toward = exactly(inputs["position"]) - exactly(inputs["visible_position"])
    along = inner(exactly(inputs["visible_normal"]), toward)
    lit: Masks = (along > 0) & (inner(exactly(inputs["normal"]), toward) < 0)
    distance = root(inner(toward[lit], toward[lit]))
    return lit, digits(along[lit]) / distance


def _jacobian(inputs: Buffers, settings: Settings) -> dict[str, Exact]:
    position, normal = exactly(inputs["position"]), exactly(inputs["normal"])

    def seen_from(name: str) -> tuple[Exact, Exact]:
        """|cos φ| and d², both 0 where the points touch."""
        v = exactly(inputs[name]) - position
        squared = inner(v, v)
        along = digits(abs(inner(normal, v)))
        return quotient(along, root(squared)), digits(squared)

    cosine_from, squared_from = seen_from("x_from")
    cosine_to, squared_to = seen_from("x_to")
    J = quotient(cosine_to, cosine_from) * quotient(squared_from, squared_to)
    return {"jacobian": J}


def _merge(inputs: Buffers, settings: Settings) -> dict[str, Exact]:
    w_a, w_b, u, M_a, M_b = (
        exactly(inputs[name]) for name in ("w_a", "w_b", "u", "M_a", "M_b")
    )
    w = w_a + w_b
    second = (u * w < w_b) | ((w_a == 0) & (w_b > 0))
    return {"second": second, "w": w, "M": M_a + M_b}


def _finalize(inputs: Buffers, settings: Settings) -> dict[str, Exact]:
    w, p_hat, Z = (exactly(inputs[name]) for name in ("w", "p_hat", "Z"))
    return {"W": quotient(digits(w), digits(Z * p_hat))}


def _similar(inputs: Buffers, settings: Settings) -> dict[str, Exact]:
    z_a, z_b = exactly(inputs["depth_a"]), exactly(inputs["depth_b"])
    cosine = inner(exactly(inputs["normal_a"]), exactly(inputs["normal_b"]))
    alike = cosine >= cosine_of_degrees(float(settings["max_angle"]))
    most = float(settings["max_depth"]) * np.maximum(z_a, z_b)
    near = abs(z_a - z_b) <= most
    return {"similar": alike & near & (z_a > 0) & (z_b > 0)}


FORMULAS: Mapping[str, Formula] = {
    "direction": _direction,
    "target": _target,
    "jacobian": _jacobian,
    "merge": _merge,
    "finalize": _finalize,
    "similar": _similar,
    "shade": _shade,
}
"""By pass: buffers and settings give what is compared, by the names of the judge."""

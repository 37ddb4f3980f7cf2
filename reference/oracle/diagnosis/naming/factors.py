"""What the numbers of a pass are made of, row by row, in the words of the contract."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Masks
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.diagnosis.luminances import (
    largest_channel,
    mean_of_channels,
    rec_601,
)
from restir_gi.reference.oracle.replay.bounded import Bounded, Rounding, constant, exact
from restir_gi.reference.oracle.replay.formulas import jacobian
from restir_gi.reference.oracle.replay.geometry import cosine_at, luminance
from restir_gi.reference.oracle.replay.judgement import Judgement
from restir_gi.reference.oracle.replay.points import (
    ReceiverPoint,
    SamplePoint,
    point_of,
    receiver_of,
)
from restir_gi.reference.oracle.replay.verbs import inner, square_root, times


@dataclass(frozen=True, slots=True, eq=False)
class RowFacts:
    """What is known of N rows.

    Attributes
    ----------
    factors : mapping of str to (N,) or (N, 3) Bounded
    conditions : mapping of str to (N,) or (N, 3) bool; what may be so, as a clause
    """

    factors: Mapping[str, Bounded] = field(default_factory=dict)
    conditions: Mapping[str, Masks] = field(default_factory=dict)

    def __or__(self, other: "RowFacts") -> "RowFacts":
        factors = {**self.factors, **other.factors}
        return RowFacts(factors, {**self.conditions, **other.conditions})

    def without(self, name: str) -> "RowFacts":
        """The same, but for one factor."""
        factors = {k: f for k, f in self.factors.items() if k != name}
        return RowFacts(factors, self.conditions)


AS_FOUND = ("azimuth from the first of its normal", "cos θ")
"""Terms of replays that are the backend's own."""

Facts = Callable[[Case, Judgement, Buffers, Rounding], RowFacts]


def facts_of(
    case: Case, judgement: Judgement, outputs: Buffers, rounding: Rounding
) -> RowFacts:
    """What is known of the rows of a case.

    Those of the pass come first, then its inputs and the terms of its replay: so a
    number that has two names is called by the shorter one.
    """
    own = FACTS.get(case.pass_name, _nothing)(case, judgement, outputs, rounding)
    return own | given_facts(case, judgement, rounding)


def _nothing(
    case: Case, judgement: Judgement, outputs: Buffers, rounding: Rounding
) -> RowFacts:
    return RowFacts()


def given_facts(case: Case, judgement: Judgement, rounding: Rounding) -> RowFacts:
    """Numbers and flags that a row has one of, and settings that are words."""
    judged = {c.name for c in judgement.compared}
    one = {k: a for k, a in case.inputs.items() if a.shape == (case.rows,)}
    reals = {
        f"the given {k}" if k in judged else k: exact(a, rounding)
        for k, a in one.items()
        if a.dtype.kind == "f"
    }
    flags = {k: a for k, a in one.items() if a.dtype.kind == "u"}
    conditions: dict[str, Masks] = {
        f"{name} is {value}": np.ones(case.rows, bool)
        for name, value in case.settings.items()
        if isinstance(value, str)
    }
    for name, flag in flags.items():
        conditions |= {f"{name} is 1": flag == 1, f"{name} is 0": flag == 0}
    for name, values in judgement.terms.items():
        known = values.shape == (case.rows,) and values.dtype.kind == "f"
        if known and name not in AS_FOUND:
            reals.setdefault(name, _nearly(values, rounding))
    return RowFacts(reals, conditions)


def _nearly(values: NDArray[Any], rounding: Rounding) -> Bounded:
    """Terms of a replay, of which a bound is not kept."""
    wide = np.asarray(values, np.float64)
    return Bounded(wide, 4 * rounding.unit * np.abs(wide), rounding)


def of_sample(x: ReceiverPoint, y: SamplePoint) -> RowFacts:
    """Distance, cosines and colours of samples, N rows, as the receivers see them."""
    v = y.position - x.position
    d, color = square_root(inner(v, v)), x.albedo * y.radiance
    black = {
        f"{name} lacks a channel": (color.value == 0).any(axis=1)
        for name, color in (("the radiance", y.radiance), ("the albedo", x.albedo))
    }
    null: Masks = (y.radiance.value == 0).all(axis=1)
    above, back = inner(x.normal, v).value > 0, inner(y.normal, v).value >= 0
    factors = {
        "d": d,
        "cos φ": abs(inner(y.normal, v)) / d,
        "cos θ": abs(cosine_at(x, y)),
        "Y(albedo)": luminance(x.albedo),
        "Y(L_o)": luminance(y.radiance),
        "Y(albedo · L_o)": luminance(color),
        "Y601(albedo · L_o)": rec_601(color),
        "mean of (albedo · L_o)": mean_of_channels(color),
        "largest of (albedo · L_o)": largest_channel(color),
    }
    conditions = {
        "the sample is a null": null,
        "the sample is no null": ~null,
        "the sample is below the horizon": ~above,
        "the sample is above the horizon": above,
        "the sample shows its back": back,
        "the sample shows its front": ~back,
        "the sample is above the horizon and shows its back": above & back,
        "the sample is below the horizon and shows its front": ~above & ~back,
        **black,
    }
    return RowFacts(factors, conditions)


def of_shift(x_from: ReceiverPoint, x_to: ReceiverPoint, y: SamplePoint) -> RowFacts:
    """Distances and cosines of shifts, N rows, and their Jacobian."""
    factors = {}
    for end, x in (("from", x_from), ("to", x_to)):
        v = x.position - y.position
        factors[f"d_{end}"] = square_root(inner(v, v))
        factors[f"cos φ_{end}"] = abs(inner(y.normal, v)) / factors[f"d_{end}"]
        factors[f"cos θ_{end}"] = abs(cosine_at(x, y))
    factors["J"] = jacobian(x_from, x_to, y)
    return RowFacts(factors)


def _sampled(
    case: Case, judgement: Judgement, outputs: Buffers, rounding: Rounding
) -> RowFacts:
    x, y = receiver_of(case.inputs, rounding), point_of(case.inputs, rounding)
    found = of_sample(x, y)
    light = found.factors["Y(L_o)"]
    if case.settings["target"] == "scattered":
        cosine = found.factors["cos θ"]
        light = found.factors["Y(albedo · L_o)"] * cosine / constant(pi, cosine)
    p_hat = next(c for c in judgement.compared if c.name == "p_hat").expected
    factors = {"p_hat": _nearly(p_hat, rounding), "p̂ of whatever side": light}
    return found | RowFacts(factors)


def _shade(
    case: Case, judgement: Judgement, outputs: Buffers, rounding: Rounding
) -> RowFacts:
    """Of each channel, where colours are what is judged."""
    x, y = receiver_of(case.inputs, rounding), point_of(case.inputs, rounding)
    found = of_sample(x, y)
    W, cosine = exact(case.inputs["W"], rounding), found.factors["cos θ"]
    whole = times(x.albedo * y.radiance, cosine * W / constant(pi, cosine))
    colors = {"albedo": x.albedo, "L_o": y.radiance}
    factors = {**colors, **found.factors, "light of whatever side": whole}
    return RowFacts(factors, found.conditions)


def _shifted(
    case: Case, judgement: Judgement, outputs: Buffers, rounding: Rounding
) -> RowFacts:
    places = {name: exact(array, rounding) for name, array in case.inputs.items()}
    n = places["normal"]
    x_from, x_to = (ReceiverPoint(places[k], n, n) for k in ("x_from", "x_to"))
    y = SamplePoint(places["position"], n, n)
    found = of_shift(x_from, x_to, y)
    behind = {
        f"the sample shows x_{end} its back": inner(n, x.position - y.position).value
        < 0
        for end, x in (("from", x_from), ("to", x_to))
    }
    return RowFacts(without_receivers(found), behind)


def without_receivers(facts: RowFacts) -> dict[str, Bounded]:
    """Factors of shifts between points whose normals are not known."""
    names = ("d_from", "d_to", "cos φ_from", "cos φ_to")
    return {name: facts.factors[name] for name in names}


def _drawn(
    case: Case, judgement: Judgement, outputs: Buffers, rounding: Rounding
) -> RowFacts:
    u = exact(case.inputs["u"], rounding)
    one = constant(1.0, u[:, 0])
    factors = {
        "u₀": u[:, 0],
        "(1 − u₀)": one - u[:, 0],
        "u₁": u[:, 1],
        "(1 − u₁)": one - u[:, 1],
    }
    cosine = next(c for c in judgement.compared if c.name == "cos θ")
    factors["cos θ"] = exact(cosine.expected, rounding)
    return RowFacts(factors)


def _hashed(
    case: Case, judgement: Judgement, outputs: Buffers, rounding: Rounding
) -> RowFacts:
    words = next(c for c in judgement.compared if c.name == "words")
    return RowFacts({"its word": exact(words.expected, rounding)})


def _packed(
    case: Case, judgement: Judgement, outputs: Buffers, rounding: Rounding
) -> RowFacts:
    """On which side of each axis normals are, as they are given or should be read."""
    read = {c.name: c.expected for c in judgement.compared} | dict(case.inputs)
    return RowFacts(
        conditions={
            f"{axis} of {name} {word} 0": side(read[name][:, place], 0)
            for name in ("visible_normal", "normal")
            if name in read
            for place, axis in enumerate("xyz")
            for word, side in (("is below", np.less), ("is above", np.greater))
        }
    )


def _joined(
    case: Case, judgement: Judgement, outputs: Buffers, rounding: Rounding
) -> RowFacts:
    places = {
        name: exact(case.inputs[name], rounding)
        for name in ("x_from", "x_to", "joint_position", "joint_normal")
    }
    n = places["joint_normal"]
    x_from, x_to = (ReceiverPoint(places[k], n, n) for k in ("x_from", "x_to"))
    found = of_shift(x_from, x_to, SamplePoint(places["joint_position"], n, n))
    return RowFacts(without_receivers(found))


FACTS: Mapping[str, Facts] = {
    "target": _sampled,
    "initial": _sampled,
    "shade": _shade,
    "jacobian": _shifted,
    "random": _hashed,
    "direction": _drawn,
    "pack": _packed,
    "unpack": _packed,
    "path_jacobian": _joined,
}

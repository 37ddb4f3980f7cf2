"""Known mistakes with targets, integrands and densities."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from math import pi
from typing import Any

import numpy as np

from restir_gi.reference.numerics.arrays import Masks
from restir_gi.reference.oracle.contract.fields import Value
from restir_gi.reference.oracle.diagnosis.hypothesis import Departure, Hypothesis
from restir_gi.reference.oracle.diagnosis.luminances import (
    largest_channel,
    mean_of_channels,
    rec_601,
    red_channel,
)
from restir_gi.reference.oracle.replay.bounded import Bounded, constant
from restir_gi.reference.oracle.replay.formulas import target
from restir_gi.reference.oracle.replay.geometry import (
    cosine_at,
    lit_at,
    luminance,
    on_both_sides,
)
from restir_gi.reference.oracle.replay.points import ReceiverPoint, SamplePoint
from restir_gi.reference.oracle.replay.rules import CONTRACT_RULES
from restir_gi.reference.oracle.replay.verbs import choose, inner, where_positive

TARGETS_IN = ("target", "initial", "temporal", "moved", "spatial")
P_RIGHT = "p̂ = Y(albedo / π · L_o) · cos θ"


def _doubled(p_hat: Bounded, x: ReceiverPoint, y: SamplePoint) -> Bounded:
    return p_hat + p_hat


def _scattered_always(kind: Value, x: ReceiverPoint, y: SamplePoint) -> Bounded:
    return target("scattered", x, y)


def _outgoing_always(kind: Value, x: ReceiverPoint, y: SamplePoint) -> Bounded:
    return target("outgoing", x, y)


def _outgoing_anywhere(kind: Value, x: ReceiverPoint, y: SamplePoint) -> Bounded:
    """Equation 10 below the horizon too."""
    if kind == "scattered":
        return target(kind, x, y)
    return where_positive(lit_at(x, y), luminance(y.radiance))


def _scattered(change: Callable[[Bounded, ReceiverPoint, SamplePoint], Bounded]) -> Any:
    """Target of Equation 9, changed; Equation 10 as it is."""

    def changed(kind: Value, x: ReceiverPoint, y: SamplePoint) -> Bounded:
        p_hat = target(kind, x, y)
        return p_hat if kind == "outgoing" else change(p_hat, x, y)

    return changed


def _times_pi(p_hat: Bounded, x: ReceiverPoint, y: SamplePoint) -> Bounded:
    return p_hat * constant(pi, p_hat)


def _over_pi(p_hat: Bounded, x: ReceiverPoint, y: SamplePoint) -> Bounded:
    return p_hat / constant(pi, p_hat)


def _without_cosine(p_hat: Bounded, x: ReceiverPoint, y: SamplePoint) -> Bounded:
    light = luminance(x.albedo * y.radiance)
    return on_both_sides(x, y, light / constant(pi, light))


def _cosine_twice(p_hat: Bounded, x: ReceiverPoint, y: SamplePoint) -> Bounded:
    # The square alone may be too small for its type, unlike its product with light.
    cosine, light = cosine_at(x, y), luminance(x.albedo * y.radiance)
    return on_both_sides(x, y, light * (cosine * cosine) / constant(pi, light))


def _without_albedo(p_hat: Bounded, x: ReceiverPoint, y: SamplePoint) -> Bounded:
    light = luminance(y.radiance)
    return on_both_sides(x, y, light * cosine_at(x, y) / constant(pi, light))


def _geometry_term(p_hat: Bounded, x: ReceiverPoint, y: SamplePoint) -> Bounded:
    v = y.position - x.position
    d2 = inner(v, v)
    return (
        p_hat
        * abs(cosine_at(ReceiverPoint(y.position, y.normal, y.normal), _at(x)))
        / d2
    )


def _at(x: ReceiverPoint) -> SamplePoint:
    return SamplePoint(x.position, x.normal, x.normal)


def _with_light(light: Callable[[Bounded], Bounded]) -> Any:
    """Target of both equations, with another number in place of luminance."""

    def changed(kind: Value, x: ReceiverPoint, y: SamplePoint) -> Bounded:
        if kind == "outgoing":
            return on_both_sides(x, y, light(y.radiance))
        found = light(x.albedo * y.radiance)
        return on_both_sides(x, y, found * cosine_at(x, y) / constant(pi, found))

    return changed


def _pure_is_null(p_hat: Bounded, x: ReceiverPoint, y: SamplePoint) -> Bounded:
    full: Masks = np.all((x.albedo * y.radiance).value > 0, axis=1)
    return choose(full, p_hat, constant(0.0, p_hat))


def _both_sides_of_sample(kind: Value, x: ReceiverPoint, y: SamplePoint) -> Bounded:
    p = target(kind, x, y)
    back = target(kind, x, SamplePoint(y.position, -y.normal, y.radiance))
    return p + back


def _below_the_horizon(kind: Value, x: ReceiverPoint, y: SamplePoint) -> Bounded:
    below = ReceiverPoint(x.position, -x.normal, x.albedo)
    return target(kind, x, y) + target(kind, below, y)


def _target_mistake(
    name: str,
    mistake: str,
    wrong: str,
    change: Any,
    *seen: str,
    departure: Departure = "",
) -> Hypothesis:
    rules = replace(
        CONTRACT_RULES, target=change, reuse_target=change, domain_target=change
    )
    return Hypothesis(name, mistake, wrong, P_RIGHT, TARGETS_IN, rules, seen, departure)


_departure = partial(_target_mistake, departure="target")


TARGETS = (
    _departure(
        "target-without-pi",
        "the target lacks 1/π",
        "p̂ = Y(albedo · L_o) · cos θ",
        _scattered(_times_pi),
    ),
    _departure(
        "target-pi-twice",
        "the target is divided by π twice",
        "p̂ = Y(albedo / π² · L_o) · cos θ",
        _scattered(_over_pi),
    ),
    _departure(
        "target-without-cosine",
        "the target lacks the cosine",
        "p̂ = Y(albedo / π · L_o)",
        _scattered(_without_cosine),
        "the paper's Equation 10, where Equation 9 is asked for",
    ),
    _departure(
        "target-cosine-twice",
        "the target has the cosine twice",
        "p̂ = Y(albedo / π · L_o) · cos² θ",
        _scattered(_cosine_twice),
    ),
    _departure(
        "target-without-albedo",
        "the target lacks the albedo",
        "p̂ = Y(L_o) / π · cos θ",
        _scattered(_without_albedo),
    ),
    _departure(
        "target-with-geometry-term",
        "the target has the geometry term of an area measure",
        "p̂ = Y(albedo / π · L_o) · cos θ cos φ / d²",
        _scattered(_geometry_term),
        "ReSTIR_GI by shallairo",
    ),
    _departure(
        "luminance-of-rec-601",
        "luminance has the weights of Rec. 601",
        "Y = 0.299 R + 0.587 G + 0.114 B",
        _with_light(rec_601),
        "ReSTIR_PT",
    ),
    _departure(
        "mean-of-channels",
        "the mean of the channels stands for luminance",
        "Y = (R + G + B) / 3",
        _with_light(mean_of_channels),
    ),
    _departure(
        "target-doubled",
        "the target is twice as large: the same distribution",
        "2 p̂",
        _scattered(_doubled),
    ),
    _departure(
        "target-always-scattered",
        "the target is that of Equation 9 whatever is asked for: right in mean",
        "p̂ = Y(albedo / π · L_o) · cos θ",
        _scattered_always,
    ),
    _departure(
        "target-always-outgoing",
        "the target is that of Equation 10 whatever is asked for: right in mean",
        "p̂ = Y(L_o)",
        _outgoing_always,
    ),
    _target_mistake(
        "outgoing-without-horizon",
        "the target of Equation 10 is not 0 below the horizon",
        "p̂ = Y(L_o) wherever the sample shines",
        _outgoing_anywhere,
    ),
    _target_mistake(
        "back-of-sample-shines",
        "sample points shine on their back too",
        "p̂ > 0 where n_s·ω > 0",
        _both_sides_of_sample,
        "C2-Renderer d4ed168",
        "RestirPT-WebGPU U8-6",
    ),
    _target_mistake(
        "light-below-the-horizon",
        "samples below the horizon count",
        "p̂ with |cos θ|",
        _below_the_horizon,
        "HIPRT 9374ec68",
    ),
    _target_mistake(
        "red-channel",
        "the red channel stands for luminance",
        "Y = R",
        _with_light(red_channel),
    ),
    _departure(
        "largest-channel",
        "the largest channel stands for luminance: the same distribution",
        "Y = max(R, G, B)",
        _with_light(largest_channel),
    ),
    _target_mistake(
        "pure-colours-are-null",
        "colours without one of the channels are taken for nothing",
        "p̂ = 0 unless R, G and B are above 0",
        _scattered(_pure_is_null),
        "bevy 01804ded1c",
    ),
)

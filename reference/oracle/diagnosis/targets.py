"""Known mistakes with targets, integrands and densities."""

from collections.abc import Callable
from dataclasses import replace
from math import pi
from typing import Any

import numpy as np

from reference.arrays import Masks
from reference.oracle.contract.fields import Value
from reference.oracle.diagnosis.hypothesis import Hypothesis
from reference.oracle.replay.bounded import Bounded, constant
from reference.oracle.replay.formulas import target
from reference.oracle.replay.geometry import cosine_at, luminance, on_both_sides
from reference.oracle.replay.points import Point, Receiver
from reference.oracle.replay.rules import CONTRACT_RULES
from reference.oracle.replay.verbs import choose, inner

TARGETS_IN = ("target", "initial", "temporal", "moved", "spatial")
P_RIGHT = "p̂ = Y(albedo / π · L_o) · cos θ"

Formula = Callable[[Bounded, Bounded], Bounded]


def _scattered(change: Callable[[Bounded, Receiver, Point], Bounded]) -> Any:
    """Target of Equation 9, changed; Equation 10 as it is."""

    def changed(kind: Value, x: Receiver, y: Point) -> Bounded:
        p_hat = target(kind, x, y)
        return p_hat if kind == "outgoing" else change(p_hat, x, y)

    return changed


def _times_pi(p_hat: Bounded, x: Receiver, y: Point) -> Bounded:
    return p_hat * constant(pi, p_hat)


def _over_pi(p_hat: Bounded, x: Receiver, y: Point) -> Bounded:
    return p_hat / constant(pi, p_hat)


def _without_cosine(p_hat: Bounded, x: Receiver, y: Point) -> Bounded:
    light = luminance(x.albedo * y.radiance)
    return on_both_sides(x, y, light / constant(pi, light))


def _cosine_twice(p_hat: Bounded, x: Receiver, y: Point) -> Bounded:
    return p_hat * cosine_at(x, y)


def _without_albedo(p_hat: Bounded, x: Receiver, y: Point) -> Bounded:
    light = luminance(y.radiance)
    return on_both_sides(x, y, light * cosine_at(x, y) / constant(pi, light))


def _geometry_term(p_hat: Bounded, x: Receiver, y: Point) -> Bounded:
    v = y.position - x.position
    d2 = inner(v, v)
    return p_hat * abs(cosine_at(Receiver(y.position, y.normal, y.normal), _at(x))) / d2


def _at(x: Receiver) -> Point:
    return Point(x.position, x.normal, x.normal)


def _with_light(light: Callable[[Bounded], Bounded]) -> Any:
    """Target of both equations, with another number in place of luminance."""

    def changed(kind: Value, x: Receiver, y: Point) -> Bounded:
        if kind == "outgoing":
            return on_both_sides(x, y, light(y.radiance))
        found = light(x.albedo * y.radiance)
        return on_both_sides(x, y, found * cosine_at(x, y) / constant(pi, found))

    return changed


def _shares(red: float, green: float, blue: float) -> Callable[[Bounded], Bounded]:
    def light(color: Bounded) -> Bounded:
        shares = np.broadcast_to([red, green, blue], color.value.shape)
        error = color.rounding.unit * shares
        return inner(color, Bounded(shares, error, color.rounding))

    return light


def _red(color: Bounded) -> Bounded:
    return color[:, 0]


def _largest(color: Bounded) -> Bounded:
    most = color.value.argmax(axis=1)
    return color[np.arange(len(most)), most]


def _pure_is_null(p_hat: Bounded, x: Receiver, y: Point) -> Bounded:
    full: Masks = np.all((x.albedo * y.radiance).value > 0, axis=1)
    return choose(full, p_hat, constant(0.0, p_hat))


def _both_sides_of_sample(kind: Value, x: Receiver, y: Point) -> Bounded:
    p = target(kind, x, y)
    back = target(kind, x, Point(y.position, -y.normal, y.radiance))
    return p + back


def _below_the_horizon(kind: Value, x: Receiver, y: Point) -> Bounded:
    below = Receiver(x.position, -x.normal, x.albedo)
    return target(kind, x, y) + target(kind, below, y)


def _target_mistake(
    name: str, mistake: str, wrong: str, change: Any, *seen: str
) -> Hypothesis:
    rules = replace(CONTRACT_RULES, target=change, reuse_target=change)
    return Hypothesis(name, mistake, wrong, P_RIGHT, TARGETS_IN, rules, seen)


TARGETS = (
    _target_mistake(
        "target-without-pi",
        "the target lacks 1/π",
        "p̂ = Y(albedo · L_o) · cos θ",
        _scattered(_times_pi),
    ),
    _target_mistake(
        "target-pi-twice",
        "the target is divided by π twice",
        "p̂ = Y(albedo / π² · L_o) · cos θ",
        _scattered(_over_pi),
    ),
    _target_mistake(
        "target-without-cosine",
        "the target lacks the cosine",
        "p̂ = Y(albedo / π · L_o)",
        _scattered(_without_cosine),
        "the paper's Equation 10, where Equation 9 is asked for",
    ),
    _target_mistake(
        "target-cosine-twice",
        "the target has the cosine twice",
        "p̂ = Y(albedo / π · L_o) · cos² θ",
        _scattered(_cosine_twice),
    ),
    _target_mistake(
        "target-without-albedo",
        "the target lacks the albedo",
        "p̂ = Y(L_o) / π · cos θ",
        _scattered(_without_albedo),
    ),
    _target_mistake(
        "target-with-geometry-term",
        "the target has the geometry term of an area measure",
        "p̂ = Y(albedo / π · L_o) · cos θ cos φ / d²",
        _scattered(_geometry_term),
        "ReSTIR_GI by shallairo",
    ),
    _target_mistake(
        "luminance-of-rec-601",
        "luminance has the weights of Rec. 601",
        "Y = 0.299 R + 0.587 G + 0.114 B",
        _with_light(_shares(0.299, 0.587, 0.114)),
        "ReSTIR_PT",
    ),
    _target_mistake(
        "mean-of-channels",
        "the mean of the channels stands for luminance",
        "Y = (R + G + B) / 3",
        _with_light(_shares(1 / 3, 1 / 3, 1 / 3)),
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
        _with_light(_red),
    ),
    _target_mistake(
        "largest-channel",
        "the largest channel stands for luminance: right in law",
        "Y = max(R, G, B)",
        _with_light(_largest),
    ),
    _target_mistake(
        "pure-colours-are-null",
        "colours without one of the channels are taken for nothing",
        "p̂ = 0 unless R, G and B are above 0",
        _scattered(_pure_is_null),
        "bevy 01804ded1c",
    ),
)

"""Known mistakes with shading and source densities."""

from dataclasses import replace
from math import pi
from typing import Any

import numpy as np

from restir_gi.reference.numerics.arrays import Masks
from restir_gi.reference.oracle.contract.fields import Value
from restir_gi.reference.oracle.contract.passes import VISIBILITY
from restir_gi.reference.oracle.diagnosis.hypothesis import Departure, Hypothesis
from restir_gi.reference.oracle.replay.bounded import Bounded, constant
from restir_gi.reference.oracle.replay.formulas import reflected, target
from restir_gi.reference.oracle.replay.geometry import cosine_at, lit_at
from restir_gi.reference.oracle.replay.points import ReceiverPoint, SamplePoint
from restir_gi.reference.oracle.replay.rules import CONTRACT_RULES
from restir_gi.reference.oracle.replay.sources import density
from restir_gi.reference.oracle.replay.verbs import (
    choose,
    inner,
    square_root,
    times,
    where_positive,
)

F_RIGHT = "color = albedo / π · cos θ · L_o · W"
D_RIGHT = "uniform 1 / 2π, cosine cos θ / π"


def _shade_times_pi(x: ReceiverPoint, y: SamplePoint) -> Bounded:
    f = reflected(x, y)
    return f * constant(pi, f)


def _shade_without_albedo(x: ReceiverPoint, y: SamplePoint) -> Bounded:
    white = ReceiverPoint(x.position, x.normal, constant(1.0, x.albedo))
    return reflected(white, y)


def _shade_albedo_twice(x: ReceiverPoint, y: SamplePoint) -> Bounded:
    return reflected(x, y) * x.albedo


def _shade_without_cosine(x: ReceiverPoint, y: SamplePoint) -> Bounded:
    color = x.albedo * y.radiance
    color = color / constant(pi, color)
    above = where_positive(inner(x.normal, y.position - x.position), color)
    return where_positive(lit_at(x, y), above)


def _shade_cosine_twice(x: ReceiverPoint, y: SamplePoint) -> Bounded:
    return times(reflected(x, y), cosine_at(x, y))


def _shade_target(x: ReceiverPoint, y: SamplePoint) -> Bounded:
    p_hat = target("scattered", x, y)
    return times(constant(1.0, x.albedo), p_hat)


def _shade_both_sides(x: ReceiverPoint, y: SamplePoint) -> Bounded:
    return reflected(x, y) + reflected(
        x, SamplePoint(y.position, -y.normal, y.radiance)
    )


def _without_W(f: Bounded, W: Bounded) -> Bounded:
    return f


def _shade_pure_is_null(x: ReceiverPoint, y: SamplePoint) -> Bounded:
    f = reflected(x, y)
    full: Masks = np.all(y.radiance.value > 0, axis=1)
    return choose(full, f, constant(0.0, f))


def _shade_pure_reflection_is_null(x: ReceiverPoint, y: SamplePoint) -> Bounded:
    f = reflected(x, y)
    full: Masks = np.all(f.value > 0, axis=1)
    return choose(full, f, constant(0.0, f))


def _shade_geometry_term(x: ReceiverPoint, y: SamplePoint) -> Bounded:
    v = x.position - y.position
    d2 = inner(v, v)
    cosine = abs(inner(y.normal, v)) / square_root(d2)
    return times(reflected(x, y), cosine / d2)


def _density_of(uniform: float | None, cosine: float | None) -> Any:
    def changed(source: Value, at: Bounded) -> Bounded:
        if source == "uniform" and uniform is not None:
            return constant(uniform, at)
        if source == "cosine" and cosine is not None:
            return at * constant(cosine, at)
        return density(source, at)

    return changed


def _uniform_density_for_cosine(source: Value, at: Bounded) -> Bounded:
    return density("uniform", at)


def _cosine_density_for_uniform(source: Value, at: Bounded) -> Bounded:
    return density("cosine", at)


def _shade_mistake(
    name: str, mistake: str, wrong: str, change: Any, departure: Departure = ""
) -> Hypothesis:
    rules = replace(CONTRACT_RULES, reflected=change)
    shows = ("shade",)
    return Hypothesis(name, mistake, wrong, F_RIGHT, shows, rules, departure=departure)


def _visibility_mistake(name: str, mistake: str, wrong: str, sees: str) -> Hypothesis:
    return Hypothesis(
        name,
        mistake,
        wrong,
        "color = 0 where x does not see the sample",
        ("shade",),
        replace(CONTRACT_RULES, shading_sees=sees),
        only=(VISIBILITY.name, VISIBILITY.more),
    )


def _density_mistake(name: str, mistake: str, wrong: str, change: Any) -> Hypothesis:
    rules = replace(CONTRACT_RULES, density=change)
    return Hypothesis(name, mistake, wrong, D_RIGHT, ("direction",), rules)


SHADING = (
    _shade_mistake(
        "shade-without-pi",
        "shading lacks 1/π",
        "color = albedo · cos θ · L_o · W",
        _shade_times_pi,
    ),
    _shade_mistake(
        "shade-without-albedo",
        "shading lacks the albedo",
        "color = 1 / π · cos θ · L_o · W",
        _shade_without_albedo,
    ),
    _shade_mistake(
        "shade-albedo-twice",
        "shading has the albedo twice",
        "color = albedo² / π · cos θ · L_o · W",
        _shade_albedo_twice,
    ),
    _shade_mistake(
        "shade-without-cosine",
        "shading lacks the cosine",
        "color = albedo / π · L_o · W",
        _shade_without_cosine,
    ),
    _shade_mistake(
        "shade-cosine-twice",
        "shading has the cosine twice",
        "color = albedo / π · cos² θ · L_o · W",
        _shade_cosine_twice,
    ),
    _shade_mistake(
        "shade-by-the-target",
        "the target, a luminance, is shown in place of the integrand",
        "color = p̂ W",
        _shade_target,
    ),
    _shade_mistake(
        "shade-back-of-sample",
        "sample points shine on their back too",
        "no test of n_s·ω, which is the target's: W is 0 there",
        _shade_both_sides,
        "order",
    ),
    _density_mistake(
        "density-of-half-the-hemisphere",
        "the uniform density is 1/π",
        "pdf = 1 / π",
        _density_of(1 / pi, None),
    ),
    _density_mistake(
        "density-of-the-sphere",
        "the uniform density is that of the whole sphere",
        "pdf = 1 / 4π",
        _density_of(1 / (4 * pi), None),
    ),
    _density_mistake(
        "density-without-pi",
        "the cosine density lacks 1/π",
        "pdf = cos θ",
        _density_of(None, 1.0),
    ),
    _density_mistake(
        "density-of-two-pi",
        "the cosine density has 1/2π",
        "pdf = cos θ / 2π",
        _density_of(None, 1 / (2 * pi)),
    ),
    _density_mistake(
        "density-of-the-other-sampler",
        "uniform directions are given the cosine density",
        "pdf = cos θ / π for uniform directions",
        _cosine_density_for_uniform,
    ),
    Hypothesis(
        "shade-without-weight",
        "shading lacks W",
        "color = albedo / π · cos θ · L_o",
        F_RIGHT,
        ("shade",),
        replace(CONTRACT_RULES, shaded=_without_W),
    ),
    _shade_mistake(
        "shade-pure-colours-black",
        "light without one of the channels is taken for none",
        "color = 0 unless R, G and B of L_o are above 0",
        _shade_pure_is_null,
    ),
    _shade_mistake(
        "shade-with-geometry-term",
        "shading has the geometry term of an area measure",
        "color = albedo / π · cos θ · cos φ / d² · L_o · W",
        _shade_geometry_term,
    ),
    _density_mistake(
        "uniform-density-for-cosine",
        "cosine directions are given the uniform density",
        "pdf = 1 / 2π for cosine directions",
        _uniform_density_for_cosine,
    ),
    _visibility_mistake(
        "shade-visibility-ignored",
        "the shading does not heed what the visible point sees, though it is asked",
        "color = f W of what is not seen too",
        "never",
    ),
    _visibility_mistake(
        "shade-visibility-turned",
        "the shading takes what is seen for what is not",
        "color = 0 where x sees the sample",
        "turned",
    ),
    _shade_mistake(
        "shade-pure-reflections-black",
        "what is reflected without one of the channels is taken for nothing",
        "color = 0 unless R, G and B of albedo · L_o are above 0",
        _shade_pure_reflection_is_null,
    ),
)

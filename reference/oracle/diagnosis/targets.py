"""Known mistakes with targets, integrands and densities."""

from dataclasses import replace
from functools import partial
from math import pi
from typing import Any

from restir_gi.reference.oracle.diagnosis.hypothesis import (
    REUSE,
    SHIFTED,
    Departure,
    Hypothesis,
)
from restir_gi.reference.oracle.diagnosis.luminances import (
    largest_channel,
    mean_of_channels,
    rec_601,
    red_channel,
    sum_of_channels,
)
from restir_gi.reference.oracle.replay.rules import CONTRACT_RULES
from restir_gi.reference.oracle.replay.target_rules import TargetRules

TARGETS_IN = ("target", "initial", *REUSE)
BOTH = ("scattered", "outgoing")
P_RIGHT = "p̂ = Y(albedo / π · L_o) · cos θ"


def _target_mistake(
    name: str,
    mistake: str,
    wrong: str,
    *seen: str,
    departure: Departure = "",
    passes: tuple[str, ...] = TARGETS_IN,
    **change: Any,
) -> Hypothesis:
    rules = replace(CONTRACT_RULES, target=TargetRules(**change))
    return Hypothesis(name, mistake, wrong, P_RIGHT, passes, rules, seen, departure)


_departure = partial(_target_mistake, departure="target")


TARGETS = (
    _departure(
        "target-without-pi",
        "the target lacks 1/π",
        "p̂ = Y(albedo · L_o) · cos θ",
        pis=0,
    ),
    _departure(
        "target-pi-twice",
        "the target is divided by π twice",
        "p̂ = Y(albedo / π² · L_o) · cos θ",
        pis=2,
    ),
    _departure(
        "target-without-cosine",
        "the target lacks the cosine",
        "p̂ = Y(albedo / π · L_o)",
        "the paper's Equation 10, where Equation 9 is asked for",
        cosines=0,
    ),
    _departure(
        "target-cosine-twice",
        "the target has the cosine twice",
        "p̂ = Y(albedo / π · L_o) · cos² θ",
        cosines=2,
    ),
    _departure(
        "target-without-albedo",
        "the target lacks the albedo",
        "p̂ = Y(L_o) / π · cos θ",
        albedo=False,
    ),
    _departure(
        "target-with-geometry-term",
        "the target has the geometry term of an area measure",
        "p̂ = Y(albedo / π · L_o) · cos θ cos φ / d²",
        "ReSTIR_GI by shallairo",
        area_measure=True,
    ),
    _departure(
        "luminance-of-rec-601",
        "luminance has the weights of Rec. 601",
        "Y = 0.299 R + 0.587 G + 0.114 B",
        "ReSTIR_PT",
        light=rec_601,
    ),
    _departure(
        "mean-of-channels",
        "the mean of the channels stands for luminance",
        "Y = (R + G + B) / 3",
        light=mean_of_channels,
    ),
    _departure(
        "sum-of-channels",
        "the sum of the channels stands for luminance",
        "Y = R + G + B",
        light=sum_of_channels,
    ),
    _departure(
        "target-doubled",
        "the target of Equation 9 is twice as large: the same distribution",
        "2 p̂",
        scale=2.0,
    ),
    _departure(
        "target-doubled-whatever-is-asked",
        "every target is twice as large: the same distribution",
        "2 p̂, of Equation 10 too",
        scale=2.0,
        scaled_in=BOTH,
    ),
    _departure(
        "target-times-pi-whatever-is-asked",
        "every target is multiplied by π: the same distribution",
        "π p̂, of Equation 10 too",
        scale=pi,
        scaled_in=BOTH,
    ),
    _departure(
        "root-of-the-target",
        "the root of the target stands for it: right in mean",
        "√p̂",
        root=True,
    ),
    _departure(
        "target-always-scattered",
        "the target is that of Equation 9 whatever is asked for: right in mean",
        "p̂ = Y(albedo / π · L_o) · cos θ",
        kind="scattered",
    ),
    _departure(
        "target-always-outgoing",
        "the target is that of Equation 10 whatever is asked for: right in mean",
        "p̂ = Y(L_o)",
        kind="outgoing",
    ),
    _target_mistake(
        "outgoing-without-horizon",
        "the target of Equation 10 is not 0 below the horizon",
        "p̂ = Y(L_o) wherever the sample shines",
        horizon_asked=("scattered",),
    ),
    _target_mistake(
        "back-of-sample-shines",
        "sample points shine on their back too",
        "p̂ > 0 where n_s·ω > 0",
        "C2-Renderer d4ed168",
        "RestirPT-WebGPU U8-6",
        passes=SHIFTED,  # what it is elsewhere hangs on the Jacobian
        back_asked=False,
    ),
    _target_mistake(
        "light-below-the-horizon",
        "samples below the horizon count",
        "p̂ with |cos θ|",
        "HIPRT 9374ec68",
        horizon_asked=(),
    ),
    _target_mistake(
        "red-channel",
        "the red channel stands for luminance",
        "Y = R",
        light=red_channel,
    ),
    _departure(
        "largest-channel",
        "the largest channel stands for luminance: the same distribution",
        "Y = max(R, G, B)",
        light=largest_channel,
    ),
    _target_mistake(
        "pure-colours-are-null",
        "colours without one of the channels are taken for nothing",
        "p̂ = 0 unless R, G and B are above 0",
        "bevy 01804ded1c",
        pure_is_null=True,
    ),
)

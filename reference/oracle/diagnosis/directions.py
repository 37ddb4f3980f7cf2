"""Known mistakes with the directions that are drawn."""

from math import pi

from restir_gi.reference.oracle.contract.fields import Value
from restir_gi.reference.oracle.diagnosis.hypothesis import mistake
from restir_gi.reference.oracle.replay.bounded import Bounded, constant
from restir_gi.reference.oracle.replay.sources import drawn_cosine
from restir_gi.reference.oracle.replay.verbs import square_root

IN = ("direction",)
COSINE = "cos θ = u₀ uniform, √(1 − u₀) in proportion to the cosine"
AZIMUTH = "φ = 2π u₁"


def _other_sampler(source: Value, u: Bounded) -> Bounded:
    return drawn_cosine("cosine" if source == "uniform" else "uniform", u)


def _always_uniform(source: Value, u: Bounded) -> Bounded:
    return drawn_cosine("uniform", u)


def _always_cosine(source: Value, u: Bounded) -> Bounded:
    return drawn_cosine("cosine", u)


def _other_end(source: Value, u: Bounded) -> Bounded:
    rest = constant(1.0, u) - u
    return rest if source == "uniform" else square_root(u)


def _cosine_from_other_end(source: Value, u: Bounded) -> Bounded:
    return u if source == "uniform" else square_root(u)


def _without_root(source: Value, u: Bounded) -> Bounded:
    return u if source == "uniform" else constant(1.0, u) - u


DIRECTIONS = (
    mistake(
        "directions-of-the-other-sampler",
        "uniform and cosine directions change places, their densities do not",
        "cos θ = √(1 − u₀) uniform, u₀ in proportion to the cosine",
        COSINE,
        IN,
        drawn_cosine=_other_sampler,
    ),
    mistake(
        "directions-always-uniform",
        "directions are uniform whatever is asked for",
        "cos θ = u₀",
        COSINE,
        IN,
        drawn_cosine=_always_uniform,
    ),
    mistake(
        "directions-always-cosine",
        "directions are in proportion to the cosine whatever is asked for",
        "cos θ = √(1 − u₀)",
        COSINE,
        IN,
        drawn_cosine=_always_cosine,
    ),
    mistake(
        "direction-root-forgotten",
        "the root of the cosine is forgotten",
        "cos θ = 1 − u₀",
        COSINE,
        IN,
        drawn_cosine=_without_root,
    ),
    mistake(
        "directions-from-the-other-end",
        "u₀ is used as 1 − u₀: the same distribution, and other numbers",
        "cos θ = 1 − u₀, √u₀",
        COSINE,
        IN,
        departure="order",
        drawn_cosine=_other_end,
    ),
    mistake(
        "cosine-directions-from-the-other-end",
        "u₀ is used as 1 − u₀ for the cosine density: the same distribution, and other"
        " numbers",
        "cos θ = √u₀",
        COSINE,
        IN,
        departure="order",
        drawn_cosine=_cosine_from_other_end,
    ),
    mistake(
        "half-of-the-azimuths",
        "azimuths go over half a turn",
        "φ = π u₁",
        AZIMUTH,
        IN,
        turn=pi,
    ),
    mistake(
        "azimuth-in-turns",
        "the factor 2π of the azimuth is missing",
        "φ = u₁",
        AZIMUTH,
        IN,
        turn=1.0,
    ),
    mistake(
        "one-number-for-both-components",
        "one random number gives both components of a direction",
        "φ = 2π u₀",
        AZIMUTH,
        IN,
        azimuth_number=0,
    ),
    mistake(
        "normal-points-inward",
        "directions leave on the other side of the surface",
        "ω = … − cos θ n",
        "ω = … + cos θ n",
        IN,
        inward=True,
    ),
)

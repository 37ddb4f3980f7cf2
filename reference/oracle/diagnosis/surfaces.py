"""Known mistakes with declared surfaces: lobes, coats and views.

In a target most of them are departures: it is above 0 wherever the integrand is, and
cancels between weight and W.  In shading all are mistakes.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from restir_gi.reference.oracle.contract.surfaces import COATED, SURFACE
from restir_gi.reference.oracle.diagnosis.hypothesis import SHIFTED, Hypothesis
from restir_gi.reference.oracle.diagnosis.targets import TARGETS_IN
from restir_gi.reference.oracle.replay.formulas import Integrand
from restir_gi.reference.oracle.replay.rules import CONTRACT_RULES
from restir_gi.reference.oracle.replay.surface_rules import SurfaceRules
from restir_gi.reference.oracle.replay.target_rules import TargetRules

DECLARED = (SURFACE.name, SURFACE.more)
OF_COATS = (SURFACE.name, (COATED,))

D = "D = α² / (π ((α² − 1) cos_h² + 1)²)"
H = "h = (v + ω) / |v + ω|"
LOBE = "lobe = D G₁ G₁ / (4 cos_i cos_o)"
F = "F = F₀ + (1 − F₀) (1 − cos_d)⁵, or that of the coat, at cos_d = ω·h"
FULL = "f = diffuse part + F lobe"
BASE = "f = T(cos_i) T(cos_o) / (π η²) · albedo / (1 − K s) + F lobe"


@dataclass(frozen=True, slots=True)
class _Change:
    """A surface that scatters in another way.

    Attributes
    ----------
    what : str; goes on from "the target" and from "shading"
    blind : bool; it is 0 where the integrand is not: no departure as a target
    """

    name: str
    what: str
    wrong: str
    right: str
    rules: SurfaceRules
    only: tuple[str, tuple[str, ...]] = field(default=DECLARED)
    blind: bool = False


CHANGES = (
    _Change(
        "taken-for-lambertian",
        "takes every surface for a Lambertian one",
        "f = albedo / π",
        FULL,
        SurfaceRules(lambertian="own"),
        blind=True,
    ),
    _Change(
        "alpha-squared",
        "takes α for a roughness and squares it once more",
        "α⁴ in place of α² in D, and in G₁",
        D,
        SurfaceRules(alpha="squared"),
    ),
    _Change(
        "alpha-not-squared",
        "has α in place of α²",
        "D = α / (π ((α − 1) cos_h² + 1)²), and so in G₁",
        D,
        SurfaceRules(alpha="root"),
    ),
    _Change(
        "view-turned",
        "takes the direction from the eye for that to the eye",
        "v = −view",
        "v = view",
        SurfaceRules(view="turned"),
        blind=True,
    ),
    _Change(
        "half-vector-of-the-turned-view",
        "has the view the wrong way round in the half vector",
        "h = (ω − v) / |ω − v|",
        H,
        SurfaceRules(view="turned-in-half"),
    ),
    _Change(
        "half-vector-not-normalized",
        "does not normalize the half vector",
        "h = v + ω, cosines cut off at 1",
        H,
        SurfaceRules(half=False),
    ),
    _Change(
        "four-cosines-left-out",
        "does not divide the lobe by 4 cos_i cos_o",
        "lobe = D G₁ G₁",
        LOBE,
        SurfaceRules(divisor=False),
    ),
    _Change(
        "lobe-without-pi",
        "lacks 1/π in D",
        "D = α² / ((α² − 1) cos_h² + 1)²",
        D,
        SurfaceRules(pi=False),
    ),
    _Change(
        "masking-left-out",
        "lacks masking and shadowing",
        "lobe = D / (4 cos_i cos_o)",
        LOBE,
        SurfaceRules(masking="none"),
    ),
    _Change(
        "masking-height-correlated",
        "has the height-correlated form of Smith's masking",
        "G = 1 / (1 + Λ(cos_i) + Λ(cos_o))",
        "G = G₁(cos_i) G₁(cos_o), the separable form",
        SurfaceRules(masking="correlated"),
    ),
    _Change(
        "fresnel-at-the-normal",
        "takes Fresnel reflectance at the angle of the view with the normal",
        "F at n·v",
        F,
        SurfaceRules(fresnel="normal"),
    ),
    _Change(
        "fresnel-left-out",
        "has the reflectance at normal incidence at every angle",
        "F = F₀",
        F,
        SurfaceRules(fresnel="none"),
    ),
    _Change(
        "lobe-left-out",
        "has the diffuse part alone, which metals do not have",
        "f = diffuse part",
        FULL,
        SurfaceRules(lobe=False),
        blind=True,
    ),
    _Change(
        "diffuse-left-out",
        "has the lobe alone",
        "f = F lobe",
        FULL,
        SurfaceRules(diffuse=False),
    ),
    _Change(
        "diffuse-times-what-is-not-reflected",
        "takes from the diffuse part what the lobe reflects",
        "f = (1 − F) diffuse part + F lobe",
        FULL,
        SurfaceRules(share="unreflected"),
    ),
    _Change(
        "diffuse-seen-from-below",
        "has the diffuse part where the view is below the horizon",
        "f = diffuse part where n·v ≤ 0",
        "f = 0 where n·v ≤ 0",
        SurfaceRules(view_asked=False),
    ),
    _Change(
        "coat-passed-once",
        "lets light pass the coat on its way in alone",
        "T(cos_i) in place of T(cos_i) T(cos_o)",
        BASE,
        SurfaceRules(ways=1),
        OF_COATS,
    ),
    _Change(
        "base-without-index",
        "does not divide the base by η²",
        "T(cos_i) T(cos_o) / π",
        BASE,
        SurfaceRules(index=False),
        OF_COATS,
    ),
    _Change(
        "bounces-below-the-coat-left-out",
        "loses the light that the coat sends back to the base",
        "albedo in place of albedo / (1 − K s)",
        BASE,
        SurfaceRules(bounces=False),
        OF_COATS,
    ),
)


def _of_target(c: _Change) -> Hypothesis:
    more = "" if c.blind else ": right in mean"
    return Hypothesis(
        f"target-{c.name}",
        f"the target {c.what}{more}",
        c.wrong,
        c.right,
        TARGETS_IN,
        replace(CONTRACT_RULES, target=TargetRules(surface=c.rules)),
        departure="" if c.blind else "target",
        only=c.only,
    )


def _of_shading(c: _Change) -> Hypothesis:
    return Hypothesis(
        f"shade-{c.name}",
        f"shading {c.what}",
        c.wrong,
        c.right,
        ("shade",),
        replace(CONTRACT_RULES, reflected=Integrand(c.rules)),
        only=c.only,
    )


def _of_views() -> Iterator[Hypothesis]:
    for name, what, wrong, right, views in (
        (
            "view-of-the-receiver-in-the-domain",
            "the domain test asks the source with the view of the receiver",
            "p̂ at x_from, with the receiver's view, is above 0",
            "with its own view",
            "receiver",
        ),
        (
            "view-of-the-source-at-the-receiver",
            "the receiver is given the view of the source of a sample that it reuses",
            "p̂ at x, with the view of x_from",
            "p̂ at x, with its own view",
            "source",
        ),
    ):
        rules = replace(CONTRACT_RULES, views=views)
        yield Hypothesis(name, what, wrong, right, SHIFTED, rules, only=DECLARED)


def _white(name: str, what: str, everywhere: bool) -> Hypothesis:
    surface = SurfaceRules(lambertian="white")
    return Hypothesis(
        name,
        f"the target {what}: right in mean",
        "p̂ = Y(L_o) / π · cos θ",
        "p̂ = Y(f · L_o) · cos θ",
        TARGETS_IN,
        replace(
            CONTRACT_RULES, target=TargetRules(albedo=not everywhere, surface=surface)
        ),
        departure="target",
        only=DECLARED,
    )


WHITE = (
    _white(
        "target-white-and-lambertian",
        "takes every declared surface for a white Lambertian one",
        everywhere=False,
    ),
    _white(
        "target-without-albedo-and-surface",
        "takes everything for white and Lambertian, as it lacks albedo and surface",
        everywhere=True,
    ),
)

SURFACES: tuple[Hypothesis, ...] = (
    *map(_of_target, CHANGES),
    *WHITE,
    *map(_of_shading, CHANGES),
    *_of_views(),
)

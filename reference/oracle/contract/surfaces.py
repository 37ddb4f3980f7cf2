"""Surfaces of visible points that are not Lambertian: their buffers and formulas."""

from restir_gi.reference.oracle.contract.fields import (
    Field,
    Setting,
    bits,
    given_with,
    real,
    vector,
)

LAMBERTIAN, GGX, COATED = "lambertian", "ggx", "coated"

SURFACE = Setting(
    "surface",
    LAMBERTIAN,
    "how visible points scatter",
    more=(GGX, COATED),
    default=LAMBERTIAN,
)

NODES = 64
"""Cosines at which the transmittance of a coat is given, evenly from 0 to 1."""

MATERIAL: tuple[Field, ...] = (
    *given_with(
        SURFACE.name,
        SURFACE.more,
        (
            vector("view", "unit vector from the visible point to the eye"),
            real("alpha", "width α of the GGX distribution, above 0"),
        ),
    ),
    *given_with(
        SURFACE.name, (GGX,), (vector("f0", "reflectance F₀ at normal incidence"),)
    ),
    *given_with(
        SURFACE.name,
        (COATED,),
        (
            real("ior", "index of refraction η of the coat, at least 1"),
            real("internal_reflectance", "share K that the coat sends back, below 1"),
            real("transmittance", f"T at the cosines k / {NODES - 1}", NODES),
            bits("nonlinear", "1 where the base colours every bounce, else 0"),
        ),
    ),
)
"""Of a visible point, beside its normal and its albedo."""

PAGE = f"""
## Surfaces

A visible point is Lambertian, f = albedo / π, in all cases without the setting
`surface`. Its declared values are materials with a glossy lobe, seen from an eye. All
passes are as they stand, with this f in place of albedo / π:

```text
v = view, n = visible_normal, ω the unit vector from x to the sample point
h = (v + ω) / |v + ω|
cos_i = n·ω, cos_o = n·v, cos_h = n·h, cos_d = ω·h

D = α² / (π ((α² − 1) cos_h² + 1)²)
G₁(c) = 2 c / (c + √(c² + α² (1 − c²)))
lobe = D G₁(cos_i) G₁(cos_o) / (4 cos_i cos_o)

ggx:     F = F₀ + (1 − F₀) (1 − cos_d)⁵, channel by channel
         f = albedo / π + F lobe
coated:  c = √(1 − (1 − cos_d²) / η²)
         F = ½ ((η cos_d − c) / (η cos_d + c))² + ½ ((cos_d − η c) / (cos_d + η c))²
         f = T(cos_i) T(cos_o) / (π η²) · albedo / (1 − K s) + F lobe
         s = albedo where nonlinear is 1, else 1

f = 0, the diffuse part too, unless cos_i > 0 and cos_o > 0
```

The masking is separable, G₁ G₁, not the height-correlated form. `alpha` is α itself; of
a perceptual roughness r it is the square. T is linear between its {NODES} cosines. The
target of Equation 10 asks neither for f nor for the view. A point whose view is below
its horizon reflects nothing: p̂ of Equation 9 is 0 there, as on a black surface. The
domain test asks a source with its own normal, material and view.

Where α goes to 0, D goes to 1 / (π α²) at cos_h = 1 and to 0 everywhere else: α = 0 is
a mirror, which has no density, and no case has it. Below 0.02 the subtraction in D
leaves float32 less than three digits at the peak: such rows, and those of α above 1,
are beyond the working range.
"""
"""Section of the contract's page."""

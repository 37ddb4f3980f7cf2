"""Materials as an author gives them.

All are opaque and two-sided (the back scatters as the front does) unless
``two_sided=False``, which makes the back black; a dielectric has an inside instead.
"""

from dataclasses import dataclass
from typing import Literal

from restir_gi.reference.scene.textures import Color, Texture

Distribution = Literal["ggx", "beckmann"]
"""Of the normals of microfacets."""


@dataclass(frozen=True, slots=True, eq=False)
class Lambertian:
    """Scatters alike into all directions: f = reflectance / π.

    Attributes
    ----------
    reflectance : Texture; 0 to 1
    two_sided : bool; whether the back scatters too
    """

    reflectance: Texture
    two_sided: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class Conductor:
    """Metal, rough or, with alpha = 0, a smooth mirror.

    Attributes
    ----------
    reflectance : Texture
        Factor on the Fresnel term; with ``eta=None`` and ``schlick`` the reflectance
        at normal incidence, else (``eta=None``) all there is.
    alpha : float
        Width of the microfacets' distribution; 0, or 1e-3 to 1.  glTF roughness r means
        alpha = r².
    eta, k : Color or None; complex index of refraction, eta + i k
    schlick : bool; Fresnel term by Schlick from the reflectance
    two_sided : bool; whether the back reflects too
    distribution : 'ggx' or 'beckmann'; of the microfacets' normals
    """

    reflectance: Texture
    alpha: float
    eta: Color | None = None
    k: Color | None = None
    schlick: bool = False
    two_sided: bool = True
    distribution: Distribution = "ggx"


@dataclass(frozen=True, slots=True, eq=False)
class Coated:
    """Diffuse base under a clear coat, rough or, with alpha = 0, smooth.

    Attributes
    ----------
    reflectance : Texture; of the base, 0 to 1
    alpha : float; width of the distribution of the coat's microfacets; 0, or 1e-3 to 1
    ior : float; index of refraction of the coat over that of the outside, above 1
    nonlinear : bool
        Light reflected back and forth below the coat takes on the base's colour
        again at each turn.
    specular : Color; factor on the coat's reflection; 1 is physical
    two_sided : bool; whether the back scatters too
    distribution : 'ggx' or 'beckmann'; of the coat's microfacets' normals
    """

    reflectance: Texture
    alpha: float
    ior: float = 1.5
    nonlinear: bool = False
    specular: Color = (1.0, 1.0, 1.0)
    two_sided: bool = True
    distribution: Distribution = "ggx"


@dataclass(frozen=True, slots=True)
class Dielectric:
    """Boundary between two clear media, which reflects and refracts.

    Attributes
    ----------
    ior : float; index of refraction behind the front over that before it
    alpha : float; width of the microfacets' distribution; 0 where smooth, or 1e-3 to 1
    distribution : 'ggx' or 'beckmann'; of the microfacets' normals
    """

    ior: float = 1.5
    alpha: float = 0.0
    distribution: Distribution = "ggx"


Material = Lambertian | Conductor | Coated | Dielectric


def mirror(reflectance: Color = (1.0, 1.0, 1.0)) -> Conductor:
    """Smooth mirror of constant reflectance, with alpha 0 and no Fresnel term.

    Parameters
    ----------
    reflectance : Color; 0 to 1
    """
    return Conductor(reflectance, alpha=0.0)

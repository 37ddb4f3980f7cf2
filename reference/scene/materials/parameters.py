"""Material parameters as columns, a row a material."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars, Vec3s, dot
from restir_gi.reference.scene.materials.coat import (
    NODES,
    internal_reflectance,
    transmittance_table,
)
from restir_gi.reference.scene.materials.facets import Facets
from restir_gi.reference.scene.materials.kinds import (
    Coated,
    Conductor,
    Lambertian,
    Material,
)
from restir_gi.reference.scene.surface import SurfacePoints
from restir_gi.reference.scene.textures import Texture, color_range, mean_color


class Kind(IntEnum):
    """What scatters in the same way."""

    LAMBERTIAN = 0
    ROUGH_CONDUCTOR = 1
    SMOOTH_CONDUCTOR = 2
    ROUGH_COATED = 3
    SMOOTH_COATED = 4
    DIELECTRIC = 5
    ROUGH_DIELECTRIC = 6


@dataclass(frozen=True, slots=True, eq=False)
class MaterialTable:
    """Material parameters as columns, K rows.

    Attributes
    ----------
    kinds : tuple of Kind; those that occur
    kind : (K,) int8; how the material scatters
    textures : tuple of Texture; reflectance of each material
    color : (K, 3) float64; mean reflectance
    two_sided : (K,) bool; whether the back scatters too
    alpha : (K,) float64; width of the microfacets' distribution, 0 where smooth
    beckmann : (K,) bool; it is Beckmann's, else GGX
    ior : (K,) float64; of a coat or a dielectric
    eta, k : (K, 3) float64; of a conductor; eta = 0 where it has no Fresnel term
    schlick : (K,) bool; Fresnel term from the reflectance
    specular : (K, 3) float64; factor on a coat's reflection
    nonlinear : (K,) bool; see :class:`Coated`
    transmittance : (K, NODES) float64; of a coat, at cosines from 0 to 1
    keep : (K,) float64; internal reflectance of a coat
    plain : bool; every point is black, or reflects all colours to its whole horizon
    """

    kinds: tuple[Kind, ...]
    kind: Indices
    textures: tuple[Texture, ...]
    color: Vec3s
    two_sided: Masks
    alpha: Scalars
    beckmann: Masks
    ior: Scalars
    eta: Vec3s
    k: Vec3s
    schlick: Masks
    specular: Vec3s
    nonlinear: Masks
    transmittance: Scalars
    keep: Scalars
    plain: bool

    def facets(self, material: Indices) -> Facets:
        """Microfacets of surfaces.

        Parameters
        ----------
        material : (N,) int; rows of the table
        """
        beckmann = self.beckmann[material] if self.beckmann.any() else None
        return Facets(self.alpha[material], beckmann)

    @property
    def transmits(self) -> bool:
        """Whether light that is chosen may come from behind a surface."""
        return Kind.ROUGH_DIELECTRIC in self.kinds


def kind_of(material: Material) -> Kind:
    """How a material scatters."""
    if isinstance(material, Lambertian):
        return Kind.LAMBERTIAN
    if isinstance(material, Conductor):
        return Kind.ROUGH_CONDUCTOR if material.alpha > 0 else Kind.SMOOTH_CONDUCTOR
    if isinstance(material, Coated):
        return Kind.ROUGH_COATED if material.alpha > 0 else Kind.SMOOTH_COATED
    return Kind.ROUGH_DIELECTRIC if material.alpha > 0 else Kind.DIELECTRIC


def tabulate(materials: list[Material]) -> MaterialTable:
    """Put materials into a table."""
    kind = [kind_of(m) for m in materials]
    white = (1.0, 1.0, 1.0)
    textures = tuple(getattr(m, "reflectance", white) for m in materials)
    coats = [m if isinstance(m, Coated) else None for m in materials]
    return MaterialTable(
        kinds=tuple(sorted(set(kind))),
        kind=np.array(kind, np.int8),
        textures=textures,
        color=np.array([mean_color(t) for t in textures]).reshape(-1, 3),
        two_sided=np.array([getattr(m, "two_sided", True) for m in materials]),
        alpha=np.array([getattr(m, "alpha", 0.0) for m in materials]),
        beckmann=np.array(
            [getattr(m, "distribution", "ggx") == "beckmann" for m in materials]
        ),
        ior=np.array([getattr(m, "ior", 1.5) for m in materials]),
        eta=_column(materials, "eta", (0.0, 0.0, 0.0)),
        k=_column(materials, "k", (0.0, 0.0, 0.0)),
        schlick=np.array([getattr(m, "schlick", False) for m in materials]),
        specular=_column(materials, "specular", white),
        nonlinear=np.array([getattr(m, "nonlinear", False) for m in materials]),
        transmittance=np.array(
            [
                transmittance_table(c.alpha, c.ior, c.distribution)
                if c
                else np.zeros(NODES)
                for c in coats
            ]
        ),
        keep=np.array(
            [
                internal_reflectance(c.alpha, c.ior, c.distribution) if c else 0.0
                for c in coats
            ]
        ),
        plain=_is_plain(materials, textures),
    )


def _is_plain(materials: list[Material], textures: tuple[Texture, ...]) -> bool:
    ranges = [color_range(texture) for texture in textures]
    all_or_nothing = all(low > 0 or high == 0 for low, high in ranges)
    two_sided = all(isinstance(m, Lambertian) and m.two_sided for m in materials)
    return two_sided and all_or_nothing


def _column(materials: list[Material], name: str, absent: tuple[float, ...]) -> Vec3s:
    values = (getattr(m, name, None) for m in materials)
    return np.array([absent if v is None else v for v in values], float)


def lit_cosine(table: MaterialTable, points: SurfacePoints, wi: Vec3s) -> Scalars:
    """Cosine of light with the shading normal where it can be reflected, else 0.

    The geometric normal decides on which side the light is, as in [Pharr23]: no light
    leaks through a smooth-shaded face.

    Parameters
    ----------
    table : MaterialTable; says which materials have a black back
    wi : (N, 3) float64; unit directions to the light

    Returns
    -------
    (N,) float64
        0 where ``wi`` is below the geometric surface or below the shading normal, and
        on the back of one-sided materials.
    """
    cosine = np.maximum(dot(points.shading, wi), 0.0)
    if points.smooth is not None:
        cosine = np.where(dot(points.normal, wi) > 0, cosine, 0.0)
    if not table.two_sided.all():
        shows = points.front | table.two_sided[points.material]
        cosine = np.where(shows, cosine, 0.0)
    return cosine

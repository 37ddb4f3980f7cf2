"""Microfacets of materials, of whichever distribution."""

from dataclasses import dataclass

import numpy as np

from restir_gi.reference.numerics.arrays import Masks, Scalars, Vec3s
from restir_gi.reference.numerics.rng import Draw
from restir_gi.reference.scene.materials.microfacet import (
    beckmann_density,
    beckmann_g1,
    facing_share,
    ggx_density,
    sample_facing_normal,
    sample_visible_normal,
    smith_g1,
)


@dataclass(frozen=True, slots=True)
class Facets:
    """Microfacets of N surfaces.

    Attributes
    ----------
    alpha : (N,) float64; width of the distribution of their normals
    beckmann : (N,) bool or None
        Beckmann's distribution, else GGX; ``None`` where all are GGX.
    """

    alpha: Scalars
    beckmann: Masks | None = None

    def density(self, cos_h: Scalars) -> Scalars:
        """Density D of normals, (N,) float, 1/sr; 0 below the surface.

        Parameters
        ----------
        cos_h : (N,) float; cosines of the normals with the surface normal
        """
        ggx = ggx_density(cos_h, self.alpha)
        if self.beckmann is None:
            return ggx
        return np.where(self.beckmann, beckmann_density(cos_h, self.alpha), ggx)

    def masking(self, cos: Scalars) -> Scalars:
        """Smith's share G1 of microfacets that directions see.

        Parameters
        ----------
        cos : (N,) float; cosines of the directions with the surface normal

        Returns
        -------
        (N,) float; 0 to 1; 0 below the surface
        """
        ggx = smith_g1(cos, self.alpha)
        if self.beckmann is None:
            return ggx
        return np.where(self.beckmann, beckmann_g1(cos, self.alpha), ggx)

    def sample(self, wo: Vec3s, u: Draw) -> tuple[Vec3s, Scalars]:
        """Normals in the frame of the surface, mostly those that the viewer sees.

        Parameters
        ----------
        wo : (N, 3) float64
            Unit directions of viewers in the frame of the surface, z > 0.
        u : four (N,) float64
            Lanes 0 to 2 are used; lane 3 belongs to those who draw whole paths.

        Returns
        -------
        (N, 3), (N,) float64
            Unit vectors of density D max(0, wo·h) / cos θ_o times `shown`; and a
            number in [0, 1) that is left of lane 0.
        """
        ggx = sample_visible_normal(wo, self.alpha, u[1], u[2])
        if self.beckmann is None:
            return ggx, u[0]
        facing, left = sample_facing_normal(wo, self.alpha, u[1], u[2], u[0])
        normals = np.where(self.beckmann[:, None], facing, ggx)
        return normals, np.where(self.beckmann, left, u[0])

    def shown(self, cos_h: Scalars, cos_o: Scalars, cos_d: Scalars) -> Scalars:
        """Share of microfacets that the sampler takes a viewer to see.

        Parameters
        ----------
        cos_h, cos_o : (N,) float64
            Cosines of microfacet normal and viewer with the surface normal.
        cos_d : (N,) float64; cosine of the viewer with the microfacet normal

        Returns
        -------
        (N,) float64; 0 to 1; 0 below the surface
        """
        ggx = smith_g1(cos_o, self.alpha)
        if self.beckmann is None:
            return ggx
        return np.where(self.beckmann, facing_share(cos_h, cos_o, cos_d), ggx)

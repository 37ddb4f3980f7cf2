"""Materials of visible points among the contract's buffers, with error bounds."""

from dataclasses import dataclass

from restir_gi.reference.numerics.arrays import Indices, Masks
from restir_gi.reference.oracle.cases import Buffers
from restir_gi.reference.oracle.replay.bounded import Bounded, Rounding, exact


@dataclass(frozen=True, slots=True, eq=False)
class Coat:
    """Clear coats over diffuse bases, N rows.

    Attributes
    ----------
    ior, internal_reflectance : Bounded; (N,)
    transmittance : Bounded; (N, K), at K cosines from 0 to 1
    nonlinear : (N,) bool; the base colours every bounce
    """

    ior: Bounded
    internal_reflectance: Bounded
    transmittance: Bounded
    nonlinear: Masks

    def rows(self, rows: Indices) -> "Coat":
        """Some of the coats.

        Parameters
        ----------
        rows : (K,) int
        """
        return Coat(
            self.ior[rows],
            self.internal_reflectance[rows],
            self.transmittance[rows],
            self.nonlinear[rows],
        )


@dataclass(frozen=True, slots=True, eq=False)
class Material:
    """What visible points have that are not Lambertian, N rows.

    Attributes
    ----------
    view : Bounded; (N, 3), unit vectors to the eye
    alpha : Bounded; (N,), width of the GGX distribution
    reflects : Bounded or Coat
        (N, 3) reflectance at normal incidence; or the coat that reflects.
    """

    view: Bounded
    alpha: Bounded
    reflects: Bounded | Coat

    def rows(self, rows: Indices) -> "Material":
        """Some of the materials.

        Parameters
        ----------
        rows : (K,) int
        """
        some = self.reflects
        return Material(
            self.view[rows],
            self.alpha[rows],
            some.rows(rows) if isinstance(some, Coat) else some[rows],
        )


def material_of(
    buffers: Buffers, rounding: Rounding, prefix: str = ""
) -> Material | None:
    """Materials among buffers; ``None`` where the visible points are Lambertian."""
    if f"{prefix}view" not in buffers:
        return None

    def given(name: str) -> Bounded:
        return exact(buffers[prefix + name], rounding)

    view, alpha = given("view"), given("alpha")
    if f"{prefix}f0" in buffers:
        return Material(view, alpha, given("f0"))
    coat = Coat(
        given("ior"),
        given("internal_reflectance"),
        given("transmittance"),
        buffers[f"{prefix}nonlinear"] == 1,
    )
    return Material(view, alpha, coat)

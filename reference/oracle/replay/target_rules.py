"""Targets that renderers have, made of factors that are chosen one by one."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import pi

import numpy as np

from restir_gi.reference.numerics.arrays import Masks
from restir_gi.reference.oracle.contract.fields import Value
from restir_gi.reference.oracle.replay.bounded import Bounded, constant
from restir_gi.reference.oracle.replay.geometry import (
    cosine_at,
    lit_at,
    luminance,
    open_at_zero,
)
from restir_gi.reference.oracle.replay.points import ReceiverPoint, SamplePoint
from restir_gi.reference.oracle.replay.surface_rules import (
    CONTRACT_SURFACES,
    SurfaceRules,
)
from restir_gi.reference.oracle.replay.verbs import (
    choose,
    inner,
    square_root,
    where_positive,
)


@dataclass(frozen=True, slots=True)
class TargetRules:
    """Target p̂ of a sample point at a visible point; the default is the contract's.

    Attributes
    ----------
    kind : 'asked', 'scattered' or 'outgoing'; Equation 9 or 10
    light : callable; what stands for luminance
    pis : int; times that Equation 9 is divided by π
    cosines : int; power of cos θ in Equation 9
    albedo : bool; whether Equation 9 has it
    area_measure : bool; cos φ / d² stands in Equation 9 too
    scale : float; factor of the target
    scaled_in : tuple of str; kinds to which that applies
    root : bool; the root stands for the target
    back_asked : bool; 0 where the back of the sample is seen
    horizon_asked : tuple of str; kinds that are 0 below the horizon
    pure_is_null : bool; Equation 9 is 0 unless all channels are above 0
    least : float; a positive target is at least that
    least_in : tuple of str; kinds to which that applies
    surface : SurfaceRules; f cos θ of declared surfaces in Equation 9
    """

    kind: str = "asked"
    light: Callable[[Bounded], Bounded] = luminance
    pis: int = 1
    cosines: int = 1
    albedo: bool = True
    area_measure: bool = False
    scale: float = 1.0
    scaled_in: tuple[str, ...] = ("scattered",)
    root: bool = False
    back_asked: bool = True
    horizon_asked: tuple[str, ...] = ("scattered", "outgoing")
    pure_is_null: bool = False
    least: float = 0.0
    least_in: tuple[str, ...] = ("scattered", "outgoing")
    surface: SurfaceRules = CONTRACT_SURFACES

    @property
    def shows_more(self) -> bool:
        """Whether choices show that change nothing in the target that is asked for."""
        return self.kind != "asked" or self.least > 0

    def __call__(self, kind: Value, x: ReceiverPoint, y: SamplePoint) -> Bounded:
        """Target of N sample points at as many visible points, (N,)."""
        chosen = str(kind) if self.kind == "asked" else self.kind
        p_hat = self._light_of(chosen, x, y)
        above = inner(x.normal, y.position - x.position)
        if chosen in self.horizon_asked:
            p_hat = where_positive(above, p_hat)
        else:
            p_hat = open_at_zero(above, abs(p_hat))
        lit = lit_at(x, y)
        p_hat = (where_positive if self.back_asked else open_at_zero)(lit, p_hat)
        if self.scale != 1 and chosen in self.scaled_in:
            p_hat = p_hat * constant(self.scale, p_hat)
        if self.root:
            p_hat = square_root(p_hat)
        return self._at_least(chosen, p_hat)

    def _light_of(self, kind: str, x: ReceiverPoint, y: SamplePoint) -> Bounded:
        if kind == "outgoing":
            return self.light(y.radiance)
        color = x.albedo * y.radiance if self.albedo else y.radiance
        cosines, pis = self.cosines, self.pis
        if x.material is not None:
            at = x if self.albedo else replace(x, albedo=constant(1.0, x.albedo))
            color = self.surface(at, x.material, y) * y.radiance
            # Of each of these it has one.
            cosines, pis = cosines - 1, pis - 1
        p_hat = self.light(color)
        if cosines:
            cosine = cosine_at(x, y)
            # The square alone may be too small for its type, unlike its product
            # with light.
            power = cosine * cosine if cosines == 2 else cosine
            p_hat = p_hat * power if cosines > 0 else p_hat / power
        for _ in range(abs(pis)):
            one_pi = constant(pi, p_hat)
            p_hat = p_hat / one_pi if pis > 0 else p_hat * one_pi
        if self.area_measure:
            p_hat = p_hat * _area_measure(x, y)
        if self.pure_is_null:
            full: Masks = np.all(color.value > 0, axis=1)
            p_hat = choose(full, p_hat, constant(0.0, p_hat))
        return p_hat

    def _at_least(self, kind: str, p_hat: Bounded) -> Bounded:
        if not self.least or kind not in self.least_in:
            return p_hat
        low = constant(self.least, p_hat)
        raised = np.maximum(p_hat.value, self.least)
        floor = Bounded(raised, p_hat.error + low.error, p_hat.rounding)
        found = choose(p_hat.value > 0, floor, p_hat)
        # Either side, where rounding leaves open whether there is light.
        unsure = (p_hat.error > 0) & ~p_hat.surely_positive & ~p_hat.surely_not_positive
        error = np.where(unsure, np.maximum(p_hat.error, self.least), found.error)
        return Bounded(found.value, error, found.rounding)


def _area_measure(x: ReceiverPoint, y: SamplePoint) -> Bounded:
    v = x.position - y.position
    d2 = inner(v, v)
    return abs(inner(y.normal, v)) / square_root(d2) / d2

"""Two shifts: within a pair, from pixel to pixel; and from a pair to another one."""

from dataclasses import dataclass

import numpy as np

from extensions.area_donor import AreaShift
from extensions.area_paths import AreaPaths, Placed
from gradient_domain.paired_domain import PairedPaths, PairValue
from gradient_domain.pairs import Pairs
from reference.arrays import Indices, Scalars
from reference.records import scatter, take


@dataclass(frozen=True, slots=True)
class InnerShift:
    """From a pixel of a pair to the other: makes offset paths of base paths.

    Attributes
    ----------
    within : AreaShift; within one image, where x_1 moves with its place
    """

    within: AreaShift

    def __call__(
        self, base: AreaPaths, placed: Placed, k: Indices, pairs: Pairs, sign: Indices
    ) -> PairValue:
        """Worth of base paths, with their offset paths [Wang25, section 4.2.1].

        Parameters
        ----------
        base : AreaPaths; N rows, where ``placed`` says
        k : (N,) int8; to which pixel of the pair they belong
        sign : (N,) int8; of the reservoirs that want them
        """
        onward = np.where(k == 0, 1.0, -1.0)
        other = np.where(k == 0, pairs.second, pairs.first)
        found, inner = self.within(base, other, onward * pairs.dx, onward * pairs.dy)
        return PairValue(k, placed, found.value, inner, sign)


@dataclass(frozen=True, slots=True)
class OuterShift:
    """From a pair to another: base paths go to the pixel that has their k.

    Attributes
    ----------
    between : AreaShift; between two images, or within one
    inner : InnerShift; at the pairs to which the samples go
    """

    between: AreaShift
    inner: InnerShift

    def __call__(
        self, samples: PairedPaths, pairs: Pairs, dx: Scalars, dy: Scalars, sign: int
    ) -> tuple[PairValue, Scalars]:
        """Shift samples to other pairs [Wang25, Eqs. 21 and 22].

        Parameters
        ----------
        dx, dy : (N,) float64, pixels; how far places move, if x_1 moves

        Returns
        -------
        PairValue, (N,) float64
            N rows, 0 where the base path has no place there; and the Jacobian of the
            base path's shift, which is all of it: k stays as it is.
        """
        k, size = samples.k, len(samples)
        pixel = np.where(k == 0, pairs.first, pairs.second)
        placed, jacobian = self.between(samples.base, pixel, dx, dy)
        at = np.flatnonzero(jacobian > 0)
        some = take(placed, at)
        base = take(samples.base, at).moved(some, jacobian[at])
        signs = np.full(len(at), sign, np.int8)
        value = self.inner(base, some, k[at], take(pairs, at), signs)
        return scatter(at, value, size), jacobian

"""The paired-pixel domain (Ω_i × {0}) ∪ (Ω_j × {1}): samples, and what they are worth.

A sample is a base path of one pixel of a pair, k says which, and its offset path in
the other.  All functions here run on any dtype.
"""

from dataclasses import dataclass

import numpy as np

from extensions.area_paths import AreaPaths, Placed
from reference.arrays import Indices, Scalars, Vec3s, divide_or_zero, plus, saturate
from reference.resampling.target import luminance

WHOLE, PLUS, MINUS = 0, 1, -1
"""What of a difference a reservoir stands for: its magnitude, or the part of a sign."""


@dataclass(frozen=True, slots=True)
class PairValue:
    """What of N samples depends on the pair that they belong to.

    Attributes
    ----------
    k : (N,) int8; 0 where the base path is one of pixel i, 1 where of j
    base : Placed; the base path, in its pixel
    offset : (N, 3)
        Contribution f of the offset path, 0 where the inner shift does not exist.
    inner : (N,); Jacobian of the inner shift, 0 there as well
    sign : (N,) int8; ``WHOLE``, ``PLUS`` or ``MINUS``
    """

    k: Indices
    base: Placed
    offset: Vec3s
    inner: Scalars
    sign: Indices


@dataclass(frozen=True, slots=True)
class PairedPaths:
    """N samples of pairs.

    Attributes
    ----------
    k : (N,) int8; 0 where the base path is one of pixel i, 1 where of j
    offset : (N, 3) float64, W/(m² sr); contribution f of the offset path
    inner : (N,) float64; Jacobian of the inner shift
    sign : (N,) int8; of the reservoir
    """

    k: Indices
    base: AreaPaths
    offset: Vec3s
    inner: Scalars
    sign: Indices

    def __len__(self) -> int:
        """Number of rows."""
        return len(self.k)

    @property
    def value(self) -> PairValue:
        """N rows, as they are here."""
        return PairValue(self.k, self.base.value, self.offset, self.inner, self.sign)

    def moved(self, value: PairValue, jacobian: Scalars) -> "PairedPaths":
        """The same samples at other pairs.

        Parameters
        ----------
        jacobian : (N,) float64, sr/sr; of the outer shift

        Returns
        -------
        PairedPaths
            N rows; k is as it was, and the offset paths are those of the other pairs.
        """
        base = self.base.moved(value.base, jacobian)
        return PairedPaths(value.k, base, value.offset, value.inner, value.sign)


def difference(value: PairValue) -> Vec3s:
    """Contribution G of a sample to the difference of its pair [Wang25, Eq. 15].

    Parameters
    ----------
    value : PairValue; N rows

    Returns
    -------
    (N, 3)
        f_i(x) − f_j(T(x)) |∂T| where k = 0, f_i(T(x)) |∂T| − f_j(x) where k = 1; ±f of
        the base path alone where the inner shift does not exist.
    """
    own = value.base.value - value.offset * value.inner[:, None]
    found: Vec3s = np.where((value.k == 0)[:, None], own, -own)
    return found


def share_of_base(p_base: Scalars, p_offset: Scalars, jacobian: Scalars) -> Scalars:
    """Weight of a base path beside the same pair of paths, drawn the other way round.

    [Wang25, Eq. 4, and Eq. 13 with targets].

    Parameters
    ----------
    p_base, p_offset : (N,)
        Densities of the paths in their pixels; or, where these are not known, targets
        that their densities come close to.
    jacobian : (N,), sr/sr; of the inner shift, 0 where it does not exist

    Returns
    -------
    (N,)
        p / (p + p_offset |∂T|): 1 where there is no offset path, 0 where the base path
        cannot be.
    """
    with np.errstate(over="ignore"):
        other = saturate(p_offset * jacobian)
    shared = divide_or_zero(p_base, plus(p_base, other))
    # Alone there is nothing to divide by: p / p would make floats of whole numbers.
    return np.where(jacobian > 0, shared, (p_base > 0) + 0 * jacobian)


def weighted(value: PairValue) -> Vec3s:
    """Integrand ω G of the paired-pixel domain.

    [Wang25, Eqs. 14 and 16].  Densities are those of primary sample space: both are 1.

    Parameters
    ----------
    value : PairValue; N rows

    Returns
    -------
    (N, 3); its integral is the difference Δ_ij = F_i − F_j
    """
    one = np.ones_like(value.inner)
    return difference(value) * share_of_base(one, one, value.inner)[:, None]


def part(value: PairValue) -> Vec3s:
    """The part of ω G that a reservoir stands for, as a magnitude.

    [Wang25, Eqs. 19, 25 and 26].

    Parameters
    ----------
    value : PairValue; N rows

    Returns
    -------
    (N, 3); |ω G|, or max(±ω G, 0) of the reservoir's sign, in each channel
    """
    signed, sign = weighted(value), value.sign[:, None]
    one_sided = np.maximum(signed * sign, 0 * signed)
    found: Vec3s = np.where(sign == WHOLE, np.abs(signed), one_sided)
    return found


def target(value: PairValue) -> Scalars:
    """Target p̂ of a sample: luminance of the part that its reservoir stands for.

    [Wang25, Eqs. 19, 25 and 26].

    Returns
    -------
    (N,); of magnitudes by channel, so that channels of both signs do not cancel
    """
    return luminance(part(value))


def contribution(value: PairValue) -> Vec3s:
    """What a sample adds to Δ_ij, times its weight W [Wang25, Eqs. 17 and 24].

    Returns
    -------
    (N, 3); ω G, or ±max(±ω G, 0) of the reservoir's sign: the sum of both is ω G
    """
    sign = value.sign[:, None]
    found: Vec3s = np.where(sign == WHOLE, weighted(value), sign * part(value))
    return found

"""Sums over outcomes and decisions, held against what they must be."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars
from restir_gi.reference.oracle.cases import Buffers
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.levels.enumeration import LatticeEnumeration
from restir_gi.reference.oracle.levels.patches import HIDDEN, PATCHES, PLACE

ROUNDINGS = 256
"""Of one contribution, in units of half an eps: W and J have some 20 operations, whose
errors cosines of at least 0.4 magnify; a term with its neighbour's J has two."""

NO_PATCH = -1
"""In place of a patch: nothing of a weight is kept, or no patch."""


@dataclass(frozen=True, slots=True, eq=False)
class KeptPatches:
    """What a pass answers in L rows.

    Attributes
    ----------
    patch : (L,) int; of the sample that is kept, or `NO_PATCH`
    W : (L,); contribution weight; 0 where nothing is kept
    M : (L,); confidence
    """

    patch: Indices
    W: Scalars
    M: Scalars

    def differs(self, other: "KeptPatches", precision: Precision) -> Masks:
        """Where it is another answer, (L,) bool, by more than rounding."""
        room = 2 * rounding_room(precision)
        return np.asarray(
            (self.patch != other.patch)
            | (np.abs(self.W - other.W) > room * np.maximum(self.W, other.W))
            | (self.M != other.M)
        )

    def rows(self, which: NDArray[np.generic] | slice) -> "KeptPatches":
        """Some of the rows.

        Parameters
        ----------
        which : (L,) bool, (K,) int or slice
        """
        return KeptPatches(self.patch[which], self.W[which], self.M[which])


def kept_by(out: Buffers, count: int) -> KeptPatches:
    """What the first rows of a pass's answer keep.

    Parameters
    ----------
    count : int; L
    """
    W = out["W"][:count].astype(float)
    y = out["position"][:count].astype(float)
    at = (np.abs(y[:, None] - PLACE) < 1e-3).all(axis=2)
    patch = np.where(at.any(axis=1) & (W != 0), at.argmax(axis=1), NO_PATCH)
    return KeptPatches(patch, W, out["M"][:count].astype(float))


def rounding_room(precision: Precision) -> float:
    """Relative error that rounding may have in one contribution."""
    return ROUNDINGS * float(np.finfo(precision).eps) / 2


def expectations(
    e: LatticeEnumeration, outcome: Indices, probability: Scalars, values: KeptPatches
) -> Scalars:
    """E[W 1{y = x}], (S, 5), sr.

    Parameters
    ----------
    outcome : (L,) int; that each row belongs to
    probability : (L,); of the row, given its outcome
    """
    held = values.patch != NO_PATCH
    rows = outcome[held]
    found = np.zeros((len(e.setups), PATCHES))
    share = e.probability[rows] * probability[held] * values.W[held]
    np.add.at(found, (e.setup[rows], values.patch[held]), share)
    return found


def bias(
    e: LatticeEnumeration,
    found: Scalars,
    precision: Precision,
    open_to: Scalars | float = 0.0,
) -> str:
    """Which expectations are wrong, in words, the largest error first; or nothing.

    By 1/M an expectation without bias is as good as the contract's.

    Parameters
    ----------
    found : (S, 5), sr; E[W 1{y = x}]
    open_to : (S, 5), sr; error that the thresholds of its decisions may have
    """

    def wrong(wanted: Scalars) -> Masks:
        room = rounding_room(precision) * e.solid_angle + open_to
        return np.asarray(np.abs(found - wanted) > room)

    if not wrong(e.unbiased).any():
        return ""
    bad = wrong(e.expected)
    if not bad.any():
        return ""
    off = 100 * (found - e.expected) / e.solid_angle
    size = np.where(bad, np.abs(off), 0.0)
    s, x = np.unravel_index(int(size.argmax()), size.shape)
    setups = sorted(np.flatnonzero(bad.any(axis=1)), key=lambda k: -size[k].max())
    rest = "; ".join(f"{e.setups[k].title}: {_each(off[k], bad[k])}" for k in setups)
    seen = ", which the pixel does not see," if x == HIDDEN else ""
    return (
        f"E[W 1(y = x)] of patch {x}{seen} is {found[s, x]:.6g} instead of"
        f" {e.expected[s, x]:.6g} ({off[s, x]:+.3g} %); all that are wrong, in % of"
        f" the patch: {rest}"
    )


def _each(off: Scalars, bad: Masks) -> str:
    order = sorted(np.flatnonzero(bad), key=lambda x: -abs(off[x]))
    return ", ".join(f"{off[x]:+.3g} of patch {x}" for x in order)


def other_confidence(
    e: LatticeEnumeration, outcome: Indices, values: KeptPatches
) -> str:
    """Where M is not the contract's, in words; or nothing.

    Parameters
    ----------
    outcome : (L,) int; that each row belongs to
    """
    wanted = e.M[e.setup[outcome]]
    wrong = np.not_equal(values.M, wanted)
    if not wrong.any():
        return ""
    row = int(np.flatnonzero(wrong)[0])
    return (
        f"M is {values.M[row]:g} instead of {wanted[row]:g}"
        f" ({e.setups[e.setup[outcome[row]]].title};"
        f" {int(wrong.sum())} of {len(wrong)} rows)"
    )

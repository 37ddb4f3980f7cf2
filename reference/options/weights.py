"""Balance, pairwise and defensive weights: the passes by the general engine [Lin22]."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from restir_gi.reference.numerics.arrays import (
    Indices,
    Scalars,
    divide_or_zero,
    saturate,
)
from restir_gi.reference.numerics.records import take
from restir_gi.reference.passes.initial import InitialSamples
from restir_gi.reference.passes.pixels import NeighborPixels, Pixels, reconnection, sees
from restir_gi.reference.resampling.generalized import Mis, Shifted, resample
from restir_gi.reference.resampling.reservoir import Reservoirs, Samples

Source = InitialSamples | Reservoirs | NeighborPixels


@dataclass(frozen=True, slots=True)
class WeighedSamples:
    """Samples with their target where they are, N rows.

    Attributes
    ----------
    value : (N,), radiance/sr; p̂(y); of neighbours, 0 until they are shifted
    """

    y: Samples
    value: Scalars

    def moved(self, value: Scalars, jacobian: Scalars) -> "WeighedSamples":
        """The same samples at other pixels.

        Parameters
        ----------
        value : (N,), radiance/sr
        jacobian : (N,), sr/sr; of the shift, a factor of the weight alone
        """
        return replace(self, value=value)


@dataclass(frozen=True, slots=True, eq=False)
class OwnSource:
    """Reservoirs of pixels' own domain, of which rows (K,) are merged."""

    reservoirs: Reservoirs
    rows: Indices
    same_domain: bool = True

    def unshifted(self, at: Indices) -> Scalars:
        """Targets of the samples of (A,) rows."""
        value: Scalars = self.reservoirs.y.value[self.rows[at]]
        return value

    def shifted(self, at: Indices) -> Shifted:
        """Samples of (A,) rows as they are: their targets, and a Jacobian of 1."""
        value = self.unshifted(at)
        return value, np.ones_like(value)

    def inverse(self, samples: WeighedSamples, at: Indices) -> Shifted:
        """The pixels' samples of (A,) rows as they are, as for `shifted`."""
        return samples.value[at], np.ones_like(samples.value[at])


@dataclass(frozen=True, slots=True, eq=False)
class ShiftedSource:
    """Reservoirs of K neighbours, as they arrive at the pixels.

    Attributes
    ----------
    reservoirs : Reservoirs; of `WeighedSamples`
    rows : (K,) int; all
    """

    q_n: NeighborPixels
    reservoirs: Reservoirs
    rows: Indices
    same_domain: bool = False

    def unshifted(self, at: Indices) -> Scalars:
        """p̂_n of what the neighbours ``at`` made, (A,), as it was: no ray."""
        row = self.q_n.rows[at]
        return self.q_n.target(row, take(self.q_n.frame.reservoirs.y, row))

    def shifted(self, at: Indices) -> Shifted:
        """p̂_q of the neighbours' samples, (A,), 0 where hidden, and the Jacobian."""
        q, y, W = self.q_n.q, self.reservoirs.y.y, self.reservoirs.W
        p, J = q.target(y), self.q_n.jacobian()
        seen = q.sees(y, (W > 0) & (p > 0) & (J > 0))
        return np.where(seen, p, p * 0)[at], J[at]

    def inverse(self, samples: WeighedSamples, at: Indices) -> Shifted:
        """p̂_n of the pixels' samples, (A,), 0 outside of D_n, and the Jacobian back."""
        q_n = self.q_n
        asked = np.zeros(len(self.rows), bool)
        asked[at] = True
        y, x_q = q_n.before(samples.y, asked)
        p = q_n.target(np.maximum(q_n.rows, 0), y)
        possible = asked & (p > 0)
        if refuses := q_n.q.refuses:
            possible &= ~refuses(q_n.x.position, x_q, y)
        p = np.where(sees(q_n.frame.world, q_n.x, y, possible), p, p * 0)
        J = reconnection(x_q, q_n.x.position, y)
        return p[at], J[at]


def resample_weighted(
    q: Pixels, sources: Sequence[tuple[Source, Scalars]], mis: Mis, cap: float
) -> Reservoirs:
    """Resample with any MIS weights.

    Parameters
    ----------
    q : Pixels; K pixels
    sources : sequence of (InitialSamples, Reservoirs or NeighborPixels, (K,))
        In the order of the stream, with the numbers that decide; the last one of q's
        own domain is the canonical one.
    cap : float; limit of M

    Returns
    -------
    Reservoirs
        K rows.  Where nothing is shifted, all samples are of one domain, and M is
        exact.
    """
    if not any(isinstance(source, NeighborPixels) for source, _ in sources):
        mis = "1/M"
    return resample_as_asked(q, sources, mis, cap)


def resample_as_asked(
    q: Pixels, sources: Sequence[tuple[Source, Scalars]], mis: Mis, cap: float
) -> Reservoirs:
    """The same, with the weights themselves where nothing is shifted either.

    Parameters
    ----------
    sources : sequence of (InitialSamples, Reservoirs or NeighborPixels, (K,))
        As of `resample_weighted`.
    cap : float; limit of M

    Returns
    -------
    Reservoirs; K rows
    """
    given = [weighed(q, source) for source, _ in sources]
    u = [u_n for _, u_n in sources]
    kept = resample(given, u, mis, cap, itself)
    return replace(kept, y=kept.y.y)


def itself(value: Scalars) -> Scalars:
    """Target of `WeighedSamples`, (N,), whose value it is."""
    return value


def weighed(q: Pixels, source: Source) -> OwnSource | ShiftedSource:
    """A source as the general engine takes it."""
    rows = np.arange(len(q.points))
    if isinstance(source, NeighborPixels):
        r = source.reservoirs
        y = WeighedSamples(r.y, np.zeros(len(rows)))
        return ShiftedSource(source, replace(r, y=y), rows)
    if isinstance(source, InitialSamples):
        pdf = source.pdf
        with np.errstate(over="ignore"):
            W = saturate(divide_or_zero(np.ones_like(pdf), pdf))
        source = Reservoirs(source.y, W, source.M)
    value = q.target(source.y)
    return OwnSource(replace(source, y=WeighedSamples(source.y, value)), rows)

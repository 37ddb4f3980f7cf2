"""What donors offer: candidates of a stream, that are told apart by their place."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from extensions.donors import Donor
from reference.arrays import Indices, Masks, Scalars
from reference.passes.neighbors import NONE
from reference.records import scatter, take, where
from reference.resampling.reservoir import Candidates, Reservoirs, reused_candidates

# p̂ of a value; its luminance, as a rule.
Target = Callable[[Any], Scalars]


@dataclass(frozen=True, slots=True, eq=False)
class Offer:
    """A competitor.

    Attributes
    ----------
    donor : Donor
        Whose samples these are.
    place : int
        In the stream.
    candidates : Candidates
        K rows, of which y is the place.
    value : record or (K, 3)
        Of the samples at the receivers.
    jacobian : (K,)
        Of their shifts.
    """

    donor: Donor
    place: int
    candidates: Candidates
    value: Any
    jacobian: Scalars


def offered(donor: Donor, place: int, target: Target) -> Offer:
    """Shift what a donor has to the receivers.

    Parameters
    ----------
    donor : Donor
        K receivers.
    place : int
        In the stream.
    target : callable
        p̂ of values.

    Returns
    -------
    Offer
        w = p̂(T(y)) W M |∂T/∂y|; M counts where nothing could be shifted too.
    """
    r, row = donor.reservoirs, np.maximum(donor.rows, 0)
    none, size = donor.rows == NONE, len(row)
    W, M = (np.where(none, a * 0, a) for a in (r.W[row], r.M[row]))
    if donor.stands:
        value, jacobian = take(r.y.value, row), np.ones_like(W)
    else:
        at = np.flatnonzero(W > 0)
        some, factor = donor.forth(at)
        value, jacobian = scatter(at, some, size), scatter(at, factor, size)
    here = Reservoirs(np.full(size, place, np.int8), W, M)
    candidates = reused_candidates(here, target(value), jacobian)
    return Offer(donor, place, candidates, value, jacobian)


def target_made(offer: Offer, active: Masks, target: Target) -> Scalars:
    """Target of a donor's own samples where they were made, in the receivers' measure.

    Parameters
    ----------
    offer : Offer
        Of the donor.
    active : (K,) bool
        Which are asked for; 0 elsewhere.
    target : callable
        p̂ of values.

    Returns
    -------
    (K,)
        p̂ / |∂T/∂y|; 0 where the shift to the receiver does not exist.
    """
    at = np.flatnonzero(active & (offer.jacobian > 0))
    base = take(offer.donor.reservoirs.y.value, offer.donor.rows[at])
    return scatter(at, target(base) / offer.jacobian[at], len(active))


def target_at(
    offer: Offer, samples: Any, p_hat: Scalars, active: Masks, target: Target
) -> Scalars:
    """Target of samples of the receivers at a donor, in the receivers' measure.

    Parameters
    ----------
    offer : Offer
        Of the donor.
    samples : record
        K of the receivers.
    p_hat : (K,)
        Their target there.
    active : (K,) bool
        Which are asked for; 0 elsewhere.
    target : callable
        p̂ of values.

    Returns
    -------
    (K,)
        p̂(T(y)) |∂T/∂y| of the shift to the donor; 0 where it could not have made them.
    """
    if offer.donor.stands:
        return np.where(active, p_hat, p_hat * 0)
    at = np.flatnonzero(active & (offer.candidates.M > 0))
    value, jacobian = offer.donor.back(samples, at)
    return scatter(at, target(value) * jacobian, len(p_hat))


def samples_of(offers: list[Offer], place: Indices) -> Any:
    """Samples by their places, as they are at the receivers.

    Parameters
    ----------
    offers : list of Offer
        In the order of the stream.
    place : (K,) int
        Which of them each receiver keeps.

    Returns
    -------
    record
        K rows, moved to the receivers.
    """
    value, jacobian = offers[0].value, offers[0].jacobian
    for offer in offers[1:]:
        here = place == offer.place
        value = where(here, offer.value, value)
        jacobian = np.where(here, offer.jacobian, jacobian)
    found: Any = None
    for reservoirs, row in _by_frame(offers, place):
        part = take(reservoirs.y, np.maximum(row, 0))
        found = part if found is None else where(row != NONE, part, found)
    return found.moved(value, jacobian)


def _by_frame(
    offers: list[Offer], place: Indices
) -> Iterable[tuple[Reservoirs, Indices]]:
    """One gather for each frame of reservoirs, whoever points into it."""
    frames: dict[int, tuple[Reservoirs, Indices]] = {}
    for offer in offers:
        reservoirs = offer.donor.reservoirs
        nowhere = np.full(len(place), NONE)
        _, rows = frames.get(id(reservoirs), (reservoirs, nowhere))
        chosen = np.where(place == offer.place, offer.donor.rows, rows)
        frames[id(reservoirs)] = reservoirs, chosen
    return frames.values()

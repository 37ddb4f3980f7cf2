"""Who stands in a place of a stream, and which path drew the sample there."""

from dataclasses import dataclass

import numpy as np

from reference.arrays import Indices
from reference.passes.past import Past
from reference.passes.resample import Competition
from reference.records import NONE


@dataclass(frozen=True, slots=True, eq=False)
class Paths:
    """Numbers of the paths that drew the samples of a frame's reservoirs, N rows each.

    A path's number is frame · pixels + pixel, as `Moment.numbers` gives it.

    Attributes
    ----------
    temporal, spatial : (N,) int64
        Or ``NONE`` where the reservoir is empty.
    """

    temporal: Indices
    spatial: Indices


@dataclass(frozen=True, slots=True, eq=False)
class Source:
    """Who stands in a place of a stream, for K receivers.

    Attributes
    ----------
    role : str
        What it is to the receiver.
    frame : int
        Whose reservoirs, or samples, these are.
    rows : (K,) int
        Pixels of that frame, or ``NONE``.
    numbers : (K,) int64
        Of the paths that drew the samples, or ``NONE``.
    """

    role: str
    frame: int
    rows: Indices
    numbers: Indices


@dataclass(frozen=True, slots=True, eq=False)
class Origins:
    """What a pass knows of where its candidates come from.

    Attributes
    ----------
    frame : int
        Its number.
    drawn : (N,) int64
        Paths of the new samples.
    past : Past or None
        What the last frame handed on.
    before : Paths or None
        Of the last frame.
    temporal : (N,) int64 or None
        Paths of this frame's temporal reservoirs; ``None`` in the pass that makes them.
    """

    frame: int
    drawn: Indices
    past: Past | None
    before: Paths | None
    temporal: Indices | None = None

    @property
    def pixels(self) -> int:
        """Of the frame."""
        return len(self.drawn)

    def source(self, competition: Competition, place: int, pixels: Indices) -> Source:
        """Who stands in a place.

        Parameters
        ----------
        competition : Competition
            K receivers.
        place : int
            In their streams.
        pixels : (K,) int
            Which pixels of the frame the receivers are.

        Returns
        -------
        Source
            K rows.
        """
        entry = competition.entries[place]
        if place == competition.canonical:
            if self.temporal is None:
                return _source("new sample", self.frame, pixels, self.drawn)
            role = "own temporal reservoir"
            return _source(role, self.frame, pixels, self.temporal)
        if entry.origin is None:
            assert self.past is not None
            assert self.before is not None
            home = self.past.home
            rows = pixels if home is None else home[pixels]
            first = self.temporal is None
            paths = self.before.temporal if first else self.before.spatial
            return _source("own past", self.frame - 1, rows, paths)
        rows, donors = entry.origin.rows, entry.origin.donors
        who = "own past" if place < competition.canonical else "neighbour"
        if self.past and self.before and donors is self.past.temporal:
            return _source(who, self.frame - 1, rows, self.before.temporal)
        if self.past and self.before and donors is self.past.spatial:
            return _source(who, self.frame - 1, rows, self.before.spatial)
        assert self.temporal is not None
        return _source(who, self.frame, rows, self.temporal)


def _source(role: str, frame: int, rows: Indices, paths: Indices) -> Source:
    numbers = np.where(rows != NONE, paths[np.maximum(rows, 0)], NONE)
    return Source(role, frame, rows, numbers)

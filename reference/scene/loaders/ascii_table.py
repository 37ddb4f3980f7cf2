"""Numbers in lines of text, whole files at a time."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Indices, Scalars

Bytes = NDArray[np.uint8]
MOST_DIGITS = 18  # of a whole number that fits 64 bits


@dataclass(frozen=True, slots=True, eq=False)
class Words:
    """Words of a text and the lines that they stand on.

    Attributes
    ----------
    text : (B,) uint8; the text
    starts, stops : (N,) int; where each word begins, and where it has ended
    counts : (L,) int; words on each line
    """

    text: Bytes
    starts: Indices
    stops: Indices
    counts: Indices

    @property
    def lines(self) -> Indices:
        """Line of each word, (N,) int."""
        return np.repeat(np.arange(len(self.counts)), self.counts)


def words_of(text: Bytes) -> Words:
    """Find the words of a text, parted by spaces and what ASCII counts as such.

    Parameters
    ----------
    text : (B,) uint8; lines that each end in a line feed
    """
    blank = (text == 32) | ((text >= 9) & (text <= 13))
    starts = np.flatnonzero(~blank & np.append(True, blank[:-1]))
    stops = np.flatnonzero(blank & np.append(False, ~blank[:-1]))
    ends = np.flatnonzero(text == 10)
    before = np.searchsorted(starts, ends)
    return Words(text, starts, stops, np.diff(before, prepend=0))


def numbers_of(text: Bytes) -> tuple[Scalars, int | None]:
    """Numbers that the words of a text are.

    Parameters
    ----------
    text : (B,) uint8; words alone

    Returns
    -------
    (N,) float64, int or None; the numbers; which word is none, if one is
    """
    words = text.tobytes().split()
    try:
        return np.array(list(map(float, words)), np.float64), None
    except ValueError:
        return np.zeros(0), next(i for i, x in enumerate(words) if not _is_number(x))


def _is_number(word: bytes) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def whole_numbers(
    text: Bytes, starts: Indices, stops: Indices
) -> tuple[Indices, NDArray[np.bool_]]:
    """Whole numbers that stretches of a text are.

    Parameters
    ----------
    text : (B,) uint8; the text
    starts, stops : (N,) int; of each stretch

    Returns
    -------
    (N,) int64, (N,) bool; the numbers, 0 where there is none; whether there is one
    """
    negative = text[np.minimum(starts, len(text) - 1)] == ord("-")
    at = starts + (negative & (stops > starts))
    lengths = stops - at
    good = (lengths > 0) & (lengths <= MOST_DIGITS)
    values = np.zeros(len(starts), np.int64)
    for place in range(min(int(lengths.max(initial=0)), MOST_DIGITS)):
        inside = place < lengths
        digits = text[np.minimum(at + place, len(text) - 1)] - np.uint8(ord("0"))
        good &= (digits <= 9) | ~inside  # unsigned: what is below "0" is far above 9
        values = np.where(inside, 10 * values + digits, values)
    return np.where(good, np.where(negative, -values, values), 0), good

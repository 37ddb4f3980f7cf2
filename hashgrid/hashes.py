"""Hashes of one 32-bit word, and of several: where a cell is kept, and its checksum.

Both are fixed by the contract, so that a shader finds the same bucket.
"""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

UInts = NDArray[np.uint32]


def pcg(x: UInts) -> UInts:
    """PCG's output permutation as a hash of one word [Jarzynski20].

    Parameters
    ----------
    x : (N,) uint32; the word

    Returns
    -------
    (N,) uint32; arithmetic is modulo 2^32
    """
    state = x * np.uint32(747796405) + np.uint32(2891336453)
    word = ((state >> ((state >> np.uint32(28)) + np.uint32(4))) ^ state) * np.uint32(
        277803737
    )
    mixed: UInts = (word >> np.uint32(22)) ^ word
    return mixed


def xxhash(x: UInts) -> UInts:
    """XxHash32 of one word [Jarzynski20], (N,) uint32; arithmetic is modulo 2^32.

    Parameters
    ----------
    x : (N,) uint32; the word
    """
    h = x + np.uint32(374761393)
    h = ((h << np.uint32(17)) | (h >> np.uint32(15))) * np.uint32(668265263)
    h = (h ^ (h >> np.uint32(15))) * np.uint32(2246822519)
    h = (h ^ (h >> np.uint32(13))) * np.uint32(3266489917)
    mixed: UInts = h ^ (h >> np.uint32(16))
    return mixed


def nested(hash_of: Callable[[UInts], UInts], words: Sequence[UInts]) -> UInts:
    """Hash of several words: h(a + h(b + h(c + ...))).

    Parameters
    ----------
    hash_of : callable; of one word
    words : sequence of (N,) uint32; the first is outermost

    Returns
    -------
    (N,) uint32; other orders give other hashes
    """
    found = hash_of(words[-1])
    for word in reversed(words[:-1]):
        found = hash_of(word + found)
    return found

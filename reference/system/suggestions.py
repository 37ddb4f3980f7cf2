"""A word that is not known: what was meant, and what there is."""

from collections.abc import Iterable
from difflib import get_close_matches

LONGEST = 60  # letters of a word that a message repeats


def unknown(kind: str, word: str, names: Iterable[str], known: str = "") -> str:
    """Say that a word is not known, which one is near, and which there are.

    Parameters
    ----------
    kind : str; of what it should name: "scene"
    known : str; what to list in their place, where more than the names is to be said

    Examples
    --------
    >>> unknown("method", "pth", ["path", "restir-pt"])
    "unknown method 'pth'; did you mean path? known are path, restir-pt"
    """
    every = list(names)
    close = get_close_matches(word[:LONGEST], every, n=1)
    hint = f"did you mean {close[0]}? " if close else ""
    shown = word if len(word) <= LONGEST else word[:LONGEST] + "..."
    return f"unknown {kind} {shown!r}; {hint}known are {known or ', '.join(every)}"

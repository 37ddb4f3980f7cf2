"""What a loader notes, replaces, or refuses."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn

from reference.errors import UsageError

LEAST_ALPHA = 1e-3
MOST_TOLD = 20
"""Refusals of one file in one message."""


@dataclass(slots=True)
class Ledger:
    """What becomes of the parts of one file that we do not model as they are.

    Attributes
    ----------
    path : Path
        The scene file.
    lenient : bool
        Replace, and say so, where a strict loader stops.
    notes : list of str
        Sentences for `Scene.notes`, each once.
    refusals : list of str
        What a strict loader refuses, each once, until `settle` tells them.
    """

    path: Path
    lenient: bool
    notes: list[str] = field(default_factory=list)
    refusals: list[str] = field(default_factory=list)
    _told: set[str] = field(default_factory=set, repr=False)

    def note(self, sentence: str) -> None:
        """Write down what the reader of an image has to know.

        Parameters
        ----------
        sentence : str
            Without its full stop.
        """
        self._tell_once(f"{sentence}.", self.notes)

    def replace(self, problem: str, instead: str) -> None:
        """Go on with something else: noted when lenient, else refused by `settle`.

        Parameters
        ----------
        problem : str
            What is not modelled, and in which element.
        instead : str
            What a lenient loader does: "taken as ...", "left out".
        """
        if self.lenient:
            self.note(f"{problem}: {instead}")
            return
        refusal = f"{self.path}: {problem} (with --lenient: {instead})"
        self._tell_once(refusal, self.refusals)

    def refuse(self, problem: str) -> None:
        """Have `settle` refuse the file, lenient or not.

        Parameters
        ----------
        problem : str
            What is not modelled and cannot be replaced, in which element.
        """
        self._tell_once(f"{self.path}: {problem}", self.refusals)

    def settle(self) -> None:
        """Refuse the file for all that it was refused for so far.

        Raises
        ------
        UsageError
            Tells all refusals so far, or the first ``MOST_TOLD`` and how many more.
        """
        more = len(self.refusals) - MOST_TOLD
        if self.refusals:
            told = "; ".join(self.refusals[:MOST_TOLD])
            raise UsageError(told + (f"; and {more} more" if more > 0 else ""))

    def _tell_once(self, sentence: str, to: list[str]) -> None:
        if sentence not in self._told:
            self._told.add(sentence)
            to.append(sentence)

    def stop(self, problem: str) -> NoReturn:
        """Refuse the file.

        Parameters
        ----------
        problem : str
            What is wrong, in which element, and what would be right.

        Raises
        ------
        UsageError
            Always.
        """
        raise UsageError(f"{self.path}: {problem}")

    @contextmanager
    def reading(self, what: str) -> Iterator[None]:
        """Tell a reader's failure on malformed data as the user's error that it is.

        Parameters
        ----------
        what : str
            What it ought to be: "glTF file".

        Yields
        ------
        None
            Nothing.

        Raises
        ------
        UsageError
            In place of whatever a reader raises on data that it cannot digest.
        """
        try:
            yield
        except (UsageError, MemoryError):
            raise
        # Readers of foreign formats fail with whatever comes first: a KeyError, an
        # assertion, a RuntimeError out of C++.
        except Exception as error:
            reason = " ".join(str(error).split()) or "no reason given"
            self.stop(f"not a valid {what} ({type(error).__name__}: {reason})")


def roughness(alpha: float, where: str, ledger: Ledger) -> float:
    """GGX width as our materials take it: 0, or not below `LEAST_ALPHA`.

    Parameters
    ----------
    alpha : float
        As in the file.
    where : str
        The material, for the note.
    ledger : Ledger
        Takes the note.

    Returns
    -------
    float
        0 where the lobe is too narrow for float32.
    """
    if not 0 < alpha < LEAST_ALPHA:
        return alpha
    ledger.note(f"{where}: alpha {alpha:.3g} < {LEAST_ALPHA:g} is taken as smooth")
    return 0.0

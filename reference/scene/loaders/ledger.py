"""What a loader notes, replaces, or refuses."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn

from reference.errors import UsageError

LEAST_ALPHA = 1e-3


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

    def note(self, sentence: str) -> None:
        """Write down what the reader of an image has to know.

        Parameters
        ----------
        sentence : str
            Without its full stop.
        """
        if f"{sentence}." not in self.notes:
            self.notes.append(f"{sentence}.")

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
        if refusal not in self.refusals:
            self.refusals.append(refusal)

    def settle(self) -> None:
        """Refuse the file if anything in it was replaced and the loader is strict.

        Raises
        ------
        UsageError
            Tells all refusals so far.
        """
        if self.refusals:
            raise UsageError("; ".join(self.refusals))

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

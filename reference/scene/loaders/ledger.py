"""What a loader notes, replaces, or refuses."""

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from json import JSONDecodeError
from pathlib import Path
from typing import NoReturn

from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.files import read_file

LEAST_ALPHA = 1e-3
ROOM = 2**29
"""Bytes of memory that a scene may take whatever its files are: a picture of one colour
with 4096 x 4096 pixels."""
MOST_EXPANSION = 1100
"""Further bytes of memory for each byte of the files: deflate ends at 1032."""
MOST_TOLD = 20  # refusals in one message
REMOTE = re.compile(r"[A-Za-z][A-Za-z0-9+.-]*:/*//|//")


@dataclass(slots=True)
class Ledger:
    """What becomes of the parts of one file that we do not model as they are.

    Attributes
    ----------
    path : Path; the scene file
    lenient : bool; replace, and say so, where a strict loader stops
    allow_outside : bool; read files outside the scene's folder, if it names them
    notes : list of str; sentences for `Scene.notes`, each once
    refusals : list of str
        What a strict loader refuses, each once, until `settle` tells them.
    """

    path: Path
    lenient: bool
    allow_outside: bool = False
    notes: list[str] = field(default_factory=list)
    refusals: list[str] = field(default_factory=list)
    _told: set[str] = field(default_factory=set)
    _bytes: int = 0  # that were read
    _memory: int = 0  # that was asked for

    def contents(self) -> bytes:
        """Contents of the scene file itself."""
        return self._counted(self.path)

    def locate(self, name: str) -> Path:
        """Where a further file of the scene lies; it need not exist.

        In the scene's folder, unless ``allow_outside``.

        Raises UsageError: the name leads to another machine, or (unless
        ``allow_outside``) out of the folder, be it by "..", by a link or as an absolute
        path.

        Parameters
        ----------
        name : str
            Path from the scene's folder, or an absolute one; either kind of slash.
        """
        plain = name.replace("\\", "/")
        if REMOTE.match(plain):
            raise UsageError(
                f'"{name}" is not on this machine; put the file beside the scene and'
                " name it by its path"
            )
        path = self.path.parent / plain
        try:
            folder, target = self.path.parent.resolve(), path.resolve()
            path.exists()
        # A NUL, a ring of links, too many letters.
        except (OSError, ValueError, RuntimeError) as error:
            shown = name if len(name) <= 60 else f"{name[:57]}..."
            raise UsageError(f"{shown!r} is not a file path") from error
        if not self.allow_outside and not target.is_relative_to(folder):
            raise UsageError(
                f'"{name}" lies outside the scene\'s folder; move it there, or read it'
                " with --allow-outside"
            )
        return path

    def read(self, name: str) -> bytes:
        """Contents of a further file of the scene.

        Raises UsageError: the file may not be read, or cannot.
        """
        return self._counted(self.locate(name))

    def has(self, name: str) -> bool:
        """Whether there is a further file of that name.

        Also false for a name that no file can have.

        Raises UsageError: see `locate`.
        """
        return os.path.isfile(self.locate(name))  # unlike Path's it never raises

    def _counted(self, path: Path) -> bytes:
        contents = read_file(path)
        self._bytes += len(contents)
        return contents

    def take(self, memory: int, what: str) -> None:
        """Refuse what would take more memory than the files make believable.

        Raises UsageError: with this, the scene takes more than `ROOM` and
        `MOST_EXPANSION` times the bytes that were read so far.

        Parameters
        ----------
        memory : int; bytes that a promise of a file is about to take
        what : str; the promise: "a.png claims 65535 x 65535 pixels"
        """
        most = ROOM + MOST_EXPANSION * self._bytes
        if self._memory + memory > most:
            raise UsageError(
                f"{what}: with it the scene takes more memory than {ROOM >> 20} MiB and"
                f" {MOST_EXPANSION} times the bytes of its files"
            )
        self._memory += memory

    def note(self, sentence: str) -> None:
        """Write down what the reader of an image has to know.

        Parameters
        ----------
        sentence : str; without its full stop
        """
        self._tell_once(f"{sentence}.", self.notes)

    def replace(self, problem: str, instead: str) -> None:
        """Go on with something else: noted when lenient, else refused by `settle`.

        Parameters
        ----------
        problem : str; what is not modelled, and in which element
        instead : str; what a lenient loader does: "taken as ...", "left out"
        """
        if self.lenient:
            self.note(f"{problem}: {instead}")
            return
        self._tell_once(f"{problem} (with --lenient: {instead})", self.refusals)

    def refuse(self, problem: str) -> None:
        """Have `settle` refuse the file, lenient or not.

        Parameters
        ----------
        problem : str; what is not modelled and cannot be replaced, in which element
        """
        self._tell_once(problem, self.refusals)

    def _tell_once(self, sentence: str, to: list[str]) -> None:
        if sentence not in self._told:
            self._told.add(sentence)
            to.append(sentence)

    def settle(self) -> None:
        """Refuse the file if anything in it was replaced and the loader is strict.

        Raises UsageError, which tells all refusals so far.
        """
        if not self.refusals:
            return
        if len(self.refusals) == 1:
            self.stop(self.refusals[0])
        told = [f"({i}) {x}" for i, x in enumerate(self.refusals[:MOST_TOLD], 1)]
        if more := len(self.refusals) - len(told):
            told.append(f"and {more} more")
        self.stop(f"{len(self.refusals)} faults: {'; '.join(told)}")

    def stop(self, problem: str) -> NoReturn:
        """Refuse the file.

        Raises UsageError.

        Parameters
        ----------
        problem : str; what is wrong, in which element, and what would be right
        """
        raise UsageError(f"{self.path}: {problem}")

    @contextmanager
    def reading(self, what: str) -> Iterator[None]:
        """Tell a reader's failure on malformed data as the user's error that it is.

        Raises UsageError in place of whatever a reader raises on data that it cannot
        digest.

        Parameters
        ----------
        what : str; what it ought to be: "glTF file"
        """
        try:
            yield
        except (UsageError, MemoryError):
            raise
        # Readers of foreign formats fail with whatever comes first: a KeyError, an
        # assertion, a RuntimeError out of C++.
        except Exception as error:
            self.stop(f"not a valid {what} ({_in_words(error)})")


def _in_words(error: Exception) -> str:
    """What a reader's failure says about the file, without the names of Python."""
    match error:
        case JSONDecodeError():
            return f"line {error.lineno}, column {error.colno}: {error.msg}"
        case UnicodeDecodeError():
            return f"byte {error.start} is not text in {error.encoding}"
        case KeyError():
            return f"it lacks {error.args[0]!r}" if error.args else "it lacks a part"
        case IndexError():
            return "it refers to something that it does not hold"
        case RecursionError():
            return "it is nested too deeply"
        case OverflowError():
            return "a number is too large"
        case TypeError() | AttributeError():
            return "a value is of another kind than it should be"
        case RuntimeError() if str(error).strip():  # a library's own words
            return " ".join(str(error).split())
    return "a value makes no sense"


def roughness(alpha: float, where: str, ledger: Ledger) -> float:
    """GGX width as our materials take it: 0, or not below `LEAST_ALPHA`.

    Returns float; 0 where the lobe is too narrow for float32.
    """
    if not 0 < alpha < LEAST_ALPHA:
        return alpha
    ledger.note(f"{where}: alpha {alpha:.3g} < {LEAST_ALPHA:g} is taken as smooth")
    return 0.0

"""A program as a backend: run on a folder of cases in the raw form."""

import shlex
import tempfile
from pathlib import Path

from reference.errors import UsageError
from reference.oracle.backends.files import FilesBackend
from reference.oracle.backends.running import Limits, run_program
from reference.oracle.cases import Case, Failure, Outcome
from reference.oracle.contract.fields import Passes, Precision
from reference.oracle.raw import write_cases

PLACE = "{directory}"


class ProgramBackend:
    """A program that reads a folder of cases and writes its outputs beside them.

    Parameters
    ----------
    template : str
        Its command line, in which ``{directory}`` stands for the folder.
    limits : Limits
        Of time and memory.
    precision : 'float32' or 'float64'
        In which it calculates.

    Raises
    ------
    UsageError
        The command line cannot be split into words.
    """

    def __init__(
        self, template: str, limits: Limits, precision: Precision = "float32"
    ) -> None:
        try:
            self._words = shlex.split(template)
        except ValueError as error:
            raise UsageError(f"{template!r} is no command line: {error}") from error
        self._limits, self.precision = limits, precision
        self._folder = tempfile.TemporaryDirectory(prefix="restir-cases-")
        self._batches = 0

    def run(self, passes: Passes, cases: list[Case]) -> list[Outcome]:
        """Outcome of each case.

        Parameters
        ----------
        passes : mapping of str to Pass
            The contract.
        cases : list of Case
            Calls.

        Returns
        -------
        list of Outcome
            In the same order.  Where the program fails on all cases at once, each
            case is given to it alone.
        """
        outcomes, trouble = self._batch(passes, cases)
        if trouble is None or len(cases) == 1:
            words = trouble or ""
            return [
                Failure(f"{case.name}: the program {words}")
                if words and not isinstance(outcome, Failure)
                else outcome
                for case, outcome in zip(cases, outcomes, strict=True)
            ]
        return [self.run(passes, [case])[0] for case in cases]

    def close(self) -> None:
        """Remove the files."""
        self._folder.cleanup()

    def _batch(
        self, passes: Passes, cases: list[Case]
    ) -> tuple[list[Outcome], str | None]:
        folder = Path(self._folder.name) / str(self._batches)
        self._batches += 1
        write_cases(folder, passes, self.precision, cases)
        words = [word.replace(PLACE, str(folder)) for word in self._words]
        seconds = self._limits.seconds * len(cases)
        trouble = run_program(words, seconds, self._limits.memory)
        return FilesBackend(folder, self.precision).run(passes, cases), trouble

"""A program as a backend: run on a folder of cases in the raw form."""

import shlex
from dataclasses import replace

from restir_gi.reference.oracle.backends.files import FilesBackend
from restir_gi.reference.oracle.backends.running import Limits, run_program
from restir_gi.reference.oracle.backends.workspace import Workspace
from restir_gi.reference.oracle.cases import (
    NO_TIME,
    NOT_AGAIN,
    Case,
    Failure,
    Outcome,
    Remaining,
    Unasked,
    for_ever,
)
from restir_gi.reference.oracle.contract.fields import Passes, Precision
from restir_gi.reference.oracle.raw import outputs_size, write_cases
from restir_gi.reference.system.errors import UsageError

PLACE = "{directory}"


class ProgramBackend:
    """A program that reads a folder of cases and writes its outputs beside them.

    Parameters
    ----------
    template : str; its command line, in which ``{directory}`` stands for the folder
    remaining : callable; seconds that are left: no call lasts longer

    Raises
    ------
    UsageError
        The command line cannot be split into words.
    """

    def __init__(
        self,
        template: str,
        limits: Limits,
        precision: Precision = "float32",
        remaining: Remaining = for_ever,
    ) -> None:
        try:
            self._words = shlex.split(template)
        except ValueError as error:
            raise UsageError(f"{template!r} is not a command line: {error}") from error
        self._limits, self.precision, self.remaining = limits, precision, remaining
        self._too_slow: set[str] = set()
        self._workspace = Workspace("cases")

    def run(self, passes: Passes, cases: list[Case]) -> list[Outcome]:
        """Outcome of each case, in the same order.

        Where the program fails on all cases at once, each case is given to it alone,
        but none of a pass that took too long before.
        """
        asked = [case for case in cases if case.pass_name not in self._too_slow]
        if len(asked) > 1 and self.remaining() > 0:
            outcomes, trouble = self._batch(passes, asked, self.remaining() / 2)
            if trouble is None:
                found = iter(outcomes)
                return [next(found) if c in asked else NOT_AGAIN for c in cases]
        return [self._alone(passes, case) for case in cases]

    def close(self) -> int:
        """End what the program has left running, and remove the files."""
        return self._workspace.close()

    def _alone(self, passes: Passes, case: Case) -> Outcome:
        if case.pass_name in self._too_slow:
            return NOT_AGAIN
        if (left := self.remaining()) <= 0:
            return NO_TIME
        (outcome,), trouble = self._batch(passes, [case], left)
        if trouble is None:
            return outcome
        if isinstance(trouble, Failure) and trouble.timed_out:
            self._too_slow.add(case.pass_name)
        if isinstance(trouble, Failure) and isinstance(outcome, Failure):
            return replace(outcome, output=trouble.output)
        if trouble is NO_TIME:
            return trouble
        return replace(trouble, reason=f"{case.name}: the program {trouble.reason}")

    def _batch(
        self, passes: Passes, cases: list[Case], left: float
    ) -> tuple[list[Outcome], Failure | Unasked | None]:
        with self._workspace.batch() as folder:
            write_cases(folder, passes, self.precision, cases)
            words = [word.replace(PLACE, str(folder)) for word in self._words]
            trouble = run_program(
                words, self._limits, left, self._workspace.environment, len(cases)
            )
            outcomes = FilesBackend(folder, self.precision).run(passes, cases)
            if trouble or any(o is None or isinstance(o, Failure) for o in outcomes):
                wanted = sum(outputs_size(passes, self.precision, c) for c in cases)
                self._workspace.need_room(wanted)
        return outcomes, trouble

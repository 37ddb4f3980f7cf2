"""What the ladder asks of a backend, however it is reached."""

from typing import Protocol

from restir_gi.reference.oracle.cases import Case, Outcome
from restir_gi.reference.oracle.contract.fields import Passes, Precision


class Backend(Protocol):
    """A backend, to the ladder."""

    @property
    def precision(self) -> Precision:
        """In which it calculates."""
        ...

    def remaining(self) -> float:
        """Seconds that are left to ask it, and to judge its answers."""
        ...

    def run(self, passes: Passes, cases: list[Case]) -> list[Outcome]:
        """Outcome of each case, whatever the backend does."""
        ...

    def close(self) -> int:
        """Let go of processes and files.

        Returns how many processes it had left running, which were ended.
        """
        ...

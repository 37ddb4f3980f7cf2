"""What the ladder asks of a backend, however it is reached."""

import resource
import signal
from dataclasses import dataclass
from typing import Protocol

from reference.oracle.cases import Case, Outcome
from reference.oracle.contract.fields import Passes, Precision


@dataclass(frozen=True, slots=True)
class Limits:
    """What a backend may use.

    Attributes
    ----------
    seconds : float
        For one case, and for starting.
    memory : int, bytes
        Of private data.
    """

    seconds: float = 30.0
    memory: int = 6 * 2**30


class Backend(Protocol):
    """A backend, to the ladder."""

    @property
    def precision(self) -> Precision:
        """In which it calculates."""
        ...

    def run(self, passes: Passes, cases: list[Case]) -> list[Outcome]:
        """Outcome of each case, whatever the backend does."""
        ...

    def close(self) -> None:
        """Let go of processes and files."""
        ...


def how_it_ended(code: int, last_words: str) -> str:
    """Why a process is no more, in one line.

    Parameters
    ----------
    code : int
        As `subprocess` gives it: negative for a signal.
    last_words : str
        Of its stderr.

    Returns
    -------
    str
        "was killed by SIGSEGV", "ended with exit code 1: MemoryError", ...
    """
    if code < 0:
        try:
            name = signal.Signals(-code).name
        except ValueError:
            name = f"signal {-code}"
        hint = " (out of memory?)" if -code == signal.SIGKILL else ""
        return f"was killed by {name}{hint}"
    words = f": {last_words}" if last_words else ""
    return f"ended with exit code {code}{words}"


def last_line(text: str) -> str:
    """Last line of what a process said that is not empty.

    Parameters
    ----------
    text : str
        Of its stderr.

    Returns
    -------
    str
        At most 200 characters.
    """
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return lines[-1][:200] if lines else ""


def bind(memory: int) -> None:
    """Limit this process, just before it becomes another program.

    Parameters
    ----------
    memory : int, bytes
        Of private data; no core is dumped.
    """
    resource.setrlimit(resource.RLIMIT_DATA, (memory, memory))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))

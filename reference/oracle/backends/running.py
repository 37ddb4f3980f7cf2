"""Foreign programs: started with limits, stopped with all that they have started."""

import os
import signal
import subprocess
from contextlib import suppress
from dataclasses import dataclass

from reference.errors import UsageError

try:
    import resource
except ImportError:  # not on Windows
    resource = None  # type: ignore[assignment]


@dataclass(frozen=True, slots=True)
class Limits:
    """What a backend may use.

    Attributes
    ----------
    seconds : float
        For one case, and for starting.
    memory : int, bytes
        Of private data, where the system can limit it.
    """

    seconds: float = 30.0
    memory: int = 6 * 2**30


def bind(memory: int) -> None:
    """Limit this process.

    Parameters
    ----------
    memory : int, bytes
        Of private data; no core is dumped.
    """
    if resource is not None:
        resource.setrlimit(resource.RLIMIT_DATA, (memory, memory))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def run_program(words: list[str], seconds: float, memory: int) -> str | None:
    """Run a program to its end.

    Parameters
    ----------
    words : list of str
        Its command line.
    seconds : float
        After which it is stopped.
    memory : int, bytes
        Of private data.

    Returns
    -------
    str or None
        What went wrong, as the end of a sentence; ``None`` if nothing did.

    Raises
    ------
    UsageError
        There is no such program.
    """
    try:
        process = subprocess.Popen(
            words,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            preexec_fn=(lambda: bind(memory)) if resource is not None else None,
            start_new_session=True,
        )
    except OSError as error:
        raise UsageError(
            f"cannot run {words[0]}: {error.strerror}; name a program that exists"
        ) from error
    try:
        _, said = process.communicate(timeout=seconds)
    except subprocess.TimeoutExpired:
        return f"did not end within {seconds:g} s"
    finally:
        stop(process)
    if process.returncode == 0:
        return None
    return how_it_ended(process.returncode, last_line(said.decode(errors="replace")))


def stop(process: "subprocess.Popen[bytes]") -> None:
    """Stop a process of a session of its own, and whatever it has left behind.

    Parameters
    ----------
    process : subprocess.Popen
        Started with ``start_new_session``; it may have ended.
    """
    # A wrapper may have children, which hold its pipes.
    if hasattr(os, "killpg"):
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)
    with suppress(OSError):
        process.kill()
    process.wait()
    if process.stderr is not None:
        process.stderr.close()


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
        hint = " (out of memory?)" if name == "SIGKILL" else ""
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

"""Foreign programs: started with limits, waited for, and stopped with their group."""

import os
import signal
import subprocess
import threading
import time
from contextlib import suppress
from dataclasses import dataclass
from errno import EAGAIN, EMFILE, ENFILE, ENOMEM
from typing import IO, Any

from restir_gi.reference.oracle.backends.descendants import alive_in
from restir_gi.reference.oracle.cases import NO_TIME, Failure, Unasked
from restir_gi.reference.system.errors import UsageError

try:
    import resource
except ImportError:  # not on Windows
    resource = None  # type: ignore[assignment]

LARGEST_FILE = 2**30
"""Bytes of a file that a backend may write: more than any output or cache has."""

LAST_BYTES = 4096
"""Of what a process says, that are kept."""

SHOWN = 1024
"""Characters of that, and of a traceback, that a report shows."""

SHORTLY, SOON = 0.5, 0.02
"""Seconds within which what a process has said is there: an ended one, a living one."""

DYING = 1.0
"""Seconds that children of a killed process have to be gone."""


@dataclass(frozen=True, slots=True)
class Limits:
    """What a backend may use.

    Attributes
    ----------
    seconds : float; for one case, and for starting
    memory : int, bytes; of private data, where the system can limit it
    """

    seconds: float = 30.0
    memory: int = 6 * 2**30


def bind(memory: int) -> None:
    """Limit this process.

    Parameters
    ----------
    memory : int, bytes
        Of private data; no core is dumped, and no file is larger than `LARGEST_FILE`.
    """
    if resource is None:
        return
    limits = {
        resource.RLIMIT_DATA: memory,
        resource.RLIMIT_CORE: 0,
        resource.RLIMIT_FSIZE: LARGEST_FILE,
    }
    for what, most in limits.items():
        _, hard = resource.getrlimit(what)
        most = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(what, (most, most))


def started(words: list[str], **options: Any) -> "subprocess.Popen[bytes]":
    """Start a program.

    Raises UsageError: there is no such program, or this machine has no room for it.
    """
    try:
        return subprocess.Popen(words, **options)
    except (OSError, ValueError, subprocess.SubprocessError) as error:
        code = getattr(error, "errno", None)
        remedy = "name a program that exists and may be run"
        if code in (EAGAIN, ENOMEM, EMFILE, ENFILE):
            remedy = (
                "a limit of this machine or container on processes, memory or open"
                " files is reached; raise it"
            )
        reason = getattr(error, "strerror", None) or error
        raise UsageError(f"cannot run {words[0]}: {reason}; {remedy}") from error


class LastWords:
    """The end of what a process says, however much that is.

    Parameters
    ----------
    stream : binary file; a pipe, read until all who hold its other end are gone

    Raises
    ------
    UsageError
        This machine has no room for another thread.
    """

    def __init__(self, stream: IO[bytes]) -> None:
        self._stream, self._kept = stream, b""
        self._reader = threading.Thread(target=self._read, daemon=True)
        try:
            self._reader.start()
        except RuntimeError as error:
            raise UsageError(
                f"cannot listen to a backend: {error}; raise the limit of processes"
            ) from error

    def last_line(self) -> str:
        """Last line that is not empty, at most 200 characters.

        Of what is there shortly after the process ended: who still holds the pipe is
        not waited for.
        """
        self._reader.join(SHORTLY)
        lines = [line.strip() for line in self.text().splitlines() if line.strip()]
        return lines[-1][:200] if lines else ""

    def settle(self) -> None:
        """Wait a moment for what a living process has written just now."""
        self._reader.join(SOON)

    def text(self) -> str:
        """What is kept so far."""
        return self._kept.decode(errors="replace")

    def _read(self) -> None:
        with suppress(OSError, ValueError), self._stream:
            while piece := os.read(self._stream.fileno(), 2**16):
                self._kept = (self._kept + piece)[-LAST_BYTES:]


def run_program(
    words: list[str],
    limits: Limits,
    left: float,
    environment: dict[str, str] | None = None,
    calls: int = 1,
) -> Failure | Unasked | None:
    """Run a program to its end.

    Returns what went wrong, as the end of a sentence; ``None`` if nothing did.  The
    program is waited for, not those that it leaves behind, nor their ends of its pipes.

    Raises UsageError: there is no such program, or no room for it.

    Parameters
    ----------
    left : float; seconds that are left for all
    environment : dict of str to str, optional; by default that of this process
    """
    process = started(
        words,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=environment,
        preexec_fn=(lambda: bind(limits.memory)) if resource is not None else None,
        start_new_session=True,
    )
    try:
        assert process.stdout is not None
        assert process.stderr is not None
        printed, said = LastWords(process.stdout), LastWords(process.stderr)
        allowed = limits.seconds * calls
        code = process.wait(min(allowed, left, threading.TIMEOUT_MAX))
    except subprocess.TimeoutExpired:
        stop(process)
        if left < allowed:
            return NO_TIME
        reason = f"did not end within {allowed:g} s"
        return Failure(reason, True, shown_output(printed, said))
    except BaseException:
        stop(process)
        raise
    if code == 0:
        return None
    last = said.last_line()
    return how_it_ended(code, last, shown_output(printed, said))


def shown_output(*streams: LastWords) -> str:
    """The end of what a process has written to each of its streams."""
    for stream in streams:
        stream.settle()
    texts = [stream.text().strip()[-SHOWN:] for stream in streams]
    return "\n".join(text for text in texts if text)


def stop(process: "subprocess.Popen[bytes]") -> None:
    """Stop a process of a session of its own, and its group.

    Parameters
    ----------
    process : subprocess.Popen; started with ``start_new_session``; it may have ended
    """
    # A wrapper may have children, which hold its pipes.
    if hasattr(os, "killpg"):
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)
    with suppress(OSError):
        process.kill()
    process.wait()
    # Its children die a moment later, and must not be taken for what it left running.
    end = time.monotonic() + DYING
    while alive_in(process.pid) and time.monotonic() < end:
        time.sleep(0.01)


def how_it_ended(code: int, last_words: str, output: str = "") -> Failure | Unasked:
    """Why a process is no more.

    "was killed by SIGSEGV", "ended with exit code 1: MemoryError", ... Nothing is known
    of a process that was killed from outside.

    Parameters
    ----------
    code : int; as `subprocess` gives it: negative for a signal
    output : str; what it has written
    """
    if code < 0:
        try:
            name = signal.Signals(-code).name
        except ValueError:
            name = f"signal {-code}"
        if name == "SIGKILL":
            return Unasked("was killed by SIGKILL from outside (out of memory?)")
        return Failure(f"was killed by {name}", output=output)
    words = f": {last_words}" if last_words else ""
    return Failure(f"ended with exit code {code}{words}", output=output)

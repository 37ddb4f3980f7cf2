"""A Python backend in a process of its own, started again when it dies."""

import os
import queue
import subprocess
import sys
import tempfile
import threading
from contextlib import suppress
from pathlib import Path

from reference.errors import UsageError
from reference.oracle.backends.running import Limits, how_it_ended, last_line, stop
from reference.oracle.cases import Case, Failure, Outcome
from reference.oracle.contract.fields import Passes, Precision
from reference.oracle.raw import read_outputs, write_cases

LOADING = 60.0
"""Seconds at least for a backend to load: libraries may take long on a busy machine."""


class PythonBackend:
    """A Python object with one method a pass, in another process.

    Parameters
    ----------
    spec : str
        As :func:`reference.oracle.backends.find.find_object` takes it.
    limits : Limits
        Of time and memory.

    Raises
    ------
    UsageError
        It cannot be loaded.
    """

    def __init__(self, spec: str, limits: Limits) -> None:
        self._spec, self._limits = spec, limits
        self._folder = tempfile.TemporaryDirectory(prefix="restir-cases-")
        self._errors = Path(self._folder.name) / "stderr.txt"
        self._batches = 0
        try:
            self.precision: Precision = self._start()
        except UsageError:
            self._folder.cleanup()
            raise

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
            In the same order.  After a death or a time-out a new process goes on with
            the next case.
        """
        outcomes: list[Outcome] = []
        while len(outcomes) < len(cases):
            left = cases[len(outcomes) :]
            try:
                outcomes += self._batch(passes, left)
            except UsageError as error:  # it died, and does not start again
                outcomes += [Failure(f"{case.name}: {error}") for case in left]
        return outcomes

    def close(self) -> None:
        """Stop the process and remove its files."""
        self._stop()
        self._folder.cleanup()

    def _batch(self, passes: Passes, cases: list[Case]) -> list[Outcome]:
        """Outcomes of the first cases: all of them, or up to one that was fatal."""
        if self._process.poll() is not None:
            self._start()
        folder = Path(self._folder.name) / str(self._batches)
        self._batches += 1
        write_cases(folder, passes, self.precision, cases)
        self._tell(str(folder))
        found: list[Outcome] = []
        for case in cases:
            answer = self._answer()
            if answer == "begin":
                answer = self._answer()
            word, _, reason = answer.partition(" ")
            if word == "end":
                found.append(read_outputs(folder, passes, self.precision, case))
            elif word == "absent":
                found.append(None)
            elif word == "failed":
                found.append(Failure(f"{case.name}: {reason}"))
            else:
                found.append(Failure(f"{case.name}: the backend {answer}"))
                self._stop()
                return found
        self._answer()  # done
        return found

    def _tell(self, line: str) -> None:
        assert self._process.stdin is not None
        with suppress(OSError):  # if it has died, its silence will tell
            self._process.stdin.write(f"{line}\n".encode())
            self._process.stdin.flush()

    def _start(self) -> Precision:
        worker = "reference.oracle.backends.worker"
        with self._errors.open("wb") as errors:
            self._process = subprocess.Popen(
                [sys.executable, "-m", worker, self._spec, str(self._limits.memory)],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=errors,
                env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
                start_new_session=True,
            )
        self._lines: queue.Queue[str | None] = queue.Queue()
        self._listener = threading.Thread(
            target=_listen, args=(self._process, self._lines), daemon=True
        )
        self._listener.start()
        seconds = max(self._limits.seconds, LOADING)
        word, _, rest = self._answer(seconds).partition(" ")
        if word != "ready" or rest not in ("float32", "float64"):
            self._stop()
            what = rest if word == "failed" else f"{word} {rest}"
            raise UsageError(f"backend {self._spec}: {what}")
        precision: Precision = "float64" if rest == "float64" else "float32"
        return precision

    def _answer(self, seconds: float | None = None) -> str:
        """Next line of the worker, or how it ended."""
        seconds = seconds or self._limits.seconds
        try:
            line = self._lines.get(timeout=seconds)
        except queue.Empty:
            return f"gave no answer within {seconds:g} s"
        if line is not None:
            return line
        code = self._process.wait()
        said = self._errors.read_text(errors="replace")
        return how_it_ended(code, last_line(said))

    def _stop(self) -> None:
        stop(self._process)
        assert self._process.stdin is not None
        with suppress(OSError):
            self._process.stdin.close()
        self._listener.join()


def _listen(
    process: "subprocess.Popen[bytes]", lines: "queue.Queue[str | None]"
) -> None:
    assert process.stdout is not None
    with process.stdout:
        for line in process.stdout:
            lines.put(line.decode(errors="replace").rstrip("\n"))
    lines.put(None)

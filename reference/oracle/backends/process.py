"""A Python backend in a process of its own, started again when it dies."""

import json
import os
import queue
import subprocess
import sys
import threading
import time
from contextlib import suppress
from dataclasses import replace
from itertools import takewhile
from typing import IO, Any

from restir_gi.reference.oracle.backends.offer import Offer
from restir_gi.reference.oracle.backends.running import (
    LastWords,
    Limits,
    how_it_ended,
    shown_output,
    started,
    stop,
)
from restir_gi.reference.oracle.backends.workspace import Workspace
from restir_gi.reference.oracle.cases import (
    NO_TIME,
    NOT_AGAIN,
    Case,
    Failure,
    Outcome,
    Remaining,
    Unasked,
    UnaskedError,
    for_ever,
)
from restir_gi.reference.oracle.contract.fields import Passes, Precision
from restir_gi.reference.oracle.raw import outputs_size, read_outputs, write_cases
from restir_gi.reference.system.errors import UsageError

LOADING = 60.0
"""Seconds at least for a backend to load: libraries may take long on a busy machine."""

LONGEST_LINE = 2**16
"""Bytes of an answer: a longer one is none."""


class PythonBackend:
    """A Python object with one method a pass, in another process.

    Parameters
    ----------
    spec : str; as :func:`restir_gi.reference.oracle.backends.find.find_object` takes it
    remaining : callable; seconds that are left: no call lasts longer
    names : tuple of str; passes of the contract, to see which of them it has

    Raises
    ------
    UsageError
        It cannot be loaded.
    UnaskedError
        It was not ready before the time was over.
    """

    def __init__(
        self,
        spec: str,
        limits: Limits,
        remaining: Remaining = for_ever,
        names: tuple[str, ...] = (),
    ) -> None:
        self._names = names
        self.offer: Offer | None = None
        self.declaration: Any = None
        self._spec, self._limits, self.remaining = spec, limits, remaining
        self._too_slow: set[str] = set()
        self._workspace = Workspace("cases")
        try:
            self.precision: Precision = self._start()
        except BaseException:
            self._workspace.close()
            raise

    def run(self, passes: Passes, cases: list[Case]) -> list[Outcome]:
        """Outcome of each case, in the same order.

        After a death or a time-out a new process goes on with the next case, but none
        of a pass that took too long before.
        """
        outcomes: list[Outcome] = []
        while len(outcomes) < len(cases):
            outcomes += self._some(passes, cases[len(outcomes) :])
        return outcomes

    def close(self) -> int:
        """End the process and what it has left running, and remove its files."""
        self._stop()
        return self._workspace.close()

    def _some(self, passes: Passes, cases: list[Case]) -> list[Outcome]:
        """Outcomes of the first cases, of one at least."""
        if cases[0].pass_name in self._too_slow:
            return [NOT_AGAIN]
        if self.remaining() <= 0:
            return [NO_TIME] * len(cases)
        if self._process.poll() is not None:
            try:
                self._start()
            except NotLoadedError as error:
                return [Failure(f"{case.name}: {error}") for case in cases]
            except UnaskedError as error:
                return [Unasked(str(error))] * len(cases)
        asked = takewhile(lambda case: case.pass_name not in self._too_slow, cases)
        return self._batch(passes, list(asked))

    def _batch(self, passes: Passes, cases: list[Case]) -> list[Outcome]:
        """Outcomes of the first cases: all of them, or up to one that was fatal."""
        found: list[Outcome] = []
        with self._workspace.batch() as folder:
            write_cases(folder, passes, self.precision, cases)
            self._tell(str(folder))
            for case in cases:
                answer = self._answer(self._limits.seconds)
                if answer == "begin":
                    answer = self._answer(self._limits.seconds)
                if isinstance(answer, Failure | Unasked):
                    self._stop()
                    found.append(self._fatal(case, answer))
                    break
                word, _, reason = answer.partition(" ")
                if word == "absent":
                    found.append(None)
                    continue
                if word == "end":
                    outcome = read_outputs(folder, passes, self.precision, case)
                else:
                    outcome = self._failed(case, reason or answer)
                if isinstance(outcome, Failure):
                    size = outputs_size(passes, self.precision, case)
                    self._workspace.need_room(size)
                found.append(outcome)
            else:
                self._answer(self._limits.seconds)  # done
        return found

    def _failed(self, case: Case, answer: str) -> Failure:
        """A call that raised, as the worker tells it."""
        reason, traceback = json.loads(answer)
        said = "\n".join(filter(None, (shown_output(self._said), traceback)))
        return Failure(f"{case.name}: {reason}", output=said)

    def _fatal(self, case: Case, answer: Failure | Unasked) -> Failure | Unasked:
        self._workspace.need_room()
        if isinstance(answer, Failure) and answer.timed_out:
            self._too_slow.add(case.pass_name)
        if answer is NO_TIME:
            return answer
        return replace(answer, reason=f"{case.name}: the backend {answer.reason}")

    def _tell(self, line: str) -> None:
        assert self._process.stdin is not None
        with suppress(OSError):  # if it has died, its silence will tell
            self._process.stdin.write(f"{line}\n".encode())
            self._process.stdin.flush()

    @property
    def _about(self) -> list[str]:
        """Arguments of the worker."""
        return [self._spec, str(self._limits.memory), *self._names]

    def _start(self) -> Precision:
        worker = "restir_gi.reference.oracle.backends.worker"
        self._process = started(
            [sys.executable, "-m", worker, *self._about],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env={
                **self._workspace.environment,
                "PYTHONPATH": os.pathsep.join(sys.path),
            },
            start_new_session=True,
        )
        assert self._process.stdout is not None
        assert self._process.stderr is not None
        try:
            self._said = LastWords(self._process.stderr)
            self._lines: queue.Queue[str | None] = queue.Queue()
            _listen(self._process.stdout, self._lines)
            answer = self._answer(max(self._limits.seconds, LOADING))
        except BaseException:
            self._stop()
            raise
        if isinstance(answer, str) and answer.startswith("ready "):
            told = json.loads(answer.removeprefix("ready "))
            precision, offer, self.declaration = told
            self.offer = Offer.from_plain(offer) if self._names else None
            return "float64" if precision == "float64" else "float32"
        self._stop()
        if isinstance(answer, Unasked):
            raise UnaskedError(f"backend {self._spec}: while it loads, {answer.reason}")
        text = answer.reason if isinstance(answer, Failure) else answer
        raise NotLoadedError(f"backend {self._spec}: {text.removeprefix('failed ')}")

    def _answer(self, allowed: float) -> str | Failure | Unasked:
        """Next line of the worker, or why there is none."""
        end = time.monotonic() + min(allowed, threading.TIMEOUT_MAX)
        left = self.remaining()
        try:
            line = self._lines.get(timeout=max(min(allowed, left, 1e6), 0.0))
            if line is not None:
                return line
            wait = min(end - time.monotonic(), self.remaining())
            code = self._process.wait(max(wait, 0.0))
        except (queue.Empty, subprocess.TimeoutExpired):
            if left < allowed:
                return NO_TIME
            reason = f"gave no answer within {allowed:g} s"
            return Failure(reason, True, shown_output(self._said))
        last = self._said.last_line()
        return how_it_ended(code, last, shown_output(self._said))

    def _stop(self) -> None:
        stop(self._process)
        assert self._process.stdin is not None
        with suppress(OSError):
            self._process.stdin.close()


class NotLoadedError(UsageError):
    """A backend cannot be loaded, by a fault of its own."""


def _listen(stream: IO[bytes], lines: "queue.Queue[str | None]") -> None:
    """Queue the lines of a stream, and ``None`` in the end, in a thread of its own."""

    def read() -> None:
        with suppress(OSError, ValueError), stream:
            while line := stream.readline(LONGEST_LINE):
                lines.put(line.decode(errors="replace").rstrip("\n"))
        lines.put(None)

    try:
        threading.Thread(target=read, daemon=True).start()
    except RuntimeError as error:
        raise UsageError(
            f"cannot listen to a backend: {error}; raise the limit of processes"
        ) from error

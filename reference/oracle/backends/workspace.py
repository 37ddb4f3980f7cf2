"""Where a backend works: a folder, and a mark on all processes that come of it."""

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from secrets import token_hex

from restir_gi.reference.oracle.backends import descendants
from restir_gi.reference.oracle.backends.descendants import end_marked, marked
from restir_gi.reference.oracle.backends.running import started
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.leftovers import scratch_folder

MOST_LEFT, EVERY = 16, 16
"""Processes that a backend may leave running until it is closed; and how many batches
lie between two counts of them."""

ROOM = 64 * 2**10
"""Bytes that must fit the disk where a backend has written nothing that can be read."""


class Workspace:
    """Folder and processes of one backend, gone also if this process is killed.

    Raises UsageError: no folder can be made, or no process started.
    """

    def __init__(self, kind: str) -> None:
        self._stack = ExitStack()
        self._mark = f"RESTIR_BACKEND_{token_hex(8)}"
        self._batches = self._ended = 0
        with ExitStack() as opening:
            self.folder = opening.enter_context(scratch_folder(kind))
            guardian = [sys.executable, "-I", "-S", descendants.__file__]
            self._guardian = started(
                [*guardian, self._mark, str(self.folder)],
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                start_new_session=True,
            )
            self._stack = opening.pop_all()

    @property
    def environment(self) -> dict[str, str]:
        """Of processes that are to be found again."""
        return {**os.environ, self._mark: "1"}

    @contextmanager
    def batch(self) -> Iterator[Path]:
        """New folder for some calls, removed in the end."""
        self._batches += 1
        folder = self.folder / str(self._batches)
        try:
            yield folder
        finally:
            shutil.rmtree(folder, ignore_errors=True)
            if self._batches % EVERY == 0 and len(marked(self._mark)) > MOST_LEFT:
                self._ended += end_marked(self._mark)

    def end_all(self) -> None:
        """End what has come of a call that failed."""
        end_marked(self._mark)

    def need_room(self, count: int = 0) -> None:
        """Refuse to go on if the disk is full, which is no fault of a backend.

        Raises UsageError: they cannot be written here either.

        Parameters
        ----------
        count : int; bytes that it was to write
        """
        probe = self.folder / "probe"
        try:
            with probe.open("wb") as file:
                for _ in range(1 + count // ROOM):
                    file.write(bytes(ROOM))
                file.flush()
        except OSError as error:
            raise UsageError(
                f"cannot write to {self.folder.parent}: {error.strerror}; make room"
                " there, or set TMPDIR to a folder with room"
            ) from error
        finally:
            with suppress(OSError):
                probe.unlink(missing_ok=True)

    def close(self) -> int:
        """End all processes, and remove the folder.

        Returns how many processes were still running.
        """
        with self._stack:
            self._ended += end_marked(self._mark)
        assert self._guardian.stdin is not None
        self._guardian.stdin.close()
        self._guardian.wait()
        return self._ended

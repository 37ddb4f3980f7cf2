"""Signals that end a run in good order."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


class Interrupted(KeyboardInterrupt):
    """A run was ended from outside; the message says what is left of it.

    Parameters
    ----------
    terminated : bool; by SIGTERM, not by Ctrl-C
    """

    def __init__(self, message: str = "", terminated: bool = False) -> None:
        super().__init__(message)
        self.terminated = terminated


@contextmanager
def terminable() -> Iterator[None]:
    """Let SIGTERM end a run as Ctrl-C does, so that its state is kept."""

    def stop(number: int, frame: FrameType | None) -> None:
        raise Interrupted("terminated; nothing half-written is left", terminated=True)

    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGTERM, stop)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)

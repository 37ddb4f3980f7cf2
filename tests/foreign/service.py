"""A renderer in a process of its own, which outlives the call: as a GPU service does.

restir check tests/foreign/service.py:STAYS
"""

import atexit
import os
import pickle
import signal
import subprocess
import sys
from pathlib import Path

from tests.foreign.renderer import ForeignRenderer

ROOT = Path(__file__).parents[2]
SERVER = "from tests.foreign.service import serve; serve()"
LIFE = 900
"""Seconds after which a child that nobody ended leaves by itself."""


class Service:
    """A backend that leaves all work to a child.

    Parameters
    ----------
    passes : tuple of str
    stays : bool; the child is never ended, and does not notice that nobody asks
    """

    precision = "float32"

    def __init__(self, passes, stays=False):
        self._passes, self._stays, self._child = passes, stays, None

    def __getattr__(self, name):
        if name.startswith("_") or name not in self._passes:
            raise AttributeError(name)
        return lambda **given: self._ask(name, given)

    def _ask(self, name, given):
        if self._child is None:
            self._start()
        pickle.dump((name, given), self._child.stdin)
        self._child.stdin.flush()
        return pickle.load(self._child.stdout)

    def _start(self):
        pipe = subprocess.PIPE
        self._child = subprocess.Popen(
            [sys.executable, "-c", SERVER, *["stays"] * self._stays],
            stdin=pipe,
            stdout=pipe,
            cwd=ROOT,
            env=os.environ | {"PYTHONPATH": str(ROOT)},
            # Whoever ends the group of its parent does not end it.
            start_new_session=self._stays,
        )
        if not self._stays:
            atexit.register(self.end)

    def end(self):
        """End the child, where somebody cares."""
        if self._child is not None:
            self._child.stdin.close()
            self._child.stdout.close()
            self._child.wait()
            self._child = None


def serve():
    """Answer for as long as somebody asks, or for longer."""
    signal.alarm(LIFE)
    renderer = ForeignRenderer()
    while True:
        try:
            name, given = pickle.load(sys.stdin.buffer)
        except EOFError:
            break
        pickle.dump(getattr(renderer, name)(**given), sys.stdout.buffer)
        sys.stdout.buffer.flush()
    if "stays" in sys.argv:
        signal.pause()


PASSES = ("temporal", "spatial")
SERVICE, STAYS = Service(PASSES), Service(PASSES, stays=True)

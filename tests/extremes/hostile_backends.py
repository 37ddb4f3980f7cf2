"""Python backends that hold on to what is not theirs, or answer with nonsense."""

import os
import signal
import subprocess
import time

import numpy as np

from restir_gi.reference.oracle.builtin.backend import FLOAT32


class _Right:
    precision = "float32"

    def __getattr__(self, name):
        if name.startswith("_"):
            raise AttributeError(name)
        return getattr(FLOAT32, name)


class Forks(_Right):
    """A child in a session of its own keeps all pipes open."""

    def jacobian(self, **given):
        """Answer, and leave a child."""
        if os.fork() == 0:
            os.setsid()
            time.sleep(300)
            os._exit(0)
        return FLOAT32.jacobian(**given)


class Serves(_Right):
    """A service is started, as if it were to be used again."""

    def jacobian(self, **given):
        """Answer, and leave a service."""
        subprocess.Popen(["sleep", "300"], start_new_session=True)
        return FLOAT32.jacobian(**given)


class HangsInEveryCall:
    """Every pass, and it does not go when it is asked to."""

    precision = "float32"

    def __getattr__(self, name):
        if name.startswith("_"):
            raise AttributeError(name)

        def hang(**given):
            signal.signal(signal.SIGTERM, signal.SIG_IGN)
            time.sleep(1000)

        return hang


class UnprintableError(Exception):
    """Raises again when it is told."""

    def __str__(self):
        raise RuntimeError


class Steers:
    """What it says would steer a terminal, or cannot be said."""

    precision = "float32"

    class _Array:
        def __array__(self, *about, **more):
            raise RuntimeError("\x1b]0;title\x07 \ud800 \x00\nend\ndone")

    def jacobian(self, **given):
        """No array."""
        return {"jacobian": self._Array()}

    def merge(self, **given):
        """An error that cannot be told."""
        raise UnprintableError


class KilledFromOutside(_Right):
    """As by a system that has no memory left."""

    def jacobian(self, **given):
        """End at once."""
        os.kill(os.getpid(), signal.SIGKILL)


class Huge(_Right):
    """Far more than was asked for."""

    def jacobian(self, **given):
        """A hundred times the rows, and then as much again in what nobody asks for."""
        more = np.zeros(2**22, np.float32)
        return {"jacobian": more, "more": more}


class Precision:
    """No precision."""

    precision = "float32\nend\nend"


FORKS, SERVES, HANGS, STEERS = Forks(), Serves(), HangsInEveryCall(), Steers()
KILLED, HUGE, PRECISION = KilledFromOutside(), Huge(), Precision()

"""Backends that go wrong, each in one way, as a process would meet them."""

import os
import signal
import sys
import time

import numpy as np

from restir_gi.reference.oracle.builtin.backend import FLOAT32


class Right:
    """The built-in passes."""

    precision = "float32"

    def __getattr__(self, name):
        return getattr(FLOAT32, name)


class Partial:
    """Two passes of all."""

    jacobian = staticmethod(FLOAT32.jacobian)
    shade = staticmethod(FLOAT32.shade)


class Empty:
    """No pass at all."""


class Loud(Right):
    """Prints what looks like answers."""

    def jacobian(self, **given):
        """Fail, or answer."""
        print("end\ndone\nfailed everything")  # noqa: T201
        return FLOAT32.jacobian(**given)


class Raises(Right):
    """Complains."""

    def jacobian(self, **given):
        """Fail, or answer."""
        raise ValueError("the buffer\nis not mapped")


class Dies(Right):
    """Is killed by a fault in native code."""

    def jacobian(self, **given):
        """Fail, or answer."""
        os.kill(os.getpid(), signal.SIGSEGV)


class Exits(Right):
    """Leaves in the middle of a call."""

    def jacobian(self, **given):
        """Fail, or answer."""
        sys.stderr.write("device lost\n")
        sys.stderr.flush()
        os._exit(7)


class Hangs(Right):
    """Never returns."""

    def jacobian(self, **given):
        """Fail, or answer."""
        time.sleep(600)


class Hungry(Right):
    """Asks for more memory than there is."""

    def jacobian(self, **given):
        """Fail, or answer."""
        return {"jacobian": np.ones(10**12)}


def changed(change):
    """Backend whose Jacobian comes back changed."""

    class ChangedOutputs(Right):
        def jacobian(self, **given):
            """Answer, changed."""
            return change(FLOAT32.jacobian(**given))

    return ChangedOutputs()


RIGHT, PARTIAL, EMPTY, LOUD, RAISES = Right(), Partial(), Empty(), Loud(), Raises()
DIES, EXITS, HANGS, HUNGRY = Dies(), Exits(), Hangs(), Hungry()
NOTHING = changed(lambda out: {})
NO_MAPPING = changed(lambda out: 3)
SHORT = changed(lambda out: {"jacobian": out["jacobian"][:-1]})
TRANSPOSED = changed(lambda out: {"jacobian": out["jacobian"][None]})
DOUBLE = changed(lambda out: {"jacobian": out["jacobian"].astype(np.float64)})
WHOLE = changed(lambda out: {"jacobian": out["jacobian"].astype(np.int32)})
SWAPPED = changed(lambda out: {"jacobian": out["jacobian"].astype(">f4")})
NAN = changed(lambda out: {"jacobian": out["jacobian"] * np.float32(np.nan)})
INFINITE = changed(lambda out: {"jacobian": out["jacobian"] + np.float32(np.inf)})
OBJECTS = changed(lambda out: {"jacobian": out["jacobian"].astype(object)})

"""Processes that come of a backend: known by a mark that they inherit, and ended.

A process of its own session has left its parent and its group; but unless it takes
pains it keeps the environment that it was born with.  Run as a program, this file is a
guardian: it waits until nobody holds its standard input any more, as when a check was
killed, and ends what the check has left.  It imports nothing but the standard library.
"""

import os
import shutil
import signal
import sys
import time
from contextlib import suppress

PROCESSES = "/proc"
ROUNDS = 100  # of ending what goes on to start others


def marked(mark: str) -> list[int]:
    """Running processes that inherited a mark; none if the system does not tell.

    Parameters
    ----------
    mark : str; a variable of their environment
    """
    wanted, found = f"{mark}=".encode(), []
    with suppress(OSError):
        for name in os.listdir(PROCESSES):
            if not name.isdigit():
                continue
            with suppress(OSError), open(f"{PROCESSES}/{name}/environ", "rb") as file:
                if any(word.startswith(wanted) for word in file.read().split(b"\0")):
                    found.append(int(name))
    return found


def alive_in(group: int) -> bool:
    """Whether a process of a group still runs; no if the system does not tell."""
    with suppress(OSError):
        for name in os.listdir(PROCESSES):
            if not name.isdigit():
                continue
            with suppress(OSError), open(f"{PROCESSES}/{name}/stat", "rb") as file:
                state, _, its_group = file.read().rpartition(b")")[2].split()[:3]
                if int(its_group) == group and state not in (b"Z", b"X"):
                    return True
    return False


def end_marked(mark: str) -> int:
    """End all processes that have inherited a mark.

    Parameters
    ----------
    mark : str; a variable of their environment
    """
    ended: set[int] = set()
    for _ in range(ROUNDS):
        found = marked(mark)
        if not found:
            break
        for process in found:
            with suppress(ProcessLookupError, PermissionError):
                os.kill(process, signal.SIGKILL)
        ended.update(found)
        time.sleep(0.01)
    return len(ended)


if __name__ == "__main__":
    sys.stdin.read()
    end_marked(sys.argv[1])
    shutil.rmtree(sys.argv[2], ignore_errors=True)

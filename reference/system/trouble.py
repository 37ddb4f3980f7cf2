"""Trouble with the machine, not with the program or its input, and what helps."""

import errno
import os
from contextlib import suppress

from restir_gi.reference.system.errors import UsageError

LEAST = 2**30
"""Bytes of address space without which libraries end or hang while they load."""

REMEDIES = (
    (("ENOSPC", "EDQUOT", "EFBIG"), "make room there, or set TMPDIR to another folder"),
    (
        ("EACCES", "EPERM", "EROFS"),
        "name a place that you may read and write, or set TMPDIR to one",
    ),
    (("ENAMETOOLONG",), "give it a shorter name"),
    (("EMFILE", "ENFILE"), "raise the limit of open files (ulimit -n)"),
    (
        ("ENOMEM", "EAGAIN"),
        "raise the limits of memory and processes (ulimit -v, ulimit -u), or ask for"
        " fewer --threads or --processes",
    ),
    (("ENOENT",), "name one that exists; temporary files need a folder, see TMPDIR"),
)
ELSE = "look to that file, its disk and the limits of this machine"
MEMORY = (
    "out of memory; ask for a smaller --size or fewer --threads, or raise the limit"
    " (ulimit -v)"
)
NO_THREADS = (
    "no more threads can be started; ask for fewer --threads, or raise the limits of"
    " processes and memory (ulimit -u, ulimit -v)"
)


def trouble(error: BaseException) -> str | None:
    """What is the matter with the machine, and what helps.

    One line, or ``None``: the error is of another kind.
    """
    if isinstance(error, MemoryError):
        return MEMORY
    # Libraries that find no memory may fail in ways that do not say so.
    if isinstance(error, ImportError | SystemError) and memory_limits():
        return MEMORY
    if isinstance(error, RuntimeError) and str(error) == "can't start new thread":
        return NO_THREADS
    if not isinstance(error, OSError):
        return None
    reason = error.strerror or str(error) or type(error).__name__
    where = f"{os.fsdecode(error.filename)}: " if _is_name(error.filename) else ""
    name = errno.errorcode.get(error.errno or 0, "")
    remedy = next((what for names, what in REMEDIES if name in names), ELSE)
    return f"{where}{reason}; {remedy}"


def refuse_narrow_limits() -> None:
    """Raise where libraries could not even be loaded.

    Raises UsageError: the shell or the container leaves less than `LEAST`.
    """
    for option, limit in memory_limits().items():
        if limit < LEAST:
            raise UsageError(
                f"memory is limited to {limit >> 20} MiB (ulimit -{option}); raise the"
                f" limit to {LEAST >> 20} MiB at least"
            )


def memory_limits() -> dict[str, int]:
    """Limits of this process, by their letters in the shell.

    Bytes; empty where there are none, or nobody knows.
    """
    found = {}
    with suppress(ImportError):
        import resource

        for option, kind in (("v", resource.RLIMIT_AS), ("d", resource.RLIMIT_DATA)):
            soft = resource.getrlimit(kind)[0]
            if soft != resource.RLIM_INFINITY:
                found[option] = soft
    return found


def _is_name(filename: object) -> bool:
    return isinstance(filename, str | bytes | os.PathLike)

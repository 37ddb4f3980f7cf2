"""What a killed process leaves behind: known by its name, swept when nobody holds it.

A hidden file or folder of ours is locked for as long as its process works on it.  The
system lifts the lock of a process that is no more, however it ended: so that whatever
has our name and no lock is left over, and a lock tells that better than the number of a
process, which another one may bear by now, or the same in another container.
"""

import os
import re
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import lru_cache
from pathlib import Path
from secrets import token_hex
from typing import BinaryIO

from restir_gi.reference.system.errors import UsageError

try:
    import fcntl
except ImportError:  # Windows has no such locks: nothing is swept there
    fcntl = None  # type: ignore[assignment]

PART = re.compile(r"\.restir-[0-9a-f]{16}\.part")
SCRATCH = re.compile(r"\.?restir-(cases|render|golden)-[0-9a-z_]{8}")
LOCK = "restir.lock"


@contextmanager
def part_beside(target: Path) -> Iterator[tuple[Path, BinaryIO]]:
    """A hidden file beside another one, removed in the end if it is still there.

    Raises OSError: it cannot be made.

    Parameters
    ----------
    target : Path; in a folder that exists

    Yields
    ------
    path, file : Path, binary file; new, and locked while it is open
    """
    sweep(target.parent)
    while True:
        part = target.parent / f".restir-{token_hex(8)}.part"
        file = part.open("xb")
        if _hold(file) and _is_there(part, file):
            break
        file.close()  # a sweeper was quicker, and removes it
    try:
        with file:
            yield part, file
    finally:
        part.unlink(missing_ok=True)


@contextmanager
def scratch_folder(kind: str, place: Path | None = None) -> Iterator[Path]:
    """A folder for as long as it is wanted.

    Raises UsageError: it cannot be made.

    Parameters
    ----------
    kind : str; what for: a word of `SCRATCH`
    place : Path, optional; where; by default the system's folder for temporary files
    """
    hidden = "." if place is not None else ""
    try:
        above = place or Path(tempfile.gettempdir())
        sweep(above)
        while True:
            folder = Path(tempfile.mkdtemp("", f"{hidden}restir-{kind}-", above))
            with suppress(FileNotFoundError):  # a sweeper was quicker
                lock = (folder / LOCK).open("xb")
                if _hold(lock) and _is_there(folder / LOCK, lock):
                    break
                lock.close()
    except OSError as error:
        raise UsageError(
            f"cannot make a folder in {place or 'the place for temporary files'}:"
            f" {error.strerror}; "
            + ("name another --out" if place else "set TMPDIR to a folder with room")
        ) from error
    with lock:
        try:
            yield folder
        finally:
            shutil.rmtree(folder, ignore_errors=True)


# What earlier processes have left is there at the first look.
@lru_cache(maxsize=256)
def sweep(folder: Path) -> None:
    """Remove what killed processes have left in a folder; once a process.

    Parameters
    ----------
    folder : Path; where such things may be
    """
    if fcntl is None:
        return
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            path = Path(entry.path)
            if PART.fullmatch(entry.name) and entry.is_file(follow_symlinks=False):
                _sweep(path, path)
            elif SCRATCH.fullmatch(entry.name) and entry.is_dir(follow_symlinks=False):
                _sweep(path, path / LOCK)


def _sweep(path: Path, lock: Path) -> None:
    with suppress(OSError), lock.open("rb+") as file:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)  # somebody holds it: no more
        if path == lock:
            path.unlink()
        else:
            shutil.rmtree(path, ignore_errors=True)


def _hold(file: BinaryIO) -> bool:
    """Lock a file until it is closed; whether no sweeper has."""
    if fcntl is None:
        return True
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:  # a file system without locks: nothing is swept there
        return True
    return True


def _is_there(path: Path, file: BinaryIO) -> bool:
    with suppress(FileNotFoundError):
        return os.path.samestat(os.stat(path), os.fstat(file.fileno()))
    return False

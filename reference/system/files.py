"""Whole files in and out: a reader never meets half of one."""

import os
from errno import EINVAL
from pathlib import Path
from stat import S_ISDIR, S_ISREG

from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.leftovers import part_beside

MOST_BYTES = 2**32
"""Of one file: as much as fits the memory of a large machine a few times."""


def read_file(path: Path, most: int = MOST_BYTES) -> bytes:
    """All that a file held when it was opened.

    The file is opened without waiting and asked what it is only then, so that neither a
    pipe can hold the reader up nor a device be put in the place of a file in between.

    Raises UsageError: it is missing, a folder, a device or a pipe, too large, or may
    not be read.

    Parameters
    ----------
    most : int; bytes that it may have
    """
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
        try:
            status = os.fstat(descriptor)
            if not S_ISREG(status.st_mode):
                kind = "a folder" if S_ISDIR(status.st_mode) else "a device or a pipe"
                raise UsageError(f"cannot read {path}: it is {kind}; name a file")
            if status.st_size > most:
                raise UsageError(
                    f"cannot read {path}: it has {status.st_size:,} bytes; at most"
                    f" {most:,} can be read"
                )
            with open(descriptor, "rb", closefd=False) as file:
                return file.read(status.st_size)
        finally:
            os.close(descriptor)
    except OSError as error:
        raise UsageError(
            f"cannot read {path}: {error.strerror}; name a file that exists"
            " and may be read"
        ) from error
    except ValueError as error:  # a NUL, or half of a surrogate pair
        raise UsageError(
            f"cannot read {str(path)!r}: no file can have this name"
        ) from error


def write_file(path: Path, contents: bytes) -> None:
    """Replace a file in one step: after an error or a crash it is the old one still.

    The bytes go to a hidden file beside the target (a rename is one step only within
    a file system) and reach the disk before the rename does: without ``fsync`` a
    power cut may leave the new name on an empty file.

    Raises UsageError: no such folder, no permission, no room, or the path is not a
    regular file.

    Parameters
    ----------
    path : Path; new, or a regular file, or a link to one; its folder exists
    """
    try:
        target = Path(os.path.realpath(path))  # the rename would cut a link
        if target.exists() and not target.is_file():
            raise OSError(EINVAL, "it is not a regular file")
        _write_and_rename(target, contents)
    except OSError as error:
        raise UsageError(
            f"cannot write {path}: {error.strerror}; name a file in a folder that"
            " exists, may be written and has room"
        ) from error


def _write_and_rename(target: Path, contents: bytes) -> None:
    with part_beside(target) as (part, file):
        file.write(contents)
        file.flush()
        os.fsync(file.fileno())
        part.replace(target)


def make_folder(path: Path) -> None:
    """Make a folder, and those above it, if they do not exist.

    Raises UsageError: it cannot be made.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UsageError(
            f"cannot make the folder {path}: {error.strerror}; name one that can be"
            " made"
        ) from error

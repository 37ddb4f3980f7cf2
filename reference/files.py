"""Whole files in and out: a reader never meets half of one."""

import os
from errno import EINVAL
from pathlib import Path
from secrets import token_hex

from reference.errors import UsageError


def read_file(path: Path) -> bytes:
    """Contents of a file.

    Parameters
    ----------
    path : Path
        A readable regular file.

    Returns
    -------
    bytes
        All of it.

    Raises
    ------
    UsageError
        It is missing, a folder, or may not be read.
    """
    try:
        return path.read_bytes()
    except OSError as error:
        raise UsageError(
            f"cannot read {path}: {error.strerror}; name a file that exists"
            " and may be read"
        ) from error


def write_file(path: Path, contents: bytes) -> None:
    """Replace a file in one step: after an error or a crash it is the old one still.

    Parameters
    ----------
    path : Path
        New, or a regular file, or a link to one; its folder exists.
    contents : bytes
        All of the new file.

    Raises
    ------
    UsageError
        No such folder, no permission, no room, or the path is not a regular file.

    Notes
    -----
    The bytes go to a hidden file beside the target (a rename is one step only within
    a file system) and reach the disk before the rename does: without ``fsync`` a
    power cut may leave the new name on an empty file.
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
    part = target.parent / f".{token_hex(8)}.part"
    try:
        with part.open("xb") as file:
            file.write(contents)
            file.flush()
            os.fsync(file.fileno())
        part.replace(target)
    except BaseException:  # Ctrl-C too
        part.unlink(missing_ok=True)
        raise


def make_folder(path: Path) -> None:
    """Make a folder, and those above it, if they do not exist.

    Parameters
    ----------
    path : Path
        Of the folder.

    Raises
    ------
    UsageError
        It cannot be made.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UsageError(
            f"cannot make the folder {path}: {error.strerror}; name one that can be"
            " made"
        ) from error

"""Where results go, looked at before hours are spent on them.

`new_file` and `new_folder` are types of arguments: what they refuse is refused while
the command line is read, before anything else is done.
"""

import os
import tempfile
from collections.abc import Callable
from pathlib import Path

from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.files import read_file

BESIDE = ".checkpoint"
"""The longest ending that a command puts to the name of a file."""


PAGE, HEAD = "index.html", 2**12
MADE_BY = b'<meta name="generator" content="restir-gi-oracle">'
"""In the head of each of our pages."""


def new_file(suffix: str = ".exr", option: str = "--out") -> Callable[[str], Path]:
    """Make a converter from text to the path of a file that can be written.

    See `check_file`.
    """

    def convert(text: str) -> Path:
        path = Path(text)
        check_file(path, suffix, option)
        return path

    return convert


def new_folder(text: str, option: str = "--out") -> Path:
    """Name of a folder that is there, or can be made, and can be written.

    Nothing is made yet.

    Raises UsageError: it cannot be made, or not be written, or somebody else's page is
    there.

    Parameters
    ----------
    option : str; that names it, for messages
    """
    path = Path(text)
    if not text:
        raise UsageError(f"{option} is empty; name a folder")
    _refuse_bad_names(path, option)
    there = path.absolute()
    while not os.path.lexists(there):
        there = there.parent
    if not os.path.isdir(there):
        what = "it" if there == path.absolute() else str(there)
        raise UsageError(
            f"{option} {path}: cannot make this folder: {what} is a file; name another"
        )
    _refuse_closed(path, there, option)
    _refuse_foreign_page(path, option)
    return path


def check_file(path: Path, suffix: str = ".exr", option: str = "--out") -> None:
    """Raise unless a file can be written.

    Raises UsageError: another suffix, no such folder, or one that may not be written.

    Parameters
    ----------
    option : str; that names it, for messages
    """
    if path.suffix.lower() != suffix:
        raise UsageError(f"{option} {path}: name a file that ends in {suffix}")
    _refuse_bad_names(path, option)
    if os.path.lexists(path) and not os.path.isfile(path):
        raise UsageError(f"{option} {path} is not a regular file; name a file")
    folder = path.resolve().parent
    if not os.path.isdir(folder):
        raise UsageError(
            f"{option} {path}: there is no folder {path.parent}; create it"
        )
    _refuse_closed(path, folder, option)


def _refuse_bad_names(path: Path, option: str = "--out") -> None:
    if "\0" in str(path):
        raise UsageError(
            f"{option} {str(path)!r}: no file can have this name; name another"
        )
    most = 255 - len(BESIDE)  # bytes, of every file system in use
    long = next((p for p in path.parts if len(os.fsencode(p)) > most), None)
    if long is not None or len(os.fsencode(path.absolute())) > 4096 - 255:
        raise UsageError(
            f"{option} {long or path:.40}...: the name is too long; give one of at most"
            f" {most} bytes"
        )


def _refuse_foreign_page(path: Path, option: str = "--out") -> None:
    """Raise where a page would be overwritten that is not one of ours."""
    page = path / PAGE
    if page.is_file() and MADE_BY not in read_file(page)[:HEAD]:
        raise UsageError(
            f"{option} {path} holds an {PAGE} that this version of restir did not"
            " write; move it, or name another folder"
        )


def _refuse_closed(path: Path, folder: Path, option: str = "--out") -> None:
    """Raise unless a file can be made there: a try tells more than permissions."""
    try:
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise UsageError(
            f"{option} {path}: {folder} may not be written: {error.strerror}; name"
            " another folder"
        ) from error

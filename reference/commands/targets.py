"""Where results go, checked before hours are spent on them."""

import os
import tempfile
from pathlib import Path

from reference.errors import UsageError


def check_file(path: Path, suffix: str = ".exr") -> None:
    """Raise unless a file can be written.

    Parameters
    ----------
    path : Path
        To be written.
    suffix : str
        In which its name ends.

    Raises
    ------
    UsageError
        Another suffix, no such folder, or one that may not be written.
    """
    if path.suffix.lower() != suffix:
        raise UsageError(f"--out {path}: name a file that ends in {suffix}")
    if path.exists() and not path.is_file():
        raise UsageError(f"--out {path} is not a regular file; name a file")
    folder = path.resolve().parent
    if not folder.is_dir():
        raise UsageError(f"--out {path}: there is no folder {path.parent}; make it")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise UsageError(
            f"--out {path}: {path.parent} may not be written; name another folder"
        )


def make_folder(path: Path) -> None:
    """Make a folder for results, and try it, or raise.

    Parameters
    ----------
    path : Path
        May exist.

    Raises
    ------
    UsageError
        It cannot be made, or not be written.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UsageError(
            f"--out {path}: cannot make this folder: {error.strerror}; name another"
        ) from error
    try:
        with tempfile.TemporaryFile(dir=path):
            pass
    except OSError as error:
        raise UsageError(
            f"--out {path}: cannot write there: {error.strerror}; name another folder"
        ) from error

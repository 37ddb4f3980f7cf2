"""What goes out: text of others is shown, not obeyed, and lost output is told."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from restir_gi.reference.system.errors import UsageError


def visible(text: str, keep: str = "") -> str:
    r"""Text with all that cannot be printed written as an escape, such as ``\x1b``.

    Parameters
    ----------
    text : str
        May hold the name of a file, of a scene, or what a program of others wrote.
    keep : str; characters that stay: line breaks, in a table

    Examples
    --------
    >>> visible("kitchen\x1b[2J")
    'kitchen\\x1b[2J'
    """
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c in keep else ascii(c)[1:-1] for c in text)


@contextmanager
def told_errors() -> Iterator[None]:
    """Write to stdout, also what is still in the buffer, or say why not.

    Raises UsageError: the disk is full, or the like.
    Raises BrokenPipeError: nobody reads.
    """
    try:
        try:
            yield
        finally:
            if sys.stdout is not None:
                sys.stdout.flush()
    except OSError as error:
        _mute()
        if isinstance(error, BrokenPipeError):
            raise
        raise UsageError(f"cannot write to stdout: {error.strerror}") from error


def _mute() -> None:
    """Let the interpreter flush what is left to nowhere, without complaint."""
    with suppress(OSError, ValueError):
        null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, sys.stdout.fileno())
        os.close(null)

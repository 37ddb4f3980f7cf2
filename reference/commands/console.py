"""Where results, remarks and progress go: stdout, stderr, and a terminal if there is.

With ``--json`` stdout holds one JSON object and nothing else.
"""

import json
import os
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from math import isfinite
from typing import Any

from rich.console import Console, RenderableType
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from reference.errors import UsageError

WIDTH = 120  # of tables where stdout is no terminal
Tick = Callable[[int, int, str], None]


def show(thing: RenderableType) -> None:
    """Show a result on stdout.

    Parameters
    ----------
    thing : str or rich renderable
        A line, or a table.
    """
    if sys.stdout is None:
        return
    with told_errors():
        width = None if sys.stdout.isatty() else WIDTH
        console = Console(file=sys.stdout, width=width, markup=False, highlight=False)
        # Of a closed pipe rich itself makes an exit of its own.
        with console.capture() as shown:
            console.print(thing, soft_wrap=isinstance(thing, str))
        sys.stdout.write(shown.get())


def emit(results: Mapping[str, Any]) -> None:
    """Write the results of a command as JSON on stdout.

    Parameters
    ----------
    results : mapping
        Numbers that are not finite become null.
    """
    if sys.stdout is None:
        return
    with told_errors():
        sys.stdout.write(json.dumps(_plain(results), indent=2, allow_nan=False) + "\n")


def remark(text: str) -> None:
    """Say on stderr what the user ought to know but did not ask for.

    Parameters
    ----------
    text : str
        One line.
    """
    if sys.stderr is not None:
        sys.stderr.write(f"restir: {text}\n")


@contextmanager
def progress(what: str) -> Iterator[Tick]:
    """Show a bar on stderr while something runs, if that is a terminal.

    Parameters
    ----------
    what : str
        What runs.

    Yields
    ------
    callable
        Takes how much is done, of how much, and its unit.
    """
    if sys.stderr is None or not sys.stderr.isatty():
        yield lambda done, total, unit: None
        return
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed}/{task.total} {task.fields[unit]}"),
        TimeRemainingColumn(),
    )
    with Progress(
        *columns,
        console=Console(file=sys.stderr),
        transient=True,
        redirect_stdout=False,
    ) as bar:
        task = bar.add_task(what, total=None, unit="")

        def tick(done: int, total: int, unit: str) -> None:
            bar.update(task, completed=done, total=total, unit=unit)

        yield tick


@contextmanager
def told_errors() -> Iterator[None]:
    """Write to stdout, also what is still in the buffer, or say why not.

    Yields
    ------
    None
        Nothing.

    Raises
    ------
    UsageError
        The disk is full, or the like.
    BrokenPipeError
        Nobody reads.
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


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float):
        return float(value) if isfinite(value) else None
    return value if isinstance(value, str | int | bool | None) else str(value)

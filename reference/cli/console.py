"""Where results, remarks and progress go: stdout, stderr, and a terminal if there is.

With ``--json`` stdout holds one JSON object and nothing else.  Text of others, such as
the name of a scene, is shown and not obeyed: see `restir_gi.reference.system.terminal`.
"""

import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from rich.console import Console, RenderableType
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.text import Text

from restir_gi.reference.system.json_text import json_text
from restir_gi.reference.system.terminal import told_errors, visible

WIDTH = 120  # of tables where stdout is no terminal
Tick = Callable[[int, int, str], None]


def show(thing: RenderableType) -> None:
    """Show a result on stdout."""
    if sys.stdout is None:
        return
    with told_errors():
        width = None if sys.stdout.isatty() else WIDTH
        console = _Console(file=sys.stdout, width=width, markup=False, highlight=False)
        # Of a closed pipe rich itself makes an exit of its own.
        with console.capture() as shown:
            console.print(thing, soft_wrap=isinstance(thing, str))
        sys.stdout.write(shown.get())


def emit(results: Mapping[str, Any]) -> None:
    """Write the results of a command as JSON on stdout.

    Parameters
    ----------
    results : mapping; numbers that are not finite become null
    """
    if sys.stdout is None:
        return
    with told_errors():
        sys.stdout.write(json_text(results))


def remark(text: str) -> None:
    """Say on stderr what the user ought to know but did not ask for."""
    if sys.stderr is not None:
        sys.stderr.write(f"restir: {visible(text)}\n")


@contextmanager
def progress(what: str) -> Iterator[Tick]:
    """Show a bar on stderr while something runs, if that is a terminal.

    Yields callable; takes how much is done, of how much, and its unit.
    """
    if sys.stderr is None or not sys.stderr.isatty():
        yield lambda done, total, unit: None
        return
    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TextColumn("{task.completed}/{task.total} {task.fields[unit]}", markup=False),
        TimeRemainingColumn(),
    )
    with Progress(
        *columns,
        console=Console(file=sys.stderr),
        transient=True,
        redirect_stdout=False,
    ) as bar:
        task = bar.add_task(visible(what), total=None, unit="")

        def tick(done: int, total: int, unit: str) -> None:
            bar.update(task, completed=done, total=total, unit=visible(unit))

        yield tick


class _Console(Console):
    """All strings that are shown, also in the cells of tables, pass here."""

    def render_str(self, text: str, **options: Any) -> Text:
        return super().render_str(visible(text, keep="\n"), **options)

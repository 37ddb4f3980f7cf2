"""A verdict for the terminal."""

from collections.abc import Mapping
from typing import Any

from rich.console import Group
from rich.table import Table
from rich.text import Text


def table(plain: Mapping[str, Any]) -> Group:
    """A verdict for the terminal.

    A line for each level, two for each wrong pass, and last the verdict.
    """
    parts: list[Table | Text] = [_levels(plain)] if plain["steps"] else []
    wrong = [p for p in plain["passes"] if p["status"] in ("wrong", "departs")]
    if wrong:
        parts.append(_wrong(wrong))
    lonely = [f for s in plain["steps"] if not s["wrong_passes"] for f in s["faults"]]
    parts += [_text(fault) for fault in lonely]
    more = [s for s in plain["steps"] if s["more"]]
    parts += [_text(f"{s['rung']} {s['title']}: {s['more']}") for s in more]
    for step in plain["steps"]:
        if lines := step["unasked"]:
            where = f"{step['rung']} {step['title']}"
            parts.append(_text(f"{where}: nothing is known of {_some(lines)}"))
    if plain["left"]:
        parts.append(_text(f"no time for: {', '.join(plain['left'])}"))
    if plain["absent"]:
        parts.append(_text(f"the backend does not have: {', '.join(plain['absent'])}"))
    if plain["left_running"]:
        parts.append(_text(left_running(plain["left_running"])))
    parts.append(_text(f"{plain['status']}: {plain['backend']}: {plain['headline']}"))
    return Group(*parts)


def printable(text: str) -> str:
    """A line that cannot steer a terminal, whatever a backend has said.

    A mark stands in place of each control character.
    """
    return "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text)


def left_running(count: int) -> str:
    """What became of processes that a backend has left.

    Parameters
    ----------
    count : int; one at least
    """
    many = "1 process" if count == 1 else f"{count} processes"
    return f"the backend left {many} running; they were ended"


def _some(lines: list[str]) -> str:
    more = f", and of {len(lines) - 1} more" if len(lines) > 1 else ""
    return f"{lines[0]}{more}"


def _text(text: str) -> Text:
    return Text(printable(text))


def _levels(plain: Mapping[str, Any]) -> Table:
    made = Table()
    made.add_column("level")
    made.add_column("step")
    for title in ("seconds", "asked", "unanswered", "failed"):
        made.add_column(title, justify="right")
    made.add_column("wrong passes")
    for step in plain["steps"]:
        counts = [str(step[name]) for name in ("asked", "unanswered", "failed")]
        words = [step["rung"], step["title"], f"{step['seconds']:.1f}", *counts]
        made.add_row(*map(_text, [*words, ", ".join(step["wrong_passes"])]))
    return made


def _wrong(passes: list[Mapping[str, Any]]) -> Table:
    made = Table(box=None, show_header=False, padding=(0, 1, 0, 0))
    made.add_column(no_wrap=True)
    made.add_column()
    for one in passes:
        made.add_row(_text(one["name"]), _text(one["fault"]))
        named = one["diagnosis"]
        mistake = f": {named[0]['mistake']}" if len(named) == 1 else ""
        made.add_row("", _text(one["conclusion"] + mistake))
    return made

"""A verdict for the terminal."""

from collections.abc import Iterator, Mapping
from typing import Any

from rich.console import Group
from rich.table import Table
from rich.text import Text

from restir_gi.reference.oracle.replay.typical import DIGITS, written

MOST = 20
"""Faults of tests of several passes that the terminal shows."""

VOID = "not held against the backend, since they rest on what it does otherwise"

LAST = 8
"""Lines of what a backend wrote that the terminal shows."""


def table(plain: Mapping[str, Any]) -> Group:
    """A verdict for the terminal.

    A line for each step that asked something of the backend, some for each wrong pass,
    and last the verdict.
    """
    steps = [step for step in plain["steps"] if was_asked(step)]
    parts: list[Table | Text] = [_levels(steps)] if steps else []
    other = ("wrong", "undecided", "departs", "by design")
    wrong = [p for p in plain["passes"] if p["status"] in other]
    if wrong:
        parts.append(_wrong(wrong))
    if plain["first_wrong_pass"]:
        first = next(p for p in wrong if p["name"] == plain["first_wrong_pass"])
        parts += map(_text, _again(first))
    parts += map(_text, _declared(plain["declaration"]))
    parts += [_text(f"at extremes alone: {line}") for line in plain["at_extremes"]]
    notes = [*plain["missing"], *plain["near"]]
    parts += [_text(note) for note in notes if note not in plain["headline"]]
    void = [s for s in steps if s["void"] and s["faults"]]
    lonely = [
        f for s in steps if s["binds"] and not s["wrong_passes"] for f in s["faults"]
    ]
    # A wrong pass is wrong in the loop as well.
    parts += map(_text, _first(list(dict.fromkeys(lonely)), 1 if wrong else MOST))
    if void:
        parts.append(_text(f"{VOID}: {', '.join(s['title'] for s in void)}"))
    more = [s for s in plain["steps"] if s["more"]]
    parts += [_text(f"{s['rung']} {s['title']}: {s['more']}") for s in more]
    for step in plain["steps"]:
        if lines := step["unasked"]:
            where = f"{step['rung']} {step['title']}"
            parts.append(_text(f"{where}: nothing is known of {_some(lines)}"))
    if plain["left"]:
        parts.append(_text(f"no time for: {', '.join(plain['left'])}"))
    if plain["not_asked"]:
        parts.append(_text(f"not asked, by --quick: {', '.join(plain['not_asked'])}"))
    if plain["absent"]:
        parts.append(_text(f"the backend does not have: {', '.join(plain['absent'])}"))
    if plain["left_running"]:
        parts.append(_text(left_running(plain["left_running"])))
    parts.append(_text(f"{plain['status']}: {plain['backend']}: {plain['headline']}"))
    return Group(*parts)


def was_asked(step: Mapping[str, Any]) -> bool:
    """Whether a step asked for anything that the backend has, or failed to."""
    told = step["failed"] or step["unasked"] or step["more"]
    return bool(told) or step["asked"] > step["unanswered"]


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


def _first(lines: list[str], most: int) -> list[str]:
    left = len(lines) - most
    more = [f"and {left} more where passes work together"] if left > 0 else []
    return [*lines[:most], *more]


def _some(lines: list[str]) -> str:
    more = f", and of {len(lines) - 1} more" if len(lines) > 1 else ""
    return f"{lines[0]}{more}"


def _text(text: str) -> Text:
    return Text(printable(text))


def _levels(steps: list[Mapping[str, Any]]) -> Table:
    made = Table()
    made.add_column("level")
    made.add_column("step")
    for title in ("seconds", "asked", "unanswered", "failed"):
        made.add_column(title, justify="right")
    made.add_column("wrong passes")
    for step in steps:
        counts = [str(step[name]) for name in ("asked", "unanswered", "failed")]
        words = [step["rung"], step["title"], f"{step['seconds']:.1f}", *counts]
        made.add_row(*map(_text, [*words, ", ".join(step["wrong_passes"])]))
    return made


def _wrong(passes: list[Mapping[str, Any]]) -> Table:
    made = Table(box=None, show_header=False, padding=(0, 1, 0, 0))
    made.add_column(no_wrap=True)
    made.add_column()
    for one in passes:
        made.add_row(_text(one["name"]), _text(one["sentence"]))
        if one["status"] != "by design":  # where no row is wrong
            made.add_row("", _text(one["fault"]))
        made.add_row("", _text(one["conclusion"]))
    return made


def _declared(said: Mapping[str, Any] | None) -> Iterator[str]:
    """What was declared and is followed, and what that does to the light."""
    if said is None:
        return
    yield from (f"declared: {one['told']}" for one in said["followed"])
    for one in said["biases"]:
        yield f"{one['told']}; {'accepted' if one['accepted'] else 'not accepted'}"
    if said["biases"] and said["measured"]:
        yield f"bias of the mean: {said['measured']['told']}"


def _again(one: Mapping[str, Any]) -> Iterator[str]:
    """A typical row of a wrong pass or what a call wrote, and how to ask again."""
    case = one["failing"]
    failure = one["failures"][0] if one["failures"] else None
    # No row is wrong where too many decisions lean on rounding.
    if case is not None and case["shown"]:
        row, kinds = case["shown"][0], case["kinds"]
        where = f"row {row['row']}" if row["x"] is None else f"({row['x']}, {row['y']})"
        inputs = [_named(n, v, kinds.get(n, "f")) for n, v in row["inputs"].items()]
        yield f"{case['case']}, {where}, inputs: {', '.join(inputs)}"
        for name, both in row["outputs"].items():
            if both["excess"] is None or both["excess"] > 1:
                kind = kinds.get(name, "f")
                right = _named(name, both["expected"], kind)
                yield f"  found {_named(name, both['found'], kind)}; expected {right}"
        terms = {name: term["expected"] for name, term in row["terms"].items()}
        if terms:
            each = (_named(name, value, "f") for name, value in terms.items())
            yield f"  terms expected: {', '.join(each)}"
    elif failure is not None and failure["output"]:
        yield f"{failure['case']}: the backend wrote:"
        yield from (f"  {line}" for line in failure["output"].splitlines()[-LAST:])
    line = (case or failure or {}).get("command")
    if line:
        yield f"to ask for this case alone: {line}"


def _named(name: str, value: Any, kind: str) -> str:
    numbers = pieces(value, "–", kind, 6)
    return (
        f"{name} {numbers[0] if len(numbers) == 1 else '(' + ', '.join(numbers) + ')'}"
    )


def pieces(
    value: Any, missing: str = "–", kind: str = "f", digits: int = DIGITS
) -> list[str]:
    """A number of a verdict as it is read, or several.

    One for each number: bits as bits, reals with as many digits as tell two apart.

    Parameters
    ----------
    missing : str; in place of what JSON cannot hold; once, if all are
    kind : str; of NumPy: 'u' for bits, 'i' for whole numbers, else reals
    """
    if isinstance(value, list):
        each = [p for item in value for p in pieces(item, missing, kind, digits)]
        return [missing] if set(each) == {missing} else each
    if value is None:
        return [missing]
    return [
        written(value, "i" if isinstance(value, int) and kind == "f" else kind, digits)
    ]

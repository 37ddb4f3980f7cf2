"""A verdict on pictures for the terminal."""

from collections.abc import Iterator, Mapping
from typing import Any

from rich.console import Group
from rich.table import Table
from rich.text import Text

from restir_gi.reference.oracle.blackbox.judge import with_error
from restir_gi.reference.system.terminal import visible


def table(plain: Mapping[str, Any]) -> Group:
    """A verdict on pictures for the terminal.

    The mean minus the truth of the picture and of its worst tile, what was asked for,
    what accuses, what the pictures agree with otherwise, and last the verdict.
    """
    parts: list[Table | Text] = [_means(plain["means"][:2])] if plain["means"] else []
    parts += [_text(line) for line in _notes(plain) if line not in plain["headline"]]
    return Group(*parts, one_line(plain))


def one_line(plain: Mapping[str, Any]) -> Text:
    """The verdict in a line."""
    return _text(f"{plain['status']}: {plain['backend']}: {plain['headline']}")


def share(of: Mapping[str, Any]) -> str:
    """A mean minus its truth, as a share of the truth."""
    if of["relative"] is None:
        return "no light should be"
    return f"{with_error(of['relative'], of['relative_error'], 100)} %"


def allowed(of: Mapping[str, Any]) -> str:
    """How far a mean may be off, as a share of its truth."""
    if of["margin"] is None:
        return "any"
    return f"± {100 * of['margin'] / of['truth']:.3g} %" if of["truth"] else "0"


def _text(text: str) -> Text:
    return Text(visible(text))


def _means(means: list[Mapping[str, Any]]) -> Table:
    made = Table()
    made.add_column("mean of")
    for title in ("truth", "mean − truth", "of its truth", "tolerance"):
        made.add_column(title, justify="right")
    made.add_column("shown to be within")
    for one, which in zip(means, ("", ", the worst"), strict=True):
        made.add_row(
            one["name"] + which,
            f"{one['truth']:.4g}",
            with_error(one["difference"], one["error"]),
            share(one),
            allowed(one),
            "yes" if one["within"] else "no",
        )
    return made


def _notes(plain: Mapping[str, Any]) -> Iterator[str]:
    asked, truth = plain["convention"], plain["truth"]
    width, height = plain["size"]
    count = plain["pictures"]
    many = "1 picture" if count == 1 else f"{count:,} pictures"
    yield f"asked for: {asked['words']} ({asked['options']}), {width}x{height}"
    yield (
        f"truth: a mean of {truth['mean']:.4g} ± {truth['error']:.2g}, by"
        f" {truth['samples']:,} samples of each pixel; {many} in"
        f" {plain['seconds']:.1f} s"
    )
    if not plain["means"]:
        yield "mean minus truth: not known, for lack of pictures"
    if plain["evidence"]:
        yield f"what accuses: {plain['accuses']}"
    if plain["negative"]:
        yield plain["negative"]
    yield from plain["likenesses"]
    if plain["evidence"] in ("proven", "statistical") and not plain["likenesses"]:
        yield "they agree with no other convention that was tried"
    if plain["wanted"]:
        yield f"about {plain['wanted']:,} pictures would decide"

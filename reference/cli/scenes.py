"""``restir scenes``: list the built-in scenes and what each requires."""

import argparse

from rich.table import Table

from restir_gi.reference.cli.arguments import add_json
from restir_gi.reference.cli.console import emit, show
from restir_gi.reference.scene.catalogue.registry import CATALOGUE
from restir_gi.reference.scene.requirements import requirements


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the arguments."""
    add_json(parser)


def run(arguments: argparse.Namespace) -> None:
    """Print the list."""
    found = {name: requirements(entry.build()) for name, entry in CATALOGUE.items()}
    if arguments.json:
        scenes = [
            {
                "name": name,
                "summary": CATALOGUE[name].summary,
                "answer": CATALOGUE[name].answer,
                "animated": CATALOGUE[name].animate is not None,
                "requires": [
                    {"name": r.name, "why": r.why, "left_out": r.left_out}
                    for r in needs
                ],
            }
            for name, needs in found.items()
        ]
        emit({"scenes": scenes})
        return
    table = Table("scene", "what it shows", "what it requires", show_lines=True)
    for name, needs in found.items():
        entry = CATALOGUE[name]
        answer = f"\nknown: {entry.answer}" if entry.answer else ""
        moves = "\nanimated: --frame T begins at frame T" if entry.animate else ""
        required = ", ".join(need.name for need in needs)
        table.add_row(name, entry.summary + answer + moves, required)
    show(table)

"""``restir scenes``: the built-in scenes and what each requires; or export them."""

import argparse
from functools import partial

from rich.table import Table

from restir_gi.reference.cli.arguments import add_json
from restir_gi.reference.cli.console import emit, show
from restir_gi.reference.cli.targets import new_folder
from restir_gi.reference.cli.values import MOST_SAMPLES, whole
from restir_gi.reference.scene.catalogue.registry import CATALOGUE, find_scene
from restir_gi.reference.scene.exporters.export import built_in_scene, exported
from restir_gi.reference.scene.requirements import requirements
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.files import make_folder, write_file


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the arguments."""
    parser.add_argument(
        "scenes",
        metavar="NAME",
        nargs="*",
        help="built-in scenes (default: all)",
    )
    parser.add_argument(
        "--export",
        type=partial(new_folder, option="--export"),
        metavar="DIR",
        help="write NAME.gltf and NAME.xml (Mitsuba 3) there, with what belongs to"
        " them; a form that cannot say a scene exactly is left out, and why is told",
    )
    parser.add_argument(
        "--frame",
        type=whole(0, MOST_SAMPLES),
        metavar="T",
        help="with --export: of animated scenes the frame to write (default 0)",
    )
    add_json(parser)


def run(arguments: argparse.Namespace) -> None:
    """Print the list, or write the files.

    Raises UsageError: no such scene, one that is named and cannot be said in any form,
    or a file cannot be written.
    """
    names = list(dict.fromkeys(arguments.scenes)) or list(CATALOGUE)
    if arguments.export is not None:
        _export(arguments, names)
    elif arguments.frame is not None:
        raise UsageError(
            "--frame says what --export DIR is to write; the list is of all frames"
        )
    else:
        _list(arguments, names)


def _export(arguments: argparse.Namespace, names: list[str]) -> None:
    frame = arguments.frame or 0
    written = [exported(built_in_scene(name, frame)) for name in names]
    for one in written:
        if arguments.scenes and not one.files:
            raise UsageError("; ".join(one.refused.values()))
    folder = arguments.export
    paths = {name: folder / name for one in written for name in one.files}
    for above in dict.fromkeys(path.parent for path in (folder / "x", *paths.values())):
        make_folder(above)
    for one in written:
        for name, contents in one.files.items():
            write_file(paths[name], contents)
    if arguments.json:
        scenes = [
            {
                "name": one.name,
                "files": [str(paths[name]) for name in one.files],
                "refused": one.refused,
            }
            for one in written
        ]
        emit({"frame": frame, "scenes": scenes})
        return
    for one in written:
        for name in one.files:
            if name.endswith((".gltf", ".xml")):
                show(str(paths[name]))
        for line in one.refused.values():
            show(line)


def _list(arguments: argparse.Namespace, names: list[str]) -> None:
    found = {name: requirements(find_scene(name)) for name in names}
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

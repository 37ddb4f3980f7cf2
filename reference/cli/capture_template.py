"""``restir capture-template``: a folder to dump the buffers of an engine into."""

import argparse

from restir_gi.reference.cli.arguments import add_json
from restir_gi.reference.cli.console import emit, show
from restir_gi.reference.cli.targets import new_folder
from restir_gi.reference.cli.values import frame_numbers, size
from restir_gi.reference.oracle.capture.families import FAMILIES
from restir_gi.reference.oracle.capture.template import template, write_template

SIZE = (1280, 720)
FRAMES = (0, 1, 2, 3)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the arguments."""
    parser.add_argument(
        "--layout",
        choices=tuple(FAMILIES),
        required=True,
        help="of the reservoirs; fields: a layout of your own, field by field",
    )
    parser.add_argument(
        "--out",
        type=new_folder,
        required=True,
        metavar="DIR",
        help="new or empty folder for capture.toml, declaration.toml and README.md",
    )
    parser.add_argument(
        "--size",
        type=size,
        default=SIZE,
        metavar="WxH",
        help=f"pixels of the frames (default {SIZE[0]}x{SIZE[1]})",
    )
    parser.add_argument(
        "--frames",
        type=frame_numbers,
        default=FRAMES,
        metavar="A-B",
        help=f"numbers of the frames (default {FRAMES[0]}-{FRAMES[-1]})",
    )
    add_json(parser)


def run(arguments: argparse.Namespace) -> None:
    """Write the folder.

    Raises UsageError: it holds something else, or cannot be written.
    """
    out, frames = arguments.out, arguments.frames
    width, height = arguments.size
    made = template(arguments.layout, width, height, frames)
    write_template(out, made.files)
    needed = [one for one in made.buffers if not one.dump.optional]
    total = len(frames) * sum(one.bytes for one in needed)
    if arguments.json:
        emit(
            {
                "out": str(out),
                "files": [str(out / name) for name in made.files],
                "frames": list(frames),
                "bytes": total,
                "buffers": [
                    {
                        "name": one.dump.name,
                        "file": one.file,
                        "format": one.dump.form,
                        "bytes": one.bytes,
                        "when": one.dump.when,
                        "optional": one.dump.optional,
                    }
                    for one in made.buffers
                ],
            }
        )
        return
    show(f"{out} holds {', '.join(sorted(made.files))}")
    show(
        f"{out / 'README.md'} lists {len(needed)} buffers to copy in each of"
        f" {len(frames)} frames, {total:,} bytes in all, and"
        f" {len(made.buffers) - len(needed)} that are optional"
    )
    show(f"when they are there, the next command is: restir check {out}")

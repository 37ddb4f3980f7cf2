"""``restir golden``: inputs and expected outputs of every pass, for other backends."""

import argparse

from restir_gi.reference.cli.arguments import add_json, add_reading
from restir_gi.reference.cli.console import emit, progress, remark, show
from restir_gi.reference.cli.targets import new_folder
from restir_gi.reference.cli.values import whole
from restir_gi.reference.oracle.frames import frame_cases
from restir_gi.reference.oracle.golden import write_golden
from restir_gi.reference.oracle.levels.kernels import kernel_probes
from restir_gi.reference.oracle.levels.lattice import lattice_probes
from restir_gi.reference.oracle.levels.replayed import replayed
from restir_gi.reference.oracle.levels.rows import row_probes
from restir_gi.reference.oracle.parts import parts, whole_contract
from restir_gi.reference.oracle.prepared_frame import prepare_frame
from restir_gi.reference.scene.named import find_scene_or_file

SIZE = 64


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the arguments."""
    parser.add_argument(
        "scene",
        metavar="SCENE",
        help="built-in scene or file, of diffuse surfaces alone",
    )
    add_reading(parser)
    parser.add_argument(
        "--out",
        type=new_folder,
        required=True,
        metavar="DIR",
        help="new folder, or a golden one, whose own files are replaced",
    )
    parser.add_argument(
        "--size",
        type=whole(8, 1024),
        default=SIZE,
        metavar="N",
        help=f"pixels of a side of the frame (default {SIZE})",
    )
    parser.add_argument(
        "--seed",
        type=whole(0, 2**27 - 1),
        default=0,
        metavar="S",
        help="of the random numbers (default 0)",
    )
    parser.add_argument(
        "--precision",
        choices=("float32", "float64"),
        default="float32",
        help="of all reals (default float32)",
    )
    add_json(parser)


def run(arguments: argparse.Namespace) -> None:
    """Write the folder.

    Raises UsageError: no such scene, or the folder cannot be written.
    """
    precision, out = arguments.precision, arguments.out
    scene = find_scene_or_file(
        arguments.scene, arguments.lenient, arguments.allow_outside
    )
    at = prepare_frame(scene, arguments.size, arguments.seed)
    probes = [*kernel_probes(precision), *lattice_probes(precision)]
    names = frozenset(whole_contract())
    for part in parts():
        probes += [*part.probes(precision), *part.frames(precision, names)]
    probes += row_probes(precision)
    probes += [replayed("L3", case) for case in frame_cases(at, precision)]
    about = {"scene": scene.name, "size": arguments.size, "seed": arguments.seed}
    with progress("golden") as tick:
        kept = write_golden(out, whole_contract(), precision, probes, about, tick)
    if kept:
        remark(
            f"{out} keeps {len(kept)} files that are not golden data, such as"
            f" {kept[0]}; results there are of the data before"
        )
    if arguments.json:
        emit({"out": str(out), "cases": [p.case.name for p in probes], **about})
        return
    show(f"{out} holds {len(probes)} cases; its index is {out / 'cases.txt'}")

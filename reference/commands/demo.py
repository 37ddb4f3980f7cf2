"""``restir demo``: path tracing, biased and unbiased ReSTIR GI, against the truth."""

import argparse
import json
from argparse import Namespace
from dataclasses import asdict
from pathlib import Path

from reference.commands import arguments as options
from reference.commands.console import emit, progress, show
from reference.commands.metadata import metadata
from reference.commands.opening import open_scene
from reference.commands.reference import EVERY, checkpoint_beside, truth, truth_image
from reference.commands.targets import make_folder
from reference.comparison import compare
from reference.demo.page import table, write_page
from reference.demo.runs import Runs, runs_of_frames, runs_of_paths
from reference.demo.score import Score, scores
from reference.demo.strip import strip
from reference.display import auto_exposure, encode_png, to_display
from reference.exr import write_exr
from reference.files import write_file
from reference.images import Image, to_image
from reference.methods import Job, method_named
from reference.methods.path import PATH, PathSettings
from reference.options import as_text
from reference.scene.scene import Scene
from reference.world import World, build_world

NAME = "demo"
SCENE, SIZE = "door-ajar", (192, 144)
TRUTH_SEED = 2**31
"""Of the truth, and the runs have 0, 1, ...: nothing is compared with itself."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the arguments.

    Parameters
    ----------
    parser : ArgumentParser
        Of this command.
    """
    count = options.whole(2, options.MOST_SAMPLES)
    options.add_scene(parser, nargs="?", default=SCENE)
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder")
    parser.add_argument("--spp", type=count, default=1024, metavar="N", help="of the truth (default 1024)")
    parser.add_argument("--frames", type=count, default=32, metavar="F", help="of ReSTIR GI (default 32)")
    parser.add_argument("--runs", type=options.whole(2, 1000), default=4, metavar="R", help="of each method, with different seeds (default 4)")
    options.add_light(parser, light=False)
    options.add_schedule(parser)
    options.add_json(parser)

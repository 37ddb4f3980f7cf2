"""``restir plan``: what a scene requires, what is left out, and what that changes."""

import argparse
from dataclasses import astuple
from typing import Any

from rich.table import Table

from restir_gi.reference.cli import arguments as options
from restir_gi.reference.cli.console import emit, progress, show
from restir_gi.reference.cli.opening import open_frames
from restir_gi.reference.cli.values import whole
from restir_gi.reference.reports.effects import ALL, Effect, effects
from restir_gi.reference.scene.animation import Animation
from restir_gi.reference.scene.requirements import Requirement, survey
from restir_gi.reference.system.machine import machine

SIDE, FRAMES = 64, 8

MOVES = {
    "nothing": "nothing moves: the past is reused as it stands, J = 1, no rays",
    "camera": "the camera moves: samples are shifted, with Jacobian, visibility and Z",
    "scene": "shapes or lights change: samples are shifted, and looked up again",
}
LEAVES_OUT = {
    "occlusion": "visibility rays between surface points, also in Z",
    "chance": "the last ray of each path, and its weights",
    "glossy": "a look at the materials of all sample points",
    "delta": "paths that leave by delta lobes",
    "motion": "the shift of the past",
    ALL: "",
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the arguments."""
    options.add_scene(parser)
    options.add_bounces(parser, 1)
    parser.add_argument(
        "--frames",
        type=whole(2, 4096),
        default=FRAMES,
        metavar="F",
        help=f"by which the effect is measured (default {FRAMES})",
    )
    options.add_json(parser)


def run(arguments: argparse.Namespace) -> None:
    """Say what is required, and measure what leaving out the rest does.

    Raises UsageError: the scene cannot be read or rendered.
    """
    animation = open_frames(arguments, lambda scene: (SIDE, SIDE))
    needs = [*survey(animation(0)), *_beside_the_scene(arguments, animation)]
    with progress("effects") as tick:
        found = effects(
            animation,
            arguments.bounces,
            arguments.frames,
            lambda done, total: tick(done, total, "frames"),
        )
    if arguments.json:
        emit(_plain(arguments, needs, found))
        return
    show(_needs_table(animation(0).name, needs))
    show(_effects_table(arguments, found))
    show(
        "--no-plan of restir render runs everything. What is left out besides"
        " costs nothing: lights and materials that are not there are empty lists."
    )


def _beside_the_scene(
    arguments: argparse.Namespace, animation: Animation
) -> list[Requirement]:
    changes, bounces = animation.changes, arguments.bounces
    several = f"--bounces {bounces}"
    lit = "of samples, for the method that takes the past as it stands"
    return [
        Requirement("motion", MOVES[changes], left_out=changes == "nothing"),
        Requirement(
            "validation",
            lit if changes == "scene" else "light cannot change between frames",
            left_out=changes != "scene",
        ),
        Requirement("several bounces", several, left_out=bounces == 1),
        Requirement(
            "Jacobians",
            "of spatial reuse"
            + ("" if changes == "nothing" else ", and of the way between frames"),
        ),
    ]


def _needs_table(name: str, needs: list[Requirement]) -> Table:
    table = Table("feature", "", "why", title=f"What {name} requires")
    for need in needs:
        table.add_row(need.name, "left out" if need.left_out else "needed", need.why)
    return table


def _effects_table(arguments: argparse.Namespace, found: list[Effect]) -> Table:
    table = Table(
        "part",
        "what is not run",
        "pictures",
        "time saved",
        title=f"Leaving out, {arguments.frames} frames of unbiased ReSTIR GI",
    )
    for effect in found:
        table.add_row(
            effect.part,
            LEAVES_OUT[effect.part],
            "the same to the last bit" if effect.identical else _bound(effect),
            "{:.0%} [{:.0%}, {:.0%}]".format(*astuple(effect.saved)),
        )
    return table


def _bound(effect: Effect) -> str:
    return (
        f"a pixel by {effect.largest:.2g} of the mean light, the mean by"
        f" {effect.deviation:.2g} of itself"
    )


def _plain(
    arguments: argparse.Namespace, needs: list[Requirement], found: list[Effect]
) -> dict[str, Any]:
    return {
        "scene": arguments.scene,
        "bounces": arguments.bounces,
        "frames": arguments.frames,
        "machine": machine(),
        "features": [
            {"name": n.name, "why": n.why, "left_out": n.left_out} for n in needs
        ],
        "left_out": [
            {
                "part": e.part,
                "identical": e.identical,
                "largest": e.largest,
                "deviation": e.deviation,
                "saved": list(astuple(e.saved)),
            }
            for e in found
        ],
    }

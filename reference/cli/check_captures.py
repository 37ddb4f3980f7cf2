"""``restir check`` of frames that an engine has dumped."""

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from restir_gi.reference.cli.console import progress, remark
from restir_gi.reference.oracle.backends.running import Limits
from restir_gi.reference.oracle.capture.cases import recorded_of
from restir_gi.reference.oracle.capture.judge import judge_captured
from restir_gi.reference.oracle.capture.manifest import NAME
from restir_gi.reference.oracle.capture.record import Capture
from restir_gi.reference.oracle.declaration.declared import NOTHING_DECLARED
from restir_gi.reference.oracle.declaration.read import read_declaration, with_names
from restir_gi.reference.oracle.parts import SEED
from restir_gi.reference.oracle.verdict import Verdict
from restir_gi.reference.scene.named import find_scene_or_file
from restir_gi.reference.scene.validation import validate
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.transport.world import World, build_world

OF_CALLS: Mapping[str, Any] = {
    "against": None,
    "case": None,
    "only": frozenset(),
    "skip": frozenset(),
    "require": frozenset(),
    "keep": None,
    "quick": False,
    "scheduler": None,
    "seed": SEED,
    "limit": Limits().seconds,
    "precision": "float32",
}
"""Options that say nothing to frames that are there, and what they are if not given."""


def is_capture(name: str) -> bool:
    """Whether this is a folder with a manifest of a capture, or such a manifest."""
    try:
        path = Path(name)
        return (path / NAME).is_file() or (path.suffix == ".toml" and path.is_file())
    except OSError:  # a command line may be longer than any name
        return False


def _world(capture: Capture) -> World | None:
    """The scene of a capture, made ready for rays.

    Raises UsageError: there is no such scene, or it cannot be read.
    """
    if capture.scene is None:
        return None
    beside = capture.folder / capture.scene if capture.folder else Path(capture.scene)
    name = str(beside) if beside.exists() else capture.scene
    return build_world(validate(find_scene_or_file(name), may_be_dark=True))


def judge_capture(arguments: argparse.Namespace) -> Verdict:
    """The verdict on a capture.

    Raises UsageError: manifest, declaration or buffers are wrong, or an option asks for
    what only a backend can do.
    """
    for option, default in OF_CALLS.items():
        if getattr(arguments, option) != default:
            raise UsageError(
                f"--{option} says nothing to a capture, whose frames are as they are;"
                " leave it out"
            )
    with progress("check") as tick:
        tick(0, 1, "reading buffers")
        capture = Capture.read(arguments.backend)
        for note in capture.notes:
            remark(note)
        file = arguments.declaration or capture.declaration
        said = NOTHING_DECLARED if file is None else read_declaration(file)
        said = with_names(said, arguments.declare, arguments.accept)
        tick(0, 1, "tracing visibility")
        return judge_captured(
            recorded_of(capture, _world(capture), said.shading_sees),
            arguments.budget,
            said,
            arguments.extremes,
            tell=lambda title: tick(0, 1, title),
        )

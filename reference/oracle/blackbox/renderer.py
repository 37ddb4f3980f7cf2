"""A renderer as a command line that writes one picture."""

import shlex
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.images.exr import read_exr
from restir_gi.reference.images.exr_parts import decode
from restir_gi.reference.oracle.backends.running import Limits, run_program
from restir_gi.reference.oracle.backends.workspace import Workspace
from restir_gi.reference.oracle.cases import (
    NO_TIME,
    Failure,
    Remaining,
    Unasked,
    UnaskedError,
    for_ever,
)
from restir_gi.reference.oracle.raw import MOST_TIMES
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.files import read_file

SIDES = ("{width}", "{height}", "{size}")
PLACES = ("{scene}", "{seed}", "{frames}", *SIDES, "{out}")
"""What stands in the template: the last is needed, and so is the seed.

``{size}`` is both sides of a square picture."""

MOST_CHANNELS, CHANNEL_BYTES = 64, 4
"""A picture of more, without any compression, is not read."""


@dataclass(frozen=True, slots=True)
class Renderer:
    """A command line that renders.

    Attributes
    ----------
    template : str; with `PLACES` in it
    scene : str; what the renderer knows the scene by
    frames : int; from an empty history to the picture
    remaining : callable; seconds that are left: no picture takes longer
    left_running : list of int
        Takes how many processes each picture left, which were ended.
    layer : str, optional; which of several pictures in its file is meant
    """

    template: str
    scene: str
    frames: int
    size: tuple[int, int]
    limits: Limits
    remaining: Remaining = for_ever
    left_running: list[int] = field(default_factory=list)
    layer: str | None = None

    def render(self, seed: int) -> NDArray[Any] | Failure:
        """One picture, from nothing, (height, width, 3) float32, or Failure; radiance.

        Parameters
        ----------
        seed : int; runs of different seeds are independent

        Raises
        ------
        UsageError
            There is no such program, or no room for its picture.
        UnaskedError
            No time was left, or it was killed from outside.
        """
        workspace = Workspace("render")
        try:
            return self._rendered(seed, workspace)
        finally:
            self.left_running.append(workspace.close())

    def _rendered(self, seed: int, workspace: Workspace) -> NDArray[Any] | Failure:
        out = workspace.folder / "picture.exr"
        words, left = self._words(seed, out), self.remaining()
        if left <= 0:
            raise UnaskedError(f"seed {seed}: {NO_TIME.reason}")
        trouble = run_program(words, self.limits, left, workspace.environment)
        if isinstance(trouble, Unasked):
            raise UnaskedError(f"seed {seed}: the renderer {trouble.reason}")
        found = self._read(seed, out) if trouble is None else trouble
        if isinstance(found, Failure):
            workspace.need_room(CHANNEL_BYTES * self.size[0] * self.size[1])
        if trouble is not None:
            return Failure(f"seed {seed}: the renderer {trouble.reason}")
        return found

    def _read(self, seed: int, out: Path) -> NDArray[Any] | Failure:
        pixels = self.size[0] * self.size[1]
        try:
            contents = read_file(out, MOST_CHANNELS * CHANNEL_BYTES * pixels + 2**20)
            decode(out, contents, MOST_TIMES * pixels)
            color = read_exr(out, self.layer).color
        except UsageError as error:
            return Failure(f"seed {seed}: {error}")
        height, width = color.shape[:2]
        if (width, height) != self.size:
            asked = "x".join(map(str, self.size))
            return Failure(
                f"seed {seed}: the picture is {width}x{height} instead of {asked}"
            )
        bad = ~np.isfinite(color).all(axis=2)
        if bad.any():
            y, x = np.argwhere(bad)[0]
            return Failure(f"seed {seed}: pixel ({x}, {y}) is not finite")
        return color

    def _words(self, seed: int, out: Path) -> list[str]:
        width, height = self.size
        if width != height and "{size}" in self.template:
            raise UsageError(
                f"{{size}} is a side of a square picture, and this one is"
                f" {width}x{height}; write {{width}} and {{height}}, or use --size N"
            )
        sides = (str(width), str(height), str(width))
        given = (self.scene, str(seed), str(self.frames), *sides, str(out))
        try:
            words = shlex.split(self.template)
        except ValueError as error:
            raise UsageError(
                f"{self.template!r} is not a command line: {error}"
            ) from error
        for place, text in zip(PLACES, given, strict=True):
            words = [word.replace(place, text) for word in words]
        return words

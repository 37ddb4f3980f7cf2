"""A renderer as a command line that writes one picture."""

import shlex
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import islice
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
PLACES = ("{scene}", "{seed}", "{frames}", *SIDES, "{out}", "{list}")
"""What stands in the template.

``{out}`` names the picture to write, and ``{seed}`` its seed; or else ``{list}`` names
a file with a line for each of several pictures: its seed, a space, and its name.
``{size}`` is both sides of a square picture."""

AT_ONCE = 8
"""Pictures of one list."""

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

    @property
    def makes_several(self) -> bool:
        """Whether one call makes the pictures of a list."""
        return "{list}" in self.template

    def render(self, seed: int) -> NDArray[Any] | Failure:
        """One picture, from nothing, (H, W, 3) float32, or Failure; radiance.

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
        return self.render_several((seed,))[0]

    def render_several(self, seeds: Sequence[int]) -> list[NDArray[Any] | Failure]:
        """As `render`, of several seeds in one call.

        Returns
        -------
        list of (H, W, 3) float32 or Failure; in their order; one Failure if the call
        has failed
        """
        workspace = Workspace("render")
        try:
            return self._rendered(seeds, workspace)
        finally:
            self.left_running.append(workspace.close())

    def pictures(self, seeds: Iterable[int]) -> Iterator[NDArray[Any] | Failure]:
        """Pictures of ever more seeds, one call after the other.

        Yields
        ------
        (H, W, 3) float32, or Failure
        """
        left, count = iter(seeds), AT_ONCE if self.makes_several else 1
        while some := tuple(islice(left, count)):
            yield from self.render_several(some)

    def _rendered(
        self, seeds: Sequence[int], workspace: Workspace
    ) -> list[NDArray[Any] | Failure]:
        outs = [workspace.folder / f"picture{seed}.exr" for seed in seeds]
        listed = workspace.folder / "pictures.txt"
        lines = [f"{seed} {out}\n" for seed, out in zip(seeds, outs, strict=True)]
        listed.write_text("".join(lines), encoding="utf-8")
        words, left = self._words(seeds[0], outs[0], listed), self.remaining()
        which = f"seed {seeds[0]}" + (f" to {seeds[-1]}" if len(seeds) > 1 else "")
        if left <= 0:
            raise UnaskedError(f"{which}: {NO_TIME.reason}")
        trouble = run_program(
            words, self.limits, left, workspace.environment, len(seeds)
        )
        if isinstance(trouble, Unasked):
            raise UnaskedError(f"{which}: the renderer {trouble.reason}")
        if trouble is not None:
            self._need_room(workspace)
            return [Failure(f"{which}: the renderer {trouble.reason}")]
        found = [self._read(*one) for one in zip(seeds, outs, strict=True)]
        if any(isinstance(one, Failure) for one in found):
            self._need_room(workspace)
        return found

    def _need_room(self, workspace: Workspace) -> None:
        workspace.need_room(CHANNEL_BYTES * self.size[0] * self.size[1])

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

    def _words(self, seed: int, out: Path, listed: Path) -> list[str]:
        width, height = self.size
        if width != height and "{size}" in self.template:
            raise UsageError(
                f"{{size}} is a side of a square picture, and this one is"
                f" {width}x{height}; write {{width}} and {{height}}, or use --size N"
            )
        sides = (str(width), str(height), str(width))
        given = (self.scene, str(seed), str(self.frames), *sides, str(out), str(listed))
        try:
            words = shlex.split(self.template)
        except ValueError as error:
            raise UsageError(
                f"{self.template!r} is not a command line: {error}"
            ) from error
        for place, text in zip(PLACES, given, strict=True):
            words = [word.replace(place, text) for word in words]
        return words

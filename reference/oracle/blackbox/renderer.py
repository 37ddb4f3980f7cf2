"""A renderer as a command line that writes one picture."""

import shlex
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reference.errors import UsageError
from reference.exr import read_exr
from reference.oracle.backends.running import Limits, run_program
from reference.oracle.cases import Failure

SIDES = ("{width}", "{height}", "{size}")
PLACES = ("{scene}", "{seed}", "{frames}", *SIDES, "{out}")
"""What stands in the template: the last is needed, and so is the seed.

``{size}`` is both sides of a square picture."""


@dataclass(frozen=True, slots=True)
class Renderer:
    """A command line that renders.

    Attributes
    ----------
    template : str
        With `PLACES` in it.
    scene : str
        What the renderer knows the scene by.
    frames : int
        From an empty history to the picture.
    size : (int, int), pixels
        Width and height.
    limits : Limits
        Of time and memory.
    layer : str, optional
        Which of several pictures in its file is meant.
    """

    template: str
    scene: str
    frames: int
    size: tuple[int, int]
    limits: Limits
    layer: str | None = None

    def render(self, seed: int) -> NDArray[Any] | Failure:
        """One picture, from nothing.

        Parameters
        ----------
        seed : int
            Runs of different seeds are independent.

        Returns
        -------
        (height, width, 3) float32, or Failure
            Radiance.

        Raises
        ------
        UsageError
            There is no such program.
        """
        with tempfile.TemporaryDirectory(prefix="restir-render-") as folder:
            out = Path(folder) / "picture.exr"
            words, limits = self._words(seed, out), self.limits
            trouble = run_program(words, limits.seconds, limits.memory)
            if trouble is not None:
                return Failure(f"seed {seed}: the renderer {trouble}")
            return self._read(seed, out)

    def _read(self, seed: int, out: Path) -> NDArray[Any] | Failure:
        try:
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
                f"{self.template!r} is no command line: {error}"
            ) from error
        for place, text in zip(PLACES, given, strict=True):
            words = [word.replace(place, text) for word in words]
        return words

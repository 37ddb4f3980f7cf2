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

PLACES = ("{scene}", "{seed}", "{frames}", "{size}", "{out}")
"""What stands in the template: the last is needed, and so is the seed."""


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
    size : int, pixels
        Width and height.
    limits : Limits
        Of time and memory.
    """

    template: str
    scene: str
    frames: int
    size: int
    limits: Limits

    def render(self, seed: int) -> NDArray[Any] | Failure:
        """One picture, from nothing.

        Parameters
        ----------
        seed : int
            Runs of different seeds are independent.

        Returns
        -------
        (size, size, 3) float32, or Failure
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
            color = read_exr(out).color
        except UsageError as error:
            return Failure(f"seed {seed}: {error}")
        if color.shape[:2] != (self.size, self.size):
            height, width = color.shape[:2]
            return Failure(
                f"seed {seed}: the picture is {width}x{height} instead of"
                f" {self.size}x{self.size}"
            )
        bad = ~np.isfinite(color).all(axis=2)
        if bad.any():
            y, x = np.argwhere(bad)[0]
            return Failure(f"seed {seed}: pixel ({x}, {y}) is not finite")
        return color

    def _words(self, seed: int, out: Path) -> list[str]:
        given = (self.scene, str(seed), str(self.frames), str(self.size), str(out))
        try:
            words = shlex.split(self.template)
        except ValueError as error:
            raise UsageError(
                f"{self.template!r} is no command line: {error}"
            ) from error
        for place, text in zip(PLACES, given, strict=True):
            words = [word.replace(place, text) for word in words]
        return words

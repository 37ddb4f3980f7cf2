"""Outputs that a backend wrote beside golden inputs, at some other time or place."""

import os
from pathlib import Path

from restir_gi.reference.oracle.cases import Case, Outcome, for_ever
from restir_gi.reference.oracle.contract.fields import Passes, Precision
from restir_gi.reference.oracle.exr_frames import read_frames
from restir_gi.reference.oracle.raw import read_outputs


class FilesBackend:
    """Files in a golden folder, or in another one with the same names.

    Parameters
    ----------
    folder : Path; holds ``CASE/out/*.raw``, ``CASE/out.npz`` or ``CASE/out/out.exr``
    """

    def __init__(self, folder: Path, precision: Precision) -> None:
        self._folder = folder
        self.precision: Precision = precision

    def run(self, passes: Passes, cases: list[Case]) -> list[Outcome]:
        """Read the outputs of cases; ``None`` where nothing was written."""
        return [self._read(passes, case) for case in cases]

    def remaining(self) -> float:
        """Files are there at once."""
        return for_ever()

    def close(self) -> int:
        """Nothing is held."""
        return 0

    def _read(self, passes: Passes, case: Case) -> Outcome:
        frames = self._folder / case.name / "out" / "out.exr"
        if os.path.lexists(frames):
            return read_frames(frames, passes, case)
        return read_outputs(self._folder, passes, self.precision, case)

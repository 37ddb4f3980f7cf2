"""The folder in which runs are kept: what is there need not be run again.

Each run is a file of its own, named by point and seed and written in one step: a run
that is done twice, by a worker that was thought lost, counts once.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from zipfile import BadZipFile

import numpy as np

from restir_gi.reference.reports.tradeoff.trials import Task, Trial
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.files import make_folder, read_file, write_file
from restir_gi.reference.truth.checkpoint import what_differs


@dataclass(frozen=True, slots=True)
class Store:
    """Runs of one scene.

    Attributes
    ----------
    folder : Path; where they are
    """

    folder: Path

    def path(self, task: Task) -> Path:
        """File of a run; it need not exist."""
        name = f"{task.seed}-after-{task.change}" if task.change else f"{task.seed}"
        return self.folder / task.point.key / f"{name}.npz"

    def put(self, task: Task, trial: Trial) -> None:
        """Keep a run.

        Raises UsageError: the file cannot be written.
        """
        words = {"seconds": trial.seconds, "rays": trial.rays, "kept": trial.kept}
        buffer = BytesIO()
        np.savez(
            buffer,
            words=np.array(json.dumps(words)),
            color=trial.color,
            mean=trial.mean,
            tiles=trial.tiles,
        )
        path = self.path(task)
        make_folder(path.parent)
        write_file(path, buffer.getvalue())

    def get(self, task: Task) -> Trial:
        """A run that is kept.

        Raises UsageError: it is not there, or damaged.
        """
        path = self.path(task)
        contents = read_file(path)
        # Damage shows as whatever the reader trips over first.
        try:
            with np.load(BytesIO(contents), allow_pickle=False) as file:
                words = json.loads(str(file["words"]))
                arrays = (file[name] for name in ("color", "mean", "tiles"))
                return Trial(*arrays, **words)
        except (ValueError, KeyError, TypeError, EOFError, BadZipFile) as error:
            raise UsageError(
                f"{path} is not a run, or is damaged; delete it to run it again"
            ) from error


def open_store(folder: Path, identity: Mapping[str, str]) -> Store:
    """Open the folder of a sweep, and only of the same sweep.

    What was done before is there.

    Raises UsageError: it holds runs of another scene, size or version: the message says
    what differs.

    Parameters
    ----------
    folder : Path; made if it is missing
    identity : mapping of str to str
        Everything but point and seed that decides what a run is.
    """
    path = folder / "identity.json"
    if path.exists():
        try:
            before = dict(json.loads(read_file(path)))
        except ValueError as error:
            raise UsageError(
                f"{path} is damaged; delete {folder} to start over"
            ) from error
        if differences := what_differs(before, identity):
            raise UsageError(
                f"{folder} holds other runs ({differences}); delete it to start"
                " over, or name another --out"
            )
    make_folder(folder)
    write_file(path, json.dumps(dict(identity), indent=2).encode())
    return Store(folder)

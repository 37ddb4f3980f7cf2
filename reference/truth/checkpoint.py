"""A file from which an accumulation goes on, and only the same accumulation.

An NPZ of the running sums, and of the run that they belong to as JSON.  It is replaced
in one step, so that a run that is killed finds the state before or the state after.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from restir_gi.reference.numerics.moments import Moments
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.files import read_file, write_file


@dataclass(frozen=True, slots=True, eq=False)
class Checkpoint:
    """State of an accumulation.

    Attributes
    ----------
    moments : Moments; of all samples so far
    seconds : float; spent on them
    rays : mapping of str to int; traced for them, by kind
    """

    moments: Moments
    seconds: float
    rays: Mapping[str, int]


def save_checkpoint(path: Path, run: Mapping[str, str], state: Checkpoint) -> None:
    """Write a checkpoint.

    Raises UsageError: the file cannot be written; see `write_file`.

    Parameters
    ----------
    path : Path; replaced in one step
    run : mapping of str to str
        Everything that decides what a sample of a given number is.
    """
    words = {
        "run": dict(run),
        "count": state.moments.count,
        "seconds": state.seconds,
        "rays": dict(state.rays),
    }
    buffer = BytesIO()
    np.savez(
        buffer,
        words=np.array(json.dumps(words)),
        mean=state.moments.mean,
        squares=state.moments.squares,
    )
    write_file(path, buffer.getvalue())


def load_checkpoint(path: Path, run: Mapping[str, str]) -> Checkpoint | None:
    """Read the checkpoint of a run; None if there is no such file.

    Raises UsageError: unreadable or damaged, or of another run: the message says what
    differs.

    Parameters
    ----------
    path : Path; where `save_checkpoint` wrote
    """
    if not path.exists():
        return None
    remedy = "delete it to start over, or name another --out"
    try:
        words, moments = _decode(read_file(path))
    # Damage shows as whatever the reader trips over first.
    except (ValueError, KeyError, TypeError, OSError, EOFError, BadZipFile) as error:
        raise UsageError(
            f"{path} is not a checkpoint, or is damaged; {remedy}"
        ) from error
    if differences := what_differs(words["run"], run):
        raise UsageError(
            f"{path} is the checkpoint of another run ({differences}); {remedy}"
        )
    return Checkpoint(moments, words["seconds"], words["rays"])


def what_differs(there: Mapping[str, str], wanted: Mapping[str, str]) -> str:
    """Where a run that was kept is not the one that is wanted.

    Empty where they are the same.

    Parameters
    ----------
    there, wanted : mapping of str to str; everything that decides what a run is
    """
    return "; ".join(
        f"{key} {there.get(key)}, not {wanted.get(key)}"
        for key in sorted({*there, *wanted})
        if there.get(key) != wanted.get(key)
    )


def _decode(contents: bytes) -> tuple[dict[str, Any], Moments]:
    with np.load(BytesIO(contents), allow_pickle=False) as file:
        words = json.loads(str(file["words"]))
        mean, squares = file["mean"], file["squares"]
    whole = {"run": dict, "count": int, "seconds": float, "rays": dict}
    if any(not isinstance(words[key], kind) for key, kind in whole.items()):
        raise TypeError("a value of the wrong type")
    if mean.shape != squares.shape or mean.shape[1:] != (3,) or words["count"] < 1:
        raise ValueError("arrays of the wrong shape")
    for array in (mean, squares):
        if array.dtype != np.float64 or not np.isfinite(array).all():
            raise ValueError("values that no accumulation leaves")
    return words, Moments(words["count"], mean, squares)

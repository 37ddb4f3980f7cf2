"""The other side of a process boundary: runs a Python backend on folders of cases.

Started by :mod:`restir_gi.reference.oracle.backends.process`.  On stdin comes the path
of a folder a line; on the real stdout go ``ready`` with the precision, what the
backend offers and its declaration, then for each case ``begin``, and ``end``,
``absent`` or ``failed`` with a reason and a traceback, then ``done``; what stands after
these words is JSON.  What the backend prints itself goes to stderr.
"""

import json
import os
import sys
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from restir_gi.reference.oracle.backends.find import find_object
from restir_gi.reference.oracle.backends.offer import (
    declaration_of,
    offer_of,
    shown_traceback,
)
from restir_gi.reference.oracle.backends.running import bind
from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.host_arrays import answered_arrays
from restir_gi.reference.oracle.raw import read_cases


def main(spec: str, memory: int, names: tuple[str, ...]) -> None:
    """Serve until stdin ends.

    Parameters
    ----------
    memory : int, bytes; that it may use
    names : tuple of str; passes of the contract
    """
    bind(memory)
    channel = os.fdopen(os.dup(1), "w", buffering=1, errors="backslashreplace")
    os.dup2(2, 1)  # a backend's prints must not be taken for answers
    try:
        backend = find_object(spec)
        precision = getattr(backend, "precision", "float32")
        declaration = declaration_of(backend)
        if precision not in ("float32", "float64"):
            raise ValueError(
                f"its precision is {precision!r}, and should be 'float32' or 'float64'"
            )
    except Exception as error:
        _say(channel, f"failed cannot be loaded: {_words(error)}")
        return
    offer = offer_of(backend, names).as_plain()
    _say(channel, f"ready {json.dumps([precision, offer, declaration])}")
    for line in sys.stdin:
        folder = Path(line.rstrip("\n"))
        for case in read_cases(folder)[1]:
            _say(channel, "begin")
            _say(channel, _run(backend, folder, case))
        _say(channel, "done")


def _run(backend: Any, folder: Path, case: Case) -> str:
    method = getattr(backend, case.pass_name, None)
    if method is None:
        return "absent"
    try:
        outputs = method(**case.inputs, **case.settings)
        arrays = answered_arrays(outputs)
        np.savez(folder / case.name / "out.npz", allow_pickle=False, **arrays)
    except NotImplementedError:
        return "absent"
    except Exception as error:
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        return f"failed {json.dumps([_words(error), shown_traceback(error)])}"
    return "end"


def _words(error: BaseException) -> str:
    try:
        text = str(error)
    except Exception:  # what a backend raises is its own too
        text = ""
    text = " ".join(text.split())[:300]
    return f"{type(error).__name__}: {text}" if text else type(error).__name__


def _say(channel: TextIO, text: str) -> None:
    channel.write(text + "\n")
    channel.flush()


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), tuple(sys.argv[3:]))

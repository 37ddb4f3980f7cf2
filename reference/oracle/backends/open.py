"""Reaching a backend: an object, a name, a file, or a command line."""

from typing import Any

from reference.errors import UsageError
from reference.oracle.backends.backend import Backend
from reference.oracle.backends.command import PLACE, ProgramBackend
from reference.oracle.backends.find import backend_names, is_python
from reference.oracle.backends.inside import InsideBackend
from reference.oracle.backends.process import PythonBackend
from reference.oracle.backends.running import Limits
from reference.oracle.contract.fields import Precision
from reference.suggestions import unknown


def open_backend(backend: Any, limits: Limits, precision: Precision) -> Backend:
    """Reach a backend.

    Parameters
    ----------
    backend : object or str
        As for `judge`.
    limits : Limits
        Of time and memory.
    precision : 'float32' or 'float64'
        Of a program.

    Returns
    -------
    Backend
        To be closed.

    Raises
    ------
    UsageError
        There is none.
    """
    if not isinstance(backend, str):
        found: Backend = backend if hasattr(backend, "run") else InsideBackend(backend)
        return found
    if PLACE in backend:
        return ProgramBackend(backend, limits, precision)
    if is_python(backend):
        return PythonBackend(backend, limits)
    every = (
        f"{', '.join(backend_names())}, module:object, file.py[:object], a command"
        f" line with {PLACE}, or a golden folder"
    )
    raise UsageError(unknown("backend", backend, backend_names(), every))

"""Reaching a backend: an object, a name, a file, or a command line."""

from typing import Any

from restir_gi.reference.oracle.backends.backend import Backend
from restir_gi.reference.oracle.backends.command import PLACE, ProgramBackend
from restir_gi.reference.oracle.backends.find import backend_names, is_python
from restir_gi.reference.oracle.backends.inside import InsideBackend
from restir_gi.reference.oracle.backends.process import PythonBackend
from restir_gi.reference.oracle.backends.running import Limits
from restir_gi.reference.oracle.cases import Remaining, for_ever
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.suggestions import unknown


def open_backend(
    backend: Any,
    limits: Limits,
    precision: Precision,
    remaining: Remaining = for_ever,
    names: tuple[str, ...] = (),
) -> Backend:
    """Reach a backend.

    Raises UsageError: there is none.
    Raises UnaskedError: it was not ready before the time was over.

    Parameters
    ----------
    remaining : callable; seconds that are left: no call lasts longer
    names : tuple of str; passes of the contract, to see which of them an object has
    """
    if not isinstance(backend, str):
        inside: Backend = InsideBackend(backend, remaining, names)
        return backend if hasattr(backend, "run") else inside
    if PLACE in backend:
        return ProgramBackend(backend, limits, precision, remaining)
    if is_python(backend):
        return PythonBackend(backend, limits, remaining, names)
    every = (
        f"{', '.join(backend_names())}, module:object, file.py[:object], a command"
        f" line with {PLACE}, or a golden folder"
    )
    raise UsageError(unknown("backend", backend, backend_names(), every))

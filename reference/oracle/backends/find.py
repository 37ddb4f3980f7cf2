"""Backends by name: built-in, of a plug-in, a module's or a file's object."""

import importlib
import importlib.util
import sys
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

from restir_gi.reference.system.errors import UsageError

GROUP = "restir.backends"
BUILT_IN = ("float32", "float64")
ATTRIBUTE = "BACKEND"


def backend_names() -> list[str]:
    """Names of built-in and registered backends.  Nothing is imported."""
    return [*BUILT_IN, *sorted(point.name for point in entry_points(group=GROUP))]


def is_python(spec: str) -> bool:
    """Whether a word on the command line means a Python object.

    Its form decides; whether the object exists is found out where it runs.

    Parameters
    ----------
    spec : str; as `find_object` takes it, or anything else
    """
    path, _, _ = spec.partition(":")
    module = ":" in spec and all(part.isidentifier() for part in path.split("."))
    return spec in backend_names() or path.endswith(".py") or module


def find_object(spec: str) -> Any:
    """The object that a backend is.

    Raises UsageError: there is none.

    Parameters
    ----------
    spec : str
        A name of `backend_names`, ``module:attribute`` or ``file.py[:attribute]``; the
        attribute is ``BACKEND`` where it is not given.
    """
    if spec in BUILT_IN:
        from restir_gi.reference.oracle.builtin.backend import FLOAT32, FLOAT64

        return FLOAT32 if spec == "float32" else FLOAT64
    for point in entry_points(group=GROUP, name=spec):
        return point.load()
    path, _, attribute = spec.partition(":")
    module = _load_file(Path(path)) if path.endswith(".py") else _load_module(path)
    try:
        return getattr(module, attribute or ATTRIBUTE)
    except AttributeError as error:
        raise UsageError(
            f"{path} has no {attribute or ATTRIBUTE!r}; name the object after a colon"
        ) from error


def _load_module(name: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise UsageError(f"cannot import {name}: {error}") from error


def _load_file(path: Path) -> Any:
    if not path.is_file():
        raise UsageError(f"no file {path}; name one that holds a backend")
    name = f"backend_{path.stem}"
    found = importlib.util.spec_from_file_location(name, path)
    assert found is not None
    assert found.loader is not None
    module = importlib.util.module_from_spec(found)
    sys.modules[name] = module  # dataclasses look their module up
    sys.path.insert(0, str(path.parent))
    found.loader.exec_module(module)
    return module

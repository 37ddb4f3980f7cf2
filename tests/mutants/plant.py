"""Plant a mistake in the running process, and take it out again.

Functions keep their identity and get another code object: whoever has imported one by
name, or keeps it in a table, runs the edited code, and classes remain what they were.
"""

import importlib
import inspect
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import cache
from types import FunctionType, ModuleType
from typing import Any

PACKAGE = "restir_gi"
PARTS = ("__code__", "__defaults__", "__kwdefaults__")
CONSTANTS = (bool, int, float, str, tuple)


@contextmanager
def planted(mutant: Any) -> Iterator[None]:
    """All edits of a mutant, while the block runs.

    Parameters
    ----------
    mutant : object with ``edits``, of (module, old, new)
        ``old`` occurs once in the source of the module, which is named with dots.

    Yields
    ------
    None
        Afterwards everything is as it was, whatever happened.
    """
    with ExitStack() as undo:
        for module, changes in _by_module(mutant.edits).items():
            undo.enter_context(_edited(importlib.import_module(module), changes))
        yield


def source_of(module: str) -> str:
    """Source of a module, by its dotted name."""
    return inspect.getsource(importlib.import_module(module))


def _by_module(edits: Any) -> dict[str, tuple[tuple[str, str], ...]]:
    found: dict[str, tuple[tuple[str, str], ...]] = {}
    for module, old, new in edits:
        found[module] = (*found.get(module, ()), (old, new))
    return found


@contextmanager
def _edited(module: ModuleType, changes: tuple[tuple[str, str], ...]) -> Iterator[None]:
    names = _run(module.__name__, changes)
    before = vars(module).copy()
    ours, theirs = (
        _functions(module.__name__, before),
        _functions(module.__name__, names),
    )
    kept = {
        f: [getattr(f, part) for part in PARTS]
        for name, f in ours.items()
        if name in theirs
    }
    rebound: list[tuple[ModuleType, str, Any]] = []
    try:
        for name, value in names.items():
            if name not in before:
                setattr(module, name, value)
            elif isinstance(value, CONSTANTS) and value != before[name]:
                rebound += _rebind(name, before[name], value)
        for name, function in ours.items():
            if name in theirs:
                # Defaults are data of the original classes: only code may differ.
                function.__code__ = theirs[name].__code__
                if _plain(theirs[name].__defaults__):
                    function.__defaults__ = theirs[name].__defaults__
        yield
    finally:
        for function, parts in kept.items():
            for part, value in zip(PARTS, parts, strict=True):
                setattr(function, part, value)
        for holder, name, value in rebound:
            setattr(holder, name, value)
        for name in names.keys() - before.keys():
            delattr(module, name)


@cache
def _run(name: str, changes: tuple[tuple[str, str], ...]) -> dict[str, Any]:
    """Names that the edited source defines; the module itself is left alone."""
    source = source_of(name)
    for old, new in changes:
        if source.count(old) != 1:
            raise ValueError(f"{name} has {source.count(old)} times {old!r}, not once")
        source = source.replace(old, new)
    module = sys.modules[name]
    names: dict[str, Any] = {"__name__": name, "__package__": module.__package__}
    exec(compile(source, str(module.__file__), "exec"), names)
    del names["__builtins__"]
    return {key: value for key, value in names.items() if not key.startswith("__")}


def _functions(module: str, names: dict[str, Any]) -> dict[str, FunctionType]:
    """Functions and methods that a module's source defines, by qualified name."""
    found: dict[str, FunctionType] = {}
    for value in names.values():
        if getattr(value, "__module__", None) != module:
            continue
        members = vars(value).values() if isinstance(value, type) else [value]
        for member in members:
            function = next(
                (
                    getattr(member, part)
                    for part in ("fget", "func", "__func__")
                    if getattr(member, part, None) is not None
                ),
                member,
            )
            written = isinstance(function, FunctionType)
            # What dataclasses generate has no source, and remains.
            if written and not function.__code__.co_filename.startswith("<"):
                found[function.__qualname__] = function
    return found


def _plain(defaults: tuple[Any, ...] | None) -> bool:
    return defaults is None or all(
        value is None or isinstance(value, CONSTANTS) for value in defaults
    )


def _rebind(name: str, old: Any, new: Any) -> list[tuple[ModuleType, str, Any]]:
    """Give a constant another value wherever it was imported under its own name."""
    undo = []
    for key, module in list(sys.modules.items()):
        if key.split(".")[0] == PACKAGE and vars(module).get(name) is old:
            undo.append((module, name, old))
            setattr(module, name, new)
    return undo


def is_refuted(evidence: Callable[[], object]) -> bool:
    """Whether a test fails: by what it asserts, or because nothing comes out.

    Parameters
    ----------
    evidence : callable
        The test, with its arguments.

    Returns
    -------
    bool
        Any other error is none of a test's.
    """
    try:
        evidence()
    except (AssertionError, IndexError, ValueError):
        return True
    return False

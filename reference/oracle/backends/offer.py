"""What a Python object offers: which passes, and which names that look like one."""

import json
import traceback
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from difflib import get_close_matches
from os import PathLike, fspath
from typing import Any

from restir_gi.reference.oracle.backends.running import SHOWN
from restir_gi.reference.system.errors import UsageError

LIKENESS = 0.75
"""Ratio of `difflib` from which a name looks like another: `jacobain`, `targets`."""


@dataclass(frozen=True, slots=True)
class Offer:
    """Passes of an object.

    Attributes
    ----------
    passes : frozenset of str; those that it has
    near : tuple of (str, str)
        Methods that are no pass, each with the pass that it lacks and looks like.
    """

    passes: frozenset[str]
    near: tuple[tuple[str, str], ...] = ()

    def as_plain(self) -> list[Any]:
        """For JSON."""
        return [sorted(self.passes), [list(pair) for pair in self.near]]

    @staticmethod
    def from_plain(plain: list[Any]) -> "Offer":
        """From what `as_plain` gave."""
        passes, near = plain
        return Offer(frozenset(passes), tuple((name, like) for name, like in near))


def offer_of(target: Any, names: Iterable[str]) -> Offer:
    """What an object offers, without calling anything of it but its attributes.

    Parameters
    ----------
    names : iterable of str; passes of the contract
    """
    every = list(names)
    has = frozenset(name for name in every if _has(target, name))
    lacking = [name for name in every if name not in has]
    near = []
    for name in _methods(target):
        if name not in every:
            like = get_close_matches(name, lacking, n=1, cutoff=LIKENESS)
            near += [(name, found) for found in like]
    return Offer(has, tuple(near))


def declaration_of(target: Any) -> Any:
    """The declaration that an object holds, as JSON can: a table or a path.

    Raises UsageError: it is neither.

    Returns mapping, str or ``None``.
    """
    given = getattr(target, "declaration", None)
    if given is None or isinstance(given, str):
        return given
    if isinstance(given, PathLike):
        return fspath(given)
    if isinstance(given, Mapping):
        return json.loads(json.dumps(given, default=_plain))
    raise UsageError(
        f"the backend's declaration is {type(given).__name__}, and should be a mapping"
        " or the path of a file"
    )


def _plain(value: Any) -> Any:
    return dict(value) if isinstance(value, Mapping) else list(value)


def shown_traceback(error: BaseException) -> str:
    """The end of a traceback, from the backend's own call on."""
    with suppress(Exception):  # what a backend raises is its own too
        trace = error.__traceback__
        below = trace.tb_next if trace else None
        lines = traceback.format_exception(type(error), error, below)
        return "".join(lines).strip()[-SHOWN:]
    return ""


def _has(target: Any, name: str) -> bool:
    """Whether there is a pass; one that cannot be reached is there, and will fail."""
    try:
        return getattr(target, name, None) is not None
    except Exception:
        return True


def _methods(target: Any) -> list[str]:
    found = []
    with suppress(Exception):
        found = [name for name in dir(target) if not name.startswith("_")]
    return [name for name in found if _is_method(target, name)]


def _is_method(target: Any, name: str) -> bool:
    with suppress(Exception):
        return callable(getattr(target, name, None))
    return False

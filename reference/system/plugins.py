"""Plug-ins: what other packages register by entry points, found by name."""

from importlib.metadata import EntryPoint, entry_points
from typing import TypeVar

from restir_gi.reference.system.errors import UsageError

Kind = TypeVar("Kind")


def plugin_names(group: str) -> list[str]:
    """Names that packages register in a group.

    Nothing is imported, so that a broken package disturbs nobody who does not ask for
    what it brings.
    """
    return sorted({point.name for point in entry_points(group=group)})


def find_plugin(group: str, name: str, kind: type[Kind], word: str) -> Kind | None:
    """The plug-in of a name; ``None`` where no package registers it.

    Raises UsageError: several packages do, or theirs is broken; the message names the
    package.

    Parameters
    ----------
    name : str; under which, and what the object itself is called
    kind : type; of the object; it has a ``name``
    """
    points = list(entry_points(group=group, name=name))
    if not points:
        return None
    if len(points) > 1:
        raise UsageError(
            f"{word} {name!r} is registered by {' and by '.join(map(_origin, points))};"
            " uninstall all but one"
        )
    return _load(points[0], kind, word)


def _load(point: EntryPoint, kind: type[Kind], word: str) -> Kind:
    try:
        found = point.load()
    # The code of others may fail in any way.
    except Exception as error:
        reason = f"{type(error).__name__}: {error}"
        raise UsageError(
            f"{word} {point.name!r} of {_origin(point)} cannot be loaded ({reason});"
            " repair or uninstall that package"
        ) from error
    if not isinstance(found, kind) or getattr(found, "name", None) != point.name:
        raise UsageError(
            f"{word} {point.name!r} of {_origin(point)} is {found!r:.80}, which is not"
            f" a {kind.__module__}.{kind.__qualname__} of that name;"
            " repair or uninstall that package"
        )
    return found


def _origin(point: EntryPoint) -> str:
    package = point.dist.name if point.dist else "an unknown package"
    return f"{package} ({point.value})"

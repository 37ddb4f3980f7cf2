"""Methods by name: the built-in ones, and those that other packages announce."""

from importlib.metadata import EntryPoint, entry_points

from reference.errors import UsageError
from reference.methods.method import Method
from reference.methods.path import PATH
from reference.methods.restir_gi import BIASED, UNBIASED

GROUP = "restir.methods"
BUILT_IN = {method.name: method for method in (PATH, BIASED, UNBIASED)}


def method_names() -> list[str]:
    """Names of all methods.

    Returns
    -------
    list of str
        The built-in ones first.  Nothing is imported, so that a broken package
        disturbs nobody who does not ask for its method.
    """
    announced = {point.name for point in entry_points(group=GROUP)}
    return [*BUILT_IN, *sorted(announced - BUILT_IN.keys())]


def method_named(name: str) -> Method:
    """Find a method.

    Parameters
    ----------
    name : str
        As `method_names` lists it.  A built-in method cannot be replaced.

    Returns
    -------
    Method
        Ready to render.

    Raises
    ------
    UsageError
        No such name, or its package is broken; the message names the package.
    """
    if name in BUILT_IN:
        return BUILT_IN[name]
    points = list(entry_points(group=GROUP, name=name))
    if not points:
        raise UsageError(
            f"unknown method {name!r}; known are {', '.join(method_names())}"
        )
    if len(points) > 1:
        raise UsageError(
            f"method {name!r} is announced by {' and by '.join(map(_origin, points))};"
            " uninstall all but one"
        )
    return _load(points[0])


def _load(point: EntryPoint) -> Method:
    try:
        method = point.load()
    # The code of others may fail in any way.
    except Exception as error:
        reason = f"{type(error).__name__}: {error}"
        raise UsageError(
            f"method {point.name!r} of {_origin(point)} cannot be loaded ({reason});"
            " repair or uninstall that package"
        ) from error
    if not isinstance(method, Method) or method.name != point.name:
        raise UsageError(
            f"method {point.name!r} of {_origin(point)} is {method!r:.80}, which is no"
            " reference.methods.Method of that name; repair or uninstall that package"
        )
    return method


def _origin(point: EntryPoint) -> str:
    package = point.dist.name if point.dist else "an unknown package"
    return f"{package} ({point.value})"

"""Methods by name: the built-in ones, and those of plug-ins."""

from restir_gi.reference.methods.method import Method
from restir_gi.reference.methods.path import PATH
from restir_gi.reference.methods.restir_gi import BIASED, UNBIASED
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.plugins import find_plugin, plugin_names
from restir_gi.reference.system.suggestions import unknown

GROUP = "restir.methods"
BUILT_IN = {method.name: method for method in (PATH, BIASED, UNBIASED)}


def method_names() -> list[str]:
    """Names of all methods.  The built-in ones first.  Nothing is imported."""
    theirs = [name for name in plugin_names(GROUP) if name not in BUILT_IN]
    return [*BUILT_IN, *theirs]


def method_named(name: str) -> Method:
    """Find a method.

    Raises UsageError: no such name, or its package is broken; the message names the
    package.

    Parameters
    ----------
    name : str; as `method_names` lists it; a built-in method cannot be replaced
    """
    found = BUILT_IN.get(name) or find_plugin(GROUP, name, Method, "method")
    if found is None:
        raise UsageError(unknown("method", name, method_names()))
    return found

"""A pytest plug-in that runs tests on code with one line changed.

``RESTIR_BROKEN`` holds, as JSON, the dotted name of a module, a text that occurs in it
once, and what stands in its place.
"""

import json
import os
from importlib import import_module
from types import SimpleNamespace

import pytest

from tests.mutants.plant import planted


@pytest.hookimpl(wrapper=True)
def pytest_runtestloop(session):
    """Plant the mistake before the first test, after all has been imported."""
    module, old, new = json.loads(os.environ["RESTIR_BROKEN"])
    import_module(module)
    with planted(SimpleNamespace(edits=((module, old, new),))):
        return (yield)

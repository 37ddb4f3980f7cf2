"""Every verdict that a test makes by the command line has its published form."""

from importlib import import_module

import pytest


@pytest.fixture(autouse=True)
def verdicts_have_their_form(monkeypatch):
    """Hold what `restir check` concludes against the schema, whoever calls it."""
    from restir_gi.reference.reports.verdict.schema import fault_of_form
    from restir_gi.reference.system.json_text import json_text

    def of(conclude):
        def checked(arguments, plain, *rest):
            code = conclude(arguments, plain, *rest)
            assert fault_of_form(import_module("json").loads(json_text(plain))) == ""
            return code

        return checked

    for name in ("check", "check_pictures"):
        module = import_module(f"restir_gi.reference.cli.{name}")
        monkeypatch.setattr(module, "conclude", of(module.conclude))

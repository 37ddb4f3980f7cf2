"""The JSON schema of a verdict, which is published with the package."""

import json
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

from jsonschema import Draft202012Validator

VERSION = "restir-verdict 1"

PUBLISHED = Path(__file__).with_name("verdict.schema.json")
"""Where the schema is installed."""


@cache
def verdict_schema() -> Mapping[str, Any]:
    """JSON schema of a verdict, as it is published [draft 2020-12]."""
    contents: Mapping[str, Any] = json.loads(PUBLISHED.read_text(encoding="utf-8"))
    return contents


@cache
def _validator() -> Any:
    return Draft202012Validator(verdict_schema())


def fault_of_form(verdict: Any) -> str:
    """What of a verdict is not as the schema has it: the first, in a line; or empty."""
    found = sorted(
        _validator().iter_errors(verdict), key=lambda e: list(map(str, e.path))
    )
    if not found:
        return ""
    where = ".".join(map(str, found[0].absolute_path)) or "the whole"
    return f"{where}: {' '.join(str(found[0].message).split())[:200]}"

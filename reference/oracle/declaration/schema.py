"""The JSON schema of a declaration, which is published with the package."""

import json
from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from restir_gi.reference.oracle.declaration.choices import (
    KEYS,
    OF_ALL,
    OF_PASSES,
    Key,
)

VERSION = "restir-declaration 1"

PUBLISHED = Path(__file__).with_name("declaration.schema.json")
"""Where the schema is installed; written from this module."""

WORDS = {"type": "array", "items": {"type": "string"}}


@cache
def declaration_schema() -> dict[str, Any]:
    """JSON schema of a declaration [draft 2020-12]."""
    inner = [key for key in KEYS if key.name not in OF_ALL]
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": VERSION,
        "description": "a table with the keys schema, name, accept, has and choices",
        "type": "object",
        "properties": {
            "schema": {"const": VERSION, "description": f'"{VERSION}"'},
            "name": {"type": "string", "description": "a name in quotes"},
            "accept": WORDS
            | {
                "description": "a list of names of declared choices whose bias is"
                " accepted"
            },
            "has": _has(),
            "choices": _choices(),
        },
        "$defs": {"choices_of_a_pass": _table(inner, "a table of choices of a pass")},
        "required": ["schema"],
        "additionalProperties": False,
    }


def written_schema() -> str:
    """The schema as the file that is published holds it."""
    return json.dumps(declaration_schema(), indent=1, ensure_ascii=False) + "\n"


def _has() -> dict[str, Any]:
    values = WORDS | {"minItems": 1, "description": "a list of words, in quotes"}
    table = {"type": "object", "additionalProperties": values}
    return {
        "description": "a table of what the backend has",
        "type": "object",
        "properties": {
            "passes": WORDS | {"minItems": 1, "description": "a list of passes"},
            "neighbors": {
                "type": "array",
                "items": {"type": "integer", "minimum": 1, "maximum": 30},
                "minItems": 1,
                "description": "a list of how many neighbours there may be, 1 to 30",
            },
            "history": {"type": "boolean", "description": "true or false"},
        },
        "additionalProperties": {
            "anyOf": [values, table],
            "additionalProperties": values,
            "description": "a list of words that a setting may be, or a table of a pass"
            " with such lists",
        },
    }


def _choices() -> dict[str, Any]:
    found = _table(KEYS, "a table of choices")
    for name in OF_PASSES:
        found["properties"][name] = {"$ref": "#/$defs/choices_of_a_pass"}
    return found


def _table(keys: Sequence[Key], what: str) -> dict[str, Any]:
    """A table of keys, those with a dot in tables of their own."""
    made: dict[str, Any] = {}
    for key in keys:
        table, _, name = key.name.rpartition(".")
        inner = made
        if table:
            empty = {"type": "object", "properties": {}, "additionalProperties": False}
            inner = made.setdefault(table, empty)["properties"]
            made[table]["description"] = f"a table with the keys {_and(inner, name)}"
        inner[name] = {"title": key.meaning, **key.form}
    return {
        "type": "object",
        "properties": made,
        "additionalProperties": False,
        "description": what,
    }


def _and(names: Iterable[str], last: str) -> str:
    return ", ".join([*names, last])

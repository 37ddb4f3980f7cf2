"""The published schema of ``capture.toml``, and what it finds, in plain words."""

import json
from collections.abc import Iterator, Mapping
from functools import cache
from math import isnan
from pathlib import Path
from typing import Any

from jsonschema import Draft202012Validator, ValidationError

from restir_gi.reference.oracle.capture.faults import place, shown
from restir_gi.reference.system.suggestions import unknown

FORM = "restir-capture 1"
PATH = Path(__file__).with_name("capture.schema.json")

TYPES = {
    "integer": "a whole number",
    "number": "a number",
    "string": "a text",
    "boolean": "true or false",
    "array": "an array",
    "object": "a table",
}


@cache
def schema() -> Mapping[str, Any]:
    """The schema, as JSON has it."""
    contents: Mapping[str, Any] = json.loads(PATH.read_text(encoding="utf-8"))
    return contents


@cache
def _validator() -> Any:
    return Draft202012Validator(schema())


def faults_of_form(data: Mapping[str, Any]) -> list[str]:
    """What of a manifest is not as the schema has it, a line each."""
    found = [_told(error) for error in _validator().iter_errors(data)]
    found += [f"{where} is no number; give one" for where in _no_numbers(data, ())]
    return sorted(dict.fromkeys(found))


def described(table: str, key: str) -> Mapping[str, Any]:
    """What the schema says of a key.

    Parameters
    ----------
    table : str; of the schema's definitions, or empty for the whole
    """
    tables = schema()["$defs"][table] if table else schema()
    of: Mapping[str, Any] = tables["properties"][key]
    return of


def _told(error: ValidationError) -> str:
    """One error in one line: the key, what it is, and what would be right."""
    where, value, wanted = (
        place(list(error.path)),
        error.instance,
        error.validator_value,
    )
    match error.validator:
        case "required":
            missing = [name for name in wanted if name not in value]
            return f"{_in(where)} lacks {', '.join(missing)}"
        case "additionalProperties":
            known = error.schema["properties"]
            (first, *_) = [key for key in value if key not in known]
            return f"{_in(where)}: {unknown('key', first, known)}"
        case "const":
            return f"{where} is {shown(value)}; it should be {shown(wanted)}"
        case "enum" if isinstance(value, str):
            return f"{where}: {unknown('word', value, wanted)}"
        case "enum":
            return f"{where} is {shown(value)}; it should be one of {', '.join(wanted)}"
        case "type":
            return f"{where or 'it'} is {shown(value)}; it should be {TYPES[wanted]}"
        case "anyOf":
            return f"{where} is {shown(value)}; it should be a number, or some numbers"
        case "minItems" | "maxItems" | "minProperties" | "maxProperties":
            return f"{where} has {len(value)} entries; it should have {_range(error)}"
        case "minLength" | "maxLength":
            return f"{where} has {len(value)} letters; it should have {_range(error)}"
        case "pattern":
            return (
                f"{_in(where)}: {shown(value)} is no name; it should begin with a"
                " letter, and have letters, digits, - and _ alone, 64 at most"
            )
        case _:
            return f"{where} is {shown(value)}; it should be {_range(error)}"


def _in(where: str) -> str:
    return where or "it"


LEAST = ("minimum", "exclusiveMinimum", "minItems", "minLength", "minProperties")
MOST = ("maximum", "exclusiveMaximum", "maxItems", "maxLength", "maxProperties")


def _range(error: ValidationError) -> str:
    of = error.schema
    least = next((of[word] for word in LEAST if word in of), None)
    most = next((of[word] for word in MOST if word in of), None)
    if least == most:
        return str(least)
    between = "between" if "exclusiveMinimum" in of else "from"
    return f"{between} {least} {'and' if between == 'between' else 'to'} {most}"


def _no_numbers(value: Any, path: tuple[str | int, ...]) -> Iterator[str]:
    """Where a manifest has NaN, which is beyond no limit."""
    if isinstance(value, float) and isnan(value):
        yield place(path)
    items: Any = ()
    if isinstance(value, Mapping):
        items = value.items()
    elif isinstance(value, list):
        items = enumerate(value)
    for key, item in items:
        yield from _no_numbers(item, (*path, key))

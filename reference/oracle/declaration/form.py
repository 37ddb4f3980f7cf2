"""What of a declaration is not as its schema has it, a line for each key."""

from collections.abc import Iterable, Iterator, Mapping
from difflib import get_close_matches
from math import isnan
from typing import Any

from jsonschema import Draft202012Validator, ValidationError

Form = Mapping[str, Any]

LONGEST = 60
"""Letters of a value that a message repeats."""


def faults(form: Form, value: Any) -> list[str]:
    """What is not of the form: which key, what stands there, and what would be right.

    Parameters
    ----------
    form : mapping; a JSON schema; each ``description`` says what would be right
    value : object; tables are dicts, and arrays are lists
    """
    errors = Draft202012Validator(form).iter_errors(value)
    found = [line for error in errors for line in _told(form, value, error)]
    found += [f"{key} is nan, and should be a number" for key in _no_numbers(value)]
    return list(dict.fromkeys(found))


def as_json(value: Any) -> Any:
    """A table as JSON has it: dicts and lists, whatever a program had in their place.

    Parameters
    ----------
    value : object; mappings and sequences within each other
    """
    if isinstance(value, Mapping):
        return {str(key): as_json(item) for key, item in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [as_json(item) for item in value]
    return value


def _told(form: Form, whole: Any, error: ValidationError) -> Iterator[str]:
    path = [step for step in error.absolute_path if isinstance(step, str)]
    if error.validator == "additionalProperties" and isinstance(error.instance, dict):
        known = error.schema.get("properties", {})
        for name in error.instance:
            if name not in known:
                yield f"{_key([*path, name])} is no key, {_meant(name, known)}"
    elif error.validator == "required":
        for name in error.validator_value:
            if name not in error.instance:
                right = _form_at(form, [*path, name])["description"]
                yield f"{_key([*path, name])} is missing, and should be {right}"
    else:
        value = whole
        for step in path:
            value = value[step]
        right = _form_at(form, path)["description"]
        yield f"{_key(path)} is {shown(value)}, and should be {right}"


def _key(path: Iterable[str]) -> str:
    return ".".join(path) or "it"


def _form_at(form: Form, path: Iterable[str]) -> Form:
    """The form of a key, found through tables and references."""
    found = form
    for step in path:
        inner = found.get("properties", {}).get(step, found.get("additionalProperties"))
        if inner is not None and "$ref" in inner:
            inner = form["$defs"][inner["$ref"].rpartition("/")[2]]
        found = inner if isinstance(inner, Mapping) else found
    return found


def _meant(name: str, known: Iterable[str]) -> str:
    close = get_close_matches(name[:LONGEST], known, n=1)
    return f"did you mean {close[0]}?" if close else f"there are {', '.join(known)}"


def _no_numbers(value: Any, path: tuple[str, ...] = ()) -> Iterator[str]:
    """Keys of NaN, which is beyond no limit."""
    if isinstance(value, float) and isnan(value):
        yield _key(path)
    elif isinstance(value, dict):
        for key, item in value.items():
            yield from _no_numbers(item, (*path, key))
    elif isinstance(value, list):
        for item in value:
            yield from _no_numbers(item, path)


def shown(value: Any) -> str:
    """A value as TOML writes it, or nearly; no longer than a line.

    Examples
    --------
    >>> shown([True, "1/Z", 0.5])
    '[true, "1/Z", 0.5]'
    """
    text = _written(value)
    return text if len(text) <= LONGEST else text[:LONGEST] + "..."


def _written(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, list):
        return f"[{', '.join(map(_written, value))}]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{k} = {_written(v)}" for k, v in value.items()) + "}"
    return str(value)

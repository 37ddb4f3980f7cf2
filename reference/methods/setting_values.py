"""Settings from text: ``KEY=VALUE`` onto the fields of a dataclass, by their types."""

from collections.abc import Hashable, Iterable, Mapping
from dataclasses import asdict, fields, is_dataclass, replace
from functools import cache
from math import isfinite, isnan
from typing import Any, Literal, TypeVar, get_args, get_origin, get_type_hints

from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.suggestions import unknown

Settings = TypeVar("Settings")


def refuse_beyond(settings: object, limits: Mapping[str, tuple[float, float]]) -> None:
    """Raise where a number among settings is out of its range.

    Raises ValueError: it names the first number that is not within.

    Parameters
    ----------
    limits : mapping of str to (float, float)
        Least and most of each number that has a range.
    """
    for name, (least, most) in limits.items():
        value = getattr(settings, name)
        if not least <= value <= most:
            end = f"to {most}" if isfinite(most) else "or more"
            raise ValueError(f"{name}={value} is out of range: {least} {end}")


@cache
def _hints(settings: Hashable) -> dict[str, Any]:
    # A sweep asks for the same few types thousands of times.
    return get_type_hints(settings)


TRUTH = {"true": True, "yes": True, "on": True, "1": True}
FALSEHOOD = {"false": False, "no": False, "off": False, "0": False}


def with_values(defaults: Settings, assignments: Iterable[str]) -> Settings:
    """Settings with some of their fields set from text, of the same type.

    Raises TypeError: the settings are no dataclass.
    Raises UsageError: no such field, or not one of its values; the message lists what
    is known.

    Parameters
    ----------
    defaults : dataclass instance
        Fields of type str, int, float, bool or Literal; its ``__post_init__`` may
        raise ValueError on values that are out of range.
    assignments : iterable of str
        Each ``KEY=VALUE``; of two with one key the last one counts.
    """
    if not is_dataclass(defaults) or isinstance(defaults, type):
        raise TypeError(f"settings must be a dataclass instance, not {defaults!r}")
    hints = _hints(type(defaults))
    found: dict[str, Any] = {}
    for assignment in assignments:
        key, equals, text = assignment.partition("=")
        if not equals:
            raise UsageError(f"--set {assignment!r} is not of the form KEY=VALUE")
        names = [field.name for field in fields(defaults)]
        if key not in names:
            raise UsageError(
                f"--set: {unknown('setting', key, names, known(defaults))}"
            )
        try:
            found[key] = _parse(hints[key], text)
        except ValueError as error:
            raise UsageError(
                f"--set {assignment}: {key} must be {_form(hints[key])}"
            ) from error
    try:
        result: Settings = replace(defaults, **found)
    except ValueError as error:
        raise UsageError(f"--set: {error}") from error
    return result


def known(settings: Any) -> str:
    """All settings with what they may be, for a message.

    It reads ``"a=1|2, b=NUMBER"``; "none" if there are none.

    Parameters
    ----------
    settings : dataclass instance; as `with_values` takes it
    """
    kind: type = type(settings)
    hints = _hints(kind)
    words = [f"{f.name}={_form(hints[f.name], '|')}" for f in fields(settings)]
    return ", ".join(words) or "none"


def as_text(settings: Any) -> dict[str, str]:
    """Every setting as text that `with_values` can read, in the order of the fields."""
    return {key: text_of(value) for key, value in asdict(settings).items()}


def text_of(value: Any) -> str:
    """One value as text, as `with_values` would read it.

    "true" and "false" for what is either.
    """
    return str(value).lower() if isinstance(value, bool) else str(value)


def _parse(kind: Any, text: str) -> Any:
    if get_origin(kind) is Literal:
        choices = {str(choice): choice for choice in get_args(kind)}
        if text not in choices:
            raise ValueError(text)
        return choices[text]
    if kind is bool:
        both = TRUTH | FALSEHOOD
        if text.lower() not in both:
            raise ValueError(text)
        return both[text.lower()]
    value = kind(text)
    if isinstance(value, float) and isnan(value):
        raise ValueError(text)
    return value


def _form(kind: Any, between: str = " or ") -> str:
    if get_origin(kind) is Literal:
        return between.join(str(choice) for choice in get_args(kind))
    words = {bool: between.join(("true", "false")), int: "INTEGER", float: "NUMBER"}
    return words.get(kind, "TEXT")

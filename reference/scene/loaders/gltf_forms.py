"""The forms that values in a glTF file have, and what is told of one that has not."""

import json
from dataclasses import dataclass
from typing import Any

LARGEST = 3.4028234663852886e38
"""Of single precision, in which glTF holds numbers."""


@dataclass(frozen=True, slots=True)
class Anything:
    """A value that is not looked at."""


@dataclass(frozen=True, slots=True)
class Flag:
    """True or false."""


@dataclass(frozen=True, slots=True)
class NumberForm:
    """A number between bounds, inclusive; a whole one without a fraction."""

    low: float = -LARGEST
    high: float = LARGEST
    whole: bool = False


@dataclass(frozen=True, slots=True)
class NumbersForm:
    """So many numbers (0: any number of them), each between bounds."""

    count: int
    low: float = -LARGEST
    high: float = LARGEST


@dataclass(frozen=True, slots=True)
class Text:
    """A text; with choices, one of them."""

    choices: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Texts:
    """A list of texts."""


@dataclass(frozen=True, slots=True)
class ChoiceForm:
    """One of some whole numbers."""

    choices: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Index:
    """The number of an element of one of the file's lists."""

    of: str


@dataclass(frozen=True, slots=True)
class Indexes:
    """A list of such numbers."""

    of: str


@dataclass(frozen=True, slots=True)
class One:
    """An object with the words of an element."""

    element: str


@dataclass(frozen=True, slots=True)
class Many:
    """A list of objects with the words of an element."""

    element: str


Form = (
    Anything
    | Flag
    | NumberForm
    | NumbersForm
    | Text
    | Texts
    | ChoiceForm
    | Index
    | Indexes
    | One
    | Many
)


def fault(form: Form, value: Any, tree: dict[str, Any]) -> str | None:
    """What a value must be, if it is not, to be read after "it must be".

    Parameters
    ----------
    tree : dict; the whole file, whose lists indices count
    """
    fits, needs = True, ""
    match form:
        case Flag():
            fits, needs = isinstance(value, bool), "true or false"
        case NumberForm(low, high, whole):
            fits = _is_number(value, low, high) and (not whole or type(value) is int)
            needs = f"a {'whole ' * whole}number{_bounds(low, high)}"
        case NumbersForm(count, low, high):
            fits = isinstance(value, list) and len(value) == (count or len(value))
            fits = fits and all(_is_number(each, low, high) for each in value)
            needs = f"{count or 'any'} numbers{_bounds(low, high)}"
        case Text(choices):
            fits = isinstance(value, str) and (not choices or value in choices)
            needs = " or ".join(choices) or "a text"
        case Texts():
            fits = isinstance(value, list)
            fits = fits and all(isinstance(each, str) for each in value)
            needs = "a list of texts"
        case ChoiceForm(choices):
            fits = type(value) is int and value in choices
            needs = f"one of {', '.join(map(str, choices))}"
        case Index(of):
            fits = _is_index(value, tree, of)
            needs = f"the number of one of the file's {of}; {_counted(tree, of)}"
        case Indexes(of):
            fits = isinstance(value, list)
            fits = fits and all(_is_index(each, tree, of) for each in value)
            needs = f"a list of numbers of the file's {of}; {_counted(tree, of)}"
        case One():
            fits, needs = isinstance(value, dict), "an object"
        case Many():
            fits = isinstance(value, list)
            fits = fits and all(isinstance(each, dict) for each in value)
            needs = "a list of objects"
    return None if fits else needs


def listed(tree: dict[str, Any], name: str) -> list[Any]:
    """List of a file by its name, also an extension's lights; empty if it has none.

    Parameters
    ----------
    name : str; "nodes", "lights", ...
    """
    if name == "lights":
        tree = _object(_object(tree.get("extensions")).get("KHR_lights_punctual"))
    found = tree.get(name, [])
    return found if isinstance(found, list) else []


def shown(value: Any) -> str:
    """A value of the file on one short line.

    Long lists and objects by their kind alone.
    """
    if isinstance(value, dict):
        return "an object"
    if isinstance(value, list):
        plain = all(isinstance(each, int | float) for each in value)
        if not plain or len(value) > 4:
            return f"a list of {len(value)}"
    text = printable(json.dumps(value, ensure_ascii=False))
    return text if len(text) <= 60 else f"{text[:57]}..."


def printable(text: str) -> str:
    """A text of the file, of which nothing can reach a terminal but letters.

    Escapes stand in place of the rest.

    Parameters
    ----------
    text : str; may hold control characters and halves of pairs
    """
    letters = (c if c.isprintable() else ascii(c)[1:-1] for c in text)
    return "".join(letters)


def _object(value: Any) -> dict[str, Any]:
    return value if isinstance(value, dict) else {}


def _is_number(value: Any, low: float, high: float) -> bool:
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return bool(number and low <= value <= high)


def _is_index(value: Any, tree: dict[str, Any], of: str) -> bool:
    return type(value) is int and 0 <= value < len(listed(tree, of))


def _bounds(low: float, high: float) -> str:
    if high < LARGEST:
        return f" from {low:g} to {high:g}"
    return " that single precision holds" + f", at least {low:g}" * (low > -LARGEST)


def _counted(tree: dict[str, Any], of: str) -> str:
    count = len(listed(tree, of))
    return f"it has 0 to {count - 1}" if count else "it has none"

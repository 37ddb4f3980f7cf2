"""One object of a scene.json file, with errors that name it."""

import json
from dataclasses import dataclass, field
from typing import Any

from restir_gi.reference.scene.loaders.json_words import names
from restir_gi.reference.scene.loaders.ledger import Ledger
from restir_gi.reference.scene.loaders.words import Use
from restir_gi.reference.scene.textures import Color

MOST_COUNT = 2**24  # beyond it no picture has a side


def shown(value: Any) -> str:
    """A value as the file may spell it, for messages; at most 60 letters."""
    text = "missing" if value is None else json.dumps(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _is_number(value: Any) -> bool:
    """Whether float64 takes it: a whole number may be too large."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return isinstance(value, float) or abs(value) < 2**1023


@dataclass(slots=True)
class JsonObject:
    """One object of the file.

    Attributes
    ----------
    element : str; what it is, as in `json_words.WORDS`
    """

    element: str
    name: str
    raw: Any
    ledger: Ledger
    _read: set[str] = field(default_factory=set)

    def __post_init__(self) -> None:
        if not isinstance(self.raw, dict):
            self.ledger.stop(f"{self.name} is not an object with keys")

    @property
    def id(self) -> str:
        """What the shape is called in later messages."""
        return str(self.raw.get("id", self.name))

    def get(self, key: str, default: Any = None) -> Any:
        """Value of a key, of whatever type."""
        assert key in names(self.element), f"{key} is no word of {self.element}"
        self._read.add(key)
        return self.raw.get(key, default)

    def number(self, key: str, default: float | None = None) -> float:
        """Number; NaN and infinities pass.

        Raises UsageError: missing, or no number.

        Parameters
        ----------
        default : float or None; if there is none; ``None`` if there has to be one
        """
        value = self.get(key, default)
        if not _is_number(value):
            self.ledger.stop(
                f"{self.name}: {key} is {shown(value)}; it should be a number"
            )
        return float(value)

    def count(self, key: str, default: int) -> int:
        """Number of things, from 1 to `MOST_COUNT`.

        Raises UsageError: no such number.
        """
        value = self.number(key, default)
        if not 1 <= value <= MOST_COUNT or value != int(value):
            self.ledger.stop(
                f"{self.name}: {key} is {value:g}; it should be a whole number from 1"
                f" to {MOST_COUNT}"
            )
        return int(value)

    def color(self, key: str, default: Color | None = None) -> Color:
        """Colour or point; one number stands for three equal ones.

        Raises UsageError: missing, or neither one number nor three.

        Parameters
        ----------
        default : Color or None; if there is none; ``None`` if there has to be one
        """
        value = self.get(key, default)
        values = value if isinstance(value, list | tuple) else [value] * 3
        if len(values) != 3 or not all(map(_is_number, values)):
            self.ledger.stop(
                f"{self.name}: {key} is {shown(value)}; it should be three numbers, or"
                " one"
            )
        x, y, z = (float(v) for v in values)
        return x, y, z

    def refuse_unread(self) -> None:
        """Stop, or note, if a key was never asked for.

        A key whose value is a text is taken for a remark, and noted.

        Raises UsageError unless lenient.
        """
        harmless = names(self.element, Use.HARMLESS)
        for key in sorted(self.raw.keys() - self._read - set(harmless)):
            if isinstance(self.raw[key], str):
                self.ledger.note(f'{self.name}: the remark "{key}" is ignored')
            elif self.raw[key] is not None:
                self.ledger.replace(
                    f'{self.name}: the key "{key}" is not understood; here'
                    f" {', '.join(sorted(self._read))} are",
                    "ignored",
                )

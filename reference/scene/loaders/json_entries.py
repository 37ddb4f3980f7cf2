"""One object of a scene.json file, with errors that name it."""

from collections.abc import Collection
from dataclasses import dataclass, field
from math import isfinite
from typing import Any

from reference.scene.loaders.ledger import Ledger
from reference.scene.textures import Color


@dataclass(slots=True)
class Entry:
    """One object of the file.

    Attributes
    ----------
    name : str
        For messages.
    raw : Any
        As in the file.
    ledger : Ledger
        Of the file.
    """

    name: str
    raw: Any
    ledger: Ledger
    _read: set[str] = field(default_factory=set)

    def __post_init__(self) -> None:
        if not isinstance(self.raw, dict):
            self.ledger.stop(f"{self.name} is no object with keys")

    @property
    def id(self) -> str:
        """What the shape is called in later messages."""
        return str(self.raw.get("id", self.name))

    def get(self, key: str, default: Any = None) -> Any:
        """Value of a key, of whatever type.

        Parameters
        ----------
        key : str
            The key.
        default : Any
            If there is none.

        Returns
        -------
        Any
            As in the file.
        """
        self._read.add(key)
        return self.raw.get(key, default)

    def number(self, key: str, default: float | None = None) -> float:
        """Number.

        Parameters
        ----------
        key : str
            The key.
        default : float or None
            If there is none; ``None`` if there has to be one.

        Returns
        -------
        float
            NaN and infinities pass.

        Raises
        ------
        UsageError
            Missing, or no number.
        """
        value = self.get(key, default)
        if isinstance(value, bool) or not isinstance(value, int | float):
            self.ledger.stop(f"{self.name}: {key} is {value!r}; it should be a number")
        return float(value)

    def count(self, key: str, default: int) -> int:
        """Whole number.

        Parameters
        ----------
        key : str
            The key.
        default : int
            If there is none.

        Returns
        -------
        int
            Of any sign.

        Raises
        ------
        UsageError
            No whole number.
        """
        value = self.number(key, default)
        if not isfinite(value) or value != int(value):
            self.ledger.stop(f"{self.name}: {key} is {value}; it should be whole")
        return int(value)

    def color(self, key: str, default: Color | None = None) -> Color:
        """Colour or point.

        Parameters
        ----------
        key : str
            The key.
        default : Color or None
            If there is none; ``None`` if there has to be one.

        Returns
        -------
        Color
            One number stands for three equal ones.

        Raises
        ------
        UsageError
            Missing, or neither one number nor three.
        """
        value = self.get(key, default)
        values = value if isinstance(value, list | tuple) else [value] * 3
        wrong = [
            v for v in values if isinstance(v, bool) or not isinstance(v, int | float)
        ]
        if wrong or len(values) != 3:
            self.ledger.stop(
                f"{self.name}: {key} is {value!r}; it should be three numbers, or one"
            )
        x, y, z = (float(v) for v in values)
        return x, y, z

    def refuse_unread(self, harmless: Collection[str] = ()) -> None:
        """Stop, or note, if a key was never asked for.

        Parameters
        ----------
        harmless : collection of str
            Keys that tell nothing new.  A key whose value is a text is taken for a
            remark, and noted.

        Raises
        ------
        UsageError
            Unless lenient.
        """
        for key in sorted(self.raw.keys() - self._read - set(harmless)):
            if isinstance(self.raw[key], str):
                self.ledger.note(f'{self.name}: the remark "{key}" is ignored')
            elif self.raw[key] is not None:
                self.ledger.replace(
                    f'{self.name}: the key "{key}" is not understood; here'
                    f" {', '.join(sorted(self._read))} are",
                    "ignored",
                )

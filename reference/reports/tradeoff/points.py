"""Operating points: a method with settings."""

from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from typing import Any

from restir_gi.reference.methods import method_named
from restir_gi.reference.methods.setting_values import as_text, with_values
from restir_gi.reference.system.errors import UsageError

UNCHANGED = "as it is"
"""Label of the base."""


@dataclass(frozen=True, slots=True)
class Design:
    """A method with settings.

    Attributes
    ----------
    values : tuple of str
        Settings, as of ``--set KEY=VALUE``; of two with one key the last one counts.
    knob : str; which knob was turned: its name, ``"several"``, or ``""`` for the base
    label : str; what it was turned to
    """

    method: str
    values: tuple[str, ...]
    knob: str = ""
    label: str = UNCHANGED

    @property
    def key(self) -> str:
        """Twelve hexadecimal digits of what decides pixels: method and settings."""
        return _key(self.method, self.values)

    @property
    def name(self) -> str:
        """Knob and label in one."""
        return f"{self.knob}: {self.label}" if self.knob else self.label


def settings_of(point: Design) -> Any:
    """Settings of a point, of the type of the method's own.

    Raises UsageError: there is no such method, setting or value.

    Parameters
    ----------
    point : Design; with the name of a method
    """
    return with_values(method_named(point.method).settings, point.values)


def can_run(point: Design) -> bool:
    """Whether the settings of a point go together.

    Its settings exist, and none rules out another.

    Parameters
    ----------
    point : Design; with the name of a method
    """
    try:
        settings_of(point)
    except UsageError:
        return False
    return True


@cache
def _key(method: str, values: tuple[str, ...]) -> str:
    settings = as_text(settings_of(Design(method, values)))
    words = repr((method, sorted(settings.items())))
    return sha256(words.encode()).hexdigest()[:12]

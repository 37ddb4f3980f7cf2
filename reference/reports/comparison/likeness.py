"""Whether two pictures are of the same thing, as far as their headers say."""

from collections.abc import Mapping
from dataclasses import dataclass

SAME = {
    "scene": "shown.scene",
    "view": "shown.view",
    "light": "light",
    "bounces": "bounces",
    "frame": "shown.frame",
    "pixel filter": "shown.pixel",
}
"""What must be the same, and the word of a header that tells it."""

SEEN = ("scene", "view")
"""A frame has another number or not: what counts is whether these differ in it."""


@dataclass(frozen=True, slots=True)
class Difference:
    """Something that two pictures have not, or not for certain, in common.

    Attributes
    ----------
    what : str; a key of `SAME`
    a, b : str or None; what each is of; ``None`` where its header does not say
    """

    what: str
    a: str | None
    b: str | None

    @property
    def certain(self) -> bool:
        """Whether both are known."""
        return self.a is not None and self.b is not None


def differences(a: Mapping[str, str], b: Mapping[str, str]) -> list[Difference]:
    """All in which two pictures differ, or may differ.

    Empty only if both headers say that all is the same.
    """
    found = [
        Difference(what, _said(what, a), _said(what, b))
        for what in SAME
        if not _same(what, a, b)
    ]
    moved = any(one.what in SEEN and one.certain for one in found)
    return [one for one in found if one.what != "frame" or moved]


def _same(what: str, a: Mapping[str, str], b: Mapping[str, str]) -> bool:
    key, said = SAME[what], _said(what, a)
    alike = a.get(key) is not None and a.get(key) == b.get(key)
    return alike or (said is not None and said == _said(what, b))


def _said(what: str, words: Mapping[str, str]) -> str | None:
    keys = ("scene", SAME[what]) if what == "scene" else (SAME[what],)
    return " ".join(words[key] for key in keys if key in words) or None

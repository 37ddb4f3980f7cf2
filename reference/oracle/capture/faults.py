"""Everything that is wrong with a capture, told at once."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from restir_gi.reference.system.errors import UsageError

MOST_TOLD, LONGEST = 20, 60


class CaptureError(UsageError):
    """A capture that cannot be read.

    Attributes
    ----------
    faults : tuple of str
        What is wrong, a line each; the message has the first `MOST_TOLD` of them.
    """

    def __init__(self, where: Path | str, faults: Iterable[str]) -> None:
        self._where = where
        self.faults = tuple(" ".join(fault.splitlines()) for fault in faults)
        told = "; ".join(self.faults[:MOST_TOLD])
        more = len(self.faults) - MOST_TOLD
        rest = f"; and {more} more" if more > 0 else ""
        super().__init__(f"{where}: {told}{rest}")

    def __reduce__(self) -> tuple[Any, ...]:
        """How another process makes it again."""
        return type(self), (self._where, self.faults)


def shown(value: Any) -> str:
    """A value as a message repeats it, cut where it is long."""
    text = repr(value) if not isinstance(value, bool) else str(value).lower()
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}..."


def place(path: Sequence[str | int]) -> str:
    """Where a value stands in a manifest: ``buffers.temporal.fields[0].kind``."""
    words = [f"[{k}]" if isinstance(k, int) else f".{k}" for k in path]
    return "".join(words).removeprefix(".")

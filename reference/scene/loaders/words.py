"""What becomes of each word of a file format: one table a loader, and a page of all.

The loaders decide by these tables and `docs/reference/formats.md` is printed from them,
so that neither can say what the other does not do.
"""

from dataclasses import dataclass
from enum import StrEnum


class Use(StrEnum):
    """What a loader does with a word."""

    MODELLED = "modelled"
    HARMLESS = "ignored: it does not change the picture"
    REPLACED = "refused, or replaced under --lenient"
    REFUSED = "refused"


@dataclass(frozen=True, slots=True)
class Word:
    """A word of a file format.

    Attributes
    ----------
    element : str; where it stands: "material", "perspective camera"
    name : str; as the file spells it
    use : Use; what the loader does with it
    remark : str; what stands in for it, or within which limits it is modelled
    """

    element: str
    name: str
    use: Use
    remark: str = ""

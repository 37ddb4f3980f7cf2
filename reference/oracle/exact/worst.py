"""The worst rows that were found for each kernel in each type, kept as vectors."""

import json
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from restir_gi.reference.oracle.exact.kernel import Inputs

PATH = Path(__file__).with_name("worst.json")

Plain = float | list[float]


@dataclass(frozen=True, slots=True)
class Worst:
    """A row on which a kernel came closest to what rounding explains.

    Attributes
    ----------
    kernel, type, extreme : str; whose, in which type, and where it was found
    ulp, share : float; its error when it was found, and that as a share of the bound
    given : mapping of str to float or list of float; the very numbers
    """

    kernel: str
    type: str
    extreme: str
    ulp: float
    share: float
    given: dict[str, Plain]

    @property
    def inputs(self) -> Inputs:
        """As arrays of one row, of the type."""
        return {k: np.array([v], self.type) for k, v in self.given.items()}

    def as_plain(self) -> dict[str, Any]:
        """For JSON, where float64 keeps every number of every type."""
        return asdict(self)


def plain(value: Any) -> Plain:
    """Numbers of a row for JSON, without an error.

    Parameters
    ----------
    value : number or (k,) array; of any floating-point type
    """
    wide = np.asarray(value, np.float64)
    return wide.tolist() if wide.ndim else float(wide)


@cache
def worst_rows() -> tuple[Worst, ...]:
    """All rows that are kept: for each kernel and type one of each extreme met."""
    return tuple(Worst(**row) for row in json.loads(PATH.read_text("utf-8")))


def worst_inputs(kernel: str, type_name: str) -> Inputs:
    """Rows of one kernel in one type, one below the other; none if none are kept."""
    rows = [w for w in worst_rows() if (w.kernel, w.type) == (kernel, type_name)]
    names = rows[0].given if rows else ()
    return {k: np.concatenate([w.inputs[k] for w in rows]) for k in names}

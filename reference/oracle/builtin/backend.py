"""The production kernels and passes behind the contract's interface."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, partial
from typing import Any

from restir_gi.reference.oracle.builtin.kernels import KERNELS
from restir_gi.reference.oracle.builtin.passes import PASSES
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.parts import PassFunction, parts


@dataclass(frozen=True, slots=True)
class BuiltIn:
    """The project's own passes, one method for each pass of the contract.

    Attributes
    ----------
    precision : 'float32' or 'float64'; of all reals
    """

    precision: Precision = "float32"

    def __getattr__(self, pass_name: str) -> Any:
        """A pass, as a function of its buffers and settings."""
        try:
            return partial(_own_passes()[pass_name], self.precision)
        except KeyError as error:
            raise AttributeError(pass_name) from error


@cache
def _own_passes() -> Mapping[str, PassFunction]:
    found = {**KERNELS, **PASSES}
    for part in parts():
        found |= part.own
    return found


FLOAT32 = BuiltIn("float32")
FLOAT64 = BuiltIn("float64")

"""What the matrix knows of a kernel: how to call it, and what it should have said."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from restir_gi.reference.oracle.exact.draws import Draws

Inputs = Mapping[str, NDArray[Any]]
"""By name, (N,) or (N, 3) arrays, all of one floating-point type."""

Row = Mapping[str, Any]
"""By name, an `Exact` or three of them."""


@dataclass(frozen=True, slots=True, eq=False)
class Kernel:
    """A function of numbers, row by row.

    Attributes
    ----------
    of_contract : str; pass of the contract whose policy this is, or ''
    draw : callable
        From `Draws` to inputs in float64, which are then rounded to the type.
    run : callable
        The production kernel: from inputs to (N,) or (N, 3) numbers, or to (N,) bool.
    formula : callable
        The source's formula on one row of `Exact`: a number, three, or a bool.
    defines : mapping of str to str
        What the kernel gives at each extreme that it can meet.
    saturates : bool
        Whether what is too large for the type becomes its largest number; else it may
        be any finite number.
    """

    name: str
    of_contract: str
    draw: Callable[[Draws], Mapping[str, NDArray[Any]]]
    run: Callable[[Inputs], NDArray[Any]]
    formula: Callable[[Row], Any]
    defines: Mapping[str, str]
    saturates: bool = False

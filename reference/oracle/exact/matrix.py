"""Each kernel at each extreme in each type, beside exact numbers."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from restir_gi.reference.oracle.exact.draws import Draws
from restir_gi.reference.oracle.exact.extremes import EXTREMES, Extreme
from restir_gi.reference.oracle.exact.judge import Judged, judge
from restir_gi.reference.oracle.exact.kernel import Inputs, Kernel
from restir_gi.reference.oracle.exact.numbers import type_of

TYPES: tuple[Any, ...] = (np.float16, np.float32, np.float64)


@dataclass(frozen=True, slots=True, eq=False)
class MatrixCell:
    """A kernel at an extreme in a type.

    Attributes
    ----------
    inputs : mapping of str to array; what it was given
    judged : Judged; what came of it
    fault : str; warning or exception, '' for none
    """

    kernel: str
    extreme: str
    type: str
    inputs: Inputs
    judged: Judged
    fault: str = ""

    @property
    def passed(self) -> bool:
        """No warning, all finite, no error that rounding does not make."""
        return not self.fault and bool((self.judged.share <= 1).all())


def reads(kernel: Kernel, extreme: Extreme) -> bool:
    """Whether a kernel can meet an extreme."""
    draws = Draws(np.random.default_rng(0), 1, np.finfo(np.float64), EXTREMES[0])
    kernel.draw(draws)
    return not extreme.drives or bool(draws.read & set(extreme.drives))


def cell(kernel: Kernel, extreme: Extreme, dtype: Any, rows: int) -> MatrixCell:
    """Draw, run and judge one cell.

    Parameters
    ----------
    rows : int; how many; the same ones whenever it is asked
    """
    name = np.dtype(dtype).name
    key = list(f"{kernel.name}/{extreme.name}/{name}".encode())
    draws = Draws(np.random.default_rng(key), rows, np.finfo(dtype), extreme)
    inputs = {k: draws.in_type(v) for k, v in kernel.draw(draws).items()}
    return judged_cell(kernel, extreme.name, inputs)


def judged_cell(kernel: Kernel, extreme: str, inputs: Inputs) -> MatrixCell:
    """Run and judge a kernel on rows that are there.

    Parameters
    ----------
    extreme : str; name of where the rows are from
    inputs : mapping of str to array; all of one type

    Returns
    -------
    MatrixCell; a warning is a fault; what was calculated is judged all the same
    """
    dtype = next(iter(inputs.values())).dtype
    fault = ""
    try:
        with np.errstate(over="raise", invalid="raise", divide="raise", under="ignore"):
            found = kernel.run(inputs)
    except FloatingPointError as error:
        fault = str(error)
        with np.errstate(all="ignore"):
            found = kernel.run(inputs)
    judged = judge(kernel, inputs, found, type_of(dtype))
    return MatrixCell(kernel.name, extreme, dtype.name, inputs, judged, fault)


def matrix(
    kernels: tuple[Kernel, ...],
    rows: int,
    tell: Callable[[int, int], None] = lambda done, total: None,
) -> list[MatrixCell]:
    """All cells, by kernel, extreme and type; without what a kernel cannot meet.

    Parameters
    ----------
    tell : callable; told how many cells are done, of how many
    """
    asked = [(k, e, t) for k in kernels for e in EXTREMES if reads(k, e) for t in TYPES]
    cells = []
    for done, (kernel, extreme, dtype) in enumerate(asked):
        tell(done, len(asked))
        cells.append(cell(kernel, extreme, dtype, rows))
    tell(len(asked), len(asked))
    return cells

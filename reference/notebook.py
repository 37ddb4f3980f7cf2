"""The verdict on a backend in a notebook: a table, and pictures of what is wrong.

``check(MyBackend())`` as the last line of a cell shows it.
"""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from restir_gi.reference.oracle.checking import judge, selection_of
from restir_gi.reference.oracle.parts import whole_contract
from restir_gi.reference.oracle.verdict import Status, Verdict
from restir_gi.reference.reports.verdict.page import cell_of, page_of, write_page
from restir_gi.reference.reports.verdict.plain import as_plain
from restir_gi.reference.system.files import write_file


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Checked:
    """A backend that was judged.

    Attributes
    ----------
    name : str; a command or file as it was given, or the class of the object
    verdict : Verdict; all that is known, with the rows that are wrong
    """

    name: str
    verdict: Verdict

    @property
    def status(self) -> Status:
        """'PASS', 'FAIL' or 'UNDECIDED'."""
        return self.verdict.status

    def to_dict(self) -> dict[str, Any]:
        """Text, numbers, lists and dicts alone: what ``restir check --json`` prints."""
        return as_plain(self.verdict, self.name, whole_contract())

    def save(self, path: Path | str) -> None:
        """Write the report.

        Raises UsageError: it cannot be written.

        Parameters
        ----------
        path : Path or str
            A file that ends in ``.html``: the page alone.  Else a folder, as that of
            ``restir check --out``: the page, and ``verdict.json``.
        """
        path, plain = Path(path), self.to_dict()
        if path.suffix == ".html":
            write_file(path, page_of(self.verdict, plain))
        else:
            write_page(path, self.verdict, plain)

    def __repr__(self) -> str:
        plain = self.to_dict()
        return f"<{self.status}: {self.name}: {plain['headline']}>"

    def _repr_html_(self) -> str:
        return cell_of(self.verdict, self.to_dict())


def check(
    backend: Any,
    budget: float = 300.0,
    *,
    statistics: bool = False,
    only: Collection[str] = (),
    skip: Collection[str] = (),
    require: Collection[str] = (),
    seed: int = 1,
    extremes: bool = False,
    declaration: Path | str | Mapping[str, Any] | None = None,
    accept: Collection[str] = (),
    tell: Callable[[str], None] = lambda title: None,
) -> Checked:
    """Judge a backend, whatever comes of it.

    Raises UsageError: there is no such backend or pass, or what is declared cannot be.

    Parameters
    ----------
    backend : object or str
        An object with one method a pass, called in this process; its methods may
        return arrays of any library.  A string is what ``restir check`` takes.
    budget : float, s; no step begins after that
    statistics : bool; whole runs too, which certify the mean
    only, skip : collection of str; passes that alone are asked, or are not
    require : collection of str; passes that must be there, else it is FAIL
    seed : int; of all rows that are random
    extremes : bool; FAIL also for what is wrong beyond the working range alone
    declaration : path or mapping, optional; what the renderer has, and what it chooses
    accept : collection of str; declared choices whose bias is no FAIL
    tell : callable; told the title of each step
    """
    verdict = judge(
        backend,
        budget,
        statistics,
        tell=tell,
        seed=seed,
        selection=selection_of(only, skip),
        require=require,
        extremes=extremes,
        declaration=declaration,
        accept=accept,
    )
    name = backend if isinstance(backend, str) else type(backend).__name__
    return Checked(name, verdict)

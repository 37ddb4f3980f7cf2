"""What a backend is asked: some passes of all, and none again that it does not have."""

from collections.abc import Iterable
from dataclasses import dataclass

from restir_gi.reference.oracle.backends.backend import Backend
from restir_gi.reference.oracle.backends.offer import Offer
from restir_gi.reference.oracle.cases import Case, Outcome, source_rows
from restir_gi.reference.oracle.contract.fields import Passes, Precision
from restir_gi.reference.oracle.contract.kernels import TARGET
from restir_gi.reference.oracle.contract.surfaces import SURFACE
from restir_gi.reference.oracle.contract.targets import DATA
from restir_gi.reference.oracle.contract.weights import MIS, MIS_AT_REST
from restir_gi.reference.system.errors import UsageError

NEIGHBORS = (1, 9, 30)
"""Numbers of neighbours that rows are designed for: the least, a middle one, and the
most."""


@dataclass(frozen=True, slots=True)
class Selection:
    """Which cases of all.

    Attributes
    ----------
    only : frozenset of str; passes that are asked; empty for all
    skip : frozenset of str; passes that are not
    case : str, optional; name of the one case that is asked
    more : frozenset of (str, str, str)
        Pass, setting and value, of settings that have to be declared; those that are.
    declined : frozenset of (str, str, str)
        Pass, setting and value that it does not have, and is not asked.
    neighbors : frozenset of int
        How many reservoirs of others passes ``spatial`` and ``fused`` may have; empty
        for any.
    history : bool; whether pass ``spatial`` merges what it left in the last frame
    """

    only: frozenset[str] = frozenset()
    skip: frozenset[str] = frozenset()
    case: str | None = None
    more: frozenset[tuple[str, str, str]] = frozenset()
    declined: frozenset[tuple[str, str, str]] = frozenset()
    neighbors: frozenset[int] = frozenset()
    history: bool = True

    @property
    def mis(self) -> str:
        """Weights of pass ``spatial`` in whole runs: 1/Z, or else others that it has.

        1/M, which is biased where not all see the same, comes last.
        """
        if ("spatial", MIS.name, "1/Z") not in self.declined:
            return "1/Z"
        had = (mis for mis in MIS.more if ("spatial", MIS.name, mis) in self.more)
        return next(had, "1/M")

    @property
    def temporal_mis(self) -> str:
        """Weights of pass ``temporal`` in whole runs; empty where nothing is said."""
        usual = "temporal", MIS_AT_REST.name, MIS_AT_REST.default
        had = (m for m in MIS_AT_REST.more if ("temporal", MIS.name, m) in self.more)
        return next(had, "") if usual in self.declined else ""

    def both(self, other: "Selection") -> "Selection":
        """What both hold: passes and values that neither of them leaves out.

        Raises UsageError: no pass is left.
        """
        only = self.only & other.only if self.only and other.only else ()
        if self.only and other.only and not only:
            names = ", ".join(sorted(self.only))
            raise UsageError(f"{names} is to be asked, and the declaration has it not")
        counts = self.neighbors & other.neighbors
        return Selection(
            only=frozenset(only or self.only | other.only),
            skip=self.skip | other.skip,
            case=self.case or other.case,
            more=self.more | other.more,
            declined=self.declined | other.declined,
            neighbors=counts or self.neighbors | other.neighbors,
            history=self.history and other.history,
        )

    def neighbors_for(self, count: int) -> int:
        """How many pass ``spatial`` is given where a case has so many.

        As many, if it may have them; else the next number above, or the largest.
        """
        if not self.neighbors or count in self.neighbors:
            return count
        above = [k for k in self.neighbors if k > count]
        return min(above) if above else max(self.neighbors)

    @property
    def designed_neighbors(self) -> tuple[int, ...]:
        """Numbers that rows are designed for: the least, a middle one and the most."""
        if not self.neighbors:
            return NEIGHBORS
        known = sorted(self.neighbors)
        return tuple(dict.fromkeys((known[0], known[len(known) // 2], known[-1])))

    def holds(self, pass_name: str) -> bool:
        """Whether a pass is asked."""
        return pass_name not in self.skip and (not self.only or pass_name in self.only)

    def has_declared(self, passes: Passes, case: Case) -> bool:
        """Whether all values of a case that have to be declared are."""
        wanted = {
            (case.pass_name, s.name, str(case.settings[s.name]))
            for s in passes[case.pass_name].settings
            if case.settings.get(s.name) in s.more
        }
        return wanted <= self.more

    def takes_targets(self, case: Case) -> bool:
        """Whether a case has a target that a pass takes as data alone."""
        name, target = case.pass_name, str(case.settings.get(TARGET.name, ""))
        data = (name, TARGET.name, DATA) in self.more
        lambertian = SURFACE.name not in case.settings
        return data and lambertian and (name, TARGET.name, target) in self.declined

    def has_settings(self, passes: Passes, case: Case) -> bool:
        """Whether no value of a case is declined, nor its number of neighbours."""
        values = {
            (case.pass_name, s.name, str(case.settings.get(s.name, s.default)))
            for s in passes[case.pass_name].settings
        }
        around = source_rows(case.inputs)
        count = case.inputs[around.rows].shape[1] if around else None
        known = not self.neighbors or count is None or count in self.neighbors
        return known and not values & self.declined

    def declares(self, setting: str) -> bool:
        """Whether any value of a setting is declared, of whichever pass."""
        return any(name == setting for _, name, _ in self.more)


EVERYTHING = Selection()


class SelectedBackend:
    """A backend of which the chosen passes are asked.

    What it is known to lack is not asked again: an object tells which methods it has;
    of a program a pass is known to be missing when it wrote nothing for a case of the
    same words among its settings.
    """

    def __init__(self, backend: Backend, selection: Selection = EVERYTHING) -> None:
        self._backend, self.selection = backend, selection
        self.precision: Precision = backend.precision
        self.offer: Offer | None = getattr(backend, "offer", None)
        self._answered: set[tuple[str, ...]] = set()
        self._silent: set[tuple[str, ...]] = set()

    def remaining(self) -> float:
        """Seconds that are left to ask it, and to judge its answers."""
        return self._backend.remaining()

    def close(self) -> int:
        """Let go of processes and files; how many processes were left running."""
        return self._backend.close()

    def lacks(self, *names: str) -> bool:
        """Whether none of these passes can have an answer, as far as is known."""
        return all(map(self._lacks, names))

    def run(self, passes: Passes, cases: list[Case]) -> list[Outcome]:
        """Outcome of each case; ``None`` for those that are not chosen."""
        chosen = [case for case in cases if self._is_asked(passes, case)]
        found = self._backend.run(passes, chosen) if chosen else []
        outcomes = dict(zip(map(id, chosen), found, strict=True))
        self._answered |= {_words(c) for c in chosen if outcomes[id(c)] is not None}
        self._silent |= {_words(c) for c in chosen if outcomes[id(c)] is None}
        return [outcomes.get(id(case)) for case in cases]

    def _lacks(self, name: str) -> bool:
        if not self.selection.holds(name):
            return True
        if self.offer is not None:
            return name not in self.offer.passes
        names = [{words[0] for words in of} for of in (self._silent, self._answered)]
        return name in names[0] - names[1]

    def _is_asked(self, passes: Passes, case: Case) -> bool:
        return (
            self.selection.holds(case.pass_name)
            and self.selection.has_declared(passes, case)
            and self.selection.has_settings(passes, case)
            and self.selection.case in (None, case.name)
            and (self.offer is None or case.pass_name in self.offer.passes)
            and _words(case) not in self._silent - self._answered
        )


def selected(backend: Backend) -> SelectedBackend:
    """A backend that remembers what it lacks; the same one if it does already."""
    if isinstance(backend, SelectedBackend):
        return backend
    return SelectedBackend(backend)


def selection_of(backend: Backend) -> Selection:
    """What of a backend is asked."""
    return backend.selection if isinstance(backend, SelectedBackend) else EVERYTHING


def lacks(backend: Backend, names: Iterable[str]) -> bool:
    """Whether a backend is known to have none of these passes."""
    return isinstance(backend, SelectedBackend) and backend.lacks(*names)


def _words(case: Case) -> tuple[str, ...]:
    """A pass, and what its settings say in words, such as which target."""
    values = case.settings.values()
    return (case.pass_name, *(value for value in values if isinstance(value, str)))

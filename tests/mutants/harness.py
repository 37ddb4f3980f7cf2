"""Run the ladder with a mistake in the built-in backend, and in nothing else.

The oracle's scenes and cases are made once, by unedited code; a mutant is planted only
while the backend runs, and its outputs are judged by unedited code again.
"""

import warnings
from collections.abc import Iterator
from contextlib import nullcontext
from dataclasses import dataclass, field
from itertools import chain
from time import perf_counter
from typing import Any

from restir_gi.reference.oracle import ladder as oracle
from restir_gi.reference.oracle.builtin.backend import BuiltIn
from restir_gi.reference.oracle.cases import Case, Failure, Outcome, for_ever
from restir_gi.reference.oracle.contract.fields import Passes, Precision
from restir_gi.reference.oracle.parts import whole_contract
from restir_gi.reference.oracle.verdict import Verdict, run_ladder
from tests.mutants.catalogue import Mutant
from tests.mutants.plant import planted

CONTRACT = whole_contract()

EXACT = ("L0", "L1", "L2", "L3")
ALL = (*EXACT, "L4")

ASIDE = (
    "shifts of paths",
    "reuse of samples",
    "hash grid",
    "differences of pixels",
)
"""Steps of whole paths, which have mistakes of their own.  In the first the built-in
backend walks through scenes itself, where others have tables: another way to draw
directions is another walk there, though its distribution be the same."""

NEVER_PLANTED = (NameError, AttributeError, SyntaxError, ImportError)
"""What code raises that was edited badly: nothing is killed by it, and no test passes.
A mistake may raise anything else."""

STATISTICAL_SECONDS = 20.0
"""Of level L4, for one mutant."""


@dataclass(frozen=True, slots=True)
class Planted:
    """The built-in backend in this process, with a mistake while it runs.

    Attributes
    ----------
    mutant : Mutant or None
        The mistake; ``None`` for none.
    precision : 'float32' or 'float64'
        Of the backend.
    """

    mutant: Mutant | None
    precision: Precision = "float32"

    def run(self, passes: Passes, cases: list[Case]) -> list[Outcome]:
        """Outcome of each case; most exceptions are a failure to answer."""
        plant = planted(self.mutant) if self.mutant else nullcontext()
        with plant, warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return [self._outcome(case) for case in cases]

    def remaining(self) -> float:
        """Mutants are not timed."""
        return for_ever()

    def close(self) -> int:
        """Nothing is held."""
        return 0

    def _outcome(self, case: Case) -> Outcome:
        run = getattr(BuiltIn(self.precision), case.pass_name)
        try:
            return run(**case.inputs, **case.settings)
        except NEVER_PLANTED:
            raise
        except Exception as error:
            words = " ".join(str(error).split())[:300]
            return Failure(f"{case.name}: {type(error).__name__}: {words}")


@dataclass(frozen=True, slots=True)
class Kill:
    """What the ladder says of a mutant.

    Attributes
    ----------
    mutant : Mutant or None
        The mistake.
    seen : dict of str to bool
        Of each level that was run: whether it found a fault.
    seconds : float or None
        Until the end of the first step that found one.
    total : float
        Seconds of all steps.
    first : str
        First fault, one line.
    diagnoses : dict of str to tuple of str
        Names of hypotheses, of each pass that is wrong.
    status : str
        Of the verdict.
    """

    mutant: Mutant | None
    seen: dict[str, bool]
    seconds: float | None
    total: float
    first: str = ""
    diagnoses: dict[str, tuple[str, ...]] = field(default_factory=dict)
    status: str = "PASS"

    @property
    def levels(self) -> tuple[str, ...]:
        """Levels that see it."""
        return tuple(level for level, seen in self.seen.items() if seen)

    @property
    def killed(self) -> bool:
        """The verdict is FAIL: a departure that brings no bias is seen, and passes."""
        return self.status == "FAIL"

    @property
    def named(self) -> str:
        """How the diagnosis did: 'right', 'several', 'none' or 'WRONG'."""
        expected = set(self.mutant.expected) if self.mutant else set()
        told = [set(names) for names in self.diagnoses.values() if names]
        if any(not names & expected for names in told):
            return "WRONG"
        if not told:
            return "none"
        return "right" if set.union(*told) <= expected else "several"


def kill(
    mutant: Mutant | None,
    levels: tuple[str, ...] = EXACT,
    statistical: float = STATISTICAL_SECONDS,
    titles: tuple[str, ...] = (),
) -> Kill:
    """Run the ladder.

    Parameters
    ----------
    mutant : Mutant or None
        To plant; ``None`` runs the unedited code.
    levels : tuple of str
        Which of them.
    statistical : float, s
        For level L4, if it is among them.
    titles : tuple of str
        Of the steps; empty for all but `ASIDE`.

    Returns
    -------
    Kill
        What each level found.
    """
    backend = Planted(mutant)
    steps = _steps(backend, levels, statistical)
    chosen = (step for step in steps if _taken(step[1], titles))
    verdict = run_ladder(
        CONTRACT,
        backend.precision,
        chosen,
        float("inf"),
        perf_counter,
        lambda title: None,
    )
    return _told(mutant, verdict, levels)


def _told(mutant: Mutant | None, verdict: Verdict, levels: tuple[str, ...]) -> Kill:
    seen, seconds, total, first = dict.fromkeys(levels, False), None, 0.0, ""
    for timed in verdict.steps:
        total += timed.seconds
        faults = timed.step.faults
        if faults:
            seen[timed.step.level] = True
            if seconds is None:
                seconds, first = total, faults[0]
    diagnoses = {
        d.pass_name: tuple(h.name for h in d.matches) for d in verdict.diagnoses
    }
    return Kill(mutant, seen, seconds, total, first, diagnoses, verdict.status)


def _taken(title: str, titles: tuple[str, ...]) -> bool:
    return title in titles if titles else title not in ASIDE


def _steps(
    backend: Planted, levels: tuple[str, ...], statistical: float
) -> Iterator[Any]:
    steps = oracle.ladder(CONTRACT, backend)
    if "L4" in levels:
        steps = chain(steps, _statistical(backend, statistical))
    return (step for step in steps if step[0] in levels)


def _statistical(backend: Planted, seconds: float) -> Iterator[Any]:
    start = perf_counter()
    yield from oracle.statistical_levels(
        CONTRACT, backend, lambda: start + seconds - perf_counter()
    )

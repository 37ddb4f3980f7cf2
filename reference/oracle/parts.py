"""Parts of the contract beside its core: passes, with all that is needed to judge them.

Whoever has passes of their own registers a `Part` through the entry-point group
``restir.passes``; the further passes of this floor are one such part.  From then on the
ladder asks for them, golden folders hold them and the diagnosis knows their mistakes.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import entry_points
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any, Protocol

from numpy.typing import NDArray

from restir_gi.reference.oracle.contract.fields import Pass, Passes, Precision
from restir_gi.reference.oracle.contract.registry import CONTRACT
from restir_gi.reference.oracle.diagnosis.hypothesis import Hypothesis
from restir_gi.reference.oracle.replay.blocks import BY_ROW, in_blocks
from restir_gi.reference.oracle.replay.judges import JUDGES, Judge
from restir_gi.reference.system.errors import UsageError

if TYPE_CHECKING:
    from restir_gi.reference.oracle.levels.probe import Probe

SEED = 1
"""Of rows that are random, unless another is asked for."""

GROUP = "restir.passes"
OWN = ("restir_gi.reference.oracle.levels.further_part:FURTHER_PART",)

PassFunction = Callable[..., dict[str, NDArray[Any]]]


class Probes(Protocol):
    """What a backend is asked of a part, on any levels."""

    def __call__(self, precision: Precision, seed: int = SEED, /) -> "list[Probe]":
        """Questions, with rows that depend on the seed wherever they are random."""


class Frames(Protocol):
    """What takes longer to make, of level L3."""

    def __call__(
        self, precision: Precision, names: frozenset[str], seed: int = SEED, /
    ) -> "list[Probe]":
        """Questions about passes that have answered the others of that level.

        Parameters
        ----------
        names : frozenset of str; of the passes
        """


def no_frames(
    precision: Precision, names: frozenset[str], seed: int = SEED
) -> "list[Probe]":
    """No probes: those of the part are soon made."""
    return []


def nothing_more(precision: Precision, seed: int = SEED) -> "list[Probe]":
    """No probes: no setting of the part has to be declared."""
    return []


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """Passes that belong together.

    Attributes
    ----------
    title : str; of their steps of the ladder
    passes : tuple of Pass; with names that no other part has
    judges : mapping of str to callable
        What judges each pass: its case, outputs, rules and precision give a
        `Judgement`.
    own : mapping of str to callable
        The project's own passes: a precision, the buffers and the settings give the
        outputs.
    probes : callable
        From a precision and a seed to what a backend is asked, on any levels.
    hypotheses : tuple of Hypothesis
        Known mistakes; `Rules.part` holds what these judges calculate with.
    frames : callable
        What takes longer to make, for level L3: from a precision, the names of the
        passes that have answered the probes of that level, and a seed.
    more : callable
        As ``probes``: what only a backend is asked that declares values of settings.
    """

    title: str
    passes: tuple[Pass, ...]
    judges: Mapping[str, Judge]
    own: Mapping[str, PassFunction]
    probes: Probes
    hypotheses: tuple[Hypothesis, ...] = field(default=())
    frames: Frames = no_frames
    more: Probes = nothing_more


@cache
def parts() -> tuple[Part, ...]:
    """All parts beside the core, ours first, then those of plug-ins.

    In the order of the names under which they are registered.

    Raises UsageError: a package registers what is no part, or a pass that exists.
    """
    found = [resolve_name(place) for place in OWN]
    points = sorted(entry_points(group=GROUP), key=lambda point: point.name)
    for point in points:
        part = point.load()
        if not isinstance(part, Part):
            raise UsageError(
                f"entry point {point.name} of {GROUP} is {type(part).__name__}, not a"
                " Part"
            )
        found.append(part)
    names = [*CONTRACT, *(p.name for part in found for p in part.passes)]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise UsageError(f"{GROUP}: several parts have a pass {', '.join(twice)}")
    return tuple(found)


def whole_contract() -> Passes:
    """All passes of the contract: the core's, then those of all parts."""
    return {**CONTRACT, **{p.name: p for part in parts() for p in part.passes}}


def judge_of(pass_name: str) -> Judge:
    """What judges a pass, from case, outputs, rules and precision to a `Judgement`."""
    if pass_name in JUDGES:
        judge = JUDGES[pass_name]
        return in_blocks(judge) if pass_name in BY_ROW else judge
    return next(p.judges[pass_name] for p in parts() if pass_name in p.judges)

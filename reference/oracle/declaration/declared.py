"""What a declaration says, for those who judge by it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from restir_gi.reference.oracle.backends.selected import EVERYTHING, Selection
from restir_gi.reference.oracle.contract.passes import ASKED, VISIBILITY
from restir_gi.reference.oracle.diagnosis.hypothesis import Hypothesis, combined
from restir_gi.reference.oracle.replay.rules import Rules
from restir_gi.reference.system.errors import UsageError

Generator = Literal["contract", "own"]


@dataclass(frozen=True, slots=True, eq=False)
class Declaration:
    """What a backend says of itself.

    Attributes
    ----------
    selection : Selection; what it has, and is asked
    hypotheses : tuple of Hypothesis
        Its choices that are other than the contract's, each once.  ``passes`` are those
        in which it makes them; ``departure`` is their kind, and never empty: it is
        'bias' of what is known to be biased.
    accept : frozenset of str
        Names of choices whose bias is accepted; see `accepts`.
    generator : 'contract' or 'own'
        Whether its random numbers are those of pass ``random``.
    has : mapping; the table ``[has]`` as it was given
    pixel : 'center' or 'box'; where the camera rays of its pictures begin
    apart : frozenset of str; passes that make other choices than the others
    """

    selection: Selection = EVERYTHING
    hypotheses: tuple[Hypothesis, ...] = ()
    accept: frozenset[str] = frozenset()
    generator: Generator = "contract"
    has: Mapping[str, Any] = field(default_factory=dict)
    pixel: Literal["center", "box"] = "center"
    apart: frozenset[str] = frozenset()

    @property
    def says_anything(self) -> bool:
        """Whether it is more than nothing."""
        asked = self.selection != EVERYTHING or bool(self.has)
        about = self.generator != "contract" or self.pixel != "center"
        return bool(self.hypotheses) or asked or about

    @property
    def shading_sees(self) -> bool:
        """Whether the shading asks what the visible point sees.

        It is said to have the setting, or to test visibility there alone.
        """
        has = ("shade", VISIBILITY.name, ASKED) in self.selection.more
        return has or any(not h.rules.visibility_in_weight for h in self.hypotheses)

    @property
    def rules(self) -> Rules:
        """Rules of all choices together.

        Raises UsageError: it makes others in one pass than elsewhere; `rules_of` gives
        those of a pass.
        """
        if self.apart:
            raise UsageError(
                f"{', '.join(sorted(self.apart))} makes other choices than the others;"
                " ask for the rules of one pass"
            )
        return combined(self.hypotheses)

    def of_pass(self, pass_name: str) -> tuple[Hypothesis, ...]:
        """Choices that it makes in a pass."""
        return tuple(h for h in self.hypotheses if pass_name in h.passes)

    def rules_of(self, pass_name: str) -> Rules:
        """Rules of a pass."""
        return combined(self.of_pass(pass_name))

    def accepts(self, name: str) -> bool:
        """Whether the bias of a choice is accepted.

        By its name, or by the words that it begins with: ``jacobian-clamped`` stands
        for ``jacobian-clamped-to-3``.
        """
        return any(name == word or name.startswith(f"{word}-") for word in self.accept)


NOTHING_DECLARED = Declaration()

"""A Python backend in this very process: for tests, where that is what is wanted."""

from typing import Any

from restir_gi.reference.oracle.backends.offer import (
    Offer,
    declaration_of,
    offer_of,
    shown_traceback,
)
from restir_gi.reference.oracle.cases import (
    NO_TIME,
    Case,
    Failure,
    Outcome,
    Remaining,
    for_ever,
)
from restir_gi.reference.oracle.contract.fields import Passes, Precision
from restir_gi.reference.oracle.host_arrays import answered_arrays


class InsideBackend:
    """A Python object with one method a pass, called directly.

    Parameters
    ----------
    target : object
        The backend.  If it takes the process down, the tests go with it; a call that
        does not return cannot be stopped.
    remaining : callable; seconds that are left: no call begins after that
    names : tuple of str; passes of the contract, to see which of them it has
    """

    def __init__(
        self,
        target: Any,
        remaining: Remaining = for_ever,
        names: tuple[str, ...] = (),
    ) -> None:
        self._target, self.remaining = target, remaining
        self.offer: Offer | None = offer_of(target, names) if names else None
        self.precision: Precision = getattr(target, "precision", "float32")
        self.declaration = declaration_of(target)

    def run(self, passes: Passes, cases: list[Case]) -> list[Outcome]:
        """Outcome of each case."""
        return [self._call(case) for case in cases]

    def close(self) -> int:
        """Nothing is held."""
        return 0

    def _call(self, case: Case) -> Outcome:
        method = getattr(self._target, case.pass_name, None)
        if method is None:
            return None
        if self.remaining() <= 0:
            return NO_TIME
        # Its own, to write into: others are asked the case, and judged by it.
        inputs = {name: array.copy() for name, array in case.inputs.items()}
        try:
            outputs = method(**inputs, **case.settings)
            return answered_arrays(outputs)
        except NotImplementedError:
            return None
        except Exception as error:
            words = " ".join(str(error).split())
            reason = f"{case.name}: {type(error).__name__}: {words}"
            return Failure(reason, output=shown_traceback(error))

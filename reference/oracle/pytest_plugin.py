"""A plug-in of pytest: the fixture ``restir_oracle``.

It is there wherever the project is installed::

    def test_my_shaders(restir_oracle):
        restir_oracle.check(MyBackend())            # an object with one method a pass
        restir_oracle.check("./backend {directory}")  # or what `restir check` takes
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from restir_gi.reference.oracle.verdict import Verdict


MOST_REASONS = 5
"""Of a verdict that says too little, that are printed."""


class Oracle:
    """What the fixture gives."""

    def check(
        self,
        backend: Any,
        budget: float = 300.0,
        statistics: bool = False,
        require: Collection[str] = (),
        only: Collection[str] = (),
        skip: Collection[str] = (),
        seed: int = 1,
        extremes: bool = False,
        declared: Collection[str] = (),
        declaration: Path | str | Mapping[str, Any] | None = None,
        accept: Collection[str] = (),
    ) -> Verdict:
        """Judge a backend, and fail the test if it is wrong; else return the verdict.

        The test fails, too, where nothing was judged, and where the time was over
        before level L3 was done: such a verdict says nothing of the backend.

        Raises UsageError: there is no such backend or pass, or what is declared cannot
        be.

        Parameters
        ----------
        backend : object or str
            An object is called in this process; a string is what ``restir check``
            takes, and runs in another.
        budget : float, s
            No step begins after that.
        statistics : bool
            Whole runs too: it takes some ten seconds, and certifies the mean; what is
            left of these for lack of time does not fail the test.
        require : collection of str; passes that the backend must have, and pass
        only, skip : collection of str; passes that alone are asked, or are not
        seed : int; of all rows that are random
        extremes : bool; fail also for what is wrong beyond the working range alone
        declared : collection of str; choices that the renderer makes, by name
        declaration : path or mapping, optional
            What the renderer has and which choices it makes; an object may have it as
            its attribute ``declaration``.
        accept : collection of str; declared choices whose bias does not fail
        """
        # Imported here: a test run that never asks should not wait for Embree.
        from restir_gi.reference.oracle.checking import (
            judge,
            selection_of,
            told,
            unjudged,
        )

        __tracebackhide__ = True
        verdict = judge(
            backend,
            budget,
            statistics,
            seed=seed,
            selection=selection_of(only, skip),
            require=require,
            extremes=extremes,
            declared=declared,
            declaration=declaration,
            accept=accept,
        )
        if verdict.status == "FAIL":
            pytest.fail(told(verdict), pytrace=False)
        if reasons := unjudged(verdict):
            pytest.fail("\n".join(reasons[:MOST_REASONS]), pytrace=False)
        return verdict


@pytest.fixture(scope="session")
def restir_oracle() -> Oracle:
    """The oracle: ``restir_oracle.check(backend)`` fails if the backend is wrong."""
    return Oracle()

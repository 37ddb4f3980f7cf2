"""A plug-in of pytest: the fixture ``restir_oracle``.

It is there wherever the project is installed::

    def test_my_shaders(restir_oracle):
        restir_oracle.check(MyBackend())            # an object with one method a pass
        restir_oracle.check("./backend {directory}")  # or what `restir check` takes
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from restir_gi.reference.oracle.verdict import Verdict


class Oracle:
    """What the fixture gives."""

    def check(
        self, backend: Any, budget: float = 60.0, statistics: bool = False
    ) -> Verdict:
        """Judge a backend, and fail the test if it is wrong; else return the verdict.

        Raises UsageError: there is no such backend.

        Parameters
        ----------
        backend : object or str
            An object is called in this process; a string is what ``restir check``
            takes, and runs in another.
        budget : float, s
            No step begins after that; what is left out does not fail the test.
        statistics : bool
            Whole runs too: it takes some ten seconds, and certifies the mean.
        """
        # Imported here: a test run that never asks should not wait for Embree.
        from restir_gi.reference.oracle.checking import judge, told

        __tracebackhide__ = True
        verdict = judge(backend, budget, statistics)
        if verdict.status == "FAIL":
            pytest.fail(told(verdict), pytrace=False)
        return verdict


@pytest.fixture(scope="session")
def restir_oracle() -> Oracle:
    """The oracle: ``restir_oracle.check(backend)`` fails if the backend is wrong."""
    return Oracle()

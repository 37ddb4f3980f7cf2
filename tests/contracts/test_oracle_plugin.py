"""The fixture that other people's tests use."""

import sys

import pytest

from restir_gi.reference.oracle.builtin.backend import FLOAT32
from restir_gi.reference.oracle.pytest_plugin import Oracle
from tests.contracts.oracle_backends import EMPTY, NAN, PARTIAL

pytest_plugins = ["pytester"]


def test_a_right_backend_passes(restir_oracle):
    assert restir_oracle.check(FLOAT32, budget=20).status == "PASS"


def test_a_subset_is_judged(restir_oracle):
    verdict = restir_oracle.check(PARTIAL, budget=20)
    assert verdict.status == "PASS"
    assert "spatial" in verdict.absent


def test_of_nothing_nothing_is_said(restir_oracle):
    """The built-in passes stand in for what is missing, and must not be praised."""
    verdict = restir_oracle.check(EMPTY, budget=60, statistics=True)
    assert verdict.status == "UNDECIDED"
    assert verdict.certified is None
    assert all(timed.step.findings == [] for timed in verdict.steps)


def test_a_wrong_backend_fails_the_test():
    with pytest.raises(pytest.fail.Exception, match="holds NaN"):
        Oracle().check(NAN, budget=20)


def test_the_plugin_is_there_without_being_asked_for(pytester):
    """In a process of its own, as whoever installs the project finds it."""
    pytester.makepyfile(
        """
        import numpy as np

        class Mine:
            def shade(self, W, **rest):
                return {"color": np.zeros((len(W), 3), np.float32)}

        def test_mine(restir_oracle):
            restir_oracle.check(Mine(), budget=20)
        """
    )
    result = pytester.run(
        sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"
    )
    assert result.ret == 1
    result.stdout.fnmatch_lines(["*shade-cornell-box*rows are wrong*"])

"""The fixture that other people's tests use."""

import sys

import pytest

from restir_gi.reference.oracle.builtin.backend import FLOAT32
from restir_gi.reference.oracle.checking import judge
from restir_gi.reference.oracle.pytest_plugin import Oracle
from restir_gi.reference.system.errors import UsageError
from tests.contracts.oracle_backends import EMPTY, NAN, PARTIAL

pytest_plugins = ["pytester"]


def test_a_right_backend_passes(restir_oracle):
    assert restir_oracle.check(FLOAT32, budget=120).status == "PASS"


def test_a_subset_is_judged(restir_oracle):
    verdict = restir_oracle.check(PARTIAL, budget=120)
    assert verdict.status == "PASS"
    assert "spatial" in verdict.absent


def failure(backend, **options):
    """Why the test of a backend fails."""
    with pytest.raises(pytest.fail.Exception) as found:
        Oracle().check(backend, **options)
    return str(found.value)


def test_of_nothing_nothing_is_said():
    """The built-in passes stand in for what is missing, and must not be praised."""
    verdict = judge(EMPTY, 60.0)
    assert verdict.status == "UNDECIDED"
    assert verdict.certified is None
    assert all(timed.step.findings == [] for timed in verdict.steps)


@pytest.mark.parametrize("backend", [EMPTY, object()])
def test_nothing_judged_is_no_success(backend):
    assert "nothing was judged" in failure(backend)


def test_a_name_that_looks_like_a_pass_is_told(restir_oracle):
    class Misspelt:
        """Its only pass has another name."""

        jacobain = staticmethod(FLOAT32.jacobian)

    told = "jacobain is no pass of the contract; did you mean jacobian?"
    assert told in failure(Misspelt())
    Misspelt.shade = staticmethod(FLOAT32.shade)
    assert restir_oracle.check(Misspelt(), budget=120).near == [told]


def test_a_budget_that_ends_before_the_frames_is_no_success():
    assert "no time was left for L0 kernels" in failure(FLOAT32, budget=0.0)


def test_a_required_pass_must_be_there():
    told = "spatial is required, and the backend does not have it"
    assert told in failure(PARTIAL, budget=120, require=("shade", "spatial"))


def test_passes_are_chosen(restir_oracle):
    verdict = restir_oracle.check(FLOAT32, budget=120, only=("jacobian", "shade"))
    assert verdict.judged == {"jacobian", "shade"}
    assert verdict.absent == []
    verdict = restir_oracle.check(PARTIAL, budget=120, skip=("shade",))
    assert verdict.judged == {"jacobian"}
    with pytest.raises(UsageError, match=r"'jacobain'; did you mean jacobian\?"):
        restir_oracle.check(PARTIAL, require=("jacobain",))


def test_a_wrong_backend_fails_the_test():
    with pytest.raises(pytest.fail.Exception, match="holds NaN"):
        Oracle().check(NAN, budget=120)


def test_the_plugin_is_there_without_being_asked_for(pytester):
    """In a process of its own, as whoever installs the project finds it."""
    pytester.makepyfile(
        """
        import numpy as np

        class Mine:
            def shade(self, W, **rest):
                return {"color": np.zeros((len(W), 3), np.float32)}

        def test_mine(restir_oracle):
            restir_oracle.check(Mine(), budget=120)
        """
    )
    result = pytester.run(
        sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"
    )
    assert result.ret == 1
    result.stdout.fnmatch_lines(["*shade-cornell-box*rows are wrong*"])

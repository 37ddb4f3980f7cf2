"""What all tests share: profiles of Hypothesis, golden files, scenes from outside."""

import os
import signal
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

# How long an example takes says nothing about whether it is right.
NO_CLOCK = {"deadline": None, "suppress_health_check": [HealthCheck.too_slow]}

# The same examples everywhere, every time.
settings.register_profile(
    "repeatable", derandomize=True, database=None, max_examples=30, **NO_CLOCK
)
# HYPOTHESIS_PROFILE=search: other examples at every run, and failures are kept.
settings.register_profile(
    "search", max_examples=2000, print_blob=True, derandomize=False, **NO_CLOCK
)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))

# In a background job of a shell Ctrl-C is ignored, and so it would be by every process
# that a test starts, some of them to interrupt it.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_addoption(parser):
    """Add ``--regenerate``."""
    parser.addoption(
        "--regenerate",
        action="store_true",
        help="write the files of tests/golden again, from the code as it is",
    )


@pytest.fixture(scope="session")
def regenerate(request):
    """Whether golden files are to be written instead of compared."""
    return request.config.getoption("--regenerate")


@pytest.fixture(scope="session")
def scenes_folder():
    """Real scenes: RESTIR_SCENES, or ``shared/scenes`` beside the checkout."""
    beside = Path(__file__).parents[2] / "shared" / "scenes"
    folder = Path(os.environ.get("RESTIR_SCENES", beside))
    if not folder.is_dir():
        pytest.skip("set RESTIR_SCENES to a folder of real scenes")
    return folder


@pytest.fixture(autouse=True)
def _floating_point_errors_are_seen():
    """No test and no kernel may silence NumPy for those that follow.

    Division by 0, overflow and invalid operations warn, and warnings are failures
    (pyproject.toml).  Underflow to 0 is what small numbers do.
    """
    expected = {"divide": "warn", "over": "warn", "invalid": "warn", "under": "ignore"}
    assert np.geterr() == expected
    yield
    assert np.geterr() == expected

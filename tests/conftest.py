"""What all tests share: profiles of Hypothesis, golden files, scenes from outside."""

import os
import random
import signal
import time
from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

from restir_gi.reference.truth.pictures import PLACE

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


LATE = "no time left of the"


def pytest_addoption(parser):
    """Add ``--regenerate``, ``--minutes`` and ``--order``."""
    parser.addoption(
        "--regenerate",
        action="store_true",
        help="write the files of tests/golden again, from the code as it is",
    )
    parser.addoption(
        "--minutes",
        type=float,
        default=float("inf"),
        help="begin no test later than that; those left are skipped, and listed",
    )
    parser.addoption(
        "--order",
        metavar="WORD",
        help="files in an order that WORD decides, so that all have their turn",
    )


@pytest.hookimpl(tryfirst=True)  # before marks are selected by
def pytest_collection_modifyitems(config, items):
    """Files in another order; the tests of each stay together, and share fixtures."""
    _leave_few(items)
    word = config.getoption("--order")
    if word is not None:
        files = sorted({item.path for item in items})
        random.Random(word).shuffle(files)
        places = {path: place for place, path in enumerate(files)}
        items.sort(key=lambda item: places[item.path])


def _leave_few(items):
    """Make all but some parameters of each test with ``few`` slow, evenly spread."""
    families = defaultdict(list)
    for item in items:
        if item.get_closest_marker("few") and not item.get_closest_marker("slow"):
            families[item.path, item.originalname].append(item)
    for family in families.values():
        (count,) = family[0].get_closest_marker("few").args
        stay = np.linspace(0, len(family) - 1, min(count, len(family))).round()
        for place, item in enumerate(family):
            if place not in stay:
                item.add_marker(pytest.mark.slow)


def pytest_sessionstart(session):
    """Note when the time of ``--minutes`` begins."""
    session.config.began = time.monotonic()


def pytest_runtest_setup(item):
    """Skip what would begin too late."""
    minutes = item.config.getoption("--minutes")
    if time.monotonic() - item.config.began > 60.0 * minutes:
        pytest.skip(f"{LATE} {minutes:g} minutes")


def pytest_terminal_summary(terminalreporter):
    """List what was skipped for want of time."""
    skipped = terminalreporter.stats.get("skipped", [])
    late = [one.nodeid for one in skipped if LATE in str(one.longrepr)]
    if late:
        terminalreporter.section(f"{len(late)} tests found no time")
        for name in late:
            terminalreporter.line(name)


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


@pytest.fixture(autouse=True, scope="session")
def truths_of_these_tests(tmp_path_factory):
    """Truths of pictures are kept apart from those of whoever runs the tests."""
    os.environ[PLACE] = str(tmp_path_factory.mktemp("truths"))


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

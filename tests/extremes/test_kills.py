"""Killed at random moments, nothing is lost and nobody is left: see `kills`."""

import os
import subprocess
import sys
import time

import pytest

from restir_gi.reference.oracle.backends.descendants import end_marked, marked
from tests.extremes import kills

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != "linux", reason="processes are found in /proc"),
]


@pytest.mark.parametrize("command", ["reference", "tradeoff"])
def test_a_handful_of_kills(command, capsys):
    assert kills.main(["--count", "3", "--seed", "7", "--only", command]) == 0, (
        capsys.readouterr().out
    )


ORPHAN = """
import subprocess, sys, time
subprocess.Popen(["sleep", "300"])
time.sleep(300)
"""


def test_control_a_process_that_outlives_its_parent_is_counted(monkeypatch):
    monkeypatch.setattr(kills, "GRACE", 0.5)
    mark = "RESTIR_TEST_ORPHAN"
    run = subprocess.Popen(
        [sys.executable, "-c", ORPHAN], env={**os.environ, mark: "1"}
    )
    try:
        while len(marked(mark)) < 2:
            time.sleep(0.05)
        run.kill()
        run.wait()
        assert kills.left_of(mark) == 1
    finally:
        assert end_marked(mark) == 1

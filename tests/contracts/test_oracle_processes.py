"""Whatever a backend does, the oracle lives on and says in one line what it was."""

import time
from pathlib import Path

import pytest

from restir_gi.reference.oracle.backends.command import ProgramBackend
from restir_gi.reference.oracle.backends.inside import InsideBackend
from restir_gi.reference.oracle.backends.process import PythonBackend
from restir_gi.reference.oracle.backends.running import Limits
from restir_gi.reference.oracle.levels.kernels import kernel_probes
from restir_gi.reference.oracle.parts import whole_contract
from restir_gi.reference.oracle.steps import asked
from restir_gi.reference.system.errors import UsageError

CONTRACT = whole_contract()

MODULE = f"{Path(__file__).parent / 'oracle_backends.py'}"
LIMITS = Limits(seconds=20, memory=2 * 2**30)


def probes():
    found = kernel_probes("float32")
    return [p for p in found if p.case.pass_name in ("jacobian", "merge")]


def answers(backend):
    try:
        return asked("L0", "all", CONTRACT, backend, probes()).answers
    finally:
        backend.close()


def python(name, limits=LIMITS):
    return answers(PythonBackend(f"{MODULE}:{name}", limits))


def faults(found):
    return [a.finding.text for a in found if a.finding and not a.finding.passed]


def test_a_right_backend_passes():
    assert faults(python("RIGHT")) == []


def test_prints_of_a_backend_are_not_taken_for_answers():
    assert faults(python("LOUD")) == []


def test_passes_that_are_missing_are_not_judged():
    found = python("PARTIAL")
    judged = {a.probe.case.pass_name for a in found if a.finding}
    assert judged == {"jacobian"}
    assert faults(found) == []


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("RAISES", "ValueError: the buffer is not mapped"),
        ("DIES", "killed by SIGSEGV"),
        ("EXITS", "exit code 7: device lost"),
        ("HUNGRY", "MemoryError"),
        ("NOTHING", "jacobian is missing"),
        ("NO_MAPPING", "TypeError"),
        ("SHORT", "shape (2047,) instead of (2048,)"),
        ("TRANSPOSED", "shape (1, 2048) instead of (2048,)"),
        ("DOUBLE", "float64 instead of float32"),
        ("WHOLE", "int32 instead of float32"),
        ("SWAPPED", "other byte order"),
        ("NAN", "holds NaN"),
        ("INFINITE", "infinity"),
        ("OBJECTS", "ValueError"),
    ],
)
@pytest.mark.few(5)
def test_each_failure_is_named_and_the_other_passes_are_judged(name, words):
    found = python(name)
    text = faults(found)
    assert any(words in line for line in text), text
    assert all("\n" not in line for line in text)
    merges = [a for a in found if a.probe.case.pass_name == "merge"]
    assert all(a.finding.passed for a in merges)


def test_a_backend_that_hangs_is_stopped():
    found = python("HANGS", Limits(seconds=2.0))
    (fault,) = faults(found)  # it is not asked again
    assert "no answer within 2 s" in fault


@pytest.mark.parametrize(
    ("spec", "words"),
    [
        (f"{MODULE}:ABSENT", "has no 'ABSENT'"),
        ("no_such_module:BACKEND", "cannot import no_such_module"),
        ("no_such_file.py", "no file no_such_file.py"),
    ],
)
def test_what_cannot_be_loaded_is_bad_usage(spec, words):
    with pytest.raises(UsageError, match=words):
        PythonBackend(spec, LIMITS)


# ---------------------------------------------------------------- programs


def program(tmp_path, body, limits=LIMITS):
    """A shell script as a backend."""
    path = tmp_path / "backend.sh"
    path.write_text(f"#!/bin/sh\n{body}\n", encoding="utf-8")
    path.chmod(0o755)
    return answers(ProgramBackend(f"{path} {{directory}}", limits))


def test_a_program_that_writes_nothing_has_no_pass(tmp_path):
    assert all(a.finding is None for a in program(tmp_path, "exit 0"))


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ("echo no device >&2; exit 3", "exit code 3: no device"),
        ("kill -ABRT $$", "killed by SIGABRT"),
        (
            'for d in "$1"/*/out; do printf abc > "$d/jacobian.raw"; done',
            "truncated: 3 bytes instead of",
        ),
    ],
)
def test_a_program_that_fails_is_told(tmp_path, body, words):
    text = faults(program(tmp_path, body))
    assert text
    assert any(words in line for line in text)


def test_a_program_that_hangs_is_stopped(tmp_path):
    text = faults(program(tmp_path, "exec sleep 600", Limits(seconds=0.3)))
    assert all("did not end within" in line for line in text)


def test_what_a_program_has_started_is_stopped_with_it(tmp_path):
    """A wrapper's child would go on, and hold its pipes."""
    body = f"sleep 600 & echo $! >> {tmp_path}/children; wait"
    text = faults(program(tmp_path, body, Limits(seconds=0.3)))
    assert all("did not end within" in line for line in text)
    children = (tmp_path / "children").read_text().split()
    deadline = time.monotonic() + 10
    while any(is_alive(int(child)) for child in children):
        assert time.monotonic() < deadline
        time.sleep(0.05)


def is_alive(process):
    """Whether a process still runs; one that waits to be reaped does not."""
    try:
        state = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False
    return state not in "ZX"


def test_a_backend_that_does_not_start_again_is_told(tmp_path):
    """It dies in its first call, and the second time it cannot be loaded."""
    path = tmp_path / "once.py"
    path.write_text(
        """
import os, pathlib
mark = pathlib.Path(__file__).with_name("mark")
if mark.exists():
    raise RuntimeError("device lost")
mark.touch()
class Once:
    def jacobian(self, **given):
        os._exit(1)
BACKEND = Once()
""",
        encoding="utf-8",
    )
    found = answers(PythonBackend(str(path), LIMITS))
    text = faults(found)
    assert len(text) == len(found)
    assert "exit code 1" in text[0]
    assert all("device lost" in line for line in text[1:])


def test_a_program_that_does_not_exist_is_bad_usage():
    backend = ProgramBackend("/no/such/program {directory}", LIMITS)
    with pytest.raises(UsageError, match="cannot run /no/such/program"):
        answers(backend)


def test_output_and_traceback_of_a_call_that_failed_are_kept(tmp_path):
    path = tmp_path / "loud.py"
    path.write_text(
        """
class Loud:
    def jacobian(self, **given):
        print("adapter: none")
        return self._mapped()

    def _mapped(self):
        raise ValueError("the buffer is not mapped")
BACKEND = Loud()
""",
        encoding="utf-8",
    )
    found = answers(PythonBackend(str(path), LIMITS))
    output = next(a.finding.output for a in found if a.finding)
    assert "adapter: none\nTraceback" in output
    assert "in _mapped" in output
    assert "worker.py" not in output
    assert output.endswith("ValueError: the buffer is not mapped")


@pytest.mark.parametrize("end", ["exit 3", "kill -ABRT $$", "exec sleep 600"])
def test_both_streams_of_a_program_that_failed_are_kept(tmp_path, end):
    body = f"echo starting; echo no device >&2; {end}"
    path = tmp_path / "backend.sh"
    path.write_text(f"#!/bin/sh\n{body}\n", encoding="utf-8")
    path.chmod(0o755)
    limits = Limits(seconds=1.0)
    found = answers(ProgramBackend(f"{path} {{directory}}", limits))
    assert found[0].finding.output == "starting\nno device"


def test_an_object_in_this_process_has_a_traceback():
    class Broken:
        """It raises."""

        def jacobian(self, **given):
            """Fail."""
            raise ValueError("lost")

    (answer, *_) = [a for a in answers(InsideBackend(Broken())) if a.finding]
    assert answer.finding.output.startswith("Traceback")
    assert "in jacobian" in answer.finding.output
    assert "inside.py" not in answer.finding.output

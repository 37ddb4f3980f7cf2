"""Whatever a backend does: no waiting, no memory without bound, nothing left behind.

And what is no fault of a backend is not held against it: a full disk, the end of the
budget, a kill from outside.
"""

import os
import resource
import shutil
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import numpy as np
import pytest

from restir_gi.reference.cli import check
from restir_gi.reference.cli.main import main
from restir_gi.reference.oracle.backends.command import ProgramBackend
from restir_gi.reference.oracle.backends.descendants import end_marked, marked
from restir_gi.reference.oracle.backends.inside import InsideBackend
from restir_gi.reference.oracle.backends.process import PythonBackend
from restir_gi.reference.oracle.backends.running import LAST_BYTES, LastWords, Limits
from restir_gi.reference.oracle.blackbox.renderer import Renderer
from restir_gi.reference.oracle.builtin.backend import FLOAT32
from restir_gi.reference.oracle.cases import (
    NO_TIME,
    NOT_AGAIN,
    Failure,
    Unasked,
    UnaskedError,
)
from restir_gi.reference.oracle.checking import judge
from restir_gi.reference.oracle.levels.kernels import kernel_probes
from restir_gi.reference.oracle.parts import whole_contract
from restir_gi.reference.oracle.verdict import Verdict
from restir_gi.reference.system.errors import UsageError

pytestmark = pytest.mark.skipif(
    sys.platform != "linux", reason="processes are found in /proc"
)

SLOW = pytest.mark.slow
ROOT = Path(__file__).parents[2]
MODULE = Path(__file__).with_name("hostile_backends.py")
CONTRACT = whole_contract()
PASSES = ("jacobian", "merge")
CASES = [p.case for p in kernel_probes("float32") if p.case.pass_name in PASSES]
JACOBIANS = [case for case in CASES if case.pass_name == "jacobian"]


def left_after(seconds):
    """How much of so many seconds is left."""
    end = time.monotonic() + seconds
    return lambda: end - time.monotonic()


def outcomes(backend, cases=CASES):
    """Of a backend, and the processes that it had left."""
    try:
        found = backend.run(CONTRACT, cases)
    finally:
        left = backend.close()
    return found, left


def python(name, limits=None, remaining=None, cases=CASES):
    more = [remaining] if remaining else []
    backend = PythonBackend(f"{MODULE}:{name}", limits or Limits(), *more)
    return outcomes(backend, cases)


def program(tmp_path, body, limits=None, remaining=None, cases=JACOBIANS):
    """A shell script as a backend; ``$1`` is the folder of the cases."""
    path = tmp_path / "backend.sh"
    path.write_text(f"#!/bin/sh\n{body}\n", encoding="utf-8")
    path.chmod(0o755)
    more = ["float32", remaining] if remaining else []
    backend = ProgramBackend(f"{path} {{directory}}", limits or Limits(), *more)
    return outcomes(backend, cases)


def reasons(found):
    lines = [outcome.reason for outcome in found if isinstance(outcome, Failure)]
    assert all(len(line.splitlines()) == 1 for line in lines)
    return lines


# ---------------------------------------------------------------- outputs

EACH = 'for f in $(awk \'$1 == "out" {print $NF}\' "$1/cases.txt"); do %s "$1/$f"; done'
PACKED = 'for d in "$1"/*/; do cp %s "$d/out.npz"; done'


@pytest.mark.parametrize(
    ("command", "words"),
    [
        ("mkfifo", "a device or a pipe"),
        ("ln -s /dev/zero", "a device or a pipe"),
        ("mkdir", "it is a folder"),
        ("ln -s /no/such/file", "No such file"),
        ("truncate -s 500M", "at most"),
    ],
)
def test_outputs_are_regular_files_of_the_promised_size(tmp_path, command, words):
    """None is waited for, and none is read further than the contract goes."""
    start = time.monotonic()
    found, _ = program(tmp_path, EACH % command)
    assert len(reasons(found)) == len(JACOBIANS)
    assert all(words in line for line in reasons(found))
    assert time.monotonic() - start < 20


def test_a_file_larger_than_any_is_not_even_written(tmp_path):
    found, _ = program(tmp_path, EACH % "truncate -s 40G")
    assert all("truncated: 0 bytes" in line for line in reasons(found))
    assert len(reasons(found)) == len(JACOBIANS)


def bomb(path):
    """A small NPZ that unpacks to much."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        file.writestr("jacobian.npy", bytes(2**26))


def promising(path):
    """A header that claims more than any memory."""
    header = "{'descr': '<f4', 'fortran_order': False, 'shape': (10000000000000,), }"
    member = b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header.encode()
    with zipfile.ZipFile(path, "w") as file:
        file.writestr("jacobian.npy", member)


def no_archive(path):
    with path.open("wb") as file:
        np.save(file, np.zeros(1))


def damaged(path):
    """Compressed data with flipped bits."""
    numbers = np.random.default_rng(1).random(2048)
    np.savez_compressed(path, jacobian=numbers)
    contents = bytearray(path.read_bytes())
    contents[80:400] = bytes(b ^ 0x55 for b in contents[80:400])
    path.write_bytes(contents)


@pytest.mark.parametrize("make", [bomb, promising, no_archive, damaged])
def test_archives_of_nonsense_are_faults(tmp_path, make):
    archive = tmp_path / "archive.npz"
    make(archive)
    found, _ = program(tmp_path, PACKED % archive)
    assert len(reasons(found)) == len(JACOBIANS)
    assert all("out.npz" in line for line in reasons(found))


# ---------------------------------------------------------------- what is said


def test_the_last_words_are_kept_and_no_others():
    process = subprocess.Popen(
        ["sh", "-c", "yes no | head -c 30000000; echo the last line"],
        stdout=subprocess.PIPE,
    )
    said = LastWords(process.stdout)
    process.wait()
    assert said.last_line() == "the last line"
    assert len(said._kept) <= LAST_BYTES


def test_a_program_that_complains_without_end_is_stopped(tmp_path):
    found, _ = program(tmp_path, "exec yes AAAAAAAA >&2", Limits(0.3), cases=CASES)
    assert all("did not end within" in line for line in reasons(found))


def test_nonsense_is_told_in_one_line(capsys):
    found, _ = python("STEERS")
    assert len(reasons(found)) == len(CASES)
    with pytest.raises(UsageError, match="should be 'float32' or 'float64'"):
        PythonBackend(f"{MODULE}:PRECISION", Limits())


@pytest.mark.slow
def test_more_than_was_asked_for_is_not_read():
    found, _ = python("HUGE", cases=JACOBIANS)
    assert all("bytes" in line for line in reasons(found))
    assert len(reasons(found)) == len(JACOBIANS)


# ---------------------------------------------------------------- processes


@pytest.mark.parametrize("name", ["FORKS", pytest.param("SERVES", marks=SLOW)])
def test_a_child_that_holds_the_pipes_holds_nobody_up(name):
    start = time.monotonic()
    found, left = python(name)
    assert reasons(found) == []
    assert left == len(JACOBIANS)
    assert time.monotonic() - start < 60


def is_alive(process):
    """Whether a process still runs; one that waits to be reaped does not."""
    try:
        state = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False
    return state not in "ZX"


@pytest.mark.parametrize("quietly", ["", ">/dev/null 2>&1 </dev/null"])
def test_a_service_that_stays_is_no_fault_and_is_ended(tmp_path, quietly):
    """The program is waited for, not for who holds its pipes."""
    body = f"setsid sleep 300 {quietly} & echo $! >> {tmp_path}/services"
    found, left = program(tmp_path, body)
    assert found == [None] * len(JACOBIANS)
    services = (tmp_path / "services").read_text().split()
    assert left == len(services) == 1
    assert not any(map(is_alive, services))


@pytest.mark.slow
def test_services_that_pile_up_are_ended_before_the_end(tmp_path):
    body = f"setsid sleep 300 & echo x >> {tmp_path}/calls; pgrep -c sleep; exit 0"
    path = tmp_path / "backend.sh"
    path.write_text(f"#!/bin/sh\n{body}\n", encoding="utf-8")
    path.chmod(0o755)
    backend = ProgramBackend(f"{path} {{directory}}", Limits())
    most = 0
    for _ in range(40):
        backend.run(CONTRACT, JACOBIANS[:1])
        most = max(most, len(marked(backend._workspace._mark)))
    assert backend.close() == 40
    assert most <= 32


def killed(command, ready, tmp_path):
    """Kill a command when it is ready; what is left of it a second later."""
    mark = f"RESTIR_TEST_{os.getpid()}_{time.monotonic_ns()}"
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    environment = {**os.environ, mark: "1", "TMPDIR": str(temporary)}
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    run = subprocess.Popen(command, cwd=ROOT, env=environment, **quiet)
    try:
        while not ready():
            assert run.poll() is None
            time.sleep(0.05)
        assert len(marked(mark)) > 1
        run.kill()
        run.wait()
        end = time.monotonic() + 10
        while (marked(mark) or any(temporary.iterdir())) and time.monotonic() < end:
            time.sleep(0.05)
        return marked(mark), list(temporary.iterdir())
    finally:
        end_marked(mark)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["python", "program"])
def test_nothing_is_left_of_a_check_that_is_killed(tmp_path, kind):
    """Neither the backend, nor its service in another session, nor a folder."""
    script = f"setsid sleep 300 & echo > {tmp_path}/ready; sleep 300"
    (tmp_path / "hangs.sh").write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
    (tmp_path / "hangs.sh").chmod(0o755)
    (tmp_path / "hangs.py").write_text(
        f"""
import subprocess
class Hangs:
    def jacobian(self, **given):
        subprocess.run([{str(tmp_path / "hangs.sh")!r}])
BACKEND = Hangs()
""",
        encoding="utf-8",
    )
    backends = {"python": "hangs.py", "program": "hangs.sh {directory}"}
    command = [sys.executable, "-m", "restir_gi.reference", "check"]
    command += [str(tmp_path / backends[kind])]
    ready = (tmp_path / "ready").exists
    assert killed(command, ready, tmp_path) == ([], [])


# ---------------------------------------------------------------- time


@pytest.mark.slow
def test_a_pass_that_took_too_long_is_not_asked_again():
    found, _ = python("HANGS", Limits(1.0))
    assert len(reasons(found)) == 2
    assert found.count(NOT_AGAIN) == len(CASES) - 2


def test_a_program_that_takes_too_long_is_asked_once_a_pass(tmp_path):
    found, _ = program(tmp_path, "sleep 300", Limits(0.2), cases=CASES)
    assert len(reasons(found)) == 2
    assert found.count(NOT_AGAIN) == len(CASES) - 2


def test_the_end_of_the_budget_is_nobodys_fault(tmp_path):
    """A call lasts what is left, and nothing is asked after that."""
    start = time.monotonic()
    found, _ = program(tmp_path, "sleep 300", Limits(60), left_after(1), CASES)
    assert found == [NO_TIME] * len(CASES)
    assert time.monotonic() - start < 5
    inside = InsideBackend(FLOAT32, lambda: 0.0)
    assert inside.run(CONTRACT, CASES) == [NO_TIME] * len(CASES)


@pytest.mark.slow
def test_the_end_of_the_budget_stops_a_python_backend():
    backend = PythonBackend(f"{MODULE}:HANGS", Limits(60))
    backend.remaining = left_after(1)
    start = time.monotonic()
    found, _ = outcomes(backend)
    assert found == [NO_TIME] * len(CASES)
    assert time.monotonic() - start < 5


def test_a_backend_that_is_not_ready_in_time_is_undecided(tmp_path):
    slow = tmp_path / "slow.py"
    slow.write_text("import time\ntime.sleep(300)\n", encoding="utf-8")
    start = time.monotonic()
    verdict = judge(str(slow), 1.0)
    assert verdict.status == "UNDECIDED"
    assert "while it loads" in verdict.left[0]
    assert time.monotonic() - start < 10


def test_an_object_is_not_asked_beyond_the_budget():
    verdict = judge(FLOAT32, 0.3, statistics=False)
    assert verdict.status == "UNDECIDED"
    assert verdict.left
    assert all(NO_TIME.reason in line for line in verdict.unasked)


def test_a_kill_from_outside_is_nobodys_fault(tmp_path):
    for found, _ in (
        program(tmp_path, "kill -9 $$"),
        python("KILLED", cases=JACOBIANS[:1]),
    ):
        assert all(isinstance(outcome, Unasked) for outcome in found)
        assert "SIGKILL" in found[0].reason


def test_a_picture_takes_no_longer_than_is_left(tmp_path):
    path = tmp_path / "render.sh"
    path.write_text("#!/bin/sh\nsetsid sleep 300 & sleep 300\n", encoding="utf-8")
    path.chmod(0o755)
    template = f"{path} {{seed}} {{out}}"
    renderer = Renderer(template, "", 1, (8, 8), Limits(60), left_after(1))
    start = time.monotonic()
    with pytest.raises(UnaskedError):
        renderer.render(1)
    assert time.monotonic() - start < 5
    assert renderer.left_running == [1]


@pytest.mark.parametrize("text", ["0", "0.01", "-1", "nan", "soon"])
def test_a_limit_in_which_nothing_can_start_is_refused(text, capsys):
    assert main(["check", "float32", f"--limit={text}"]) == 2
    assert capsys.readouterr().err.count("\n") == 1


# ---------------------------------------------------------------- our own trouble


def run_check(arguments, **options):
    command = [sys.executable, "-m", "restir_gi.reference", "check", *arguments]
    return subprocess.run(
        command, cwd=ROOT, capture_output=True, text=True, check=False, **options
    )


@pytest.mark.slow
def test_a_disk_that_takes_no_cases_is_no_verdict():
    def no_room():
        resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, 10_000))

    found = run_check(["float32", "--budget", "60"], preexec_fn=no_room)
    assert found.returncode == 2
    assert "File too large" in found.stderr
    assert found.stderr.count("\n") == 1


@pytest.fixture
def small_disk(tmp_path):
    """A real disk that is soon full."""
    place = tmp_path / "disk"
    place.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=1m", "tmpfs", str(place)]
    if os.geteuid() or shutil.which("mount") is None:
        pytest.skip("only root can make a small disk")
    if subprocess.run(mount, capture_output=True, check=False).returncode:
        pytest.skip("no small disk can be made here")
    yield place
    subprocess.run(["umount", "-l", str(place)], check=True)


def test_a_backend_that_cannot_write_on_a_full_disk_is_not_accused(
    small_disk, tmp_path, monkeypatch
):
    """It fills the disk that its outputs go to, or somebody else does."""
    monkeypatch.setattr("tempfile.tempdir", str(small_disk))
    body = f"dd if=/dev/zero of={small_disk}/more bs=64k 2>/dev/null"
    with pytest.raises(UsageError, match=r"No space left.*TMPDIR"):
        program(tmp_path, f"{body}; exit 1")
    (small_disk / "more").unlink()
    with pytest.raises(UsageError, match=r"No space left.*TMPDIR"):
        program(tmp_path, f"{body}; {EACH % 'echo x >'}")


def test_a_place_for_temporary_files_that_is_none_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "missing"))
    with pytest.raises(UsageError, match="set TMPDIR"):
        ProgramBackend("true {directory}", Limits())


def test_a_limit_of_processes_is_told(monkeypatch):
    def none(*about, **more):
        raise BlockingIOError(11, "Resource temporarily unavailable")

    monkeypatch.setattr(subprocess, "Popen", none)
    with pytest.raises(UsageError, match="container on processes"):
        ProgramBackend("true {directory}", Limits())


@pytest.mark.slow
def test_a_tighter_limit_of_memory_than_ours_is_kept():
    """``ulimit -d``: the backend is bound to what there is, and not to more."""

    def tight():
        resource.setrlimit(resource.RLIMIT_DATA, (2 * 2**30, 2 * 2**30))

    found = run_check(["float32", "--budget", "2"], preexec_fn=tight)
    assert found.returncode == 3, found.stderr


# ---------------------------------------------------------------- the report


def test_where_the_report_goes_is_tried_before_the_run(tmp_path, capsys):
    (tmp_path / "file").touch()
    start = time.monotonic()
    assert main(["check", "float32", "--out", str(tmp_path / "file" / "x")]) == 2
    assert time.monotonic() - start < 5
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize(("status", "code"), [("FAIL", 1), ("PASS", 2)])
def test_a_verdict_outlives_its_report(tmp_path, capsys, monkeypatch, status, code):
    """It is printed first, and FAIL stays the exit code."""

    def full(*about):
        raise UsageError("cannot write index.html: No space left on device")

    def known(*about, **more):
        return Verdict(status, [], [], [], [], left_running=3)

    monkeypatch.setattr(check, "write_page", full)
    monkeypatch.setattr(check, "judge", known)
    assert main(["check", "float32", "--out", str(tmp_path)]) == code
    said = capsys.readouterr()
    assert status in said.out
    assert "left 3 processes running; they were ended" in said.out
    assert "No space left" in said.err
    assert said.err.count("\n") == 1


# ---------------------------------------------------------------- all of it

BUDGET = 8

PROGRAMS = {
    "fifo": EACH % "mkfifo",
    "folders": EACH % "mkdir -p",
    "zeros": EACH % "ln -s /dev/zero",
    "large": EACH % "truncate -s 40G",
    "daemon": "setsid sleep 300 &",
    "quiet daemon": "setsid sleep 300 >/dev/null 2>&1 </dev/null &",
    "endless": "exec yes AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA >&2",
}
OBJECTS = ["FORKS", "SERVES", "HANGS", "STEERS", "KILLED", "HUGE"]


@pytest.mark.slow
@pytest.mark.parametrize("name", [*PROGRAMS, *OBJECTS])
def test_a_whole_check_keeps_its_budget_and_its_memory(name, tmp_path):
    """Beyond what a check of no budget takes on this machine at this time."""
    backend = f"{MODULE}:{name}"
    if name in PROGRAMS:
        path = tmp_path / "backend.sh"
        path.write_text(f"#!/bin/sh\n{PROGRAMS[name]}\n", encoding="utf-8")
        path.chmod(0o755)
        backend = f"{path} {{directory}}"
    start = time.monotonic()
    assert run_check(["float32", "--budget", "0"]).returncode == 3
    least = time.monotonic() - start
    start = time.monotonic()
    found = run_check([backend, "--budget", str(BUDGET), "--limit", "2"])
    took = time.monotonic() - start
    assert found.returncode in (1, 3), found.stderr
    assert took < BUDGET + 5 + least
    # In KiB on Linux: the largest of all children so far.
    most = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    assert most < 1.5 * 2**20

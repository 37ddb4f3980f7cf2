"""Exit codes mean what they say: a fault of the program is no verdict."""

import errno
import os
import resource
import subprocess
import sys
from pathlib import Path

import pytest

from restir_gi.reference.cli import main as cli
from restir_gi.reference.cli import scenes
from restir_gi.reference.cli.main import main
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.trouble import LEAST, memory_limits, trouble

ROOT = Path(__file__).parents[2]


@pytest.fixture
def fails(monkeypatch, capsys):
    """Let a command raise something.  Returns the exit code and stderr."""

    def run(error):
        def raise_it(arguments):
            raise error

        monkeypatch.setattr(scenes, "run", raise_it)
        code = main(["scenes"])
        out, err = capsys.readouterr()
        assert out == ""
        return code, err

    return run


@pytest.mark.parametrize(
    "error",
    [
        ZeroDivisionError("division by zero"),
        IndexError("list index out of range"),
        RecursionError("too deep"),
        AssertionError(),
        ValueError("embedded null byte\nand a line"),
        SystemExit(1),
        SystemExit(0),
        GeneratorExit(),
        UnicodeDecodeError("utf-8", b"\xff", 0, 1, "no text"),
    ],
    ids=repr,
)
def test_what_nobody_expects_is_a_fault_of_the_program(fails, error):
    """70, in one line; never 1, which says that a backend is wrong, and never 0."""
    code, err = fails(error)
    assert code == 70
    assert err.startswith(f"restir: internal error: {type(error).__name__}")
    assert err.endswith(
        "; this is a fault of restir; set RESTIR_TRACEBACK=1 to see where\n"
    )
    assert len(err.splitlines()) == 1


def test_the_traceback_is_shown_to_who_asks(fails, monkeypatch):
    monkeypatch.setenv("RESTIR_TRACEBACK", "1")
    code, err = fails(ZeroDivisionError("division by zero"))
    assert code == 70
    assert err.startswith("Traceback (most recent call last)")
    assert "raise_it" in err
    assert err.splitlines()[-1].startswith("restir: internal error: ZeroDivisionError")
    monkeypatch.setenv("RESTIR_TRACEBACK", "0")
    assert "Traceback" not in fails(ZeroDivisionError())[1]


@pytest.mark.parametrize(
    ("error", "remedy"),
    [
        (OSError(errno.ENOSPC, "No space left on device", "/tmp/x"), "set TMPDIR"),
        (PermissionError(errno.EACCES, "Permission denied", "/x"), "TMPDIR"),
        (OSError(errno.ENAMETOOLONG, "File name too long", "x"), "shorter name"),
        (OSError(errno.EMFILE, "Too many open files"), "ulimit -n"),
        (OSError(errno.ENOMEM, "Cannot allocate memory"), "ulimit -v"),
        (BlockingIOError(errno.EAGAIN, "try again"), "ulimit -u"),
        (FileNotFoundError(errno.ENOENT, "No usable temporary directory"), "TMPDIR"),
        (OSError("no number"), "no number"),
        (OSError(errno.EIO, "Input/output error", b"\xff"), "its disk"),
        (MemoryError(), "--size"),
        (RuntimeError("can't start new thread"), "--threads"),
    ],
    ids=repr,
)
def test_trouble_with_the_machine_is_told_with_its_remedy(fails, error, remedy):
    code, err = fails(error)
    assert code == 2
    assert remedy in err
    assert len(err.splitlines()) == 1
    assert "Error" not in err


def test_control_another_error_is_no_trouble_with_the_machine():
    assert trouble(RuntimeError("of another kind")) is None
    assert trouble(ValueError()) is None


def test_libraries_that_find_no_memory_under_a_limit(monkeypatch):
    """They raise what does not say so; without a limit it is a fault."""
    errors = (ImportError("failed to map segment"), SystemError("no exception set"))
    monkeypatch.setattr("restir_gi.reference.system.trouble.memory_limits", dict)
    assert [trouble(error) for error in errors] == [None, None]
    monkeypatch.setattr(
        "restir_gi.reference.system.trouble.memory_limits", lambda: {"v": 2 * LEAST}
    )
    assert all("ulimit -v" in trouble(error) for error in errors)


def test_a_limit_too_narrow_to_load_anything(tmp_path):
    """Told before: under it libraries end the process, or wait for ever."""
    script = (
        "import resource, sys\n"
        f"resource.setrlimit(resource.RLIMIT_AS, ({LEAST - 1}, {LEAST - 1}))\n"
        "from restir_gi.reference.cli.main import main\n"
        "sys.exit(main(['scenes']))\n"
    )
    result = subprocess.run(
        [sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True
    )
    assert result.returncode == 2
    assert result.stderr == (
        "restir: memory is limited to 1023 MiB (ulimit -v); raise the limit to 1024 MiB"
        " at least\n"
    )


def test_limits_are_those_of_the_process():
    soft = resource.getrlimit(resource.RLIMIT_AS)[0]
    assert memory_limits().get("v", resource.RLIM_INFINITY) == soft


def test_a_message_cannot_steer_the_terminal(fails):
    code, err = fails(UsageError("cannot read \x1b[2J\x9b\u202e.glb\rrestir: fine"))
    assert code == 2
    assert err == "restir: cannot read \\x1b[2J\\x9b\\u202e.glb restir: fine\n"


def test_every_entry_is_the_same():
    """``restir``, and ``python -m`` of the package and of its module ``cli.main``."""
    for module in ("restir_gi.reference", "restir_gi.reference.cli.main"):
        command = [sys.executable, "-m", module, "rendr"]
        result = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
        assert result.returncode == 2
        assert result.stderr.startswith("restir: unknown command 'rendr'; did you mean")


# ---------------------------------------------------------------- where results go

DIRECTORIES = ("demo", "figures", "golden cornell-box", "tradeoff cornell-box",
               "check float32", "compare a.exr b.exr")  # fmt: skip
FILES = ("render cornell-box --method path", "reference cornell-box", "inspect a.exr")


@pytest.fixture
def refused(capsys, monkeypatch, tmp_path):
    """Run a command whose work must not begin; returns the line."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("")
    before = sorted(tmp_path.rglob("*"))

    def run(line, out):
        name = line.partition(" ")[0]
        module = f"restir_gi.reference.cli.{name}"
        monkeypatch.setattr(f"{module}.run", lambda arguments: pytest.fail("it ran"))
        assert main([*line.split(), "--out", out]) == 2
        written = capsys.readouterr()
        assert written.out == ""
        assert len(written.err.splitlines()) == 1
        assert sorted(tmp_path.rglob("*")) == before
        return written.err

    return run


@pytest.mark.parametrize("line", DIRECTORIES)
@pytest.mark.parametrize(
    "out",
    [
        "file",
        "file/below",
        "/dev/null/x",
        "/proc/x",
        "x" * 256,
        "",
        "a\0b",
        "a/" * 3000,
    ],
    ids=lambda out: repr(out[:12]),
)
def test_a_folder_is_looked_at_before_the_work(refused, line, out):
    assert "--out" in refused(line, out)


@pytest.mark.parametrize("line", FILES)
@pytest.mark.parametrize(
    "out",
    ["/", "", "file/x", "/dev/null/x", "/proc/x", "x" * 256, "a\0b", ".", "no/x"],
    ids=lambda out: repr(out[:12]),
)
def test_a_file_is_looked_at_before_the_work(refused, line, out):
    ending = ".html" if line.startswith("inspect") else ".exr"
    assert "--out" in refused(line, out if out in ("/", "", ".") else out + ending)


def test_control_a_good_name_is_taken(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    reached = []
    for line, out in [(FILES[1], "x.exr"), (DIRECTORIES[0], "a/b/c")]:
        name = line.partition(" ")[0]
        monkeypatch.setattr(f"restir_gi.reference.cli.{name}.run", reached.append)
        assert main([*line.split(), "--out", out]) == 0
    assert len(reached) == 2
    assert list(tmp_path.iterdir()) == []


# ---------------------------------------------------------------- numbers


@pytest.mark.parametrize(
    ("line", "value"),
    [
        (line, value)
        for line in (
            "check float32 --limit", "check float32 --budget", "check float32 --bound",
            "reference cornell-box --out x.exr --checkpoint",
            "tradeoff cornell-box --out t --for-time",
            "compare a.exr b.exr --tolerance",
        )
        for value in ("inf", "-inf", "nan", "1e308", "9" * 400, "-1", "", "1e10")
    ],
)  # fmt: skip
def test_amounts_have_a_range(capsys, monkeypatch, tmp_path, line, value):
    """A clock takes no infinite time, and a bound of NaN bounds nothing."""
    monkeypatch.chdir(tmp_path)
    *words, option = line.split()
    assert main([*words, f"{option}={value}"]) == 2
    err = capsys.readouterr().err
    assert f"argument {option}: " in err
    assert "from 0 to 1e+09" in err


@pytest.mark.parametrize("value", ["1_0", " 5", "\u0665", "9" * 5000, "+", "5."])
def test_whole_numbers_are_plain_digits(capsys, value):
    assert main(["reference", "cornell-box", "--out", "x.exr", "--spp", value]) == 2
    assert "is not an integer from 2" in capsys.readouterr().err


# ---------------------------------------------------------------- near misses


@pytest.mark.parametrize(
    ("line", "meant"),
    [
        ("rendr", "render"),
        ("tradeof x", "tradeoff"),
        ("render cornel-box --method path --out x.exr", "cornell-box"),
        ("render cornell-box --method pth --out x.exr", "path"),
        ("render cornell-box --method path --out x.exr --set pixl=box", "pixel"),
        ("render cornell-box --method path --out x.exr --aov dept", "depth"),
        ("render cornell-box --method path --out x.exr --light ful", "full"),
        ("figures jacobean --out f", "jacobian"),
        ("check flaot32", "float32"),
    ],
)
def test_near_misses_are_suggested(capsys, monkeypatch, tmp_path, line, meant):
    monkeypatch.chdir(tmp_path)
    assert main(line.split()) == 2
    err = capsys.readouterr().err
    assert f"; did you mean {meant}? " in err
    assert "unknown " in err
    assert len(err.splitlines()) == 1


def test_control_nothing_is_suggested_for_what_is_far(capsys):
    assert main(["zzz"]) == 2
    assert "did you mean" not in capsys.readouterr().err


def test_help_is_no_mistake(capsys):
    """``restir`` alone asks what there is."""
    assert main([]) == 0
    out, err = capsys.readouterr()
    assert out.startswith("usage: restir ")
    assert err == ""
    assert main(["--"]) == cli.BAD_USAGE


@pytest.mark.skipif(os.name != "posix", reason="bytes that are no text are of POSIX")
def test_names_that_are_no_text(capsys, tmp_path):
    name = os.fsdecode(b"\xff\xfe.glb")
    assert main(["plan", str(tmp_path / name)]) == 2
    assert r"\udcff\udcfe.glb" in capsys.readouterr().err

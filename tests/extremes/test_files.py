"""A file is whole or not there: full disks, wrong paths, Ctrl-C."""

import errno
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from restir_gi.reference.images.exr import write_exr
from restir_gi.reference.images.image import Image
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.files import read_file, write_file

ROOT = Path(__file__).parents[2]
GREY = Image({"color": np.full((4, 6, 3), 0.5, np.float32)})


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def assert_one_line(error, *words):
    message = str(error.value)
    assert len(message.splitlines()) == 1
    for word in words:
        assert str(word) in message


def test_a_message_stays_one_line():
    assert str(UsageError("no\nsuch\r\nfile\u2028here")) == "no such file here"


def test_a_file_is_replaced(tmp_path):
    path = tmp_path / "a"
    write_file(path, b"old")
    write_file(path, b"new")
    assert read_file(path) == b"new"
    assert names(tmp_path) == ["a"]


def test_a_new_file_may_be_read_by_those_whom_the_umask_allows(tmp_path):
    """Not the 0600 of a file made as temporary."""
    (tmp_path / "plain").touch()
    write_file(tmp_path / "a", b"")
    assert (tmp_path / "a").stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_a_link_stays_a_link(tmp_path):
    (tmp_path / "far").mkdir()
    link = tmp_path / "link"
    link.symlink_to(tmp_path / "far" / "a")
    write_file(link, b"new")
    assert link.is_symlink()
    assert (tmp_path / "far" / "a").read_bytes() == b"new"


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("missing/a", "No such file or directory"),
        ("file/a", "Not a directory"),
        ("folder", "not a regular file"),
        ("x" * 300, "File name too long"),
    ],
)
def test_where_nothing_can_be_written(tmp_path, name, reason):
    (tmp_path / "file").touch()
    (tmp_path / "folder").mkdir()
    before = names(tmp_path)
    with pytest.raises(UsageError, match=reason) as error:
        write_file(tmp_path / name, b"new")
    assert_one_line(error, tmp_path / name)
    assert names(tmp_path) == before


def test_a_device_is_not_replaced_by_a_file():
    with pytest.raises(UsageError, match="not a regular file"):
        write_file(Path(os.devnull), b"new")


def forbid(path, mode):
    path.chmod(mode)
    if os.access(path, os.R_OK | os.W_OK):
        pytest.skip("permissions do not bind this user")


def test_a_folder_that_may_not_be_written(tmp_path):
    folder = tmp_path / "folder"
    folder.mkdir()
    forbid(folder, 0o500)
    with pytest.raises(UsageError, match="Permission denied"):
        write_file(folder / "a", b"new")
    folder.chmod(0o700)
    assert names(folder) == []


@pytest.mark.parametrize("what", ["os.fsync", "pathlib.Path.replace"])
@pytest.mark.parametrize(
    ("failure", "raised"),
    [
        (OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)), UsageError),
        (KeyboardInterrupt(), KeyboardInterrupt),
    ],
)
def test_an_old_file_survives(tmp_path, monkeypatch, what, failure, raised):
    path = tmp_path / "a"
    write_file(path, b"old")

    def fail(*_):
        raise failure

    monkeypatch.setattr(what, fail)
    with pytest.raises(raised) as error:
        write_file(path, b"new")
    monkeypatch.undo()
    assert path.read_bytes() == b"old"
    assert names(tmp_path) == ["a"]
    if raised is UsageError:
        assert_one_line(error, path, "No space left on device")


@pytest.mark.skipif(sys.platform == "win32", reason="no limit on file size there")
def test_a_write_that_really_fails_half_way(tmp_path):
    """The system stops the write after 1000 bytes, in a process of its own."""
    path = tmp_path / "a"
    path.write_bytes(b"old")
    script = f"""
import resource
from pathlib import Path
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.files import write_file
resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
try:
    write_file(Path({str(path)!r}), bytes(10**6))
except UsageError as error:
    print(error)
"""
    command = [sys.executable, "-W", "error", "-c", script]
    result = subprocess.run(
        command, cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert result.stdout.splitlines() == [result.stdout.rstrip("\n")]
    assert f"cannot write {path}: File too large" in result.stdout
    assert path.read_bytes() == b"old"
    assert names(tmp_path) == ["a"]


@pytest.mark.parametrize(
    ("name", "reason"),
    [("missing", "No such file"), ("folder", "it is a folder"), ("a\nb", "No such")],
)
def test_what_cannot_be_read(tmp_path, name, reason):
    (tmp_path / "folder").mkdir()
    with pytest.raises(UsageError, match=reason) as error:
        read_file(tmp_path / name)
    assert_one_line(error, tmp_path)


def test_what_may_not_be_read(tmp_path):
    path = tmp_path / "a"
    path.touch()
    forbid(path, 0o000)
    with pytest.raises(UsageError, match="Permission denied"):
        read_file(path)


# ---------------------------------------------------------------- images


def test_a_full_disk_leaves_the_old_image(tmp_path, monkeypatch):
    path = tmp_path / "a.exr"
    write_exr(path, GREY)
    before = path.read_bytes()

    def full(_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(UsageError, match="No space left") as error:
        write_exr(path, Image({"color": 2 * GREY.color}))
    assert str(path) in str(error.value)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("name", ["missing/a.exr", "folder"])
def test_a_place_that_cannot_hold_an_image(tmp_path, name):
    (tmp_path / "folder").mkdir()
    with pytest.raises(UsageError, match="cannot write") as error:
        write_exr(tmp_path / name, GREY)
    assert str(tmp_path / name) in str(error.value)
    assert [path.name for path in tmp_path.rglob("*")] == ["folder"]

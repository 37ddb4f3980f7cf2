"""``restir capture-template``: what it writes can be filled and read."""

import json
import re
import tomllib

import numpy as np
import pytest

from restir_gi.reference.cli.main import BAD_USAGE, main
from restir_gi.reference.oracle.capture.families import FAMILIES
from restir_gi.reference.oracle.capture.faults import CaptureError
from restir_gi.reference.oracle.capture.layouts import LAYOUTS
from restir_gi.reference.oracle.capture.record import Capture
from restir_gi.reference.oracle.declaration.read import read_declaration

FILES = ["README.md", "capture.toml", "declaration.toml"]
WIDTH, HEIGHT = 20, 10

every_family = pytest.mark.parametrize("layout", FAMILIES)


@pytest.fixture
def template(tmp_path, capsys):
    """Run the command; gives the folder, and what is on stdout."""

    def run(layout, *more, out=None):
        folder = tmp_path / "frames" if out is None else out
        line = ["capture-template", "--layout", layout, "--out", str(folder), *more]
        code = main(line)
        stdout, stderr = capsys.readouterr()
        assert (code, stderr) == (0, "")
        return folder, stdout

    return run


def refused(capsys, *line):
    """What the command says that it refuses."""
    assert main(["capture-template", *map(str, line)]) == BAD_USAGE
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    return err


SMALL = ("--size", f"{WIDTH}x{HEIGHT}", "--frames", "4-5")


def fill(folder, sizes, frames):
    """Zeros, as many as the list of buffers says."""
    for pattern, size in sizes.items():
        for number in frames:
            (folder / pattern.replace("{frame}", str(number))).write_bytes(bytes(size))


def listed(folder):
    """File and bytes of each row of the README, and whether it is optional."""
    text = (folder / "README.md").read_text("utf-8")
    rows = re.findall(r"^\| `([^`]*)`( \(optional\))? \| .* \| ([\d,]+) \|", text, re.M)
    return {
        file: (int(size.replace(",", "")), bool(optional))
        for file, optional, size in rows
    }


def uncommented(text):
    """The manifest, with the optional buffers taken in."""
    head, *tables = text.split(
        "\n# Optional: take away the marks before these lines.\n"
    )
    for table in tables:
        marked, blank, rest = table.partition("\n\n")
        head += "\n" + re.sub("^# ", "", marked, flags=re.M) + blank + rest
    return head


@every_family
def test_what_is_listed_can_be_dumped_and_read(template, layout):
    folder, _ = template(layout, *SMALL)
    assert sorted(path.name for path in folder.iterdir()) == FILES
    sizes = listed(folder)
    needed = {file: size for file, (size, optional) in sizes.items() if not optional}
    fill(folder, needed, (4, 5))
    capture = Capture.read(folder)
    assert (capture.width, capture.height) == (WIDTH, HEIGHT)
    assert [frame.number for frame in capture.frames] == [4, 5]
    assert capture.declaration == folder / "declaration.toml"
    frame = capture.frames[0]
    assert set(frame.roles) == {
        "gbuffer", "initial", "history", "temporal", "neighbors", "spatial"
    }  # fmt: skip
    seen = {"visible_position", "visible_normal", "albedo", "depth"}
    assert set(frame["gbuffer"].columns) == seen
    for role in ("initial", "temporal", "spatial"):
        assert {"position", "normal", "radiance", "W", "M"} <= set(frame[role].columns)
        assert frame[role].storage == (layout if layout in LAYOUTS else "fields")
    assert frame["neighbors"]["neighbors"].shape == (WIDTH * HEIGHT, 2)


@every_family
def test_what_is_optional_can_be_taken_in(template, layout):
    folder, _ = template(layout, *SMALL)
    path = folder / "capture.toml"
    path.write_text(uncommented(path.read_text("utf-8")), "utf-8")
    sizes = {file: size for file, (size, _) in listed(folder).items()}
    assert len(tomllib.loads(path.read_text("utf-8"))["buffers"]) == len(sizes)
    fill(folder, sizes, (4, 5))
    frame = Capture.read(folder).frames[1]
    more = {"visible_temporal", "visible_spatial", "shade", "visible_shade"}
    assert more <= set(frame.roles)
    # Pixel and neighbours, each with a mask.
    assert frame["visible_spatial"]["visible"].shape == (WIDTH * HEIGHT, 3)


@every_family
def test_a_declaration_stands_beside(template, layout):
    folder, _ = template(layout)
    text = (folder / "declaration.toml").read_text("utf-8")
    declaration = tomllib.loads(text)
    assert declaration["schema"] == "restir-declaration 1"
    assert declaration["choices"]["generator"] == "own"
    # With the line of what is accepted taken in, nothing biased is left.
    whole = read_declaration(tomllib.loads(text.replace("# accept = ", "accept = ")))
    biased = [h.name for h in whole.hypotheses if h.departure == "bias"]
    assert all(map(whole.accepts, biased))
    assert ("# accept = " in text) == bool(biased)


def test_the_list_has_the_bytes_of_the_gpu(template):
    """20 x 10 pixels are 2 x 1 blocks of 256 reservoirs, or 200 reservoirs in rows."""
    folder, _ = template("rtxdi", *SMALL)
    sizes = listed(folder)
    assert sizes["temporal.{frame}.bin"] == (512 * 32, False)
    assert sizes["gbuffer-position.{frame}.bin"] == (200 * 16, False)
    assert sizes["neighbors.{frame}.bin"] == (200 * 8, False)
    assert sizes["visible_spatial.{frame}.bin"] == (200 * 12, True)
    folder, _ = template("paper", *SMALL, out=folder.with_name("paper"))
    assert listed(folder)["spatial.{frame}.bin"] == (200 * 48, False)


def test_what_it_prints(template):
    folder, text = template("rtxdi", *SMALL)
    assert f"restir check {folder}" in text
    assert "9 buffers to copy in each of 2 frames" in text
    _, text = template("rtxdi", *SMALL, "--json")
    told = json.loads(text)
    assert told["out"] == str(folder)
    assert told["frames"] == [4, 5]
    needed = [buffer for buffer in told["buffers"] if not buffer["optional"]]
    assert told["bytes"] == 2 * sum(buffer["bytes"] for buffer in needed)
    sizes = listed(folder)
    assert {b["file"]: (b["bytes"], b["optional"]) for b in told["buffers"]} == sizes


def test_twice_is_once(template):
    folder, _ = template("paper", *SMALL)
    before = {name: (folder / name).read_bytes() for name in FILES}
    (folder / "README.md").unlink()  # as after a kill
    template("paper", *SMALL)
    assert {name: (folder / name).read_bytes() for name in FILES} == before


def test_a_folder_that_holds_something_else_is_refused(template, capsys):
    folder, _ = template("paper", *SMALL)
    line = ("--layout", "paper", "--out", folder, *SMALL)
    path = folder / "capture.toml"
    mine = path.read_text("utf-8") + "# mine\n"
    path.write_text(mine, "utf-8")
    assert "holds another capture.toml" in refused(capsys, *line)
    assert path.read_text("utf-8") == mine
    path.unlink()
    (folder / "a.bin").write_bytes(b"")
    assert "holds a.bin; name a new or empty folder" in refused(capsys, *line)
    assert not path.exists()
    other = ("--layout", "rtxdi", "--out", folder, *SMALL)
    (folder / "a.bin").unlink()
    assert "holds another" in refused(capsys, *other)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        (["--out", "a"], "--layout"),
        (["--layout", "paper"], "--out"),
        (["--layout", "rtxd", "--out", "a"], "did you mean rtxdi?"),
        (
            ["--layout", "paper", "--out", "a", "--frames", "3-0"],
            "'3-0' is not a range",
        ),
        (["--layout", "paper", "--out", "a", "--frames", "0-256"], "1 to 256 frames"),
        (["--layout", "paper", "--out", "a", "--frames", "-1"], "--frames"),
        (["--layout", "paper", "--out", "a", "--size", "0x4"], "WIDTHxHEIGHT"),
        (["--layout", "paper", "--out", ""], "--out is empty"),
    ],
)
def test_what_is_no_request_is_refused(line, words, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert words in refused(capsys, *line)
    assert list(tmp_path.iterdir()) == []


def test_the_largest_image(template):
    folder, _ = template("rtxdi", "--size", "16384x16384", "--frames", "7")
    assert listed(folder)["spatial.{frame}.bin"] == (2**28 * 32, False)


def test_a_folder_that_cannot_be_written(capsys, tmp_path):
    (tmp_path / "file").write_text("")
    line = ("--layout", "paper", "--out", tmp_path / "file" / "a")
    assert "cannot make this folder" in refused(capsys, *line)


def test_control_a_size_that_is_not_the_listed_one(template):
    folder, _ = template("rtxdi", *SMALL)
    needed = {f: size for f, (size, optional) in listed(folder).items() if not optional}
    fill(folder, needed, (4, 5))
    (folder / "spatial.5.bin").write_bytes(np.zeros(200 * 32, np.uint8).tobytes())
    words = "frame 5: spatial, spatial.5.bin: has 6,400 bytes where 512"
    with pytest.raises(CaptureError, match=re.escape(words)):
        Capture.read(folder)

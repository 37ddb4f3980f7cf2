"""``restir check`` of a command line that makes pictures."""

import json

import numpy as np
import pytest

from restir_gi.reference.cli.main import main
from restir_gi.reference.images.exr import write_exr
from restir_gi.reference.images.image import Image
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.scene.catalogue.registry import find_animation
from restir_gi.reference.transport.accumulate import path_samples
from tests.statistics.replicates import small_world

SIZE, PATHS, PICTURES = 8, 64, 40


@pytest.fixture(scope="module")
def pictures(tmp_path_factory):
    """Path-traced pictures by seed, and some that are twice as bright, in a folder."""
    folder = tmp_path_factory.mktemp("pictures")
    world = small_world(find_animation("cornell-box")(0), SIZE, SIZE)
    about = {"light": "indirect", "bounces": 1, "seed": 5}
    samples = path_samples(world, Schedule(), **about)
    every = slice(0, SIZE**2)
    for picture in range(PICTURES):
        paths = range(picture * PATHS, (picture + 1) * PATHS)
        mean = sum(samples.radiance(every, k) for k in paths) / PATHS
        color = mean.reshape(SIZE, SIZE, 3).astype(np.float32)
        for name, factor in (("right", 1), ("bright", 2)):
            path = folder / f"{name}{100 + picture}.exr"
            write_exr(path, Image({"color": np.float32(factor) * color}, {}))
    return folder


def checked(capsys, template, *options):
    about = ["--size", str(SIZE), "--tolerance", "10%", "--tile-tolerance", "0.4"]
    code = main(["check", template, *about, *options, "--json"])
    told = capsys.readouterr()
    assert told.err == ""
    return code, json.loads(told.out)


def test_a_right_renderer_passes(pictures, capsys, tmp_path):
    template = f"cp {pictures}/right{{seed}}.exr {{out}}"
    code, told = checked(capsys, template, "--out", str(tmp_path / "report"))
    assert (code, told["status"]) == (0, "PASS")
    assert told["pictures"] >= 8
    assert (tmp_path / "report" / "index.html").stat().st_size > 10_000
    assert json.loads((tmp_path / "report" / "verdict.json").read_text()) == told


@pytest.mark.parametrize("jobs", ["1", "2"])
def test_a_wrong_renderer_fails(pictures, capsys, jobs):
    """Whoever makes its pictures; and it is told what they agree with."""
    template = f"cp {pictures}/bright{{seed}}.exr {{out}}"
    code, told = checked(capsys, template, "--jobs", jobs)
    assert (code, told["evidence"]) == (1, "statistical")
    assert any("times 2" in text for text in told["likenesses"])


def test_the_same_bias_is_known_and_files_for_machines_are_written(
    pictures, capsys, tmp_path
):
    """Beside a baseline of its own; of another renderer it is refused."""
    template = f"cp {pictures}/bright{{seed}}.exr {{out}}"
    first, xml = tmp_path / "first", tmp_path / "a.xml"
    checked(capsys, template, "--out", str(first), "--junit", str(xml))
    assert "<failure" in xml.read_text()
    baseline, sarif = str(first / "verdict.json"), str(tmp_path / "a.sarif")
    more = ("--junit", str(xml), "--sarif", sarif)
    code, told = checked(capsys, template, "--baseline", baseline, *more)
    assert (code, told["status"], len(told["baseline"]["known"])) == (0, "FAIL", 1)
    assert "<failure" not in xml.read_text()
    (result,) = json.loads((tmp_path / "a.sarif").read_text())["runs"][0]["results"]
    assert (result["ruleId"], result["baselineState"]) == ("pictures", "unchanged")
    other = template.replace("bright", "right")
    size = ["--size", str(SIZE), "--baseline", baseline]
    assert main(["check", other, *size]) == 2
    assert "BACKEND is" in capsys.readouterr().err
    assert main(["check", template, *size, "--light", "full"]) == 2
    assert "light is indirect there, and full here" in capsys.readouterr().err


def test_without_time_for_the_truth_junit_has_an_error(pictures, capsys, tmp_path):
    template, xml = f"cp {pictures}/right{{seed}}.exr {{out}}", tmp_path / "a.xml"
    late = ("--budget", "0.001", "--bounces", "8", "--junit", str(xml))
    assert checked(capsys, template, *late)[0] == 3
    assert "<error" in xml.read_text()
    # Nothing is known that a report could show, and none is told of.
    folder = tmp_path / "report"
    size = ["--size", str(SIZE), "--out", str(folder)]
    assert main(["check", template, *size, *late]) == 3
    assert "index.html" not in capsys.readouterr().out
    assert not folder.exists()


def test_a_list_makes_several(pictures, capsys, tmp_path):
    script = tmp_path / "several.sh"
    lines = (
        "#!/bin/sh",
        f"echo >> {tmp_path}/calls",
        f'while read -r seed out; do cp {pictures}/right$seed.exr "$out"; done < "$1"',
    )
    script.write_text("\n".join(lines) + "\n")
    script.chmod(0o755)
    code, told = checked(capsys, f"{script} {{list}}")
    assert (code, told["status"]) == (0, "PASS")
    assert len((tmp_path / "calls").read_text()) == -(-told["pictures"] // 8)


def test_a_picture_that_is_missing_is_no_bias(pictures, capsys):
    template = f"cp {pictures}/right10{{seed}}.exr {{out}}"
    code, told = checked(capsys, template)
    assert (code, told["evidence"]) == (1, "broken")
    assert "exit code 1" in told["headline"]


def test_without_time_for_the_truth_nothing_is_said(pictures, capsys):
    template = f"cp {pictures}/right{{seed}}.exr {{out}}"
    code, told = checked(capsys, template, "--budget", "0.001", "--bounces", "9")
    assert (code, told["status"]) == (3, "UNDECIDED")
    assert "longer --budget" in told["headline"]


@pytest.mark.parametrize("text", ["0", "2", "-1%", "120%", "some", ""])
def test_a_tolerance_is_a_share(text, capsys):
    assert main(["check", "x {seed} {out}", f"--tolerance={text}"]) == 2
    assert "is no share, such as 0.01 or 1%" in capsys.readouterr().err

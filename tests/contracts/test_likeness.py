"""Like is compared with like, or it is said: headers, layers, and the tolerance."""

import json
import re

import numpy as np
import OpenEXR
import pytest

from restir_gi.reference.cli.main import main
from restir_gi.reference.images.exr import read_exr, write_exr
from restir_gi.reference.images.image import Image
from restir_gi.reference.reports.comparison.likeness import SAME, differences
from restir_gi.reference.system.errors import UsageError

HEADER = {
    "scene": "kitchen",
    "shown.scene": "0123456789abcdef",
    "shown.view": "from 0 0 1 to 0 0 0",
    "shown.frame": "0",
    "shown.pixel": "center",
    "light": "indirect",
    "bounces": "1",
    "method": "path",
    "seed": "3",
}


# ---------------------------------------------------------------- headers


def test_the_same_header_is_the_same():
    assert differences(HEADER, HEADER) == []
    # How, and with which numbers, is what is compared.
    assert (
        differences(HEADER, HEADER | {"method": "restir-gi-biased", "seed": "4"}) == []
    )


@pytest.mark.parametrize("what", SAME)
def test_each_difference_is_found(what):
    other = HEADER | {SAME[what]: "another"}
    if what == "frame":  # counts where what is seen differs with it
        other |= {"shown.view": "from 0 0 2 to 0 0 0"}
    found = {one.what: one for one in differences(HEADER, other)}
    assert what in found
    assert found[what].certain
    assert found[what].b.endswith("another")
    assert found.keys() <= {what, "view"}


def test_a_frame_of_a_scene_that_stands_still_has_any_number():
    assert differences(HEADER, HEADER | {"shown.frame": "31"}) == []


def test_a_scene_of_another_name_is_the_same_if_it_is():
    assert differences(HEADER, HEADER | {"scene": "kitchen-2"}) == []
    other = HEADER | {"shown.scene": "f" * 16}
    (one,) = differences(HEADER, other)
    assert one.a == "kitchen 0123456789abcdef"
    assert one.b == f"kitchen {'f' * 16}"


def test_what_is_not_known_is_not_certain():
    found = differences(HEADER, {})
    assert {one.what for one in found} == SAME.keys() - {"frame"}
    assert not any(one.certain for one in found)
    assert all(one.b is None for one in found)
    assert len(differences({}, {})) == len(SAME) - 1


# ---------------------------------------------------------------- rendered pictures


@pytest.fixture
def compared(tmp_path, capsys):
    """Render two pictures and compare them; returns JSON, text and page."""

    def run(first, second, *more):
        for name, line in (("a", first), ("b", second)):
            words = line.split()
            small = [] if "--size" in words else ["--size", "8x6"]
            out = ["--out", str(tmp_path / f"{name}.exr")]
            assert main(["render", *words, *small, *out]) == 0
        pair = [str(tmp_path / "a.exr"), str(tmp_path / "b.exr")]
        page = tmp_path / "page"
        capsys.readouterr()
        main(["compare", *pair, "--json", *more])
        found = json.loads(capsys.readouterr().out)
        main(["compare", *pair, "--out", str(page), *more])
        return found, capsys.readouterr().out, (page / "index.html").read_text()

    return run


PATH = "cornell-box --method path --spp 1"
RESTIR = "cornell-box --method restir-gi-unbiased --frames 3"


@pytest.mark.parametrize(
    ("first", "second", "whats"),
    [
        (PATH, f"{PATH} --seed 9", set()),
        (PATH, RESTIR, set()),
        (PATH, f"{PATH} --light full", {"light"}),
        (PATH, f"{PATH} --bounces 3", {"bounces"}),
        (PATH, f"{PATH} --set pixel=box", {"pixel filter"}),
        (PATH, "door-ajar --method path --spp 1", {"scene", "view"}),
        (
            "moving-camera --method path --spp 1 --frame 2",
            "moving-camera --method restir-gi-unbiased --frames 3",
            set(),
        ),
        (
            "moving-camera --method path --spp 1",
            "moving-camera --method restir-gi-unbiased --frames 3",
            {"view", "frame"},
        ),
    ],
)
def test_pictures_of_other_things_are_told_apart(compared, first, second, whats):
    found, text, page = compared(first, second)
    assert {one["what"] for one in found["differences"]} == whats
    warning = "Not pictures of the same thing"
    assert (warning in text) == (warning in page) == bool(whats)
    if whats:
        # First of all, before any number.
        assert text.index(warning) < text.index("RMSE")
        assert page.index(warning) < page.index("<h2>Numbers</h2>")
        for what in whats:
            assert re.search(rf"^│ {what} +│", text, re.MULTILINE)
        first_row = page.partition("<h2>Where they come from</h2>")[2]
        key = re.search(r'<tr class="differs"><th scope="row">([^<]+)', first_row)[1]
        assert key in {SAME[what] for what in whats}


def test_pictures_without_headers(tmp_path, capsys):
    color = np.ones((4, 4, 3), np.float32)
    a = tmp_path / "a.exr"
    write_exr(a, Image({"color": color}))
    assert main(["compare", str(a), str(a), "--out", str(tmp_path / "page")]) == 0
    text = capsys.readouterr().out
    page = (tmp_path / "page" / "index.html").read_text()
    for shown in (text, page):
        assert "Not known to be pictures of the same thing" in shown
        assert shown.count("not known") >= 2 * (len(SAME) - 1)


# ---------------------------------------------------------------- the tolerance


@pytest.fixture
def pair(tmp_path):
    """Write B = 1, and A = 1 + d, with some pixels of A that are not finite."""

    def write(difference, bad=0):
        a = np.full((4, 4, 3), 1 + difference, np.float32)
        a.reshape(-1, 3)[:bad] = np.nan
        paths = [tmp_path / "a.exr", tmp_path / "b.exr"]
        for path, color in zip(paths, (a, np.ones_like(a)), strict=True):
            write_exr(path, Image({"color": color}))
        return [str(path) for path in paths]

    return write


@pytest.mark.parametrize(
    ("difference", "bad", "tolerance", "code"),
    [
        (0.0, 0, "0", 0),
        (0.5, 0, "0.2500", 0),  # relMSE = 0.25 / (1 + 0.01) = 0.2475...
        (0.5, 0, "0.2400", 1),
        (-0.5, 0, "0.2400", 1),
        (0.0, 1, "1e9", 1),  # a pixel that is no number is within nothing
    ],
)
def test_the_exit_code_is_that_of_the_tolerance(
    pair, capsys, difference, bad, tolerance, code
):
    line = ["compare", *pair(difference, bad), "--tolerance", tolerance]
    assert main(line) == code
    text = capsys.readouterr().out.splitlines()[-1]
    assert text.startswith("relMSE ")
    assert ("within" in text) == (code == 0)
    assert main([*line, "--json"]) == code
    found = json.loads(capsys.readouterr().out)
    assert found["within"] is (code == 0)
    assert found["tolerance"] == float(tolerance)


def test_without_a_tolerance_there_is_no_verdict(pair, capsys):
    line = ["compare", *pair(5.0, 1)]
    assert main(line) == 0
    assert "beyond" not in capsys.readouterr().out
    assert main([*line, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["within"] is None


# ---------------------------------------------------------------- layers


@pytest.fixture
def several(tmp_path):
    """Write a file with layers of these values."""

    def write(name="several.exr", **values):
        channels = {
            channel.replace("_", "."): np.full((4, 4), value, np.float32)
            for channel, value in values.items()
        }
        header = {
            "compression": OpenEXR.ZIP_COMPRESSION,
            "type": OpenEXR.scanlineimage,
        }
        OpenEXR.File(header, channels).write(str(tmp_path / name))
        return tmp_path / name

    return write


def rgb(root, value):
    """Channels of one layer."""
    return {f"{root}_{component}": value for component in "RGB"}


BLENDER = {
    **rgb("ViewLayer_Combined", 0.5),
    "ViewLayer_Combined_A": 1.0,
    **rgb("ViewLayer_DiffDir", 0.25),
    "ViewLayer_Depth_Z": 7.0,
    **rgb("Back_Combined", 0.125),
}


@pytest.mark.parametrize(
    ("layer", "value"),
    [
        ("ViewLayer.Combined", 0.5),
        ("ViewLayer.DiffDir", 0.25),
        ("DiffDir", 0.25),
        ("Back.Combined", 0.125),
        ("ViewLayer.Depth.Z", 7.0),
        ("Z", 7.0),
    ],
)
def test_a_layer_by_name(several, layer, value):
    image = read_exr(several(**BLENDER), layer)
    assert (image.color == value).all()
    assert image.color.shape == (4, 4, 3)


@pytest.mark.parametrize(
    ("layer", "reasons"),
    [
        (None, ["no colour channels R, G, B", "--layer", "ViewLayer.Combined, ",
                "Back.Combined", "ViewLayer.Depth.Z"]),
        ("Combined", ["several layers 'Combined'", "name one in full"]),
        ("ViewLayer", ["unknown layer 'ViewLayer'", "known are Back.Combined, View"]),
        ("ViewLayer.Combinde", ["did you mean ViewLayer.Combined?"]),
        ("color", ["unknown layer 'color'"]),
        ("", ["unknown layer ''"]),
    ],
)  # fmt: skip
def test_a_layer_that_is_not_one(several, layer, reasons):
    with pytest.raises(UsageError) as refusal:
        read_exr(several(**BLENDER), layer)
    for reason in reasons:
        assert reason in str(refusal.value)


def test_a_name_may_end_as_a_component_does(several):
    """A layer "a.R" is not the red of a layer "a" that has no green."""
    image = read_exr(several(**rgb("a_R", 0.5), a_G=3.0), "a.R")
    assert (image.color == 0.5).all()
    image = read_exr(several(R=1.0, G=1.0, B=1.0, **rgb("R_Combined", 0.5)), "Combined")
    assert (image.color == 0.5).all()


def test_the_standard_error_belongs_to_the_picture(several, tmp_path):
    color = np.ones((4, 4, 3), np.float32)
    path = tmp_path / "ours.exr"
    layers = {"color": color, "direct": color / 2, "standard_error": color / 9}
    write_exr(path, Image(layers))
    assert "standard_error" in read_exr(path).layers
    assert "standard_error" in read_exr(path, "color").layers
    direct = read_exr(path, "direct")
    assert (direct.color == 0.5).all()
    assert "standard_error" not in direct.layers


def test_compare_layers_of_both_or_of_each(several, tmp_path, capsys):
    theirs = str(several(**BLENDER))
    ours = tmp_path / "ours.exr"
    write_exr(ours, Image({"color": np.full((4, 4, 3), 0.25, np.float32)}))

    def mean_of(*line):
        assert main(["compare", *map(str, line), "--json"]) == 0
        found = json.loads(capsys.readouterr().out)
        return found["mean_a"][0], found["mean_b"][0]

    both = ("--layer", "ViewLayer.Combined")
    assert mean_of(theirs, theirs, *both) == (0.5, 0.5)
    assert mean_of(theirs, ours, *both, "--layer", "color") == (0.5, 0.25)
    assert mean_of(theirs, theirs, *both, "--layer", "DiffDir") == (0.5, 0.25)
    assert main(["compare", theirs, str(ours), *both]) == 2
    assert "ours.exr: unknown layer" in capsys.readouterr().err
    assert main(["compare", theirs, theirs, *both * 3]) == 2
    assert "twice, for A and for B, not 3 times" in capsys.readouterr().err


def test_inspect_a_layer(several, tmp_path, capsys):
    out = tmp_path / "p.html"
    theirs = str(several(**BLENDER))
    assert main(["inspect", theirs, "--out", str(out)]) == 2
    assert "--layer" in capsys.readouterr().err
    assert main(["inspect", theirs, "--layer", "DiffDir", "--out", str(out)]) == 0
    assert out.exists()

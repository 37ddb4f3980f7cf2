"""What a comparison says, and the folder that it leaves."""

import json
import re
from dataclasses import fields
from html.parser import HTMLParser

import numpy as np
import pytest
from PIL import Image as Pillow

from reference.comparison import Comparison, compare
from reference.comparison.histogram import histogram_bars
from reference.comparison.labels import NUMBERS
from reference.comparison.maps import (
    difference_map,
    flip_map,
    relative_error_map,
    scale_of,
    z_map,
)
from reference.display import MARKER
from reference.errors import UsageError
from reference.images import Image

PICTURES = ["a.png", "b.png", "difference.png", "flip.png", "relative_error.png"]


def grey(value, height=4, width=6):
    return np.full((height, width, 3), value, np.float32)


def image(value, error=None, **metadata):
    layers = {"color": value}
    if error is not None:
        layers["standard_error"] = error
    return Image(layers, metadata)


@pytest.fixture
def noisy():
    rng = np.random.default_rng(0)
    truth = rng.random((12, 16, 3), np.float32)
    a = image(truth * 1.1, method="restir-gi-biased", scene="door-ajar")
    b = image(truth, grey(0.1, 12, 16), method="path", scene="door-ajar", spp="64")
    return a, b


# ---------------------------------------------------------------- numbers


def test_of_an_image_with_itself_nothing_differs():
    numbers = compare(image(grey(0.5)), image(grey(0.5)))
    for name in ("relative_bias", "mse", "rmse", "rel_mse", "mape", "smape"):
        assert getattr(numbers, name) == 0
    assert numbers.flip_ldr == numbers.flip_hdr == 0
    assert numbers.z_rms is numbers.mse_of_b is numbers.mse_corrected is None


def test_numbers_of_flat_images():
    """A is 3/2 of B = 0.5, whose standard error is 0.1."""
    numbers = compare(image(grey(0.75)), image(grey(0.5), grey(0.1)))
    assert (numbers.width, numbers.height) == (6, 4)
    assert numbers.mean_a == (0.75, 0.75, 0.75)
    assert numbers.exposure == pytest.approx(0.8 / 0.5)
    assert numbers.relative_bias == pytest.approx(0.5)
    assert numbers.mse == pytest.approx(0.0625)
    assert numbers.mse_of_b == pytest.approx(0.01)
    assert numbers.mse_corrected == pytest.approx(0.0525)
    assert numbers.rel_mse_corrected == pytest.approx(0.0525 / 0.26)
    assert numbers.z_rms == pytest.approx(2.5)
    assert numbers.z_above_3 == 0
    assert numbers.flip_ldr > 0.05


def test_both_standard_errors_add_in_squares():
    a, b = image(grey(0.75), grey(0.3)), image(grey(0.5), grey(0.4))
    assert compare(a, b).z_rms == pytest.approx(0.5)


def test_a_standard_error_of_a_alone_gives_scores_but_no_correction():
    numbers = compare(image(grey(0.75), grey(0.1)), image(grey(0.5)))
    assert numbers.z_rms == pytest.approx(2.5)
    assert numbers.mse_corrected is None


def test_a_standard_error_of_one_component_holds_for_all_channels():
    numbers = compare(image(grey(0.75)), image(grey(0.5), grey(0.1)[..., :1]))
    assert numbers.z_rms == pytest.approx(2.5)


def test_certain_pixels_count_among_the_scores_above_3_only():
    error = grey(0.1)
    error[0] = 0
    numbers = compare(image(grey(0.75)), image(grey(0.5), error))
    assert numbers.z_above_3 == pytest.approx(1 / 4)
    assert numbers.z_rms == pytest.approx(2.5)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("layer", ["color", "standard_error"])
def test_pixels_that_are_not_finite_are_counted_and_left_out(bad, layer):
    a, b = image(grey(0.75), grey(0.1)), image(grey(0.5), grey(0.1))
    a.layers[layer][1, 2, 0] = bad
    b.layers[layer][1, 2:4, 1] = bad
    numbers = compare(a, b)
    assert (numbers.not_finite_a, numbers.not_finite_b) == (1, 2)
    assert numbers.mse == pytest.approx(0.0625)
    assert numbers.relative_bias == pytest.approx(0.5)


def test_images_of_one_pixel():
    assert compare(image(grey(2, 1, 1)), image(grey(1, 1, 1))).mse == 1


def test_radiance_at_the_end_of_the_range():
    numbers = compare(image(grey(-3e38)), image(grey(3e38)))
    assert numbers.mse == pytest.approx(3.6e77)


def test_for_json_infinity_is_none():
    numbers = compare(image(grey(1)), image(grey(0))).as_dict()
    assert numbers["relative_bias"] is None
    assert set(numbers) == {field.name for field in fields(Comparison)}
    assert json.loads(json.dumps(numbers, allow_nan=False))["mse"] == 1


def test_every_number_has_a_label():
    shown = {"width", "height"} | {number.name for number in NUMBERS}
    assert shown == {field.name for field in fields(Comparison)}


def test_other_sizes_are_refused_with_both(tmp_path):
    with pytest.raises(UsageError, match=r"a\.exr has 6x4 .*b\.exr 4x6") as error:
        compare(
            image(grey(1)), image(grey(1, 6, 4)), tmp_path / "x", ("a.exr", "b.exr")
        )
    assert len(str(error.value).splitlines()) == 1
    assert not list(tmp_path.iterdir())


def test_without_a_finite_pixel_there_is_nothing_to_compare(tmp_path):
    with pytest.raises(UsageError, match="no pixel is finite in both A and B"):
        compare(image(grey(np.nan)), image(grey(1)), tmp_path / "x")
    assert not list(tmp_path.iterdir())


# ---------------------------------------------------------------- maps


def test_red_is_where_a_is_brighter():
    a, b = grey(0.5).astype(float), grey(0.5).astype(float)
    a[0] += 0.2
    a[1] -= 0.2
    a[2] = np.nan
    shown = difference_map(a, b)
    assert shown.low == -shown.high == pytest.approx(-0.2)
    brighter, darker, unknown, equal = shown.pixels()[:, 0].astype(int)
    assert brighter[0] > 2 * brighter[2]
    assert darker[2] > 2 * darker[0]
    assert tuple(unknown) == MARKER
    assert equal.min() > 240


def test_the_mean_of_the_relative_map_is_mape(noisy):
    a, b = (i.color.astype(float) for i in noisy)
    values = relative_error_map(a, b).values
    assert values.mean() == pytest.approx(compare(*noisy).mape)


def test_the_z_map_shows_the_channel_that_stands_out():
    z = np.array([[[1.0, -7.0, 2.0], [np.inf, 0.0, 0.0], [0.0, 0.0, 0.0]]])
    shown = z_map(z)
    assert shown.values.tolist() == [[-7, np.inf, 0]]
    low, high, middle = shown.pixels()[0].astype(int)
    assert low[2] > low[0]
    assert high[0] > high[2]
    assert middle.min() > 240


def test_the_bar_runs_from_low_to_high():
    shown = flip_map(np.array([[0.0, 1.0]]))
    assert shown.bar()[[0, -1]].tolist() == shown.pixels()[0].tolist()


@pytest.mark.parametrize(
    ("difference", "scale"),
    [([0, 0, 0], 1), ([0] * 1000 + [-5], 5), ([3.0] * 1000 + [500], 3)],
)
def test_the_scale_ignores_fireflies_and_is_never_0(difference, scale):
    assert scale_of(np.array(difference, float)) == scale


def test_the_histogram_counts_every_pixel():
    values = np.array([0, 0, 0.1, -0.1, 5, -5, -5, np.nan])
    bars = histogram_bars(values, limit=1)
    assert sum(bar.count for bar in bars) == 7
    assert (bars[0].count, bars[30].count, bars[-1].count) == (2, 2, 1)
    assert bars[30].middle == pytest.approx(0, abs=1e-12)
    assert max(bar.height for bar in bars) == 1


# ---------------------------------------------------------------- folder


class Page(HTMLParser):
    """Elements of a page, and whether its tags are balanced."""

    def __init__(self, text):
        super().__init__()
        self.elements, self.open = [], []
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        """Note an element, and that it must be closed."""
        self.elements.append((tag, dict(attrs)))
        if tag not in ("meta", "img", "input"):
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        """Note an element that closes itself."""
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        """Close the element that was opened last."""
        assert self.open.pop() == tag

    def all(self, tag):
        """Attributes of each element of a kind."""
        return [attributes for name, attributes in self.elements if name == tag]


def test_the_folder(tmp_path, noisy):
    out = tmp_path / "new" / "folder"
    compare(*noisy, out)
    assert {path.name for path in out.iterdir()} == {*PICTURES, "z.png", "index.html"}
    for path in out.glob("*.png"):
        with Pillow.open(path) as picture:
            assert (picture.size, picture.mode) == ((16, 12), "RGB")


def test_without_standard_error_there_is_no_z_map(tmp_path):
    compare(image(grey(1)), image(grey(1)), tmp_path)
    assert sorted(p.name for p in tmp_path.glob("*.png")) == PICTURES


def test_the_same_images_make_the_same_page(tmp_path, noisy):
    for name in ("a", "b"):
        compare(*noisy, tmp_path / name)
    pages = [(tmp_path / name / "index.html").read_bytes() for name in ("a", "b")]
    assert pages[0] == pages[1]


def test_the_page_needs_no_network_and_no_other_file(tmp_path, noisy):
    compare(*noisy, tmp_path)
    text = (tmp_path / "index.html").read_text(encoding="utf-8")
    page = Page(text)
    assert not re.search(r"https?:|@import|url\(", text)
    assert not page.all("link")
    assert all("src" not in script for script in page.all("script"))
    assert all(i["src"].startswith("data:image/png;base64,") for i in page.all("img"))


def test_every_picture_has_a_text(tmp_path, noisy):
    compare(*noisy, tmp_path)
    page = Page((tmp_path / "index.html").read_text(encoding="utf-8"))
    assert len(page.all("img")) == 6
    assert all(attributes["alt"] for attributes in page.all("img"))
    assert all("aria-label" in attributes for attributes in page.all("svg"))
    assert page.all("html") == [{"lang": "en"}]


def test_the_page_tells_numbers_and_origins(tmp_path, noisy):
    numbers = compare(*noisy, tmp_path, ("biased.exr", "truth.exr"))
    text = (tmp_path / "index.html").read_text(encoding="utf-8")
    for words in ("biased.exr", "truth.exr", "restir-gi-biased", "door-ajar", "spp"):
        assert words in text
    assert f"{numbers.rmse:.4g}" in text
    assert text.count('class="differs"') == 2  # method and spp, not scene


def test_names_and_metadata_cannot_break_out_of_the_page(tmp_path):
    evil = "</script><script>alert(1)</script>\"'<img src=x>\udcff"
    compare(
        image(grey(1), k=evil), image(grey(1), **{evil: "v"}), tmp_path, (evil, evil)
    )
    page = Page((tmp_path / "index.html").read_text(encoding="utf-8"))
    assert len(page.all("script")) == 3  # two of values, one of ours
    assert len(page.all("img")) == 5


def test_values_for_the_probe_are_left_out_of_large_pages(tmp_path):
    large = image(grey(1, 513, 512))
    compare(large, large, tmp_path)
    assert 'id="values-a"' not in (tmp_path / "index.html").read_text(encoding="utf-8")


def test_a_folder_that_cannot_be_made(tmp_path, noisy):
    (tmp_path / "file").touch()
    for name in ("file", "file/below"):
        with pytest.raises(UsageError, match="cannot make the folder") as error:
            compare(*noisy, tmp_path / name)
        assert len(str(error.value).splitlines()) == 1
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


def test_an_older_page_stays_whole_if_a_picture_cannot_be_replaced(tmp_path, noisy):
    compare(*noisy, tmp_path)
    before = (tmp_path / "index.html").read_bytes()
    (tmp_path / "flip.png").unlink()
    (tmp_path / "flip.png").mkdir()
    with pytest.raises(UsageError, match=r"flip\.png"):
        compare(image(grey(1)), image(grey(2)), tmp_path)
    assert (tmp_path / "index.html").read_bytes() == before
    assert not list(tmp_path.glob(".*"))

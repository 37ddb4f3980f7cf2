"""The folder that a comparison leaves: whole, and without need of anything else."""

import re
from base64 import b64decode

import numpy as np
import pytest
from PIL import Image as Pillow

from restir_gi.reference.images.display import MARKER
from restir_gi.reference.images.image import Image
from restir_gi.reference.reports.comparison import compare
from restir_gi.reference.system.errors import UsageError
from tests.contracts.elements import Page

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


def test_the_folder(tmp_path, noisy):
    out = tmp_path / "new" / "folder"
    compare(*noisy, out)
    assert {path.name for path in out.iterdir()} == {*PICTURES, "z.png", "index.html"}
    for path in out.glob("*.png"):
        with Pillow.open(path) as picture:
            assert (picture.size, picture.mode) == ((16, 12), "RGB")


def test_what_is_left_out_is_magenta_in_every_map(tmp_path, noisy):
    a, b = noisy
    a.color[3, 5, 1] = np.nan
    compare(a, b, tmp_path)
    for name in ("a", "difference", "relative_error", "flip", "z"):
        with Pillow.open(tmp_path / f"{name}.png") as picture:
            assert picture.getpixel((5, 3)) == MARKER
            assert picture.getpixel((6, 3)) != MARKER


def test_the_page_carries_the_values_of_each_pixel(tmp_path, noisy):
    compare(*noisy, tmp_path)
    text = (tmp_path / "index.html").read_text(encoding="utf-8")
    for name, shown in zip("ab", noisy, strict=True):
        found = re.search(rf'id="values-{name}">([^<]*)<', text)
        values = np.frombuffer(b64decode(found[1]), "<f4").reshape(12, 16, 3)
        np.testing.assert_array_equal(values, shown.color)


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
    assert f">{numbers.rmse:.4g}<" in text
    assert f">{numbers.relative_bias:+.3%}<" in text
    assert f">{', '.join(f'{mean:.4g}' for mean in numbers.mean_a)}<" in text
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

"""The page of the inspector in a browser: right numbers, by mouse and by keys."""

import re

import numpy as np
import pytest

from restir_gi.reference.cli.main import main
from restir_gi.reference.images.exr import read_exr, write_exr
from restir_gi.reference.images.image import Image
from tests.browser.accessible import overflow, violations

WIDTH, HEIGHT, FRAMES = 16, 12, 3
PIXELS = [(0, 0), (7, 5), (3, 11), (15, 6), (9, 9)]
AOVS = "M,W,radiance,sample_position,sample_normal"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two runs, one picture without its history, and pages of them."""
    folder = tmp_path_factory.mktemp("inspector")
    for name in ("unbiased", "biased"):
        out = folder / f"{name}.exr"
        where = ("--size", f"{WIDTH}x{HEIGHT}", "--out", str(out), "--aov", AOVS)
        what = ("--method", f"restir-gi-{name}", "--frames", str(FRAMES))
        assert main(["render", "cornell-box", *what, *where, "--seed", "3"]) == 0
    image = read_exr(folder / "biased.exr")
    write_exr(folder / "theirs.exr", Image(image.layers, {}))
    for page, runs in {
        "one": ("unbiased",),
        "two": ("unbiased", "biased"),
        "theirs": ("unbiased", "theirs"),
    }.items():
        files = [str(folder / f"{run}.exr") for run in runs]
        assert main(["inspect", *files, "--out", str(folder / f"{page}.html")]) == 0
    return folder


@pytest.fixture
def inspector(folder, visit):
    def opened(name="one", **window):
        page = visit(folder / f"{name}.html", **window)
        page.wait_for_selector("body[data-ready]")
        return page

    return opened


def click(page, x, y):
    box = page.locator("#image").bounding_box()
    place = {
        "x": box["width"] * (x + 0.5) / WIDTH,
        "y": box["height"] * (y + 0.5) / HEIGHT,
    }
    page.locator("#image").click(position=place)


def table(page, caption):
    """Rows of the table of that caption, by their headings."""
    rows = page.get_by_role("region", name=caption, exact=True).locator("tbody tr")
    return [[cell.strip() for cell in row] for row in rows.evaluate_all(
        "rows => rows.map(row => Array.from(row.cells, cell => cell.textContent))"
    )]  # fmt: skip


def numbers(text):
    return [float(word.replace("−", "-")) for word in text.split()]


LAYER_OF = {
    "confidence M": "M",
    "contribution weight W, sr": "W",
    "sample point, m": "sample_position",
    "its normal": "sample_normal",
    "its radiance": "radiance",
}


def shown_reservoir(page, run=1):
    rows = table(page, "spatial reservoir")
    return {LAYER_OF[row[0]]: numbers(row[run]) for row in rows if row[0] in LAYER_OF}


def assert_shown(page, image, run=1):
    """Each number, to the seven digits that are shown, is that of the file."""
    for x, y in PIXELS:
        click(page, x, y)
        shown = shown_reservoir(page, run)
        for name, layer in image.layers.items():
            if name == "color" or (name != "M" and not image.layers["W"][y, x]):
                continue
            known = [float(f"{value:.7g}") for value in layer[y, x].tolist()]
            assert shown[name] == known, (x, y, name)


def test_it_opens_and_fetches_nothing(inspector):
    page = inspector("two")
    assert page.complaints == []
    assert [url for url in page.fetched if not url.startswith("file:")] == []
    assert page.title() == "unbiased.exr and biased.exr"


def test_control_what_is_fetched_is_noticed(tmp_path, visit):
    file = tmp_path / "page.html"
    file.write_text('<img src="http://127.0.0.1:9/picture.png" alt="">')
    page = visit(file)
    assert any(url.startswith("http:") for url in page.fetched)
    assert page.complaints


def test_a_click_shows_the_numbers_of_the_buffers(inspector, folder):
    assert_shown(inspector(), read_exr(folder / "unbiased.exr"))


def test_each_of_two_runs_has_its_own_numbers(inspector, folder):
    page = inspector("two")
    assert_shown(page, read_exr(folder / "unbiased.exr"), 1)
    assert_shown(page, read_exr(folder / "biased.exr"), 2)


def test_control_a_millionth_is_too_much(inspector, folder):
    image = read_exr(folder / "unbiased.exr")
    layers = {
        name: layer * np.float32(1 + 1e-6) for name, layer in image.layers.items()
    }
    with pytest.raises(AssertionError):
        assert_shown(inspector(), Image(layers))


def test_candidates_add_up(inspector):
    """Σ w is the sum of the reservoir, and one candidate is the kept one."""
    page = inspector()
    for x, y in PIXELS:
        click(page, x, y)
        for name in ("temporal", "spatial"):
            rows = table(page, f"candidates of the {name} pass")
            w = [numbers(row[7])[0] for row in rows if row[7] != "–"]
            known = dict(row[:2] for row in table(page, f"{name} reservoir"))
            total = numbers(known["sum of weights w"])[0]
            # Each is rounded to seven digits, half a unit at most.
            assert sum(w) == pytest.approx(total, rel=len(w) * 1e-6)
            kept = [row for row in rows if row[-1] == "kept"]
            assert len(kept) == (numbers(known["contribution weight W, sr"])[0] > 0)


def test_the_origin_is_a_place_to_go_to(inspector):
    page = inspector()
    click(page, 7, 5)
    button = page.locator("#candidates button").last
    words = button.text_content()
    button.click()
    assert f"Pixel {words}, " in page.locator("#where").text_content()


def test_frames_are_stepped_through(inspector):
    page = inspector()
    seen = []
    for _ in range(FRAMES):
        seen.append(page.locator("#frame-number").text_content())
        page.get_by_role("button", name="◀ frame").click()
    assert seen == ["2", "1", "0"]
    assert "frame 0" in page.locator("#where").text_content()
    page.get_by_role("button", name="frame ▶").click()
    assert page.locator("#frame-number").text_content() == "1"


def test_the_keyboard_is_enough(inspector):
    page = inspector("two")
    for _ in range(20):
        page.keyboard.press("Tab")
        if page.evaluate("document.activeElement.id") == "image":
            break
    else:
        pytest.fail("the image is not reached by Tab")
    for key in ["ArrowRight"] * 3 + ["ArrowDown"] * 2:
        page.keyboard.press(key)
    where = page.locator("#where")
    assert where.text_content() == f"Pixel (3, 2), row {2 * WIDTH + 3}, frame 2"
    page.keyboard.press("[")
    assert "frame 1" in where.text_content()
    page.keyboard.press("Shift+ArrowRight")
    assert "(11, 2)" in where.text_content()
    page.keyboard.press("]")
    page.keyboard.press("n")
    a, b = page.locator("#color").text_content().split("; ")
    assert a.removeprefix("A: ") != b.removeprefix("B: ")
    page.locator("#x").fill("5")
    page.locator("#x").press("Tab")
    assert "Pixel (5," in where.text_content()


def test_the_scene_is_drawn_and_turns(inspector):
    page = inspector()
    click(page, 7, 5)
    drawn = "document.getElementById('room').toDataURL()"
    room = page.locator("#room")
    pictures = [page.evaluate(drawn)]
    for key in ("ArrowLeft", "+", "Home"):
        room.press(key)
        pictures.append(page.evaluate(drawn))
    assert len(set(pictures[:3])) == 3
    assert pictures[3] == pictures[0]
    click(page, 3, 11)
    assert page.evaluate(drawn) != pictures[0]


def test_every_view_paints_the_picture_anew(inspector):
    page = inspector("two")
    drawn = "document.getElementById('image').toDataURL()"
    pictures = set()
    options = page.locator("#view option").all_text_contents()
    assert len(options) == 7
    for name in options:
        page.locator("#view").select_option(name)
        pictures.add(page.evaluate(drawn))
    # M is the same in both runs: they differ in what they divide by.
    assert len(pictures) == len(options) - 1


def test_the_picture_is_the_picture(inspector, folder):
    """Pixels of the canvas against the exposure and curve of the previews."""
    from restir_gi.reference.images.display import auto_exposure, to_display

    color = read_exr(folder / "unbiased.exr").color
    known = to_display(color, auto_exposure(color)).astype(int)
    data = inspector().evaluate(
        f"""Array.from(document.getElementById('image').getContext('2d')
            .getImageData(0, 0, {WIDTH}, {HEIGHT}).data)"""
    )
    shown = np.reshape(data, (HEIGHT, WIDTH, 4))[..., :3]
    # Both round to 8 bits, from exposures that are the same but for a last place.
    assert np.abs(shown - known).max() <= 1


def test_a_picture_of_another_renderer_stands_beside_it(inspector, folder):
    page = inspector("theirs")
    assert_shown(page, read_exr(folder / "theirs.exr"), 2)
    captions = page.locator("#candidates caption").all_text_contents()
    assert captions
    assert all(text.startswith("A: ") for text in captions)


def test_a_picture_without_frames_says_so_and_does_not_hold_up(inspector, folder):
    """Also as the first of the two."""
    out = folder / "first.html"
    runs = [str(folder / f"{name}.exr") for name in ("theirs", "unbiased")]
    assert main(["inspect", *runs, "--out", str(out)]) == 0
    page = inspector("first")
    assert page.locator("#frame-number").text_content() == str(FRAMES - 1)
    page.locator("#image").press("[")
    assert page.locator("#frame-number").text_content() == str(FRAMES - 2)
    heads = page.locator("#reservoirs thead").first.locator("th").all_text_contents()
    assert heads == ["", "A, frame of the file", "B"]
    assert page.complaints == []


def test_differences_are_marked(inspector):
    page = inspector("two")
    page.locator("#image").press("n")
    assert page.locator("tr.differs").count() > 0
    page = inspector("one")
    assert page.locator("tr.differs").count() == 0


@pytest.mark.parametrize("width", [320, 1280])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_everybody_can_read_it(inspector, width, scheme):
    page = inspector("two", width=width, scheme=scheme)
    page.locator("summary").first.click()
    click(page, 7, 5)
    assert violations(page) == {}
    assert overflow(page) == 0


def test_control_what_cannot_be_read_is_found(inspector):
    page = inspector("two", width=320)
    page.add_style_tag(content="td { color: #eee !important } body { width: 50rem }")
    page.evaluate("document.getElementById('x').parentNode.replaceWith("
                  "document.getElementById('x'))")  # fmt: skip
    assert {"color-contrast", "label"} <= set(violations(page))
    assert overflow(page) > 0


def test_a_browser_that_cannot_read_the_numbers_says_so(folder, tmp_path, visit):
    text = (folder / "one.html").read_text()
    block = re.search(r'id="block">([^<]+)<', text).group(1)
    (tmp_path / "cut.html").write_text(
        text.replace(block, block[: len(block) // 8 * 4])
    )
    page = visit(tmp_path / "cut.html")
    page.wait_for_function(
        "document.getElementById('where').textContent.startsWith('The page cannot')"
    )

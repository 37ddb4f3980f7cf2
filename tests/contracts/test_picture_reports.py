"""The report of a verdict on pictures: its numbers, its words, and its page."""

import json
from dataclasses import replace
from functools import cache
from io import BytesIO, StringIO

import numpy as np
import pytest
from PIL import Image as Pillow
from rich.console import Console

from restir_gi.reference.numerics.moments import Moments
from restir_gi.reference.oracle.blackbox.convention import Convention
from restir_gi.reference.oracle.blackbox.evidence import DARK, MISSED
from restir_gi.reference.oracle.blackbox.judge import with_error
from restir_gi.reference.oracle.blackbox.likeness import Likeness
from restir_gi.reference.oracle.blackbox.tiles import tile_means
from restir_gi.reference.oracle.cases import Failure
from restir_gi.reference.reports.pictures.chart import convergence
from restir_gi.reference.reports.pictures.maps import (
    GREY,
    error_maps,
    shown,
    tints,
)
from restir_gi.reference.reports.pictures.page import write_page
from restir_gi.reference.reports.pictures.plain import as_plain
from restir_gi.reference.reports.pictures.table import table
from restir_gi.reference.reports.verdict.schema import fault_of_form
from restir_gi.reference.system.json_text import json_text
from tests.contracts.elements import Page
from tests.contracts.synthetic_pictures import HEIGHT, WIDTH, judged, light, pictures_of

EVIL = "</style><script>alert(1)</script>\"'<img src=x>\x1b[2J\udcff"
OFF = 1.3
TILE = (slice(4, 8), slice(12, 18))
"""Pixels of tile (2, 1)."""


def one_tile_off():
    mean = light()
    mean[TILE] *= OFF
    return mean


def broken():
    yield from pictures_of(light(), 12, samples=1)
    yield Failure(f"seed 112: exit code 9:\nno license {EVIL}")


def negative():
    for picture in pictures_of(light(), 12, samples=1):
        picture[0, 0] = -picture[0, 0]
        yield picture


MADE = {
    "right": lambda: judged(pictures_of(light(), 100)),
    "two bounces": lambda: judged(pictures_of(light(Convention(bounces=2)), 100)),
    "tile": lambda: judged(pictures_of(one_tile_off(), 100)),
    "black": lambda: judged(pictures_of(0 * light(), 100)),
    "lit": lambda: judged(pictures_of(light(), 8), dark=slice(0, 4)),
    "flicker": lambda: judged(
        np.float32(1.5 if k % 2 else 60) * picture
        for k, picture in enumerate(pictures_of(light(), 80))
    ),
    "broken": lambda: judged(broken()),
    "negative": lambda: judged(negative()),
    "few": lambda: judged(pictures_of(light(), 4, samples=1)),
    "one": lambda: judged(pictures_of(light(), 1)),
    "none": lambda: judged(iter(())),
}

every_kind = pytest.mark.parametrize("kind", MADE)


@cache
def verdict_of(kind):
    return MADE[kind]()


def plain_of(kind):
    return as_plain(verdict_of(kind), "renderer", 12.5)


def printed(plain, width=120):
    """What a terminal shows."""
    file = StringIO()
    Console(file=file, width=width, highlight=False).print(table(plain))
    return file.getvalue()


def lines(plain):
    """Its lines, none of them broken."""
    return printed(plain, width=1000).splitlines()


# ---------------------------------------------------------------- for programs


@every_kind
def test_the_verdict_has_the_published_form(kind):
    assert fault_of_form(json.loads(json_text(plain_of(kind)))) == ""


@every_kind
def test_json_holds_the_whole_verdict(kind):
    plain = plain_of(kind)
    assert json.loads(json.dumps(plain, allow_nan=False)) == plain
    assert "\n" not in plain["headline"]


@pytest.mark.parametrize(
    ("kind", "status", "evidence"),
    [
        ("right", "PASS", ""),
        ("two bounces", "FAIL", "statistical"),
        ("tile", "FAIL", "statistical"),
        ("black", "FAIL", "statistical"),
        ("lit", "FAIL", "statistical"),
        ("flicker", "FAIL", "proven"),
        ("broken", "FAIL", "broken"),
        ("negative", "UNDECIDED", ""),
        ("none", "UNDECIDED", ""),
    ],
)
def test_the_verdict_is_told(kind, status, evidence):
    plain = plain_of(kind)
    assert (plain["status"], plain["evidence"]) == (status, evidence)
    assert (plain["accuses"] == "nothing") == (evidence == "")


def test_the_difference_is_that_of_the_means():
    """From the pixels, of which nothing but their moments is kept."""
    verdict, plain = verdict_of("tile"), plain_of("tile")
    mean = verdict.pixels.mean.reshape(HEIGHT, WIDTH, 3)
    expected = (tile_means(mean) - tile_means(light())).mean(axis=1)
    found = {one["name"]: one["difference"] for one in plain["means"]}
    assert len(found) == 17
    assert found["the picture"] == pytest.approx(expected[0], rel=1e-9)
    assert found["tile (2, 1)"] == pytest.approx(expected[1 + 4 + 2], rel=1e-9)
    assert found["tile (3, 2)"] == pytest.approx(expected[1 + 8 + 3], rel=1e-9)


def test_its_error_is_that_of_independent_pixels():
    """√(Σ m² / samples / pictures), and the truth's beside it.

    The spread of n ≥ 8 pictures is known to 1 / √2(n − 1), 27 % at most: this allows
    twice as much.
    """
    plain = plain_of("right")
    one, count = plain["means"][0], plain["looks"][-1]["pictures"]
    channels = light() ** 2 / 9 / (HEIGHT * WIDTH) ** 2
    expected = np.sqrt(channels.sum() * (1 / (64 * count) + 1 / 2**16))
    assert one["error"] == pytest.approx(expected, rel=0.54)
    assert one["relative"] == pytest.approx(one["difference"] / one["truth"])
    assert one["relative_error"] == pytest.approx(one["error"] / one["truth"])
    assert one["deviations"] == pytest.approx(one["difference"] / one["error"])


def test_the_worst_tile_is_the_first():
    first, worst, *others = plain_of("tile")["means"]
    assert (first["name"], first["x"]) == ("the picture", None)
    assert (worst["name"], worst["x"], worst["y"]) == ("tile (2, 1)", 2, 1)
    assert not worst["within"]
    assert worst["relative"] == pytest.approx(OFF - 1, abs=6 * worst["relative_error"])
    assert [one["p"] for one in others] == sorted(one["p"] for one in others)
    assert worst["p"] < others[0]["p"]


def test_margins_are_shares_of_the_truth():
    first, *tiles = plain_of("right")["means"]
    assert first["margin"] == pytest.approx(0.01 * first["truth"])
    for one in tiles:
        if one["x"] is not None:
            assert one["margin"] == pytest.approx(0.05 * one["truth"])
    lit = plain_of("lit")["means"]
    dark = next(one for one in lit if one["truth"] == 0 and one["x"] is not None)
    assert dark["margin"] == pytest.approx(
        DARK * plain_of("lit")["truth"]["mean"], rel=1e-9
    )


def test_evidence_that_accuses_is_beyond_what_is_asked_of_it():
    statistical, proven = (plain_of(k)["looks"][-1] for k in ("tile", "flicker"))
    assert statistical["p"] <= statistical["p_accuses"]
    assert statistical["e"] < statistical["e_accuses"]
    assert proven["e"] >= proven["e_accuses"]
    right = plain_of("right")
    assert right["looks"][-1]["p"] > right["looks"][-1]["p_accuses"]
    assert right["missed"] == MISSED


def test_light_where_none_should_be_has_no_relative_difference():
    plain = plain_of("lit")
    dark = [one for one in plain["means"] if one["truth"] == 0]
    assert sum(one["x"] is not None for one in dark) == 4
    assert all(one["relative"] is one["relative_error"] is None for one in dark)
    assert all(one["difference"] > 0 for one in dark)


def test_one_tile_is_followed_over_all_looks():
    looks = plain_of("negative")["looks"]
    assert [look["pictures"] for look in looks] == [8, 10, 12]
    assert len({look["worst_tile"]["name"] for look in looks}) == 1
    last = plain_of("negative")["means"]
    assert looks[-1]["worst_tile"]["difference"] == last[1]["difference"]
    assert looks[-1]["difference"] == last[0]["difference"]


def test_a_convention_that_alone_agrees_is_in_the_headline():
    verdict = verdict_of("two bounces")
    told = plain_of("two bounces")
    assert any("--bounces 2" in text for text in told["likenesses"])
    one, other = (Likeness(text, 51, 51, 1.0) for text in ("this one", "that one"))
    for likely, named in (((one,), True), ((one, other), False), ((), False)):
        plain = as_plain(replace(verdict, likenesses=likely), "renderer", 1.0)
        assert plain["headline"].endswith("they agree with this one") == named


# ---------------------------------------------------------------- in the terminal


@every_kind
def test_the_last_line_is_the_verdict(kind):
    plain = plain_of(kind)
    last = lines(plain)[-1]
    assert last.startswith(f"{plain['status']}: renderer: ")
    assert "\x1b" not in printed(plain)


@every_kind
def test_the_convention_is_told(kind):
    assert "--light indirect --bounces 1 --pixel center" in printed(plain_of(kind))


@every_kind
def test_mean_minus_truth_is_told_with_its_error(kind):
    plain = plain_of(kind)
    text = printed(plain)
    if not plain["means"]:
        assert kind in ("one", "none")
        assert "mean minus truth: not known" in text
    for one in plain["means"][:2]:
        assert one["name"] in text
        assert with_error(one["difference"], one["error"]) in text


@every_kind
def test_no_accuracy_is_told_that_was_not_held_against_the_truth(kind):
    """Nothing is "right to" so much, and "within" is said where it was shown."""
    text = printed(plain_of(kind), 1000)
    assert "right to" not in text
    assert "not too" not in text
    assert ("within the tolerance, and" in text) == (kind == "right")


def test_what_accuses_is_told_with_what_it_rests_on():
    assert "statistical evidence, which rests on noise of a finite variance" in (
        printed(plain_of("tile"), 1000)
    )
    proven = printed(plain_of("flicker"), 1000)
    assert "proven evidence, which rests on light that is never negative" in proven
    assert "your word" not in proven
    bound = replace(verdict_of("flicker"), bound=7.0)
    assert "on your word that no mean of a tile exceeds 7 times its truth" in (
        printed(as_plain(bound, "renderer", 1.0), 1000)
    )
    assert "what accuses" not in printed(plain_of("right"))


def test_negative_light_is_told():
    told = "what rests on light that is never negative was not used"
    assert told in printed(plain_of("negative"), 1000)
    assert told not in printed(plain_of("few"), 1000)


def test_what_would_decide_is_told_once():
    plain = plain_of("negative")
    assert plain["wanted"] > plain["pictures"]
    text = printed(plain, 1000)
    assert text.count(f"about {plain['wanted']:,} pictures would decide") == 1


def test_pictures_before_a_broken_one_are_in_the_means():
    plain = plain_of("broken")
    assert (plain["pictures"], plain["looks"][-1]["pictures"]) == (12, 12)
    assert "no license" in plain["headline"]


@pytest.mark.parametrize(
    ("value", "error", "factor", "text"),
    [
        (0.0123456, 0.00123, 100, "+1.23 ± 0.12"),
        (-214.6, 12.3, 1, "-215 ± 12"),
        (1e6, 12345.0, 1, "+1000000 ± 12345"),
        (0.5, 0.0, 100, "+50"),
        (0.5, None, 1, "+0.5"),
        (0.0, 3e-20, 1, "+0.000000000000 ± 0.000000000000"),
    ],
)
def test_a_number_has_as_many_digits_as_its_error(value, error, factor, text):
    assert with_error(value, error, factor) == text


# ---------------------------------------------------------------- pictures


def test_the_map_of_errors_takes_both_errors_together():
    verdict = verdict_of("tile")
    z = error_maps(verdict)[0].values
    y, x = 5, 13
    row = y * WIDTH + x
    own, mean = verdict.pixels.standard_error()[row], verdict.pixels.mean[row]
    truth, error = (a[y, x] for a in verdict.truth.picture)
    expected = (mean - truth).mean() / np.hypot(own.mean(), error.mean())
    assert z[y, x] == pytest.approx(expected)
    elsewhere = np.ones((HEIGHT, WIDTH), bool)
    elsewhere[TILE] = False
    assert z[TILE].mean() > 2 > np.abs(z[elsewhere].mean())


def test_the_map_of_per_cent_is_a_share_of_each_truth():
    percent = error_maps(verdict_of("black"))[1]
    assert percent.values == pytest.approx(np.full((HEIGHT, WIDTH), -100.0))
    assert (percent.low, percent.high) == pytest.approx((-100, 100))


def test_what_does_not_vary_is_grey():
    """In errors where neither varies; in per cent where there is no truth."""
    verdict = verdict_of("lit")
    pixels = verdict.pixels
    squares = pixels.squares.copy()
    squares[:WIDTH] = 0
    still = replace(verdict, pixels=Moments(pixels.count, pixels.mean, squares))
    z, percent = (one.pixels() for one in error_maps(still))
    assert (z[0] == GREY).all()
    assert not (z[1:] == GREY).all(axis=-1).any()
    assert (percent[:4] == GREY).all()
    assert not (percent[4:] == GREY).all(axis=-1).any()


@pytest.mark.parametrize(("kind", "maps"), [("none", 0), ("one", 0), ("few", 2)])
def test_one_picture_has_no_error(kind, maps):
    assert len(error_maps(verdict_of(kind))) == maps
    assert (shown(verdict_of(kind))[1] is None) == (kind == "none")


def test_truth_and_mean_are_shown_at_one_exposure():
    truth, mean = (
        np.asarray(Pillow.open(BytesIO(png))).astype(int)
        for png in shown(verdict_of("tile"))
    )
    assert truth.shape == mean.shape == (HEIGHT, WIDTH, 3)
    brighter = mean - truth
    assert brighter[TILE].mean() > 10 > np.abs(brighter[8:].mean())


def test_tints_are_red_where_it_is_too_bright():
    plain = plain_of("tile")
    red, _, blue = tints(plain["means"])[1, 2].astype(int)
    assert red > blue + 50
    assert (tints([]) == 160).all()


def test_the_chart_shows_the_looks_and_the_band():
    looks = plain_of("negative")["looks"]
    (axes,) = convergence([8, 10, 12], looks, 0.01).axes
    line = axes.containers[0].lines[0]
    assert line.get_xdata().tolist() == [8, 10, 12]
    assert line.get_ydata() == pytest.approx([100 * o["relative"] for o in looks])
    band = axes.patches[0].get_extents().transformed(axes.transData.inverted())
    assert (band.y0, band.y1) == pytest.approx((-1, 1))
    assert axes.get_xscale() == "log"
    assert [text.get_text() for text in axes.get_xticklabels()] == ["8", "10", "12"]


# ---------------------------------------------------------------- the page


def written(out, kind, name="renderer"):
    verdict = verdict_of(kind)
    plain = as_plain(verdict, name, 12.5)
    write_page(out, verdict, plain)
    return (out / "index.html").read_text(encoding="utf-8"), plain


IMAGES = {"none": 1, "one": 2, "few": 6}


@every_kind
def test_the_page_is_whole(kind, tmp_path):
    """Truth, mean, two maps, and two charts: where there is something to show."""
    text, plain = written(tmp_path, kind)
    page = Page(text)
    assert len(page.all("img")) == IMAGES.get(kind, 6) - (kind == "lit")
    assert all(one["src"].startswith("data:image/png") for one in page.all("img"))
    assert all(one["alt"] for one in page.all("img"))
    assert json.loads((tmp_path / "verdict.json").read_text()) == plain
    assert plain["convention"]["options"] in text


def test_the_page_tells_tiles_evidence_and_conventions(tmp_path):
    text, plain = written(tmp_path, "two bounces")
    assert text.count('class="beyond"') == 16
    for one in plain["means"]:
        assert f">{one['name']}</th>" in text
    assert "Statistical evidence, which rests on noise of a finite variance" in text
    assert "They agree with indirect light of 2 bounces" in text


def test_control_the_page_of_a_right_renderer_marks_nothing(tmp_path):
    text, _ = written(tmp_path, "right")
    assert 'class="failed"' not in text
    assert 'class="beyond"' not in text
    assert "What they agree with" not in text


def test_nothing_breaks_out_of_the_page(tmp_path):
    text, _ = written(tmp_path, "broken", name=EVIL)
    assert Page(text).all("script") == []

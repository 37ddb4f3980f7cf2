"""Renderers of which nothing is known but their pictures."""

from dataclasses import replace
from itertools import chain, count, islice, repeat

import numpy as np
import pytest

from restir_gi.reference.images.display import encode_srgb
from restir_gi.reference.images.exr import write_exr
from restir_gi.reference.images.image import Image
from restir_gi.reference.numerics.moments import Moments
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.oracle.backends.running import Limits
from restir_gi.reference.oracle.blackbox.convention import Convention
from restir_gi.reference.oracle.blackbox.evidence import Tolerance, pictures_to_decide
from restir_gi.reference.oracle.blackbox.judge import judge_pictures
from restir_gi.reference.oracle.blackbox.renderer import AT_ONCE, Renderer
from restir_gi.reference.oracle.blackbox.tiles import (
    COLUMNS,
    PLACES,
    TILES,
    columns,
    tile_means,
)
from restir_gi.reference.oracle.blackbox.truth import LEAST_SAMPLES, Truth, rows_of
from restir_gi.reference.oracle.cases import Failure, UnaskedError
from restir_gi.reference.scene.catalogue.registry import find_scene
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.transport.accumulate import path_samples
from restir_gi.reference.truth.pictures import PictureTruths
from tests.statistics.replicates import small_world

SIZE = 16
ASKED = Convention()
SAMPLES = 10**6


def scenery():
    """Light that differs from pixel to pixel, and from channel to channel."""
    y, x, channel = np.mgrid[:SIZE, :SIZE, :3]
    return 0.1 + 0.02 * x + 0.01 * y + 0.05 * channel


def truth_of(mean, shape=1.0):
    """What very many pictures of gamma-distributed light would leave behind."""
    squares = rows_of(mean) ** 2 * (SAMPLES - 1) / shape
    # Means over so many pixels, and over all channels.
    squares[SIZE * SIZE :] /= SIZE * SIZE
    squares[SIZE * SIZE :][~is_of_the_whole()] *= TILES**2
    squares[SIZE * SIZE :][:PLACES] /= 3
    return Truth(Moments(SAMPLES, rows_of(mean), squares), (SIZE, SIZE))


def is_of_the_whole():
    """Columns of no tile: the picture, and each of its channels."""
    return np.isin(np.arange(COLUMNS), [0, *range(PLACES, PLACES + 3)])


def pictures(mean, shape=20.0, seed=3):
    """Gamma-distributed light about a mean; a larger shape has less noise."""
    rng = np.random.default_rng(seed)
    while True:
        yield (mean * rng.gamma(shape, 1 / shape, mean.shape)).astype(np.float32)


KNOWN = {
    ASKED: truth_of(scenery()),
    replace(ASKED, pixel="box"): truth_of(1.2 * scenery()[:, ::-1]),
    replace(ASKED, bounces=2): truth_of(1.7 * scenery() ** 1.3),
    replace(ASKED, light="direct"): truth_of(scenery()[::-1] + 0.3),
    replace(ASKED, light="full"): truth_of(scenery()[::-1] + scenery()),
}


def verdict_on(made, most=150, **options):
    return judge_pictures(
        islice(made, most), KNOWN.__getitem__, ASKED, Tolerance(), **options
    )


def brighter(made, factor):
    return (factor * picture for picture in made)


# ---------------------------------------------------------------- verdicts


def test_a_right_renderer_passes():
    verdict = verdict_on(pictures(scenery()))
    assert (verdict.status, verdict.evidence) == ("PASS", "")
    assert "within the tolerance" in verdict.sentence


def test_a_right_renderer_is_undecided_for_want_of_pictures():
    """Noise of one in a hundred a picture needs a few more than two."""
    verdict = verdict_on(pictures(scenery(), shape=0.05), most=3)
    assert verdict.status == "UNDECIDED"
    assert verdict.wanted > 3
    assert "pictures would decide" in verdict.sentence


@pytest.mark.parametrize("factor", [1.01, 0.99, 1.3, 0.5])
def test_a_wrong_mean_is_found(factor):
    verdict = verdict_on(brighter(pictures(scenery()), np.float32(factor)))
    assert (verdict.status, verdict.evidence) == ("FAIL", "statistical")
    assert "of its truth" in verdict.sentence


def test_a_wrong_tile_is_found_and_named():
    mean = scenery()
    mean[4:8, 8:12] *= 1.05
    verdict = verdict_on(pictures(mean))
    assert verdict.status == "FAIL"
    assert "tile (2, 1)" in verdict.sentence


def test_black_pictures_are_wrong():
    verdict = verdict_on(brighter(pictures(scenery()), np.float32(0)))
    assert verdict.status == "FAIL"
    assert "-100" in verdict.sentence


def test_too_much_light_is_proven_where_it_is_hardly_the_same_twice():
    """Capital grows by 2 and by 8: to 4e6 in 12 pictures; t is 4 then."""
    made = (
        p * np.float32(2 if k % 2 else 8) for k, p in enumerate(pictures(scenery()))
    )
    verdict = verdict_on(made)
    assert (verdict.status, verdict.evidence) == ("FAIL", "proven")
    assert "never negative" in verdict.sentence


@pytest.mark.parametrize(("light", "status"), [(0.002, "PASS"), (0.02, "FAIL")])
def test_light_that_the_truth_never_met_may_be_there(light, status):
    """In a tile that is black in the truth, up to a hundredth of the picture's mean."""
    mean = scenery()
    mean[:4, :4] = 0
    made = (picture + np.float32(light) * (mean == 0) for picture in pictures(mean))
    truth = truth_of(mean)
    about = ASKED, Tolerance()
    verdict = judge_pictures(islice(made, 150), lambda _: truth, *about)
    assert verdict.status == status


def test_light_below_zero_is_not_held_against_a_renderer():
    """Gradient-domain pictures: what rests on light above 0 is not used."""
    made = (p - np.float32(0.2) * (k % 2) for k, p in enumerate(pictures(scenery())))
    verdict = judge_pictures(
        (p + np.float32(0.1) for p in islice(made, 150)),
        KNOWN.__getitem__,
        ASKED,
        Tolerance(0.2, 0.5),
    )
    assert verdict.negative
    assert all(look.e == 1 for look in verdict.looks)
    assert verdict.status == "PASS"


def test_light_below_zero_hides_no_bias():
    made = (p - np.float32(0.5) * (k % 2) for k, p in enumerate(pictures(scenery())))
    assert verdict_on(made).status == "FAIL"


# ---------------------------------------------------------------- what is broken


def test_seeds_that_do_nothing_are_no_bias():
    same = next(pictures(scenery()))
    verdict = verdict_on(same for _ in count())
    assert (verdict.status, verdict.evidence) == ("FAIL", "broken")
    assert "of two seeds are the same" in verdict.sentence


def test_light_without_noise_may_be_the_same_for_all_seeds():
    """As that of point lamps is, through the centres of pixels: right, and wrong."""
    exact = Truth(
        Moments(300, rows_of(scenery()), 0 * rows_of(scenery())), (SIZE, SIZE)
    )
    for factor, status in ((1.0, "PASS"), (1.01, "FAIL")):
        picture = (factor * scenery()).astype(np.float32)
        truths_of = {**KNOWN, ASKED: exact}.__getitem__
        verdict = judge_pictures(iter([picture] * 20), truths_of, ASKED, Tolerance())
        assert verdict.status == status
        assert verdict.evidence != "broken"


@pytest.mark.parametrize("light", [0.0, 1.0])
def test_nothing_is_said_where_the_truth_is_black(light):
    """Neither of black pictures nor of light that the path tracer may have missed."""
    black = truth_of(0 * scenery())
    made = brighter(islice(pictures(scenery()), 20), np.float32(light))
    verdict = judge_pictures(made, lambda _: black, ASKED, Tolerance())
    assert (verdict.status, verdict.wanted) == ("UNDECIDED", None)
    assert "met no such light" in verdict.sentence


def test_seeds_that_come_again_are_told():
    first = list(islice(pictures(scenery()), 5))
    verdict = verdict_on(first[k % 5] for k in count())
    assert verdict.evidence == "broken"


def test_a_picture_that_is_missing_is_no_bias():
    made = iter([*islice(pictures(scenery()), 2), Failure("seed 102: cannot read x")])
    verdict = verdict_on(made)
    assert (verdict.status, verdict.evidence) == ("FAIL", "broken")
    assert verdict.sentence == "seed 102: cannot read x"


# ---------------------------------------------------------------- other conventions


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (encode_srgb, "encoded as sRGB"),
        (lambda p: np.pi * p, "times pi"),
        (lambda p: p / 2, "times 1/2"),
        (lambda p: 1.05 * p, "times 1.05, throughout"),
        (lambda p: p[::-1], "upside down"),
        (lambda p: p[:, ::-1], "left and right exchanged"),
        (lambda p: p[..., ::-1], "red and blue exchanged"),
        (
            lambda p: np.repeat(
                (p @ np.array([0.2126, 0.7152, 0.0722]))[..., None], 3, axis=2
            ),
            "luminance in all channels",
        ),
        (lambda p: p * (1.7 * scenery() ** 0.3), "--bounces 2"),
        (lambda p: p * (1.2 * scenery()[:, ::-1] / scenery()), "--pixel box"),
        (lambda p: p * (scenery()[::-1] + scenery()) / scenery(), "--light full"),
    ],
)
def test_another_convention_is_named(change, words):
    made = (change(p).astype(np.float32) for p in pictures(scenery(), shape=100.0))
    verdict = verdict_on(made)
    assert verdict.status == "FAIL"
    assert words in verdict.likenesses[0].sentence


def test_what_follows_no_convention_is_not_named():
    mean = scenery()
    mean[:8, :8] *= 1.4
    verdict = verdict_on(pictures(mean))
    assert verdict.status == "FAIL"
    assert verdict.likenesses == ()


# ---------------------------------------------------------------- numbers


def test_the_number_of_pictures_that_would_decide_decides():
    few = verdict_on(pictures(scenery(), shape=0.05), most=20)
    many = verdict_on(pictures(scenery(), shape=0.05), most=2 * few.wanted)
    assert few.status == "UNDECIDED"
    assert many.status == "PASS"
    assert len(many.looks[-1].differences.error) == COLUMNS


def test_no_number_of_pictures_decides_against_a_rough_truth():
    verdict = verdict_on(pictures(scenery(), shape=0.05), most=20)
    found = verdict.looks[-1].differences
    rough = replace(found, error=np.hypot(found.error, 0.02 * found.truth))
    margins = Tolerance().margins(verdict.truth)
    assert pictures_to_decide(rough, margins, len(verdict.looks)) is None


def test_tiles_are_where_they_are_said_to_be():
    color = np.zeros((SIZE, 2 * SIZE, 3))
    color[4:8, 16:24] = 1  # the second row of tiles, the third column
    found = columns(tile_means(color))[:PLACES]
    assert found[0] == pytest.approx(32 / (2 * SIZE**2))
    assert np.flatnonzero(found[1:]).tolist() == [1 * 4 + 2]


# ---------------------------------------------------------------- truths


def truths(folder, size=8, **options):
    about = {
        "scene": find_scene("cornell-box"),
        "size": (size, size),
        "asked": ASKED,
        "tolerance": Tolerance(0.5, 0.9),
        "remaining": lambda: 1e6,
        "folder": folder,
    }
    return PictureTruths(**{**about, **options})


def test_a_truth_is_kept_and_not_traced_again(tmp_path):
    told = []
    first = truths(tmp_path)(ASKED)
    again = truths(tmp_path, tell=told.append)(ASKED)
    assert told == []
    assert (first.moments.mean == again.moments.mean).all()
    assert first.samples == again.samples


def test_a_truth_goes_on_from_what_is_kept(tmp_path):
    """With the very next sample; those before are not traced again."""
    told = []
    rough = truths(tmp_path)(ASKED)
    finer = truths(tmp_path, tolerance=Tolerance(0.1, 0.5), tell=told.append)(ASKED)
    assert told[0] == f"truth, {rough.samples + 1} samples"
    assert finer.samples > rough.samples


@pytest.mark.parametrize(
    "change",
    [
        {"size": 12},
        {"scene": find_scene("door-ajar")},
    ],
)
@pytest.mark.few(1)
def test_another_truth_is_traced_anew(tmp_path, change):
    truths(tmp_path)(ASKED)
    truths(tmp_path, **change)(ASKED)
    assert len(list(tmp_path.iterdir())) == 2


def test_each_convention_has_a_truth_of_its_own(tmp_path):
    found = [truths(tmp_path)(c).mean[0] for c in (ASKED, *ASKED.others())]
    assert len(set(found)) == len(found) == len(list(tmp_path.iterdir()))


@pytest.mark.slow
@pytest.mark.parametrize(("factor", "agrees"), [(1.0, True), (1.15, False)])
def test_a_truth_has_the_error_that_it_says(tmp_path, factor, agrees):
    """Within 6 errors of as many other paths, in 68 means: wrong in 1e-7 of cases.

    The control is 15 % off, some 40 of the errors that a tolerance of 5 % asks for.
    """
    found = truths(tmp_path, tolerance=Tolerance(0.05, 0.5))(ASKED)
    world = small_world(find_scene("cornell-box"), 8, 8)
    about = {"light": "indirect", "bounces": 1, "seed": 77}
    paths = path_samples(world, Schedule(), **about)
    made = [paths.radiance(slice(0, 64), k) for k in range(found.samples)]
    means = columns(np.array([tile_means(one.reshape(8, 8, 3)) for one in made]))
    error = np.hypot(means.std(axis=0) / len(means) ** 0.5, found.standard_error)
    off = np.abs(factor * means.mean(axis=0) - found.mean)
    assert (off <= 6 * error).all() == agrees


def test_a_kept_truth_that_is_damaged_is_made_anew(tmp_path):
    first = truths(tmp_path)(ASKED)
    (file,) = tmp_path.iterdir()
    file.write_bytes(b"damaged")
    again = truths(tmp_path)(ASKED)
    error = np.hypot(first.standard_error, again.standard_error)
    assert (np.abs(again.mean - first.mean) <= 6 * error).all()


def test_a_truth_that_cannot_be_kept_is_traced_all_the_same(tmp_path):
    (tmp_path / "file").write_text("in the way")
    assert truths(tmp_path / "file")(ASKED).samples >= LEAST_SAMPLES


def test_a_truth_counts_against_the_time(tmp_path):
    times = chain([10.0], repeat(4.0))
    with pytest.raises(UnaskedError):
        truths(tmp_path, size=64, remaining=lambda: next(times))(ASKED)


# ---------------------------------------------------------------- programs


def program(tmp_path, body, limits=None, size=(SIZE, SIZE), places="{seed} {out}"):
    path = tmp_path / "render.sh"
    path.write_text(f"#!/bin/sh\n{body}\n", encoding="utf-8")
    path.chmod(0o755)
    template = f"{path} {places} {{scene}} {{frames}} {{width}}"
    return Renderer(template, "my scene", 3, size, limits or Limits())


def ready(tmp_path, color):
    path = tmp_path / "ready.exr"
    write_exr(path, Image({"color": color}, {}))
    return path


GREY = np.full((SIZE, SIZE, 3), 0.5, np.float32)


def test_the_template_is_filled_in(tmp_path):
    picture = ready(tmp_path, GREY)
    body = f'echo "$1|$3|$4|$5" > {tmp_path}/said; cp {picture} "$2"'
    found = program(tmp_path, body).render(11)
    assert (found == GREY).all()
    assert (tmp_path / "said").read_text() == f"11|my scene|3|{SIZE}\n"


def test_one_call_makes_the_pictures_of_a_list(tmp_path):
    picture = ready(tmp_path, GREY)
    body = f"""echo called >> {tmp_path}/calls
    while read -r seed out
    do echo $seed >> {tmp_path}/seeds; cp {picture} $out
    done < $1"""
    renderer = program(tmp_path, body, places="{list}")
    found = list(islice(renderer.pictures(count(5)), 2 * AT_ONCE))
    assert all((one == GREY).all() for one in found)
    assert len((tmp_path / "calls").read_text().split()) == 2
    seeds = (tmp_path / "seeds").read_text().split()
    assert seeds == [str(5 + k) for k in range(2 * AT_ONCE)]


def test_a_picture_missing_from_a_list_is_told(tmp_path):
    picture = ready(tmp_path, GREY)
    body = f'read -r seed out < "$1"; cp {picture} $out'
    found = list(islice(program(tmp_path, body, places="{list}").pictures(count(5)), 2))
    assert (found[0] == GREY).all()
    assert "seed 6: cannot read" in found[1].reason


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ("exit 0", "cannot read"),
        ("echo no license >&2; exit 9", "exit code 9: no license"),
        ('echo text > "$2"', "is not an OpenEXR file"),
        ("exec sleep 60", "did not end"),
    ],
)
def test_what_a_program_does_wrong_is_told(tmp_path, body, words):
    found = program(tmp_path, body, Limits(seconds=1.0)).render(1)
    assert isinstance(found, Failure)
    assert words in found.reason


@pytest.mark.parametrize(
    ("color", "words"),
    [
        (np.full((SIZE, SIZE, 3), np.nan, np.float32), "pixel (0, 0) is not finite"),
        (np.zeros((4, 4, 3), np.float32), "4x4 instead of 16x16"),
    ],
)
def test_pictures_that_cannot_be_judged_are_told(tmp_path, color, words):
    found = program(tmp_path, f'cp {ready(tmp_path, color)} "$2"').render(1)
    assert isinstance(found, Failure)
    assert words in found.reason


def test_the_sides_of_an_oblong_picture_are_filled_in_apart(tmp_path):
    template = "sh -c 'exit {width}{height}' {out}"
    found = Renderer(template, "x", 1, (4, 2), Limits()).render(1)
    assert "exit code 42" in found.reason
    square = replace(Renderer(template, "x", 1, (4, 2), Limits()), template="a {size}")
    with pytest.raises(UsageError, match=r"4x2; write \{width\} and \{height\}"):
        square.render(1)


def test_a_program_that_does_not_exist_is_bad_usage():
    renderer = Renderer("/no/such {out}", "x", 1, (SIZE, SIZE), Limits())
    with pytest.raises(UsageError, match="cannot run /no/such"):
        renderer.render(1)

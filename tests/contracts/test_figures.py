"""The paper's figures made again: files, numbers, and the mathematics of both."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats

from restir_gi.figures import contest, validation
from restir_gi.figures.contest import FRAMES, Contender, Contest, compete
from restir_gi.figures.gradient_domain import ablations, gradients, images, rounds
from restir_gi.figures.hashgrid import turns
from restir_gi.figures.paths import sized_world
from restir_gi.figures.regions import floor_points, zones
from restir_gi.gradient_domain import least_absolute
from restir_gi.reference.cli.main import main
from restir_gi.reference.images.image import luminance
from restir_gi.reference.methods import Progress
from restir_gi.reference.methods.restir_gi import UNBIASED
from restir_gi.reference.numerics.intervals import mean_interval, ratio_interval
from restir_gi.reference.numerics.moments import Moments, add_samples, merge, no_samples
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.reports import timing
from restir_gi.reference.reports.demo.runs import CONVERGED
from restir_gi.reference.reports.figures.canvas import Tile, blank, draw_tiles
from restir_gi.reference.reports.figures.record import (
    Deviation,
    Interval,
    PaperFigure,
    Work,
)
from restir_gi.reference.reports.figures.registry import (
    NUMBERS,
    FigureEntry,
    figure_names,
    find_figure,
)
from restir_gi.reference.reports.figures.spread import spreads
from restir_gi.reference.reports.figures.table import as_plain, table, text
from restir_gi.reference.reports.figures.tiles import (
    largest_of_half,
    rms_without_noise,
    tile_luminance,
)
from restir_gi.reference.system import plugins

FALSE_ALARM = 1e-6
SMALL = Work(16, 4, Schedule())


# ---------------------------------------------------------------- the command


@pytest.fixture
def restir(capsys):
    """Run a command in this process.  Returns its code, stdout and stderr."""

    def run(*arguments):
        code = main([str(argument) for argument in arguments])
        return code, *capsys.readouterr()

    return run


@pytest.mark.parametrize("name", figure_names())
@pytest.mark.few(3)
def test_every_figure_is_made(restir, tmp_path, monkeypatch, name):
    """Small, of few frames: what is written is what is printed, and it is finite."""
    monkeypatch.setattr(contest, "FRAMES", 4)
    monkeypatch.setattr(validation, "SAMPLES", 8)
    for name_of_frames in ("WARM", "COUNTED"):
        monkeypatch.setattr(turns, name_of_frames, 2)
    monkeypatch.setattr(rounds, "FRAMES", 2)
    monkeypatch.setattr(least_absolute, "STEPS", 2)
    for gradient_figure in (gradients, images, ablations):
        monkeypatch.setattr(gradient_figure, "TRUTH", 2)
        monkeypatch.setattr(gradient_figure, "SCENES", ("checker", "moving-camera"))
    out = tmp_path / "new"
    quick = ("--size", 16, "--runs", 4, "--json")
    code, printed, told = restir("figures", name, "--out", out, *quick)
    assert (code, told) == (0, "")
    assert {path.name for path in out.iterdir()} == {f"{name}.png", f"{name}.json"}
    assert (out / f"{name}.png").read_bytes().startswith(b"\x89PNG")
    (numbers,) = json.loads(printed)["figures"]
    assert numbers == json.loads((out / f"{name}.json").read_text())
    assert (numbers["name"], numbers["size"], numbers["runs"]) == (name, 16, 4)
    assert numbers["remarks"]
    columns = {tuple(row) for row in numbers["rows"]}
    assert len(columns) == 1
    assert "null" not in printed


def test_the_figures_as_a_table(restir, tmp_path, monkeypatch):
    plug_in(monkeypatch, "one", "two")
    code, printed, told = restir("figures", "--out", tmp_path)
    assert (code, told) == (0, "")
    assert printed.index("title of one") < printed.index("title of two")
    assert "remark of two" in printed
    assert f"Look at {tmp_path / 'two.png'}." in printed


def test_a_figure_asked_for_twice_is_made_once(restir, tmp_path, monkeypatch):
    plug_in(monkeypatch, "one")
    _, printed, _ = restir("figures", "one", "one", "--out", tmp_path, "--json")
    assert len(json.loads(printed)["figures"]) == 1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("sorce", "unknown figure 'sorce'; did you mean source? known are equal-time"),
        ("source nothing", "unknown figure 'nothing'"),
        ("source --runs 1", "from 2 to 1000"),
        ("bias --runs 3", "figure bias needs at least 4"),
        ("source --size 15", "from 16 to 4096"),
        ("source --size 32x32", "from 16 to 4096"),
    ],
)
def test_bad_requests_are_told_in_one_line(restir, tmp_path, arguments, words):
    """Before anything runs: not even the folder is made."""
    out = tmp_path / "new"
    code, printed, told = restir("figures", *arguments.split(), "--out", out)
    assert (code, printed) == (2, "")
    assert words in told
    assert told.count("\n") == 1
    assert not out.exists()


def test_the_command_explains_itself(restir, monkeypatch):
    monkeypatch.setenv("COLUMNS", "1000")  # names must not be broken at their hyphens
    code, printed, _ = restir("figures", "--help")
    assert code == 0
    assert printed.startswith("usage: restir figures ")
    assert ", ".join(figure_names()) in printed


def test_the_folder_is_needed(restir):
    code, _, told = restir("figures", "source")
    assert code == 2
    assert "--out" in told


def test_a_broken_figure(restir, tmp_path, monkeypatch):
    """Announced by an entry point; broken, its package is named in one line."""
    (point,) = plug_in(monkeypatch, "grey")
    assert figure_names() == ["grey"]
    code, printed, _ = restir("figures", "grey", "--out", tmp_path)
    assert (code, "title of grey" in printed) == (0, True)
    point.load = lambda: None
    code, _, told = restir("figures", "grey", "--out", tmp_path)
    assert code == 2
    assert "figure 'grey' of an unknown package (x:grey) is None" in told


def plug_in(monkeypatch, *names):
    """FigureEntry points of figures that take no time; there are no others."""

    def point(name):
        entry = FigureEntry(name, lambda work: drawn(name), 2)
        return SimpleNamespace(
            name=name, value=f"x:{name}", dist=None, load=lambda: entry
        )

    points = [point(name) for name in names]

    def entry_points(group, name=None):
        return [point for point in points if name in (None, point.name)]

    monkeypatch.setattr(plugins, "entry_points", entry_points)
    return points


def drawn(name):
    picture = blank(1.0, 1.0)
    draw_tiles(picture, [[Tile(np.zeros((2, 2, 3), np.uint8))]])
    rows = ({"x": "a", "y": 1.0}, {"x": "b", "y": float("inf")})
    return PaperFigure(name, f"title of {name}", picture, rows, (f"remark of {name}",))


# ---------------------------------------------------------------- registry


def test_names_are_those_of_the_entries():
    entries = {name: find_figure(name) for name in figure_names()}
    assert all(entry.name == name for name, entry in entries.items())
    assert find_figure("13") is find_figure("1") is entries["equal-time"]
    assert all(find_figure(n) is entries[name] for n, name in NUMBERS.items())
    assert all(entry.runs >= entry.least_runs >= 2 for entry in entries.values())


def test_the_papers_figures_come_first_and_in_its_order(monkeypatch):
    plug_in(monkeypatch, "source", "grey", "jacobian", "blue")
    assert figure_names() == ["jacobian", "source", "blue", "grey"]


# ---------------------------------------------------------------- tables


@pytest.mark.parametrize(
    ("cell", "words"),
    [
        ("a b", "a b"),
        (7, "7"),
        (0.012345, "0.0123"),
        (Interval(15.21, 13.06, 17.9), "15.2 [13.1, 17.9]"),
        (Deviation(-0.0123, 0.004), "-1.23% ± 0.40%"),
    ],
)
def test_numbers_as_they_are_read(cell, words):
    assert text(cell) == words


def test_a_row_of_the_table_a_row_of_the_figure():
    made = table(drawn("one"))
    assert [column.header for column in made.columns] == ["x", "y"]
    assert made.row_count == 2


def test_numbers_for_a_program():
    figure = replace(
        drawn("one"), rows=({"a": Interval(1.0, 0.5, float("inf")), "b": "c"},)
    )
    (row,) = as_plain(figure)["rows"]
    assert row == {"a": {"value": 1.0, "low": 0.5, "high": None}, "b": "c"}


def test_pixels_are_those_of_the_file():
    pixels = drawn("one").pixels()
    assert pixels.shape == (144, 144, 3)
    assert pixels.dtype == np.uint8
    assert len(np.unique(pixels)) > 1


# ---------------------------------------------------------------- intervals


def test_an_interval_of_what_does_not_vary():
    assert mean_interval(np.full(5, 3.0)) == Interval(3.0, 3.0, 3.0)


def test_a_ratio_pairs_the_runs():
    """Twice a in each run: the ratio is certain, though a and b are not."""
    a = np.array([1.0, 10.0, 100.0, 1000.0])
    interval = ratio_interval(2 * a, a, factor=3.0)
    assert interval == Interval(6.0, 6.0, 6.0)
    shuffled = ratio_interval(2 * a, a[::-1], factor=3.0)
    assert shuffled.low < 6.0 < shuffled.high


def test_a_ratio_to_nothing_is_infinite():
    """Errors may fall below 0 where the truth is noisier than the pictures."""
    interval = ratio_interval(np.ones(3), np.array([-1.0, -2.0, -3.0]))
    assert interval == Interval(np.inf, np.inf, np.inf)
    mixed = ratio_interval(np.ones(3), np.array([-1.0, 2.0, 3.0]))
    assert mixed.low < np.inf == mixed.high


def covers(runs, repetitions, draw, squeeze=1.0):
    """How many intervals, narrowed about their middle, hold the true mean 0."""
    rng = np.random.default_rng(1)
    found = [mean_interval(draw(rng, runs)) for _ in range(repetitions)]
    return sum(
        i.value + squeeze * (i.low - i.value)
        <= 0
        <= i.value + squeeze * (i.high - i.value)
        for i in found
    )


def band(repetitions, low, high):
    """Counts that a coverage between the two leaves at half the rate on each side."""
    return (
        stats.binom.ppf(FALSE_ALARM / 2, repetitions, low),
        stats.binom.isf(FALSE_ALARM / 2, repetitions, high),
    )


def normal(rng, runs):
    return rng.standard_normal(runs)


def test_coverage_of_three_runs_is_exact():
    """The share of all draws whose mean is the least value is 1/27 > 2.5 %.

    So the interval is [min, max] of three values, which misses the median of a
    continuous law with probability 2 · (1/2)³: it covers in 3 of 4 cases.  That the
    least of 27 equally likely draws makes up more than 2.5 % of the 4000 actual ones
    is certain but for a chance of P(Bin(4000, 1/27) <= 100) = 2e-5 a seed, and the
    seed is fixed.
    """
    values = np.array([-1.0, 0.3, 2.0])
    assert mean_interval(values) == Interval(values.mean(), -1.0, 2.0)
    low, high = band(1000, 0.75, 0.75)
    assert low <= covers(3, 1000, normal) <= high


def test_coverage_of_32_runs_is_that_of_the_docstring():
    """P(|t| <= 1.96 sqrt(31/32)) with 31 degrees of freedom, for normal values.

    The bootstrap distribution of a mean of 32 values is normal but for terms of order
    1/32 in its shape, and its quantiles of 4000 draws scatter by 2 %: the half-width is
    right within 5 %, which moves the coverage by less than 0.013 to either side.
    """
    reach = stats.norm.ppf(0.975) * np.sqrt(31 / 32)
    least, most = (1 - 2 * stats.t.sf(reach * by, 31) for by in (0.95, 1.05))
    low, high = band(2000, least, most)
    assert low <= covers(32, 2000, normal) <= high


def test_control_an_interval_too_narrow_covers_too_rarely():
    """Narrowed to 3/4, as by a standard error with the wrong root, it is found out."""
    reach = stats.norm.ppf(0.975) * np.sqrt(31 / 32)
    least = 1 - 2 * stats.t.sf(reach * 0.95, 31)
    low, _ = band(2000, least, least)
    assert covers(32, 2000, normal, squeeze=0.75) < low


# ---------------------------------------------------------------- batches and tiles


def test_batches_merge_into_the_whole():
    """As one accumulation of all samples.

    Both sum at most 9 terms of size below 16, each rounded a few times: 9 · 16 · 10
    steps of 1.1e-16 are below 2e-13.
    """
    x = np.random.default_rng(0).uniform(-4, 4, (9, 5, 3))
    schedule = Schedule()

    def moments(some):
        return add_samples(no_samples(5), lambda r, i: some[i][r], len(some), schedule)

    whole, merged = moments(x), merge([moments(x[:2]), moments(x[2:3]), moments(x[3:])])
    assert merged.count == 9
    np.testing.assert_allclose(merged.mean, whole.mean, atol=2e-13, rtol=0)
    np.testing.assert_allclose(merged.squares, whole.squares, atol=2e-13, rtol=0)


def test_tiles_hold_their_own_pixels():
    """Grey of 2 x 2 tiles of 8 pixels, with a border of one pixel that is left over.

    Powers of two: the means are exact, and luminance weights sum to 1 within rounding.
    """
    size = 17
    grey = np.full((size, size), 1000.0)
    grey[:8, :8], grey[:8, 8:16], grey[8:16, :8], grey[8:16, 8:16] = 1, 2, 4, 8
    rows = np.repeat(grey.reshape(-1, 1), 3, axis=1)
    white = luminance(np.ones((1, 3)))[0]
    np.testing.assert_allclose(
        tile_luminance(rows, size), white * np.array([[1, 2], [4, 8]]), rtol=1e-14
    )


def test_the_largest_tile_is_judged_by_runs_that_did_not_choose_it():
    """Even runs say that column 1 is the largest; odd runs alone say by how much."""
    values = np.array([[0.1, -9.0], [5.0, 1.0], [0.2, -7.0], [6.0, 2.0]])
    index, mean, error = largest_of_half(values)
    # 1 and 2: mean 1.5, standard deviation sqrt(1/2), error sqrt(1/2) / sqrt(2).
    assert (index, mean) == (1, 1.5)
    assert error == pytest.approx(0.5, rel=1e-15)


def test_noise_is_not_taken_for_a_deviation():
    """Columns 3 and -1 in expectation, plus noise that each half of the runs sums to 0.

    √((3² + 1²) / 2) = √5; the root mean square of the runs themselves is √12.5.
    """
    noise = np.array([[2.0, -4.0], [1.0, 3.0], [-2.0, 4.0], [-1.0, -3.0]])
    values = np.array([3.0, -1.0]) + noise
    assert rms_without_noise(values) == pytest.approx(np.sqrt(5), rel=1e-15)
    assert np.sqrt((values**2).mean()) == pytest.approx(np.sqrt(12.5), rel=1e-15)


def test_halves_that_contradict_each_other_deviate_by_nothing():
    assert rms_without_noise(np.array([[1.0, -2.0], [-1.0, 2.0]])) == 0.0


# ---------------------------------------------------------------- regions


def test_zones_share_no_pixel_and_leave_none_out():
    distance = np.array([-0.1, 0.0, 0.4, 0.5, 0.99, 1.0])
    among = np.array([True, True, False, True, True, True])
    found = zones(distance, among, (0.0, 0.5, 1.0, 2.0, 3.0))
    assert {ends: list(np.flatnonzero(mask)) for ends, mask in found.items()} == {
        (0.0, 0.5): [1],
        (0.5, 1.0): [3, 4],
        (1.0, 2.0): [5],
    }


def test_the_floor_is_where_things_stand():
    world = sized_world("sunlit-wall", 16)
    position, normal, floor = floor_points(world, SMALL)
    assert floor.any()
    assert not floor.all()
    np.testing.assert_array_equal(position[floor, 1], 0.0)
    np.testing.assert_array_equal(normal[floor, 1], 1.0)


# ---------------------------------------------------------------- contests


def hand_made(colors, truth, error, spread):
    """Contest of one contender with pictures of one pixel."""
    count = 2
    squares = np.full((1, 3), error**2 * count * (count - 1.0))
    batches = [Moments(2, np.zeros((1, 3)), np.full((1, 3), s)) for s in spread]
    runs = {"a": SimpleNamespace(colors=[np.full((1, 3), c) for c in colors])}
    moments = Moments(count, np.full((1, 3), truth), squares)
    return Contest(None, 1, batches, moments, 1.0, runs)


def test_errors_leave_out_those_of_the_truth():
    """Differences 1 and 3 squared, less 0.5 squared; exact in binary."""
    found = hand_made([3.0, 5.0], truth=2.0, error=0.5, spread=[1.0])
    np.testing.assert_array_equal(found.errors("a"), [0.75, 8.75])


def test_errors_of_some_pixels():
    found = hand_made([3.0, 5.0], truth=2.0, error=0.5, spread=[1.0])
    mask = np.array([True])
    np.testing.assert_array_equal(found.errors("a", mask), found.errors("a"))


def test_variance_of_one_sample():
    """Two samples with squares s have variance s / (2 - 1)."""
    found = hand_made([3.0], truth=2.0, error=0.5, spread=[1.0, 4.0])
    np.testing.assert_array_equal(found.path_variances(), [1.0, 4.0])


def test_contenders_and_paths_take_turns():
    """Every contender is asked for each frame before any is asked for the next."""
    asked = []

    def render(name):
        def steps(job):
            for frame in range(job.counts["frames"]):
                asked.append((job.seed, frame, name))
                yield Progress(frame + 1, FRAMES, "frames")
            return {"color": np.full((256, 3), float(job.seed))}

        return steps

    contenders = [
        Contender(name, replace(UNBIASED, render=render(name)), 1) for name in "ab"
    ]
    found = compete(sized_world("cornell-box", 16), contenders, 1, SMALL, paths=2)
    assert asked == [
        (run, frame, name)
        for run in range(SMALL.runs)
        for frame in range(FRAMES)
        for name in "ab"
    ]
    assert [color[0, 0] for color in found.runs["b"].colors] == [0.0, 1.0, 2.0, 3.0]
    assert [batch.count for batch in found.batches] == [2 * FRAMES] * SMALL.runs
    assert found.truth.count == 2 * FRAMES * SMALL.runs
    assert found.path_seconds > 0


def test_the_time_of_a_frame_is_that_of_the_last_ones(monkeypatch):
    """By a clock on which early frames take 100 s and the last ones 2 s."""
    now = [0.0]

    def steps(job):
        for frame in range(job.counts["frames"]):
            now[0] += 100.0 if frame < FRAMES - CONVERGED else 2.0
            yield Progress(frame + 1, FRAMES, "frames")
        return {"color": np.zeros((256, 3))}

    clock = SimpleNamespace(perf_counter=lambda: now[0])
    monkeypatch.setattr(timing, "time", clock)
    contenders = [Contender("a", replace(UNBIASED, render=steps), 1)]
    found = compete(sized_world("cornell-box", 16), contenders, 1, SMALL)
    assert found.runs["a"].seconds == 2.0
    assert found.path_seconds == 0.0


def test_batches_are_independent_of_each_other_and_of_the_runs():
    """Other seeds, other samples: no two batches agree."""
    found = compete(sized_world("cornell-box", 16), [], 1, replace(SMALL, runs=3))
    means = [batch.mean.sum() for batch in found.batches]
    assert len(set(means)) == 3


def test_the_spread_of_runs_is_their_variance():
    """In the mean over the runs, whatever they are; and a run that is off shows."""
    runs = np.random.default_rng(3).gamma(0.3, size=(7, 20, 3))
    expected = runs.var(axis=0, ddof=1).mean()
    assert spreads(list(runs)).mean() == pytest.approx(expected, rel=1e-12)
    runs[4] += 10.0
    assert spreads(list(runs)).argmax() == 4

"""Renderers of which nothing is known but their pictures."""

import numpy as np
import pytest

from restir_gi.reference.images.exr import write_exr
from restir_gi.reference.images.image import Image
from restir_gi.reference.oracle.backends.running import Limits
from restir_gi.reference.oracle.blackbox.judge import renderer_levels
from restir_gi.reference.oracle.blackbox.renderer import Renderer
from restir_gi.reference.oracle.blackbox.truth import Truth, path_traced, statistics
from restir_gi.reference.oracle.cases import Failure
from restir_gi.reference.scene.catalogue.registry import find_scene
from restir_gi.reference.system.errors import UsageError

SIZE = 8


class Pictures(Renderer):
    """In place of a program: pictures of a known distribution."""

    def __init__(self, mean, same=False, changes=False):
        super().__init__("", "", 1, (SIZE, SIZE), Limits())
        object.__setattr__(self, "kind", (mean, same, changes))
        object.__setattr__(self, "calls", [])

    __slots__ = ("calls", "kind")

    def render(self, seed):
        """Exponential light about a mean."""
        mean, same, changes = self.kind
        self.calls.append(seed)
        salt = len(self.calls) if changes else 0
        rng = np.random.default_rng([7 if same else seed, salt])
        return mean * rng.exponential(size=(SIZE, SIZE, 3)).clip(max=6)


MEAN = 1 - np.exp(-6)
"""Of an exponential variable cut at 6."""

KNOWN = Truth(np.full(17, MEAN), np.full(17, 1e-4), 4096)


def run_ladder(renderer, bound=7.0, runs=300):
    """Steps of the ladder, until so many pictures have been made."""
    levels = renderer_levels(
        renderer, lambda: KNOWN, bound, lambda: runs - len(renderer.calls)
    )
    return [take() for _, _, take in levels]


def faults(steps):
    return [text for step in steps for text in step.faults]


def test_a_right_renderer_is_not_accused():
    """With probability 5e-7 at most."""
    steps = run_ladder(Pictures(1.0))
    assert faults(steps) == []
    assert "right to about" in steps[-1].more


@pytest.mark.parametrize("mean", [1.3, 0.5])
def test_control_a_wrong_mean_is_found(mean):
    """Darkness takes about 2 · 7 / 0.5 · ln(2 / α) = 430 pictures."""
    assert "relative to the truth" in faults(run_ladder(Pictures(mean), runs=800))[0]


def test_without_a_bound_only_too_much_light_is_a_fault():
    assert faults(run_ladder(Pictures(1.3), bound=None))
    dark = run_ladder(Pictures(0.5), bound=None)
    assert faults(dark) == []
    assert "--bound" in dark[-1].more


def test_seeds_that_do_nothing_are_a_fault():
    assert "runs repeat" in faults(run_ladder(Pictures(1.0, same=True), runs=5))[0]


def test_pictures_that_cannot_be_repeated_are_a_fault():
    assert (
        "of one seed differ"
        in faults(run_ladder(Pictures(1.0, changes=True), runs=5))[0]
    )


def test_tiles_are_where_they_are_said_to_be():
    color = np.zeros((SIZE, 2 * SIZE, 3))
    color[2:4, 8:12] = 1  # the second row of tiles, the third column
    found = statistics(color)
    assert found[0] == pytest.approx(8 / (2 * SIZE**2))
    assert np.flatnonzero(found[1:]).tolist() == [1 * 4 + 2]


def test_the_truth_has_the_error_that_it_says():
    """Two halves of the samples agree within 6 of their errors, in 17 statistics."""
    scene = find_scene("cornell-box")
    few, many = (path_traced(scene, (SIZE, SIZE), 1, n) for n in (64, 256))
    error = np.hypot(few.standard_error, many.standard_error)
    assert (np.abs(few.mean - many.mean) < 6 * error).all()
    assert (many.standard_error < few.standard_error).all()


# ---------------------------------------------------------------- programs


def program(tmp_path, body, limits=None, size=(SIZE, SIZE)):
    path = tmp_path / "render.sh"
    path.write_text(f"#!/bin/sh\n{body}\n", encoding="utf-8")
    path.chmod(0o755)
    template = f"{path} {{scene}} {{seed}} {{frames}} {{size}} {{out}}"
    return Renderer(template, "my scene", 3, size, limits or Limits())


def test_the_template_is_filled_in(tmp_path):
    picture = tmp_path / "ready.exr"
    color = np.full((SIZE, SIZE, 3), 0.5, np.float32)
    write_exr(picture, Image({"color": color}, {}))
    body = f'echo "$1|$2|$3|$4" > {tmp_path}/said; cp {picture} "$5"'
    found = program(tmp_path, body).render(11)
    assert (found == color).all()
    assert (tmp_path / "said").read_text() == "my scene|11|3|8\n"


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ("exit 0", "cannot read"),
        ("echo no license >&2; exit 9", "exit code 9: no license"),
        ('echo text > "$5"', "is not an OpenEXR file"),
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
        (np.zeros((4, 4, 3), np.float32), "4x4 instead of 8x8"),
    ],
)
def test_pictures_that_cannot_be_judged_are_told(tmp_path, color, words):
    picture = tmp_path / "ready.exr"
    write_exr(picture, Image({"color": color}, {}))
    found = program(tmp_path, f'cp {picture} "$5"').render(1)
    assert isinstance(found, Failure)
    assert words in found.reason


def test_the_sides_of_an_oblong_picture_are_filled_in_apart(tmp_path):
    template = "sh -c 'exit {width}{height}' {out}"
    found = Renderer(template, "x", 1, (4, 2), Limits()).render(1)
    assert "exit code 42" in found.reason
    with pytest.raises(UsageError, match=r"4x2; write \{width\} and \{height\}"):
        program(tmp_path, "exit 0", size=(4, 2)).render(1)


def test_a_program_that_does_not_exist_is_bad_usage():
    renderer = Renderer("/no/such {out}", "x", 1, (SIZE, SIZE), Limits())
    with pytest.raises(UsageError, match="cannot run /no/such"):
        renderer.render(1)

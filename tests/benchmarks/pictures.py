"""Table of verdicts on pictures: right renderers, and some that are wrong.

    python -m tests.benchmarks.pictures [WORD ...]

Pictures of 64 x 64 pixels and 64 paths a pixel, as they are or changed as a wrong
renderer changes them, and eighth frames of ReSTIR GI.  Words choose rows.
"""

import sys
import time
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import replace
from functools import cache, partial
from io import StringIO
from itertools import count, islice
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from restir_gi.reference.cli.main import main
from restir_gi.reference.images.display import encode_srgb
from restir_gi.reference.images.exr import read_exr
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.oracle.blackbox.convention import Convention
from restir_gi.reference.oracle.blackbox.evidence import Tolerance
from restir_gi.reference.oracle.blackbox.judge import judge_pictures, with_error
from restir_gi.reference.scene.catalogue.registry import find_animation, find_scene
from restir_gi.reference.transport.accumulate import path_samples
from restir_gi.reference.truth.pictures import PictureTruths
from tests.statistics.replicates import small_world

SIZE, PATHS, FRAMES = 64, 64, 8
MOST, MOST_REUSED = 150, 1000
SCENES = ("cornell-box", "glossy-floor", "checker")
ASKED = Convention()


def path_traced(scene, pixel="center"):
    """Pictures without end."""
    world = small_world(find_scene(scene), SIZE, SIZE)
    whole = Schedule(band=SIZE**2 + 1)
    about = {"light": "indirect", "bounces": 1, "seed": 5, "pixel": pixel}
    samples = path_samples(world, whole, **about)
    every, number = slice(0, SIZE**2), 0
    while True:
        paths = range(number, number + PATHS)
        mean = sum(samples.radiance(every, k) for k in paths) / PATHS
        yield mean.reshape(SIZE, SIZE, 3).astype(np.float32)
        number += PATHS


@cache
def kept(scene, pixel="center"):
    """The first of them, made once."""
    return list(islice(path_traced(scene, pixel), MOST))


def changed(scene, change):
    """Of a scene, changed as a wrong renderer changes them."""
    return map(change, kept(scene))


def reused(scene, *options):
    """Eighth frames of ReSTIR GI, by the command line; without end."""
    with TemporaryDirectory() as folder:
        for seed in count(100):
            out = Path(folder) / f"{seed}.exr"
            about = ["--seed", str(seed), "--frames", str(FRAMES), "--out", str(out)]
            words = ["render", scene, *options, "--size", f"{SIZE}x{SIZE}", *about]
            with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
                assert main(words) == 0
            yield read_exr(out).color
            out.unlink()


def one_tile(picture):
    """One tile of sixteen is 5 % too bright."""
    changed = picture.copy()
    changed[SIZE // 2 : 3 * SIZE // 4, SIZE // 4 : SIZE // 2] *= np.float32(1.05)
    return changed


CHANGES = {
    "right": lambda p: p,
    "1 % too bright": lambda p: p * np.float32(1.01),
    "1 % too dark": lambda p: p * np.float32(0.99),
    "one tile 5 % too bright": one_tile,
    "black": lambda p: p * np.float32(0),
    "sRGB": lambda p: encode_srgb(p).astype(np.float32),
    "upside down": lambda p: p[::-1],
    "red and blue exchanged": lambda p: p[..., ::-1],
    "times pi": lambda p: p * np.float32(np.pi),
}

FILTERED = ("glossy-floor", "checker", "grazing-light")
"""Scenes in which the pixel filter changes a tile by more than 5 %."""

UNBIASED, BIASED = ("--method", "restir-gi-unbiased"), ("--method", "restir-gi-biased")
REUSED = {
    "ReSTIR GI, unbiased": ("cornell-box", *UNBIASED),
    "ReSTIR GI, 1/M": ("cornell-box", *UNBIASED, "--set", "mis=1/M"),
    "ReSTIR GI, no Jacobian": ("cornell-box", *UNBIASED, "--set", "jacobian=left-out"),
    "ReSTIR GI, unbiased, moving": ("moving-camera", *UNBIASED),
    "ReSTIR GI, biased, as it stands": ("moving-camera", *BIASED),
}


def rows():
    """Name, pictures, scene, and what was asked for, of each row."""
    for scene in SCENES:
        for name, change in CHANGES.items():
            made = partial(changed, scene, change)
            yield f"{scene}: {name}", made, find_scene(scene), ASKED
        deeper = replace(ASKED, bounces=2)
        missing = partial(changed, scene, CHANGES["right"])
        yield f"{scene}: a bounce is missing", missing, find_scene(scene), deeper
    for scene in FILTERED:
        jittered = partial(path_traced, scene, "box")
        yield f"{scene}: another pixel filter", jittered, find_scene(scene), ASKED
    for name, (scene, *options) in REUSED.items():
        last = find_animation(scene)(FRAMES - 1)
        yield name, partial(reused, scene, *options), last, ASKED


def main_table(words):
    """Write the table."""
    say("| pictures | verdict | by | pictures | mean − truth | named | s |")
    say("|---|---|---|---|---|---|---|")
    for name, made, scene, asked in rows():
        if words and not any(word in name for word in words):
            continue
        truths = PictureTruths(scene, (SIZE, SIZE), asked, Tolerance(), lambda: 1e4)
        truths(asked)  # its time is another matter
        most = MOST_REUSED if name.startswith("ReSTIR") else MOST
        start = time.monotonic()
        verdict = judge_pictures(islice(made(), most), truths, asked, Tolerance())
        seconds = time.monotonic() - start
        last = verdict.looks[-1].differences
        relative, error = last.relative[0], last.error[0] / last.truth[0]
        named = "; ".join(one.text for one in verdict.likenesses[:2])
        off = with_error(relative, error, 100)
        say(
            f"| {name} | {verdict.status} | {verdict.evidence} | {last.count} |"
            f" {off} % | {named} | {seconds:.1f} |"
        )


def say(line):
    """Write a line, at once."""
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main_table(sys.argv[1:])

"""What each option of ReSTIR GI costs and gains: bias, error and time beside the plain.

    python -m tests.benchmarks.bench_options [SCENE] [RUNS] [SIZE] [OPTION ...]

Prints a line an option: bias of the image mean with its standard error, mean squared
error over that of the unbiased form without options, and time of a frame over its.
SCENE is built in, still or animated; two bounces, the twelfth frame.  Runs of all
options take turns, so that the ratios of times mean something on a busy machine.
"""

import sys
from dataclasses import replace
from functools import partial
from itertools import islice

import numpy as np

from restir_gi.reference.numerics.moments import add_samples, no_samples
from restir_gi.reference.numerics.rng import Stream
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.reports.timing import in_turns
from restir_gi.reference.restir_gi import render_frames
from restir_gi.reference.scene.animation import Animation
from restir_gi.reference.scene.catalogue.registry import find_animation
from restir_gi.reference.settings import BIASED, UNBIASED, Settings
from restir_gi.reference.transport.accumulate import path_samples
from restir_gi.reference.transport.world import World, build_world

FRAMES, BOUNCES, SAMPLES = 12, 2, 3000

OPTIONS: dict[str, Settings] = {
    "unbiased": UNBIASED,
    "biased": BIASED,
    "mis=balance": replace(UNBIASED, mis="balance"),
    "mis=pairwise": replace(UNBIASED, mis="pairwise"),
    "mis=defensive": replace(UNBIASED, mis="defensive"),
    "target=outgoing": replace(UNBIASED, target="outgoing"),
    "visibility=chosen": replace(UNBIASED, visibility="chosen"),
    "visibility=none": replace(UNBIASED, visibility="none"),
    "visibility=none final_visibility=traced": replace(
        UNBIASED, visibility="none", final_visibility="traced"
    ),
    "visibility=none final_visibility=reused": replace(
        UNBIASED, visibility="none", final_visibility="reused"
    ),
    "glossy_samples=as-lambertian": replace(UNBIASED, glossy_samples="as-lambertian"),
    "motion=as-stored": replace(UNBIASED, motion="as-stored"),
    "motion=as-stored validate_every=6": replace(
        UNBIASED, motion="as-stored", validate_every=6
    ),
    "boost_below=30": replace(UNBIASED, boost_below=30.0),
    "roulette=0.25": replace(UNBIASED, roulette=0.25),
    "storage=paper": replace(UNBIASED, storage="paper"),
    "reuse=double-buffered": replace(UNBIASED, reuse="double-buffered"),
    "reuse=fused": replace(UNBIASED, reuse="fused"),
    "jacobian=left-out": replace(UNBIASED, jacobian="left-out"),
    "jacobian=divided": replace(UNBIASED, jacobian="divided"),
    "jacobian_limit=3": replace(UNBIASED, jacobian_limit=3.0),
    "jacobian_limit=3 beyond_limit=reject": replace(
        UNBIASED, jacobian_limit=3.0, beyond_limit="reject"
    ),
    "jacobian_limit=3 beyond_limit=clamp": replace(
        UNBIASED, jacobian_limit=3.0, beyond_limit="clamp"
    ),
    "max_age=8": replace(UNBIASED, max_age=8.0),
    "boiling_filter=0.2": replace(UNBIASED, boiling_filter=0.2),
    "boiling_filter=0.6": replace(UNBIASED, boiling_filter=0.6),
    "permutation=true": replace(UNBIASED, permutation=True),
    "fallback_search=true": replace(UNBIASED, fallback_search=True),
    "checkerboard=true": replace(UNBIASED, checkerboard=True),
    "lattice=2": replace(UNBIASED, lattice=2),
}


def main(name: str, runs: int, size: int, chosen: list[str]) -> None:
    animation = sized(find_animation(name), size)
    first, last = build_world(animation(0)), build_world(animation(FRAMES - 1))
    truth, error, noise = truth_of(last)
    names = ["unbiased", *(n for n in chosen or OPTIONS if n != "unbiased")]
    means: dict[str, list[float]] = {n: [] for n in names}
    squares: dict[str, list[float]] = {n: [] for n in names}
    ratios: dict[str, list[float]] = {n: [] for n in names}
    for seed in range(runs):
        calls = {
            option: partial(twelfth, first, animation, OPTIONS[option], seed)
            for option in names
        }
        (turn,) = in_turns(calls, 1)
        for option, (color, seconds) in turn.items():
            means[option].append(float(color.mean()))
            squares[option].append(float(((color - truth) ** 2).mean()) - noise)
            ratios[option].append(seconds / turn["unbiased"].seconds)
    plain = np.mean(squares["unbiased"])
    print(f"{name}, {size} x {size}, {BOUNCES} bounces, frame {FRAMES}, {runs} runs")
    for option in names:
        mean = truth.mean()
        bias = np.mean(means[option]) / mean - 1
        scatter = np.std(means[option], ddof=1) / np.sqrt(runs)
        print(
            f"{option:42} bias {bias:+8.2%} +- {np.hypot(scatter, error) / mean:.2%}"
            f"  error x {np.mean(squares[option]) / plain:5.2f}"
            f"  time x {np.median(ratios[option]):.2f}",
            flush=True,
        )


def twelfth(
    world: World, animation: Animation, settings: Settings, seed: int
) -> np.ndarray:
    """The last of the frames that a run is timed by."""
    frames = render_frames(world, settings, BOUNCES, seed, Schedule(), animation)
    return next(islice(frames, FRAMES - 1, None)).color


def sized(animation: Animation, size: int) -> Animation:
    """The animation with pictures of a size."""
    seen = {}

    def at(frame: int):
        scene = animation(frame)
        # What stays the same object is not made again.
        if id(scene) not in seen:
            camera = replace(scene.camera, width=size, height=size)
            seen[id(scene)] = scene, replace(scene, camera=camera)
        return seen[id(scene)][1]

    return Animation(at, animation.changes)


def truth_of(world: World) -> tuple[np.ndarray, float, float]:
    """Path-traced truth, the standard error of its mean, and its own mean square."""
    samples = path_samples(
        world, Schedule(), light="indirect", bounces=BOUNCES, seed=1 << 20,
        stream=Stream.PATH,
    )  # fmt: skip
    none = no_samples(samples.rows)
    truth = add_samples(none, samples.radiance, SAMPLES, Schedule())
    # Pixels are independent of each other; channels of a pixel may err alike.
    off = truth.standard_error()
    error = float(np.sqrt((off.sum(axis=1) ** 2).sum()) / off.size)
    return truth.mean, error, float((off**2).mean())


if __name__ == "__main__":
    words = sys.argv[1:]
    scene = words[0] if words else "cornell-box"
    runs, size = (int(w) for w in [*words[1:3], *("24", "48")[len(words[1:3]) :]])
    main(scene, runs, size, words[3:])

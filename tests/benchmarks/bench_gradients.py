"""Differences and images of a scene file by each gradient-domain method.

As ``restir figures gradients gradient-images``, of any file: the article's scene is
Veach Ajar.

    python -m tests.benchmarks.bench_gradients scene.xml --size 128 --runs 6 --out DIR
"""

import argparse
from dataclasses import replace
from pathlib import Path

from rich.console import Console

from restir_gi.figures.gradient_domain import gradients, images
from restir_gi.figures.gradient_domain.rounds import RoundScene
from restir_gi.figures.gradient_domain.variants import BOUNCES
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.reports.figures.record import Work
from restir_gi.reference.reports.figures.table import table
from restir_gi.reference.scene.loaders.load import load_scene
from restir_gi.reference.scene.validation import validate
from restir_gi.reference.transport.world import build_world


def main() -> None:
    """Measure, print, and write the pictures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene", type=Path)
    parser.add_argument("--size", type=int, default=128)
    parser.add_argument("--runs", type=int, default=6)
    parser.add_argument("--out", type=Path, default=Path())
    asked = parser.parse_args()
    scene = load_scene(asked.scene)
    camera = replace(scene.camera, width=asked.size, height=asked.size)
    world = build_world(validate(replace(scene, camera=camera)))
    shown = [RoundScene(asked.scene.parent.name, world, BOUNCES)]
    work = Work(size=asked.size, runs=asked.runs, schedule=Schedule())
    for made in (gradients.of_scenes(shown, work), images.of_scenes(shown, work)):
        Console(width=150).print(table(made))
        asked.out.mkdir(parents=True, exist_ok=True)
        (asked.out / f"{made.name}.png").write_bytes(made.png())


if __name__ == "__main__":
    main()

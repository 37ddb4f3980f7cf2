"""The folder of a demonstration: pictures, comparisons, the strip, the page."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from restir_gi.reference.images.display import auto_exposure, encode_png, to_display
from restir_gi.reference.images.exr import write_exr
from restir_gi.reference.images.image import Image, to_image
from restir_gi.reference.methods.metadata import header, metadata
from restir_gi.reference.reports.comparison import compare
from restir_gi.reference.reports.demo.page import write_page
from restir_gi.reference.reports.demo.runs import Runs
from restir_gi.reference.reports.demo.score import RunScore
from restir_gi.reference.reports.demo.strip import strip
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.system.files import write_file
from restir_gi.reference.system.json_text import json_text

TITLES = {
    "path": "path traced, equal time",
    "restir-gi-biased": "ReSTIR GI, biased",
    "restir-gi-unbiased": "ReSTIR GI, unbiased",
}


def write_gallery(
    out: Path,
    scene: Scene,
    truth: Image,
    contenders: Sequence[tuple[Runs, RunScore]],
    remarks: Sequence[str],
) -> None:
    """Write everything that there is to look at; ``index.html`` comes last.

    Parameters
    ----------
    out : Path; folder that exists
    truth : Image; with its standard error; the caller has written ``truth.exr``
    contenders : sequence of (Runs, RunScore); from left to right
    remarks : sequence of str; how the numbers came about, for the page

    Raises
    ------
    UsageError
        A file cannot be written.
    """
    exposure = auto_exposure(truth.color)
    shown, captions = [], []
    for runs, score in contenders:
        name = runs.method.name
        words = metadata(scene, runs.method, runs.job, runs.rays, score.seconds)
        color = to_image(runs.colors[0], truth.width, truth.height)
        image = Image({"color": color}, header(words))
        write_exr(out / f"{name}.exr", image)
        compare(image, truth, out / name, names=(TITLES[name], "truth"))
        shown.append(to_display(color, exposure))
        captions.append((TITLES[name], _caption(runs, score)))
        write_file(out / f"{name}.png", encode_png(shown[-1]))
    shown.append(to_display(truth.color, exposure))
    captions.append(("truth", f"{truth.metadata['spp']} samples a pixel"))
    write_file(out / "truth.png", encode_png(shown[-1]))
    write_file(out / "teaser.png", strip(shown, captions))
    numbers = {"scene": scene.name, "methods": [asdict(s) for _, s in contenders]}
    write_file(out / "numbers.json", json_text(numbers).encode())
    write_page(out / "index.html", scene.name, remarks, [s for _, s in contenders])


def _caption(runs: Runs, score: RunScore) -> str:
    counts = runs.job.counts
    amount = (
        f"frame {counts['frames']}" if "frames" in counts else f"{counts['spp']} spp"
    )
    return f"{amount}, {1000 * score.seconds:.0f} ms, MSE {score.mse:.2g}"

"""The truth of a scene: accumulated, kept safe, and written as a picture."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

from restir_gi.reference.images.image import Image, to_image
from restir_gi.reference.methods import Job
from restir_gi.reference.methods.setting_values import as_text
from restir_gi.reference.numerics.moments import Moments, add_samples
from restir_gi.reference.scene.fingerprint import fingerprint
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.system.version import project_version
from restir_gi.reference.transport.accumulate import path_samples
from restir_gi.reference.truth.checkpoint import Checkpoint
from restir_gi.reference.truth.resumable import SampleSource, accumulate_resumably


def checkpoint_beside(out: Path) -> Path:
    """Where the checkpoint of a picture lies."""
    return out.with_name(out.name + ".checkpoint")


def accumulate_truth(
    scene: Scene,
    job: Job,
    checkpoint: Path,
    every: float,
    tick: Callable[[int, int, str], None],
    source_of: Callable[[Job], SampleSource] | None = None,
) -> Checkpoint:
    """Accumulate the truth of a scene, from a checkpoint if there is one.

    Parameters
    ----------
    scene : Scene; of which ``job.world`` was built
    job : Job; with the settings of the method ``path``
    checkpoint : Path; left in place; see `accumulate_resumably`
    every : float, s; time between checkpoints
    tick : callable; told the samples so far, their number in the end, and "samples"
    source_of : callable, optional
        Draws the samples of a job, say in other processes; by default this one does.

    Returns
    -------
    Checkpoint; with ``job.counts["spp"]`` samples
    """
    spp = job.counts["spp"]
    return accumulate_resumably(
        (source_of or _in_this_process)(job),
        spp,
        checkpoint,
        identity(scene, job),
        every,
        lambda count: tick(count, spp, "samples"),
    )


def _in_this_process(job: Job) -> SampleSource:
    samples = path_samples(
        job.world,
        job.schedule,
        light=job.light,
        bounces=job.bounces,
        seed=job.seed,
        pixel=job.settings.pixel,
    )

    def advance(before: Moments, until: int) -> Moments:
        return add_samples(before, samples.radiance, until, job.schedule)

    return SampleSource(samples.rows, advance, lambda: job.world.caster.counts)


def identity(scene: Scene, job: Job) -> dict[str, str]:
    """Everything that decides what a sample of a given number is.

    Not the number of samples, nor bands and threads.

    Parameters
    ----------
    scene : Scene; of which ``job.world`` was built
    job : Job; with the settings of the method ``path``
    """
    camera = scene.camera
    # The size is told by itself, so that a message can say what it is.
    scene = replace(scene, camera=replace(camera, width=1, height=1), notes=())
    return {
        "version": project_version(),
        "scene": f"{scene.name} {fingerprint(scene)[:16]}",
        "size": f"{camera.width}x{camera.height}",
        "light": job.light,
        "bounces": str(job.bounces),
        "seed": str(job.seed),
        **as_text(job.settings),
    }


def truth_image(state: Checkpoint, job: Job, words: Mapping[str, str]) -> Image:
    """Mean and standard error as a picture.

    Parameters
    ----------
    state : Checkpoint; at least two samples
    """
    size = job.world.camera.width, job.world.camera.height
    layers = {
        "color": to_image(state.moments.mean, *size),
        "standard_error": to_image(state.moments.standard_error(), *size),
    }
    return Image(layers, words)

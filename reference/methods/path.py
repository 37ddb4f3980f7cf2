"""Method ``path``: plain path tracing, a mean of independent samples."""

from collections.abc import Generator, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import count

from restir_gi.reference.methods.aovs import GBUFFER, gbuffer_layers
from restir_gi.reference.methods.method import Job, Method, Progress, Rendering, Shown
from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.numerics.moments import Moments, no_samples
from restir_gi.reference.numerics.rng import Stream
from restir_gi.reference.numerics.schedule import in_bands
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.transport.accumulate import (
    PathSamples,
    Pixel,
    accumulate,
    path_samples,
)
from restir_gi.reference.transport.path_tracer import Light
from restir_gi.reference.transport.world import World, next_world


@dataclass(frozen=True, slots=True, kw_only=True)
class PathTracerSettings:
    """Settings of path tracing.

    Attributes
    ----------
    pixel : 'center' or 'box'
        Camera rays through the centres of the pixels, as a G-buffer has them, or
        anywhere in the pixels.
    """

    pixel: Pixel = "center"


def render(job: Job) -> Rendering:
    """Mean of ``spp`` path-traced samples.

    The colour, and the layers asked for.  Direct and indirect light follow the very
    paths of the picture, so that they add up to ``full``.

    Raises UsageError: a standard error of one sample is asked for.
    """
    if "standard_error" in job.aovs and job.counts["spp"] < 2:
        raise UsageError("--aov standard_error needs an --spp of at least 2")
    parts: list[Light] = [job.light]
    parts += [p for p in ("direct", "indirect") if p in job.aovs and p != job.light]
    found = {}
    for index, light in enumerate(parts):
        found[light] = yield from mean_of_paths(
            job,
            light,
            job.settings.pixel,
            Stream.PATH,
            index * job.counts["spp"],
            len(parts) * job.counts["spp"],
        )
    layers: dict[str, Scalars] = {"color": found[job.light].mean}
    layers |= {part: found[part].mean for part in found if part in job.aovs}
    if "standard_error" in job.aovs:
        layers["standard_error"] = found[job.light].standard_error()
    return layers | gbuffer_layers(job.world, job.schedule, job.aovs)


def mean_of_paths(
    job: Job, light: Light, pixel: Pixel, stream: Stream, before: int, total: int
) -> Generator[Progress, None, Moments]:
    """Moments of ``spp`` path-traced samples, as one part of a rendering.

    Parameters
    ----------
    light : 'indirect', 'direct' or 'full'; in place of the job's own
    before, total : int; steps of the rendering before this part, and in all
    """
    samples = path_samples(
        job.world,
        job.schedule,
        light=light,
        bounces=job.bounces,
        seed=job.seed,
        pixel=pixel,
        stream=stream,
    )
    moments = none = no_samples(samples.rows)
    for moments in accumulate(samples, none, job.counts["spp"], job.schedule):
        yield Progress(before + moments.count, total, "samples")
    return moments


def frames(job: Job) -> Iterator[Shown]:
    """One path-traced sample of indirect light a frame, without end; nothing is kept.

    Parameters
    ----------
    job : Job; what to render; a moving scene as it is in each frame
    """
    samples = _indirect(job, job.world)
    for number in count():
        if job.animation:
            world = next_world(samples.world, job.animation(number))
            samples = samples if world is samples.world else _indirect(job, world)

        draw = partial(samples.radiance, number=number)
        yield Shown(in_bands(job.schedule, samples.rows, draw), 0.0)


def _indirect(job: Job, world: World) -> PathSamples:
    return path_samples(
        world,
        job.schedule,
        light="indirect",
        bounces=job.bounces,
        seed=job.seed,
        pixel=job.settings.pixel,
    )


PATH = Method(
    name="path",
    summary="Path tracing with next-event estimation, independent samples",
    counts={"spp": 32},
    settings=PathTracerSettings(),
    aovs={
        "direct": "light that was never reflected before the visible point",
        "indirect": "the rest",
        "standard_error": "standard error of the colour",
        **GBUFFER,
    },
    render=render,
    frames=frames,
)

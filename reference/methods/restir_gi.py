"""Methods ``restir-gi-unbiased`` and ``restir-gi-biased``: ReSTIR GI, two settings."""

from collections.abc import Generator
from dataclasses import asdict, dataclass, replace
from itertools import islice
from math import isfinite
from typing import Literal

import numpy as np

from reference import settings
from reference.arrays import Scalars, Vec3s
from reference.biases import biases
from reference.errors import UsageError
from reference.methods.aovs import (
    GBUFFER,
    RESERVOIRS,
    gbuffer_layers,
    reservoir_layers,
)
from reference.methods.method import Job, Method, Progress, Rendering
from reference.methods.path import mean_of_paths
from reference.restir_gi import Frame, render_frames
from reference.rng import Stream
from reference.settings import Settings
from reference.world import World, next_world

LEAST_AND_MOST = {
    "temporal_cap": (1, float("inf")),
    "spatial_cap": (1, float("inf")),
    "iterations_few": (0, 63),  # of 64 dimensions the last is the pixel's own
    "iterations_many": (0, 63),
    "radius": (0, 1),
    "min_radius": (0, 2**14),
    "max_angle": (0, 180),
    "max_depth": (0, float("inf")),
    "validate_every": (0, 2**27 - 1),
    "validation_tolerance": (0, 1),
    "boost_below": (0, float("inf")),
    "roulette": (2**-10, 1),
    "jacobian_limit": (1, float("inf")),
    "max_age": (1, float("inf")),
    "boiling_filter": (0, 1),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class RestirSettings(Settings):
    """Settings of the algorithm, and of the picture.

    Attributes
    ----------
    image : 'last' or 'mean'
        The last frame, as a renderer shows it, or the mean of all frames; of their
        indirect light, since everything else is that of the last frame.
    """

    image: Literal["last", "mean"] = "last"

    def __post_init__(self) -> None:
        for name, (least, most) in LEAST_AND_MOST.items():
            if not least <= getattr(self, name) <= most:
                end = f"to {most}" if isfinite(most) else "or more"
                raise ValueError(
                    f"{name}={getattr(self, name)} is out of range: {least} {end}"
                )


@dataclass(frozen=True, slots=True, eq=False)
class _Indirect:
    last: Frame
    mean: Vec3s


def render(job: Job) -> Rendering:
    """Indirect light by ReSTIR GI, direct light by path tracing.

    Parameters
    ----------
    job : Job
        What to render.

    Yields
    ------
    Progress
        In frames, then in samples of the direct light.

    Returns
    -------
    Layers
        The colour, and the layers asked for, all of the last frame.
    """
    has_direct = job.light != "indirect" or "direct" in job.aovs
    has_indirect = job.light != "direct" or "indirect" in job.aovs
    frames = job.counts["frames"] if has_indirect and job.bounces else 0
    missing = [name for name in job.aovs if name in (*RESERVOIRS, "mean")]
    if missing and not frames:
        raise UsageError(
            f"--aov {missing[0]} needs indirect light: --light indirect or full,"
            " and --bounces of at least 1"
        )
    total = frames + (job.counts["spp"] if has_direct else 0)

    layers: dict[str, Scalars] = {}
    indirect = direct = _black(job)
    if frames:
        found = yield from _frames(job, frames, total)
        indirect = found.mean if job.settings.image == "mean" else found.last.color
        layers |= {"mean": found.mean} if "mean" in job.aovs else {}
        layers |= reservoir_layers(found.last.spatial, job.aovs)
    shown = found.last.world if frames else _last_world(job)
    if has_direct:
        moments = yield from mean_of_paths(
            replace(job, world=shown), "direct", "center", Stream.DIRECT, frames, total
        )
        direct = moments.mean
    parts = {"indirect": indirect, "direct": direct, "full": indirect + direct}
    layers |= {name: parts[name] for name in ("indirect", "direct") if name in job.aovs}
    layers |= gbuffer_layers(shown, job.schedule, job.aovs)
    return {"color": parts[job.light], **layers}


def named_biases(job: Job) -> tuple[str, ...]:
    """What biases the indirect light of a picture.

    Parameters
    ----------
    job : Job
        What is rendered.

    Returns
    -------
    tuple of str
        See :func:`reference.biases.biases`.
    """
    if job.light == "direct" or job.bounces == 0:
        return ()
    changes = job.animation.changes if job.animation else "nothing"
    return biases(job.settings, job.world.scene, changes)


def _frames(job: Job, frames: int, total: int) -> Generator[Progress, None, _Indirect]:
    run = render_frames(
        job.world, job.settings, job.bounces, job.seed, job.schedule, job.animation
    )
    mean = _black(job)
    for frame in islice(run, frames):
        mean = mean + (frame.color - mean) / (frame.number + 1.0)
        yield Progress(frame.number + 1, total, "frames")
    return _Indirect(frame, mean)


def _last_world(job: Job) -> World:
    if job.animation is None:
        return job.world
    return next_world(job.world, job.animation(job.counts["frames"] - 1))


def _black(job: Job) -> Vec3s:
    return np.zeros((job.world.camera.width * job.world.camera.height, 3))


def _method(name: str, summary: str, defaults: Settings) -> Method:
    return Method(
        name=name,
        summary=summary,
        counts={"frames": 32, "spp": 32},
        settings=RestirSettings(**asdict(defaults)),
        aovs={
            "direct": "path-traced direct light, a mean of --spp samples",
            "indirect": "light by ReSTIR GI",
            "mean": "mean of the indirect light of all frames",
            **RESERVOIRS,
            **GBUFFER,
        },
        render=render,
        biases=named_biases,
    )


BIASED = _method(
    "restir-gi-biased",
    "ReSTIR GI with weights 1/M: fast, and wrong where neighbours differ",
    settings.BIASED,
)
UNBIASED = _method(
    "restir-gi-unbiased",
    "ReSTIR GI with weights 1/Z and visibility: its mean over runs is the truth",
    settings.UNBIASED,
)

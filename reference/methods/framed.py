"""Pictures of methods that go on from frame to frame: their light, and all the rest."""

from collections.abc import Callable, Generator, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any, Literal, Protocol

import numpy as np

from restir_gi.reference.methods.aovs import GBUFFER, gbuffer_layers
from restir_gi.reference.methods.method import (
    Job,
    Method,
    Preset,
    Progress,
    Rendering,
    Shown,
)
from restir_gi.reference.methods.path import mean_of_paths
from restir_gi.reference.numerics.arrays import Scalars, Vec3s
from restir_gi.reference.numerics.records import fields_but, nbytes
from restir_gi.reference.numerics.rng import Stream
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.transport.accumulate import Pixel
from restir_gi.reference.transport.world import World, next_world

Image = Literal["last", "mean"]

PARTS = {
    "direct": "path-traced direct light, a mean of --spp samples",
    "indirect": "indirect light by the method",
    "mean": "mean of the indirect light of all frames",
}


class NumberedFrame(Protocol):
    """A frame: ``number`` and ``world``."""

    @property
    def number(self) -> int:
        """From 0."""
        ...

    @property
    def world(self) -> World:
        """The scene as it was."""
        ...


def color_of(frame: Any) -> Vec3s:
    """Indirect light of a frame that has a ``color``.

    Returns (N, 3) float64, W/(m² sr); its colour.
    """
    color: Vec3s = frame.color
    return color


def as_it_is(job: Job, color: Scalars) -> Vec3s:
    """Take a picture that is one already, (N, 3) float64.

    Parameters
    ----------
    job : Job; does not matter
    color : (N, 3) float64; the picture
    """
    return color


def bytes_of_frame(job: Job, frame: Any) -> int:
    """Bytes that a frame holds beside its picture and the scene.

    Parameters
    ----------
    job : Job; does not matter
    frame : record; with ``world`` and ``color``
    """
    return nbytes(fields_but(frame, "world", "color"))


@dataclass(frozen=True, slots=True, eq=False)
class Framed:
    """How a method makes frames.

    Attributes
    ----------
    frames : callable; from a job to frames without end
    layers : callable
        From a frame and names to the layers of these names, beside the picture's.
    own : mapping of str to str; names that ``layers`` knows, and what they are
    pixel : 'center' or 'box'
        What a pixel shows: what its centre sees, or the mean over its area.
    estimates : callable
        From a frame to what is averaged over frames, (N, C); its light by default.
    develop : callable; from a job, and such a mean, to indirect light, (N, 3)
    size : callable; from a job and a frame to the bytes that the next frame is given
    """

    frames: Callable[[Job], Iterator[Any]]
    layers: Callable[[Any, tuple[str, ...]], Mapping[str, Scalars]]
    own: Mapping[str, str]
    pixel: Pixel = "center"
    estimates: Callable[[Any], Scalars] = color_of
    develop: Callable[[Job, Scalars], Vec3s] = as_it_is
    size: Callable[[Job, Any], int] = bytes_of_frame

    def method(
        self,
        name: str,
        summary: str,
        settings: Any,
        biases: Callable[[Job], tuple[str, ...]],
        presets: Mapping[str, Preset] | None = None,
    ) -> Method:
        """Method that makes these frames, of 32 frames, and 32 samples of direct light.

        Parameters
        ----------
        settings : dataclass instance; defaults; they have ``image``
        biases : callable; names what biases the indirect light of a job that shows some
        """

        def named_biases(job: Job) -> tuple[str, ...]:
            return () if job.light == "direct" or job.bounces == 0 else biases(job)

        return Method(
            name=name,
            summary=summary,
            counts={"frames": 32, "spp": 32},
            settings=settings,
            aovs={**PARTS, **self.own, **GBUFFER},
            render=self.render,
            biases=named_biases,
            frames=self.shown,
            pixel=self.pixel,
            presets=presets or {},
        )

    def shown(self, job: Job) -> Iterator[Shown]:
        """Indirect light, frame after frame, without end."""
        for frame in self.frames(job):
            color = self.develop(job, self.estimates(frame))
            yield Shown(color, self.size(job, frame) / len(color))

    def render(self, job: Job) -> Rendering:
        """Indirect light by the method, direct light by path tracing.

        The colour, and the layers asked for, all of the last frame.

        Raises UsageError: a layer of the frames is wanted where there are none.

        Parameters
        ----------
        job : Job
            What to render; its settings have ``image``, the last frame or the mean of
            the indirect light of all.

        Yields
        ------
        Progress; in frames, then in samples of the direct light
        """
        has_direct = job.light != "indirect" or "direct" in job.aovs
        has_indirect = job.light != "direct" or "indirect" in job.aovs
        frames = job.counts["frames"] if has_indirect and job.bounces else 0
        missing = [name for name in job.aovs if name in (*self.own, "mean")]
        if missing and not frames:
            raise UsageError(
                f"--aov {missing[0]} needs indirect light: --light indirect or full,"
                " and --bounces of at least 1"
            )
        total = frames + (job.counts["spp"] if has_direct else 0)
        layers: dict[str, Scalars] = {}
        indirect = direct = _black(job)
        if frames:
            found = yield from self._frames(job, frames, total)
            last = found.last
            of_all = job.settings.image == "mean"
            shown_now = found.mean if of_all else self.estimates(last)
            indirect = self.develop(job, shown_now)
            if "mean" in job.aovs:
                layers["mean"] = self.develop(job, found.mean)
            layers |= self.layers(last, job.aovs)
        shown = found.last.world if frames else _last_world(job)
        if has_direct:
            there = replace(job, world=shown)
            moments = yield from mean_of_paths(
                there, "direct", self.pixel, Stream.DIRECT, frames, total
            )
            direct = moments.mean
        parts = {"indirect": indirect, "direct": direct, "full": indirect + direct}
        wanted = [name for name in ("indirect", "direct") if name in job.aovs]
        layers |= {name: parts[name] for name in wanted}
        layers |= gbuffer_layers(shown, job.schedule, job.aovs)
        return {"color": parts[job.light], **layers}

    def _frames(
        self, job: Job, frames: int, total: int
    ) -> Generator[Progress, None, "_Indirect"]:
        mean: Scalars = np.zeros(())
        for frame in islice(self.frames(job), frames):
            mean = mean + (self.estimates(frame) - mean) / (frame.number + 1.0)
            yield Progress(frame.number + 1, total, "frames")
        return _Indirect(frame, mean)


@dataclass(frozen=True, slots=True, eq=False)
class _Indirect:
    last: NumberedFrame
    mean: Scalars


def _last_world(job: Job) -> World:
    if job.animation is None:
        return job.world
    return next_world(job.world, job.animation(job.counts["frames"] - 1))


def _black(job: Job) -> Vec3s:
    return np.zeros((job.world.camera.width * job.world.camera.height, 3))

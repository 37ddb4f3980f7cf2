"""What a method is, to the command line and to packages that bring one along.

A package registers a method by an entry point of the group ``restir.methods``, here in
its ``pyproject.toml``::

    [project.entry-points."restir.methods"]
    world-reservoirs = "restir_gi.hashgrid.light_method:METHOD"

The name of the entry point is the name of the method.  The object that it points to is
a `Method`, whose ``render`` is a generator function::

    def render(job: Job) -> Rendering:
        for frame in range(job.counts["frames"]):
            color = ...  # (N, 3), row = y * width + x
            yield Progress(frame + 1, job.counts["frames"], "frames")
        return {"color": color}

    METHOD = Method(
        name="world-reservoirs",
        summary="Reservoirs in a hashed world-space grid",
        counts={"frames": 32},
        settings=MySettings(),
        aovs={"cells": "occupied cells of the grid"},
        render=render,
    )
"""

from collections.abc import Callable, Generator, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from restir_gi.reference.numerics.arrays import Scalars, Vec3s
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.scene.animation import Animation
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.suggestions import unknown
from restir_gi.reference.transport.accumulate import Pixel
from restir_gi.reference.transport.path_tracer import Light
from restir_gi.reference.transport.world import World

Layers = Mapping[str, Scalars]
"""Quantities by name, (N,) or (N, 3); ``"color"`` is the picture."""


@dataclass(frozen=True, slots=True)
class Progress:
    """How far a rendering is: ``done`` of ``total`` frames, samples, ..."""

    done: int
    total: int
    unit: str


Rendering = Generator[Progress, None, Layers]
"""Yields after each step, which is where it may be cut off; returns the layers."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Job:
    """What to render.

    Attributes
    ----------
    world : World; the scene, with a camera of the size of the picture
    light : 'indirect', 'direct' or 'full'; which paths count
    bounces : int; bounces of indirect light, 0 to 30
    seed : int; 0 to 2²⁷ − 1; runs of different seeds are independent
    counts : mapping of str to int
        The method's own ``counts``, with what the command line says instead.
    settings : dataclass instance; of the type of the method's own ``settings``
    aovs : tuple of str
        Names out of the method's ``aovs``, to be returned beside ``"color"``.
    schedule : Schedule; bands and threads; must not change a bit of the result
    animation : Animation, optional
        Scenes of all frames, validated, of which frame 0 is that of ``world``; by
        default the scene stands still.  A method of F frames shows frame F - 1.
    frame : int
        What frame 0 is called on the command line and in the header: its number in the
        animated scene.
    """

    world: World
    light: Light
    bounces: int
    seed: int
    counts: Mapping[str, int]
    settings: Any
    aovs: tuple[str, ...]
    schedule: Schedule
    animation: Animation | None = None
    frame: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class Preset:
    """Settings that go together.

    Attributes
    ----------
    summary : str; one line, without a full stop
    values : tuple of str; what differs from the defaults, each ``KEY=VALUE``
    """

    summary: str
    values: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Shown:
    """A frame of indirect light, as a renderer would show it.

    Attributes
    ----------
    color : (N, 3) float64, W/(m² sr); indirect light
    kept : float; bytes a pixel that the next frame is given
    """

    color: Vec3s
    kept: float


def _none(job: Job) -> tuple[str, ...]:
    return ()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Method:
    """A way to make a picture.

    Attributes
    ----------
    name : str; on the command line
    summary : str; one line, without a full stop
    counts : mapping of str to int
        Which of the options ``"frames"`` and ``"spp"`` it heeds, and their defaults.
    settings : dataclass instance
        Defaults of what ``--set`` changes;
        :mod:`restir_gi.reference.methods.setting_values` says which fields it may have.
    presets : mapping of str to Preset; names that ``--preset`` takes
    aovs : mapping of str to str; names that ``--aov`` takes, and what they are
    render : callable; takes a `Job` and generates; `Rendering`
    biases : callable
        Takes a `Job` and names what biases its picture; by default nothing does.
    frames : callable or None
        Takes a `Job` and yields `Shown`, frame after frame without end, by which speed
        is weighed against accuracy; ``None`` where frames are not made one by one.
    pixel : 'center' or 'box'
        What a pixel shows: what its centre sees, or the mean over its area.
    """

    name: str
    summary: str
    counts: Mapping[str, int]
    settings: Any
    aovs: Mapping[str, str]
    render: Callable[[Job], Rendering]
    biases: Callable[[Job], tuple[str, ...]] = _none
    frames: Callable[[Job], Iterator[Shown]] | None = None
    pixel: Pixel = "center"
    presets: Mapping[str, Preset] = field(default_factory=dict)


def preset_values(method: Method, preset: str | None) -> tuple[str, ...]:
    """What a preset of a method sets, each ``KEY=VALUE``; nothing without one.

    Raises UsageError: the method has no such preset; the message lists those it has.
    """
    if preset is None:
        return ()
    if preset not in method.presets:
        known = "" if method.presets else "none"
        raise UsageError(
            f"--preset: {unknown('preset', preset, method.presets, known)}"
            f" (method {method.name!r})"
        )
    return method.presets[preset].values


def drive(method: Method, job: Job, tick: Callable[[Progress], None]) -> Layers:
    """Render to the end.

    Parameters
    ----------
    tick : callable; told after each step
    """
    steps = method.render(job)
    while True:
        try:
            step = next(steps)
        except StopIteration as end:
            layers: Layers = end.value
            return layers
        tick(step)

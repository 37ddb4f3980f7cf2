"""Methods ``gradient-pt``, ``gradient-after-restir`` and ``gradient-restir``."""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from restir_gi.extensions.area_method import PLACES, area_layers
from restir_gi.extensions.method import PATHS
from restir_gi.gradient_domain.after_restir import render_after_frames
from restir_gi.gradient_domain.gradient_pt import render_gradient_paths
from restir_gi.gradient_domain.gradient_restir import (
    GradientFrame,
    render_gradient_frames,
)
from restir_gi.gradient_domain.least_absolute import least_absolute
from restir_gi.gradient_domain.reconstruction import Differences, least_squares
from restir_gi.gradient_domain.settings import (
    AfterSettings,
    GradientPathSettings,
    GradientSettings,
    Reconstruction,
)
from restir_gi.reference.methods.framed import Framed
from restir_gi.reference.methods.method import Job, Method
from restir_gi.reference.numerics.arrays import Scalars, Vec3s

GRADIENTS = {
    "dx": "right neighbour less pixel, of the last frame",
    "dy": "lower neighbour less pixel, of the last frame",
    "primal": "pixels of the last frame, before the image is reconstructed",
}

Renders = Callable[..., Iterator[GradientFrame]]


def _frames(render: Renders) -> Callable[[Job], Iterator[GradientFrame]]:
    def frames(job: Job) -> Iterator[GradientFrame]:
        return render(
            job.world, job.settings, job.bounces, job.seed, job.schedule, job.animation
        )

    return frames


def _layers(frame: GradientFrame, names: tuple[str, ...]) -> Mapping[str, Scalars]:
    d = frame.differences
    found = {"dx": d.x, "dy": d.y, "primal": frame.color}
    own = {name: found[name] for name in names if name in GRADIENTS}
    return {**area_layers(frame, names), **own}


RECONSTRUCT: Mapping[Reconstruction, Callable[[Vec3s, Differences, int], Vec3s]] = {
    "l2": least_squares,
    "l1": least_absolute,
}
"""Image from pixels and differences, by the norm of what is left of the differences."""


def developed(job: Job, estimates: Scalars) -> Vec3s:
    """Image of pixels and differences; emission seen directly is no part of them.

    Parameters
    ----------
    job : Job; whose settings name the norm
    estimates : (N, 9) float64; as of `GradientFrame`

    Returns
    -------
    (N, 3) float64, W/(m² sr); indirect light
    """
    primal, x, y = np.split(estimates, 3, axis=1)
    width = job.world.camera.width
    return RECONSTRUCT[job.settings.reconstruction](primal, Differences(x, y), width)


def named_biases(job: Job) -> tuple[str, ...]:
    """What biases the indirect light of a picture."""
    if job.settings.reconstruction == "l1":
        return (
            "reconstruction=l1 is not linear: biased, though what it is given is not",
        )
    return ()


def _method(name: str, summary: str, settings: Any, render: Renders) -> Method:
    framed = Framed(
        _frames(render),
        _layers,
        {**PATHS, **PLACES, **GRADIENTS},
        pixel="box",
        estimates=lambda frame: frame.estimates,
        develop=developed,
    )
    return framed.method(name, summary, settings, named_biases)


PATH_TRACED = _method(
    "gradient-pt",
    "pixels and their differences by path tracing; a sample a frame",
    GradientPathSettings(),
    render_gradient_paths,
)
AFTER = _method(
    "gradient-after-restir",
    "Area ReSTIR, and differences from the paths that it keeps",
    AfterSettings(),
    render_after_frames,
)
METHOD = _method(
    "gradient-restir",
    "pairs of paths reused together, for differences; Area ReSTIR for pixels",
    GradientSettings(),
    render_gradient_frames,
)

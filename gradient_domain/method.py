"""Methods ``gradient-pt``, ``gradient-after-restir`` and ``gradient-restir``."""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from extensions.area_method import PLACES, area_layers
from extensions.method import PATHS
from gradient_domain.after_restir import render_after_frames
from gradient_domain.differences import Differences
from gradient_domain.frame import GradientFrame
from gradient_domain.gradient_pt import render_gradient_paths
from gradient_domain.gradient_restir import render_gradient_frames
from gradient_domain.images import reconstructed
from gradient_domain.settings import (
    AfterSettings,
    GradientPathSettings,
    GradientSettings,
)
from reference.arrays import Scalars, Vec3s
from reference.methods.aovs import GBUFFER
from reference.methods.framed import PARTS, Framed
from reference.methods.method import Job, Method

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
    kind = job.settings.reconstruction
    return reconstructed(kind, primal, Differences(x, y), width)


def named_biases(job: Job) -> tuple[str, ...]:
    """What biases the indirect light of a picture."""
    if job.light == "direct" or job.bounces == 0:
        return ()
    if job.settings.reconstruction == "l1":
        return (
            "reconstruction=l1 is not linear: biased, though what it is given is not",
        )
    return ()


def _method(name: str, summary: str, settings: Any, render: Renders) -> Method:
    own = {**PATHS, **PLACES, **GRADIENTS}
    framed = Framed(
        _frames(render),
        _layers,
        own,
        pixel="box",
        estimates=lambda frame: frame.estimates,
        develop=developed,
    )
    return Method(
        name=name,
        summary=summary,
        counts={"frames": 32, "spp": 32},
        settings=settings,
        aovs={**PARTS, **own, **GBUFFER},
        render=framed.render,
        biases=named_biases,
        frames=framed.shown,
        pixel=framed.pixel,
    )


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

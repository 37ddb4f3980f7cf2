"""Method ``restir-pt``: whole paths, reused by shift mappings."""

from collections.abc import Iterator, Mapping

import numpy as np

from restir_gi.extensions.frame_loop import PathFrame
from restir_gi.extensions.pt_settings import PathSettings
from restir_gi.extensions.restir_pt import render_path_frames
from restir_gi.extensions.shifting import Paths
from restir_gi.reference.methods.framed import Framed
from restir_gi.reference.methods.method import Job
from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.resampling.reservoir import Reservoirs

PATHS = {
    "M": "confidence of the pixel's reservoir",
    "W": "its unbiased contribution weight, in primary sample space",
    "joint": "index of the reconnection vertex, 0 where the path is replayed whole",
    "length": "index of the last surface point, 0 where there is no path",
}


def _frames(job: Job) -> Iterator[PathFrame]:
    return render_path_frames(
        job.world, job.settings, job.bounces, job.seed, job.schedule, job.animation
    )


def path_layers(
    r: Reservoirs, paths: Paths, names: tuple[str, ...]
) -> dict[str, Scalars]:
    """Layers of what reservoirs of paths keep, dict of str to (N,) float64; by name.

    Parameters
    ----------
    names : tuple of str; which; others than those of `PATHS` are passed over
    """
    full = r.W > 0
    found = {
        "M": r.M,
        "W": r.W,
        "joint": np.where(full, paths.joint, 0.0),
        "length": np.where(full, paths.end, 0.0),
    }
    return {name: found[name] for name in names if name in PATHS}


def _layers(frame: PathFrame, names: tuple[str, ...]) -> Mapping[str, Scalars]:
    return path_layers(frame.reservoirs, frame.reservoirs.y, names)


def named_biases(job: Job) -> tuple[str, ...]:
    """What biases the indirect light of a picture."""
    reuses = job.settings.spatial or (job.animation and job.settings.temporal)
    if reuses and job.settings.mis == "1/M":
        return ("mis=1/M counts those who could not have made the sample: too dark",)
    return ()


FRAMED = Framed(_frames, _layers, PATHS)
METHOD = FRAMED.method(
    "restir-pt",
    "whole paths, reused by reconnection, random replay or both",
    PathSettings(),
    named_biases,
)

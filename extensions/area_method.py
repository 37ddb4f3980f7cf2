"""Method ``area-restir``: whole paths over the area of each pixel."""

from collections.abc import Iterator, Mapping

from restir_gi.extensions.area_restir import render_area_frames
from restir_gi.extensions.area_settings import AreaSettings
from restir_gi.extensions.frame_loop import PathFrame
from restir_gi.extensions.method import PATHS, path_layers
from restir_gi.reference.methods.framed import Framed
from restir_gi.reference.methods.method import Job
from restir_gi.reference.numerics.arrays import Scalars

PLACES = {
    "x": "where the kept path appears in the image, pixels from the left",
    "y": "where the kept path appears in the image, pixels from the top",
}


def _frames(job: Job) -> Iterator[PathFrame]:
    return render_area_frames(
        job.world,
        job.settings,
        bounces=job.bounces,
        seed=job.seed,
        schedule=job.schedule,
        animation=job.animation,
    )


def area_layers(frame: PathFrame, names: tuple[str, ...]) -> Mapping[str, Scalars]:
    """Layers of what the reservoirs of a frame keep.

    Parameters
    ----------
    names : tuple of str; which; those that are not known here are passed over

    Returns
    -------
    dict of str to (N,) float64; by name
    """
    r = frame.reservoirs
    places = {name: getattr(r.y, name) for name in names if name in PLACES}
    return {**path_layers(r, r.y.paths, names), **places}


FRAMED = Framed(_frames, area_layers, {**PATHS, **PLACES}, pixel="box")
METHOD = FRAMED.method(
    "area-restir",
    "whole paths, reused over the area of each pixel: antialiased",
    AreaSettings(),
    lambda job: (),
)

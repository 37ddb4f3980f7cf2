"""Method ``world-reservoirs``: light reservoirs at every vertex, in a hashed grid."""

from collections.abc import Iterator, Mapping

import numpy as np

from restir_gi.hashgrid.grid import levels
from restir_gi.hashgrid.light_settings import LightSettings
from restir_gi.hashgrid.world_reservoirs import LightFrame, render_light_frames
from restir_gi.reference.methods.framed import Framed
from restir_gi.reference.methods.method import Job, Preset
from restir_gi.reference.numerics.arrays import Scalars

VERTEX = {
    "M": "confidence of the reservoir at the first surface point after the visible one",
    "W": "its unbiased contribution weight",
    "level": "level of detail of the cell that the visible point lies in",
    "cell": "cell that the sample at that surface point was taken from, 0 for none",
}


def _frames(job: Job) -> Iterator[LightFrame]:
    return render_light_frames(
        job.world, job.settings, job.bounces, job.seed, job.schedule, job.animation
    )


def _layers(frame: LightFrame, names: tuple[str, ...]) -> Mapping[str, Scalars]:
    r, at = frame.cache.reservoirs, np.flatnonzero(frame.vertex == 2)
    pixels = len(frame.color)

    def of_second(values: Scalars) -> Scalars:
        layer = np.zeros(pixels)
        layer[frame.pixel[at]] = values[at]
        return layer

    found = {
        "M": of_second(r.M),
        "W": of_second(r.W),
        "level": levels(frame.cache.lattice, frame.visible.surface.position) * 1.0,
        "cell": of_second(np.where(r.W > 0, r.y.cell, 0)),
    }
    return {name: found[name] for name in names if name in VERTEX}


def named_biases(job: Job) -> tuple[str, ...]:
    """What biases the indirect light of a picture."""
    if job.settings.cells and job.settings.mis == "1/M":
        return ("mis=1/M counts vertices that cannot reflect the light: too dark",)
    return ()


FRAMED = Framed(_frames, _layers, VERTEX)
METHOD = FRAMED.method(
    "world-reservoirs",
    "light reservoirs at every path vertex, reused in a hashed grid",
    LightSettings(),
    named_biases,
    {"paper": Preset("as [Boisse21] has it: weights 1/M", ("mis=1/M",))},
)

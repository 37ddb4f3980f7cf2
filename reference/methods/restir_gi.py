"""Methods ``restir-gi-unbiased`` and ``restir-gi-biased``: ReSTIR GI, two settings."""

from collections.abc import Iterator
from dataclasses import asdict, dataclass

from restir_gi.reference import settings
from restir_gi.reference.methods.aovs import RESERVOIRS, reservoir_layers
from restir_gi.reference.methods.biases import biases
from restir_gi.reference.methods.framed import Framed, Image
from restir_gi.reference.methods.method import Job, Method, Preset
from restir_gi.reference.methods.setting_values import refuse_beyond
from restir_gi.reference.numerics.arrays import Scalars
from restir_gi.reference.numerics.records import nbytes
from restir_gi.reference.options.storage import stored_bytes
from restir_gi.reference.restir_gi import Frame, render_frames
from restir_gi.reference.settings import Settings

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
    "lattice": (1, 64),
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

    image: Image = "last"

    def __post_init__(self) -> None:
        refuse_beyond(self, LEAST_AND_MOST)
        if self.lattice > 1 and not (self.spatial and self.reuse == "separate"):
            raise ValueError(
                f"lattice={self.lattice} needs spatial=true and reuse=separate: pixels"
                " without a reservoir reuse those of their neighbours"
            )


def named_biases(job: Job) -> tuple[str, ...]:
    """What biases the indirect light of a picture."""
    changes = job.animation.changes if job.animation else "nothing"
    return biases(job.settings, job.world.scene, changes)


def _frames(job: Job) -> Iterator[Frame]:
    return render_frames(
        job.world, job.settings, job.bounces, job.seed, job.schedule, job.animation
    )


def _layers(frame: Frame, names: tuple[str, ...]) -> dict[str, Scalars]:
    return reservoir_layers(frame.spatial, names)


def _size(job: Job, frame: Frame) -> int:
    kinds = [frame.temporal]
    if frame.spatial is not frame.temporal:
        kinds.append(frame.spatial)
    whole = sum(stored_bytes(job.settings.storage, r) for r in kinds)
    one_in: int = job.settings.lattice**2
    return whole // one_in + nbytes([frame.visible, frame.seen])


FRAMED = Framed(_frames, _layers, RESERVOIRS, size=_size)


PRESETS = {
    "paper": Preset(
        "as [Ouyang21] describes its own renderer: Eq. 10, roulette, two buffers",
        ("target=outgoing", "roulette=0.25", "reuse=double-buffered"),
    ),
    "rtxdi": Preset(
        "in the manner of RTXDI's sample application",
        (
            "source=bsdf",
            "mis=balance",
            "visibility=none",
            "final_visibility=traced",
            "temporal_cap=8",
            "max_age=30",
            "iterations_few=2",
            "iterations_many=8",
            "radius=0",
            "min_radius=32",
            "max_angle=53.13",
            "max_depth=0.1",
            "jacobian_limit=10",
            "beyond_limit=reject",
            "boiling_filter=0.2",
            "fallback_search=true",
        ),
    ),
    "restir_pt": Preset(
        "in the manner of the ReSTIR GI pass beside ReSTIR PT's published code",
        (
            "source=bsdf",
            "mis=1/Z",
            "temporal_cap=30",
            "spatial_cap=100",
            "max_age=100",
            "iterations_few=3",
            "iterations_many=10",
            "min_radius=10",
            "max_angle=60",
            "max_depth=0.1",
            "storage=paper",
        ),
    ),
}
"""What each leaves out of the renderer that it is named after stands in the How-to."""


def _method(name: str, summary: str, defaults: Settings) -> Method:
    settings = RestirSettings(**asdict(defaults))
    return FRAMED.method(name, summary, settings, named_biases, PRESETS)


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

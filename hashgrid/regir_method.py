"""Method ``regir-gi``: paths in the cells of a grid, and ReSTIR PT on top."""

from collections.abc import Iterator, Mapping

from restir_gi.extensions.method import PATHS, path_layers
from restir_gi.hashgrid.path_settings import CellSettings
from restir_gi.hashgrid.regir_gi import CellFrame, render_cell_frames
from restir_gi.reference.methods.framed import Framed
from restir_gi.reference.methods.method import Job, Preset
from restir_gi.reference.numerics.arrays import Scalars


def _frames(job: Job) -> Iterator[CellFrame]:
    return render_cell_frames(
        job.world, job.settings, job.bounces, job.seed, job.schedule, job.animation
    )


def _layers(frame: CellFrame, names: tuple[str, ...]) -> Mapping[str, Scalars]:
    return path_layers(frame.reservoirs, frame.reservoirs.y, names)


def named_biases(job: Job) -> tuple[str, ...]:
    """What biases the indirect light of a picture."""
    s = job.settings
    looks_up = any(s.looks_up(v) for v in range(1, job.bounces + 1))
    reuses = s.spatial or (job.animation and s.temporal)
    found = {
        "mis=1/M counts those who could not have made the sample: too dark": (
            reuses and s.mis == "1/M"
        ),
        "cell_mis=1/M counts vertices that could not have made the path: too dark": (
            looks_up and s.cell_mis == "1/M"
        ),
        "nulls=dropped forgets the paths that found nothing: too bright": (
            looks_up and s.nulls == "dropped"
        ),
        "writers=every-bounce lets a path's end decide which vertex reuses it": (
            looks_up and s.writers == "every-bounce"
        ),
    }
    return tuple(line for line, holds in found.items() if holds)


FRAMED = Framed(_frames, _layers, PATHS)
METHOD = FRAMED.method(
    "regir-gi",
    "paths in the cells of a hashed grid, then reused over the screen",
    CellSettings(),
    named_biases,
    {
        "paper": Preset(
            "as its article has it: 1/M, useful paths alone, all bounces in one grid",
            ("cell_mis=1/M", "nulls=dropped", "writers=every-bounce"),
        )
    },
)

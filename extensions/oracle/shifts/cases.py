"""Cases of shifts in real scenes: rows in which everything happens that can."""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from restir_gi.extensions.oracle.shifts.passes import SHIFT
from restir_gi.extensions.oracle.shifts.rows import buffers, eventful
from restir_gi.extensions.oracle.shifts.scenes import frame_of
from restir_gi.extensions.pt_settings import CRITERIA
from restir_gi.extensions.shifting import Criterion
from restir_gi.reference.oracle.buffers import given
from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.contract.fields import Precision, Value, dtype_of
from restir_gi.reference.oracle.parts import SEED

SIZE, BOUNCES = 24, 4
NEVER = 2.0
"""More than any perceptual roughness."""

WIDE = Criterion(roughness=0.2, distance=0.5)
"""Ways of half the box are too short."""

KINDS = {
    "hybrid": CRITERIA["hybrid"],
    "wide": WIDE,
    "reconnection": CRITERIA["reconnection"],
    "replay": Criterion(roughness=NEVER),
    "early": Criterion(roughness=0.2, distance=0.5, last_joint=2),
}


@dataclass(frozen=True, slots=True)
class RowOrigin:
    """Where rows come from.

    Attributes
    ----------
    scene, kind : str; of ``BLOCKS`` of the scenes, and of `KINDS`
    frame : int; of the random numbers
    right, down : int, pixels; to which pixels paths are shifted
    """

    scene: str
    kind: str
    frame: int
    right: int
    down: int


PLACES = (
    RowOrigin("paint", "hybrid", 0, 2, 1),
    RowOrigin("paint", "wide", 1, 5, 3),
    RowOrigin("rough-metal", "hybrid", 2, 1, 1),
    RowOrigin("rough-metal", "wide", 3, 3, 1),
    RowOrigin("glossy-metal", "hybrid", 4, 1, 0),
    RowOrigin("mirror", "hybrid", 5, 0, 1),
    RowOrigin("glass", "hybrid", 6, 1, 2),
    RowOrigin("rough-coat", "hybrid", 7, 3, 2),
    RowOrigin("smooth-coat", "hybrid", 8, 1, 1),
    RowOrigin("smooth-coat", "wide", 9, 2, 2),
    RowOrigin("bright", "hybrid", 12, 2, 1),
    RowOrigin("mirror", "reconnection", 10, 4, 1),
    RowOrigin("glazed", "hybrid", 22, 0, 1),
    RowOrigin("rough-metal", "replay", 11, 1, 1),
    RowOrigin("bright", "replay", 13, 1, 2),
    RowOrigin("paint", "early", 14, 1, 1),
    RowOrigin("glass", "early", 15, 2, 1),
    RowOrigin("paint", "early", 23, 2, 1),
    RowOrigin("paint", "wide", 16, 1, 0),
    RowOrigin("glossy-metal", "wide", 17, 1, 1),
    RowOrigin("glass", "reconnection", 18, 2, 1),
    RowOrigin("mirror", "reconnection", 19, 1, 1),
    RowOrigin("glazed", "hybrid", 20, 1, 1),
    RowOrigin("glazed", "hybrid", 21, 2, 1),
)


@cache
def shift_case(place: RowOrigin, precision: Precision, seed: int = SEED) -> Case:
    """Rows of one frame.

    Parameters
    ----------
    seed : int; of its random numbers
    """
    criterion = KINDS[place.kind]
    frame = frame_of(
        place.scene,
        SIZE,
        seed=seed,
        frame=place.frame,
        bounces=BOUNCES,
        criterion=criterion,
    )
    grid = np.arange(SIZE * SIZE).reshape(SIZE, SIZE)
    to = np.roll(grid, (-place.down, -place.right), axis=(0, 1)).ravel()
    start = np.flatnonzero(frame.paths.value.any(axis=1))
    inputs = buffers(frame, criterion, start=start, to=to[start], bounces=BOUNCES)
    rows = eventful(frame, criterion, start=start, to=to[start], inputs=inputs)
    inputs = {name: array[rows] for name, array in inputs.items()}
    name = f"shift-{place.scene}-{place.kind}-{place.frame}"
    extent = float(frame.world.geometry.extent)
    settings = settings_of(extent, criterion, place) | {"seed": seed}
    return Case(name, "shift", settings, given(inputs, precision))


def without_light_choice(case: Case) -> Case:
    """A case in which the lights after the joint are never chosen by sampling them."""
    none = np.zeros_like(case.inputs["pdf_light"])
    name = f"{case.name}-not-chosen"
    return replace(case, name=name, inputs={**case.inputs, "pdf_light": none})


def settings_of(
    extent: float, criterion: Criterion, place: RowOrigin
) -> dict[str, Value]:
    """Settings of a case, in the order of the contract.

    Parameters
    ----------
    extent : float, m; half of the scene
    """
    return {
        "roughness": criterion.roughness,
        "least_distance": criterion.distance,
        "extent": extent,
        "last_joint": criterion.last_joint,
        "replays": int(criterion.replays),
        "scene": place.scene,
        "size": SIZE,
        "seed": SEED,
        "frame": place.frame,
        "bounces": BOUNCES,
    }


def null_case(precision: Precision) -> Case:
    """One row without a path, which every backend that has the pass answers.

    Made soon: whoever does not answer is not asked further.
    """
    place, bounces = RowOrigin("paint", "hybrid", 0, 0, 0), 1
    criterion = KINDS[place.kind]
    inputs = {}
    for field in SHIFT.inputs:
        columns = [bounces + 1 if c == "V" else int(c) for c in field.columns]
        kind = dtype_of(field.kind, precision)
        inputs[field.name] = np.zeros((1, *columns), kind)
    settings = settings_of(1.0, criterion, place) | {"size": 2, "bounces": bounces}
    return Case("shift-null", "shift", settings, inputs)

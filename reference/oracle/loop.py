"""The frame loop with a backend's own passes: it runs free, from its own outputs."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Indices, Masks, Vec3s
from restir_gi.reference.numerics.rng import KeyedUniforms, Stream
from restir_gi.reference.oracle.backends.selected import Selection
from restir_gi.reference.oracle.buffers import given, prefixed
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision, Value
from restir_gi.reference.oracle.contract.targets import DATA
from restir_gi.reference.oracle.contract.weights import DEFENSIVE
from restir_gi.reference.oracle.given_targets import scattered, with_given_targets
from restir_gi.reference.oracle.visibility import made_it

Array = NDArray[Any]


class Harness(Protocol):
    """What stands around the passes: rays, and who sees whom."""

    def receivers(self) -> dict[str, Array]:
        """Buffers of the visible points, N rows."""
        ...

    def trace(self, direction: Vec3s, frame: int) -> dict[str, Array]:
        """Buffers of the sample points that rays from the visible points meet."""
        ...

    def sees(self, viewer: Indices, position: Vec3s, normal: Vec3s) -> Masks:
        """Whether visible points, by row, see sample points."""
        ...


@dataclass(frozen=True, slots=True)
class Run:
    """How the loop runs.

    Attributes
    ----------
    source : 'uniform' or 'cosine'; density of the directions
    target : 'scattered', 'outgoing' or 'data'; Equation 9 or 10, or 9 as data
    mis : str; weights of Algorithm 4
    temporal_mis : str; those of Algorithm 3; empty where a case says nothing of them
    temporal_cap, spatial_cap : float; limits of M
    seed : int; of the random numbers
    neighbors : frozenset of int; how many Algorithm 4 may have; empty for any
    history : bool; whether it merges what it left in the last frame
    """

    frames: int = 3
    source: str = "cosine"
    target: str = "scattered"
    mis: str = "1/Z"
    temporal_mis: str = ""
    temporal_cap: float = 30.0
    spatial_cap: float = 500.0
    seed: int = 0
    neighbors: frozenset[int] = frozenset()
    history: bool = True

    def around(self, usual: int) -> int:
        """How many neighbours there are, where usually there are so many."""
        return Selection(neighbors=self.neighbors).neighbors_for(usual)

    @property
    def counts(self) -> bool:
        """Whether each sample weighs M where all could have made it with one density.

        By the defensive weight the pixel's own weighs more.
        """
        return DEFENSIVE not in (self.mis, self.temporal_mis)


@dataclass(frozen=True, slots=True, eq=False)
class LoopFrame:
    """What a frame leaves, N rows.

    Attributes
    ----------
    color : (N, 3); indirect light
    spatial : mapping of str to array; reservoirs that were shown
    radiance : (N, 3); of the new samples
    """

    color: Vec3s
    spatial: Buffers
    radiance: Vec3s


Ask = Callable[[Case], Buffers]
"""Asks the backend, and raises where it does not answer."""


def run_frames(
    ask: Ask,
    harness: Harness,
    neighbors: Callable[[int], Indices],
    run: Run,
    precision: Precision,
) -> list[LoopFrame]:
    """Frames of a backend's passes [Ouyang21, Fig. 4].

    Parameters
    ----------
    neighbors : callable; (N, K) neighbours of each row in a frame, or −1
    """
    x = harness.receivers()
    rows = len(x["visible_position"])
    temporal = spatial = _empty(rows)
    shown = []

    def call(pass_name: str, inputs: Any, **settings: Value) -> Buffers:
        name = f"loop-{pass_name}"
        case = Case(name, pass_name, settings, given(inputs, precision))
        if settings.get("target") == DATA:
            case = with_given_targets(case, scattered)
        return ask(case)

    pixel = np.arange(rows, dtype=np.uint32)
    for frame in range(run.frames):
        at = partial(KeyedUniforms, pixel, frame, run.seed)
        # Algorithm 2: a direction, and what it meets.
        u = np.stack(at(Stream.INITIAL).draw(0)[1:3], axis=1)
        drawn = call(
            "direction",
            {"visible_normal": x["visible_normal"], "u": u},
            source=run.source,
        )
        new = prefixed("new", harness.trace(drawn["direction"].astype(float), frame))
        # Algorithm 3.
        inputs = x | prefixed("past", temporal) | new
        inputs |= {"new_pdf": drawn["pdf"], "u": at(Stream.TEMPORAL).draw(0)[0]}
        words = {"mis": run.temporal_mis} if run.temporal_mis else {}
        temporal = dict(
            call("temporal", inputs, target=run.target, cap=run.temporal_cap, **words)
        )
        # Algorithm 4.
        around = neighbors(frame)
        count = around.shape[1]
        decide = [at(Stream.SPATIAL).draw(k)[2] for k in range(count)]
        before = spatial if run.history else _empty(rows)
        inputs = x | temporal | prefixed("past", before)
        inputs |= {
            "neighbors": around,
            "visible": _bits(harness, temporal, before, around),
            "u_own": at(Stream.SPATIAL).draw(63)[0],
            "u_neighbors": np.stack(decide, axis=1),
        }
        spatial = dict(
            call("spatial", inputs, target=run.target, cap=run.spatial_cap, mis=run.mis)
        )
        # Equation 8.
        kept = {name: spatial[name] for name in ("position", "normal", "radiance", "W")}
        color = call("shade", x | kept)["color"]
        shown.append(LoopFrame(color, spatial, new["new_radiance"]))
    return shown


def _empty(rows: int) -> dict[str, Array]:
    vectors = {n: np.zeros((rows, 3)) for n in ("position", "normal", "radiance")}
    return vectors | {"W": np.zeros(rows), "M": np.zeros(rows)}


def _bits(
    harness: Harness, own: Buffers, past: Buffers, around: Indices
) -> NDArray[np.uint32]:
    rows, count = np.arange(len(around)), around.shape[1]
    viewers = [rows, *(around[:, k] for k in range(count))]
    samples = [(own, row) for row in viewers] + [(past, rows)]
    places = [r["position"][np.maximum(row, 0)] for r, row in samples]
    makers = [*viewers, np.full(len(rows), -1)]
    words = np.zeros((len(rows), count + 1), np.uint32)
    for column, viewer in enumerate(viewers):
        for bit, (r, row) in enumerate(samples):
            at = np.maximum(row, 0)
            seen = harness.sees(np.maximum(viewer, 0), places[bit], r["normal"][at])
            made = made_it(viewer, places[bit], makers, places)
            words[:, column] |= (seen | made).astype(np.uint32) << np.uint32(bit)
    return words

"""L4: whether a backend has the same distribution as the reference, in real scenes.

Under the null hypothesis the runs of both are exchangeable, so that ranks are exact for
any distribution and any number of runs: fireflies cost nothing.  A bias far below the
noise of a few runs is not seen here; it is the lattices' and the replay's to find.  Of
a backend with other weights, another target or other domains it says nothing: their
distribution is another one, and may be right.
"""

from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.oracle.builtin.backend import BuiltIn
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.levels.probe import Finding
from restir_gi.reference.oracle.levels.spheres import PLAIN
from restir_gi.reference.oracle.loop import Ask, Run, run_frames
from restir_gi.reference.oracle.prepared_frame import NEIGHBORS
from restir_gi.reference.oracle.scene_harness import open_harness
from restir_gi.reference.oracle.statistics.distribution import distribution_p_values
from restir_gi.reference.oracle.statistics.families import bonferroni

ALPHA = 5e-7
"""False alarms of this level in a run, all scenes and functionals together."""

SCENES = ("cornell-box", "door-ajar", "sunlit-wall", "many-lights")

SIZE, RUNS, TILE, FRAMES = 16, 48, 4, 3


@dataclass(frozen=True, slots=True)
class DistributionTest:
    """What the ranks have shown in one scene.

    Attributes
    ----------
    finding : Finding; of the smallest p-value
    p : float; that of the scene, for all its functionals together
    """

    finding: Finding
    p: float


def same_distribution(
    ask: Ask,
    precision: Precision,
    scene: str,
    tests: int = len(SCENES),
    alpha: float = ALPHA,
    seed: int = 0,
    like: Run = PLAIN,
) -> DistributionTest:
    """Compare independent runs of a backend with as many of the reference.

    The functionals are the means of tiles, capped and not, how many pixels are black,
    the spread within the image and the mean of M.

    Parameters
    ----------
    scene : str; built-in, of diffuse surfaces alone
    tests : int; scenes that are tested, among which alpha is shared
    alpha : float; probability of a false alarm in all of them
    seed : int; of the runs; the reference has others
    like : Run; its weights are those of the runs of both
    """
    ours = BuiltIn("float64")

    def ask_ours(case: Case) -> Buffers:
        found: Buffers = getattr(ours, case.pass_name)(**case.inputs, **case.settings)
        return found

    theirs = _runs(ask, precision, scene, 2 * seed, like)
    reference = _runs(ask_ours, "float64", scene, 2 * seed + 1, like)
    # The same whoever made which run: else runs would not be exchangeable.
    cap = 2 * float(np.median([color.mean() for color, _ in (*theirs, *reference)]))
    p = distribution_p_values(_functionals(theirs, cap), _functionals(reference, cap))
    whole = bonferroni(p)
    if whole * tests >= alpha:
        return DistributionTest(Finding(True), whole)
    text = (
        f"{scene}: runs do not have the distribution of the reference,"
        f" p = {whole:.2g} in {len(p)} functionals; the first is"
        f" {_name(int(np.argmin(p)))}: statistics of ranks, exact for any distribution"
    )
    return DistributionTest(Finding(False, text), whole)


Runs = list[tuple[NDArray[Any], NDArray[Any]]]


def _runs(ask: Ask, precision: Precision, scene: str, seed: int, like: Run) -> Runs:
    """Colour and M of the last frame, a run each."""
    harness = open_harness(scene, SIZE, RUNS, seed)
    run = replace(like, frames=FRAMES, source="uniform", seed=seed)
    around = partial(harness.neighbors, like.around(NEIGHBORS))
    shown = run_frames(ask, harness, around, run, precision)[-1]
    color = shown.color.astype(float).mean(axis=1).reshape(RUNS, -1)
    M = shown.spatial["M"].astype(float).reshape(RUNS, -1)
    return list(zip(color, M, strict=True))


def _functionals(runs: Runs, cap: float) -> NDArray[np.float64]:
    """(R, columns): what is compared of each run."""
    color = np.stack([c for c, _ in runs])
    M = np.stack([m for _, m in runs])
    least = np.minimum(color, cap)
    spread = np.log1p(least.var(axis=1))
    one = [
        color.mean(axis=1),
        least.mean(axis=1),
        (color == 0).sum(axis=1),
        (color > cap).sum(axis=1),
        spread,
        M.mean(axis=1),
    ]
    return np.column_stack([*one, _tiles(color), _tiles(least)])


FUNCTIONALS = (
    "the mean of the image",
    "the mean of the image, capped",
    "the number of black pixels",
    "the number of bright pixels",
    "the spread within the image",
    "the mean of M",
)


def _name(column: int) -> str:
    if column < len(FUNCTIONALS):
        return FUNCTIONALS[column]
    tile = (column - len(FUNCTIONALS)) % (SIZE // TILE) ** 2
    return f"the mean of tile {tile}"


def _tiles(color: NDArray[Any]) -> NDArray[Any]:
    side = SIZE // TILE
    blocks = color.reshape(len(color), side, TILE, side, TILE)
    found: NDArray[Any] = blocks.mean(axis=(2, 4)).reshape(len(color), -1)
    return found

"""Statistics of a backend that other processes gather, each from a backend of its own.

Batches of runs are numbered, and judged in the order of their numbers: whoever made
them, the verdict is the same.
"""

import atexit
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import lru_cache, partial
from itertools import count
from threading import TIMEOUT_MAX

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.oracle.backends.backend import Backend
from restir_gi.reference.oracle.backends.open import open_backend
from restir_gi.reference.oracle.backends.running import Limits
from restir_gi.reference.oracle.backends.selected import (
    EVERYTHING,
    SelectedBackend,
    Selection,
)
from restir_gi.reference.oracle.cases import NO_TIME, UnaskedError
from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.ladder import (
    distribution_step,
    run_of,
    statistical_levels,
)
from restir_gi.reference.oracle.levels.distribution import SCENES
from restir_gi.reference.oracle.levels.means import replicates
from restir_gi.reference.oracle.parts import whole_contract
from restir_gi.reference.oracle.steps import Asker, Level, LevelStep
from restir_gi.reference.system.workers import ahead

AHEAD = 32
"""Batches that are handed out before they are wanted."""


@dataclass(frozen=True, slots=True)
class Reached:
    """A backend as any process can reach it.

    Attributes
    ----------
    name : str; object, file or command line, the same everywhere
    precision : 'float32' or 'float64'; of a command line
    selection : Selection; passes that are asked
    """

    name: str
    limits: Limits
    precision: Precision
    selection: Selection = EVERYTHING

    def open(self) -> Backend:
        """Of this process, opened once, and closed when the process ends.

        Raises UsageError: there is none here.
        """
        return _opened(self)


@lru_cache(maxsize=1)
def _opened(reached: Reached) -> Backend:
    backend = open_backend(reached.name, reached.limits, reached.precision)
    atexit.register(backend.close)
    return SelectedBackend(backend, reached.selection)


def batch(reached: Reached, seed: int) -> NDArray[np.float64]:
    """Runs of the backend of this process.

    Returns (R, 1 + T) float64; as of
    :func:`restir_gi.reference.oracle.levels.means.replicates`.
    """
    backend = reached.open()
    ask = Asker(whole_contract(), backend)
    return replicates(ask, backend.precision, seed, run_of(reached.selection))


def distribution(reached: Reached, scene: str) -> LevelStep:
    """Step of the distribution test in one scene, with the backend of this process.

    As if it had been taken here.
    """
    return distribution_step(whole_contract(), reached.open(), scene)


def distributed_levels(
    reached: Reached,
    backend: Backend,
    executor: Executor,
    remaining: Callable[[], float],
) -> Iterator[Level]:
    """Levels of whole runs, of which other processes make all but the first batch.

    Parameters
    ----------
    remaining : callable; seconds that are left
    """
    found = {s: executor.submit(distribution, reached, s) for s in SCENES}

    def distribution_of(scene: str) -> LevelStep:
        try:
            return found[scene].result(min(max(remaining(), 0.0), TIMEOUT_MAX))
        except TimeoutError as error:
            raise UnaskedError(NO_TIME.reason) from error

    distributions = {scene: partial(distribution_of, scene) for scene in SCENES}

    def batches(first: int) -> Iterator[NDArray[np.float64]]:
        return ahead(executor, partial(batch, reached), count(first), AHEAD, remaining)

    yield from statistical_levels(
        whole_contract(), backend, remaining, batches, distributions
    )

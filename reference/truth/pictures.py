"""Truths of whole pictures, traced as exactly as they are wanted, and kept."""

import hashlib
import json
import os
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path

import numpy as np
from platformdirs import user_cache_path

from restir_gi.reference import numerics, scene, transport
from restir_gi.reference.numerics.arrays import Vec3s
from restir_gi.reference.numerics.moments import Moments, add_samples, no_samples
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.oracle import blackbox
from restir_gi.reference.oracle.blackbox.convention import Convention
from restir_gi.reference.oracle.blackbox.evidence import Tolerance, is_exact
from restir_gi.reference.oracle.blackbox.truth import (
    LEAST_SAMPLES,
    MOST_SAMPLES,
    Truth,
    rows_of,
)
from restir_gi.reference.oracle.cases import NO_TIME, Remaining, UnaskedError
from restir_gi.reference.scene.fingerprint import fingerprint
from restir_gi.reference.scene.scene import Scene
from restir_gi.reference.scene.validation import validate
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.files import make_folder
from restir_gi.reference.system.version import project_version
from restir_gi.reference.transport.accumulate import in_batches, path_samples
from restir_gi.reference.transport.world import build_world
from restir_gi.reference.truth.checkpoint import (
    Checkpoint,
    load_checkpoint,
    save_checkpoint,
)

SEED = 2**26 + 1
"""Of the path tracer: far from what a user counts from."""

ROUGHLY = 4.0
"""How many times larger the error is of conventions that nobody asked for."""

SHARE = 0.5
"""Of the time that is left, what a truth may take."""

PLACE = "RESTIR_CACHE"
"""Variable of the environment that names the folder where truths are kept."""


def truths_folder() -> Path:
    """Where truths are kept."""
    named = os.environ.get(PLACE)
    return Path(named) if named else user_cache_path("restir-gi-oracle") / "truths"


@dataclass(frozen=True, slots=True)
class PictureTruths:
    """Truths of the pictures of a scene.

    Attributes
    ----------
    scene : Scene; as an author or a loader gives it
    size : (int, int); of the picture, in pixels
    asked : Convention; of which the truth is traced exactly, of others roughly
    tolerance : Tolerance; what the error of a truth is held against
    remaining : callable; seconds that are left
    tell : callable; told what is traced, and how many samples there are
    folder : Path; where truths are kept
    """

    scene: Scene
    size: tuple[int, int]
    asked: Convention
    tolerance: Tolerance
    remaining: Remaining
    tell: Callable[[str], None] = lambda _: None
    folder: Path = field(default_factory=truths_folder)

    def __call__(self, convention: Convention) -> Truth:
        """Truth of a convention: kept, or traced until it is exact enough.

        Raises UnaskedError: there was no time for `LEAST_SAMPLES`.
        """
        path, run = self._kept(convention)
        state = _load(path, run)
        roughly = 1.0 if convention == self.asked else ROUGHLY
        truth = Truth(state.moments, self.size)
        if not is_exact(truth, self.tolerance, roughly):
            for truth in self._traced(convention, state.moments):
                self.tell(f"truth, {truth.samples} samples")
                if is_exact(truth, self.tolerance, roughly):
                    break
            _save(path, run, truth)
        if truth.samples < LEAST_SAMPLES:
            raise UnaskedError(NO_TIME.reason)
        return truth

    def _traced(self, convention: Convention, before: Moments) -> Iterator[Truth]:
        """Ever more samples, until the time for them is over."""
        end = (1 - SHARE) * self.remaining()
        width, height = self.size
        camera = replace(self.scene.camera, width=width, height=height)
        world = build_world(validate(replace(self.scene, camera=camera)))
        whole = Schedule(band=width * height + 1)
        samples = path_samples(
            world,
            whole,
            light=convention.light,
            bounces=convention.bounces,
            seed=SEED,
            pixel=convention.pixel,
        )

        def sample(rows: slice, number: int) -> Vec3s:
            color = samples.radiance(slice(0, width * height), number)
            return rows_of(color.reshape(height, width, 3))

        def advance(moments: Moments, until: int) -> Moments:
            return add_samples(moments, sample, until, everything)

        rows = len(rows_of(np.zeros((height, width, 3))))
        everything = Schedule(band=rows)
        start = before if before.count else no_samples(rows)
        for moments in in_batches(advance, start, MOST_SAMPLES):
            yield Truth(moments, self.size)
            if self.remaining() <= end:
                return

    def _kept(self, convention: Convention) -> tuple[Path, dict[str, str]]:
        """File of a truth, and everything that it depends on."""
        shown = replace(self.scene, notes=())
        width, height = self.size
        run = {
            "version": project_version(),
            "sources": _sources(),
            "scene": fingerprint(shown),
            "size": f"{width}x{height}",
            "convention": convention.options,
            "seed": str(SEED),
        }
        digest = hashlib.sha256(json.dumps(run).encode()).hexdigest()
        return self.folder / f"{digest[:32]}.npz", run


@cache
def _sources() -> str:
    """Digest of the code that traces and adds up: a change of it is another truth."""
    digest = hashlib.sha256()
    for room in (numerics, scene, transport, blackbox):
        for file in sorted(Path(room.__path__[0]).rglob("*.py")):
            digest.update(file.read_bytes())
    return digest.hexdigest()


def _load(path: Path, run: dict[str, str]) -> Checkpoint:
    """What is kept, or nothing: a file that is damaged is replaced."""
    nothing = Checkpoint(no_samples(0), 0.0, {})
    try:
        return load_checkpoint(path, run) or nothing
    except UsageError:
        return nothing


def _save(path: Path, run: dict[str, str], truth: Truth) -> None:
    """Keep a truth where that is possible; else it is traced again the next time."""
    with suppress(UsageError):
        make_folder(path.parent)
        save_checkpoint(path, run, Checkpoint(truth.moments, 0.0, {}))

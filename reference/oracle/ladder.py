"""The ladder: every level in turn, the cheap ones first."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache, partial

from restir_gi.reference.oracle.backends.backend import Backend
from restir_gi.reference.oracle.backends.selected import (
    SelectedBackend,
    Selection,
    lacks,
    selected,
    selection_of,
)
from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.contract.fields import Passes, Precision
from restir_gi.reference.oracle.contract.passes import BORDER, SEARCH, VISIBILITY
from restir_gi.reference.oracle.contract.surfaces import SURFACE
from restir_gi.reference.oracle.contract.targets import DATA
from restir_gi.reference.oracle.contract.weights import MIS
from restir_gi.reference.oracle.diagnosis.hypothesis import Departure
from restir_gi.reference.oracle.frames import frame_cases
from restir_gi.reference.oracle.levels.declared import (
    declared_kernel_probes,
    declared_row_probes,
)
from restir_gi.reference.oracle.levels.distribution import SCENES as DISTRIBUTION_SCENES
from restir_gi.reference.oracle.levels.distribution import same_distribution
from restir_gi.reference.oracle.levels.fitted import fitted, fitted_probes
from restir_gi.reference.oracle.levels.given_targets import given_target_probes
from restir_gi.reference.oracle.levels.grades import graded
from restir_gi.reference.oracle.levels.kernels import kernel_probes
from restir_gi.reference.oracle.levels.lattice import lattice_step
from restir_gi.reference.oracle.levels.means import Batches, Mean, mean_over_runs
from restir_gi.reference.oracle.levels.probe import Finding, Probe
from restir_gi.reference.oracle.levels.relations import relations_of
from restir_gi.reference.oracle.levels.replayed import replayed
from restir_gi.reference.oracle.levels.rows import neighbor_row_probes, row_probes
from restir_gi.reference.oracle.levels.spheres import (
    LONG,
    furnace,
    half_lit,
    long_furnace,
    long_half_lit,
    long_run,
)
from restir_gi.reference.oracle.levels.surfaces import SCENE as SURFACE_SCENE
from restir_gi.reference.oracle.levels.surfaces import (
    surface_kernel_probes,
    surface_row_probes,
    surface_scene_probes,
)
from restir_gi.reference.oracle.levels.weights import weight_row_probes
from restir_gi.reference.oracle.loop import Ask, LoopFrame, Run
from restir_gi.reference.oracle.parts import SEED, Frames, Part, no_frames, parts
from restir_gi.reference.oracle.prepared_frame import SCENES, prepare_frame
from restir_gi.reference.oracle.steps import (
    Level,
    LevelStep,
    MeasuredBias,
    asked,
    taken,
)
from restir_gi.reference.scene.catalogue.registry import find_scene

SIZE = 48

SUMS_OF_M: tuple[Departure, ...] = ("target", "mis", "domain", "storage")
"""Under which a pixel inside a sphere is no mean of what was met, weighted with M: that
needs p̂ = f, weights that divide by sums of M, all samples shifted, and kept as they
are."""

THE_MEAN: tuple[Departure, ...] = (*SUMS_OF_M, "bias")
"""Under which nothing is proved of the mean inside a sphere."""

SAME_NUMBERS: tuple[Departure, ...] = (
    "confidence",
    *THE_MEAN,
    "visibility",
)
"""Under which the distribution of the estimate is another one, or M is."""

LOOP = ("direction", "temporal", "spatial", "shade")
"""Passes of the frame loop of the spheres and of whole runs."""

FRAME = (
    *("direction", "initial", "temporal", "moved", "neighbors", "spatial", "fused"),
    "shade",
)
"""Passes that are asked about frames of scenes."""


QUICK = frozenset(
    {
        "designed rows",
        "declared settings",
        "declared surfaces",
        "declared weights",
        "targets as data",
    }
)
"""Steps of level L3 that are quick: rows without a scene."""


def quick_levels(levels: Iterator[Level], left_out: list[str]) -> Iterator[Level]:
    """Those that are quick: single calls of kernels, lattices and designed rows.

    Parameters
    ----------
    left_out : list of str; the titles of the others are put into it
    """
    titles = QUICK | {part.title for part in parts()}
    for level, title, take in levels:
        if level in ("L0", "L1") or (level == "L3" and title in titles):
            yield level, title, take
        else:
            left_out.append(f"{level} {title}")


def ladder(
    passes: Passes, backend: Backend, seed: int = SEED, frames: bool = True
) -> Iterator[Level]:
    """Levels of a backend that can be asked.

    Parameters
    ----------
    seed : int; of all rows that are random
    frames : bool; whether parts make frames of scenes, which takes long

    Yields
    ------
    level, title : str; of the next step
    callable; takes it
    """
    backend, precision = selected(backend), backend.precision
    of_one_case = backend.selection.case is not None
    surfaces = backend.selection.declares(SURFACE.name)

    def level_of(
        level: str, title: str, probes: Callable[[], Sequence[Probe]]
    ) -> Level:
        def take() -> LevelStep:
            fit = fitted_probes(probes(), backend.selection)
            return asked(level, title, passes, backend, fit)

        return level, title, take

    questions = [
        (part, _probes_of(part, backend, seed))
        for part in parts()
        if not backend.lacks(*(one.name for one in part.passes))
    ]

    def of_parts(level: str) -> Iterator[Level]:
        for part, probes in questions:
            chosen = [probe for probe in probes if probe.level == level]
            if chosen:
                more = part.frames if frames and level == "L3" else no_frames
                about = level, part.title, chosen, more, seed
                take = partial(_asked_of_part, passes, backend, *about)
                yield level, part.title, take

    yield level_of("L0", "kernels", partial(kernel_probes, precision, seed))
    if backend.selection.declares(VISIBILITY.name):
        of_declared = partial(declared_kernel_probes, precision, seed)
        yield level_of("L0", "declared settings", of_declared)
    if surfaces:
        of_kernels = partial(surface_kernel_probes, precision, seed)
        yield level_of("L0", "declared surfaces", of_kernels)
    yield from of_parts("L0")
    yield "L1", "lattices", partial(lattice_step, passes, backend)
    yield from of_parts("L1")
    if not of_one_case and not backend.lacks(*LOOP):
        yield "L2", "spheres", partial(_spheres, passes, backend)
        yield from _long_spheres(passes, backend)
    if not of_one_case and not backend.lacks(*FRAME):
        yield "L2", "relations", partial(_relations, passes, backend, seed)
    yield from of_parts("L2")
    if not backend.lacks(*FRAME):
        yield level_of("L3", "designed rows", partial(row_probes, precision, seed))
        counts = backend.selection.designed_neighbors
        around = partial(neighbor_row_probes, precision, seed, counts)
        yield level_of("L3", "numbers of neighbours", around)
    if any(map(backend.selection.declares, (SEARCH.name, BORDER.name))):
        of_declared = partial(declared_row_probes, precision, seed)
        yield level_of("L3", "declared settings", of_declared)
    if surfaces:
        of_rows = partial(surface_row_probes, precision, seed)
        of_scene = partial(surface_scene_probes, precision, seed)
        yield level_of("L3", "declared surfaces", of_rows)
        yield level_of("L3", SURFACE_SCENE, of_scene)
    if backend.selection.declares(MIS.name):
        of_rows = partial(weight_row_probes, precision, seed)
        yield level_of("L3", "declared weights", of_rows)
    if DATA in (word for *_, word in backend.selection.more):
        of_rows = partial(given_target_probes, precision, seed)
        yield level_of("L3", "targets as data", of_rows)
    for scene in SCENES if not backend.lacks(*FRAME) else ():
        yield level_of("L3", scene, partial(scene_probes, scene, precision, seed))
    yield from of_parts("L3")


def _probes_of(part: Part, backend: SelectedBackend, seed: int) -> list[Probe]:
    """Probes of a part, and those of values that have to be declared, if any are."""
    found = part.probes(backend.precision, seed)
    if not backend.selection.more:
        return found
    return found + part.more(backend.precision, seed)


def _asked_of_part(
    passes: Passes,
    backend: Backend,
    level: str,
    title: str,
    probes: list[Probe],
    frames: Frames,
    seed: int,
) -> LevelStep:
    """A step of a part: frames are made for a backend that has the passes alone."""
    step = asked(level, title, passes, backend, probes)
    names = {a.probe.case.pass_name for a in step.answers if a.finding is not None}
    more = frames(backend.precision, frozenset(names), seed)
    if not more:
        return step
    rest = asked(level, title, passes, backend, more)
    return replace(
        step,
        answers=step.answers + rest.answers,
        unasked=step.unasked + rest.unasked,
    )


def statistical_levels(
    passes: Passes,
    backend: Backend,
    remaining: Callable[[], float],
    batches: Batches | None = None,
    distributions: Mapping[str, Callable[[], LevelStep]] | None = None,
) -> Iterator[Level]:
    """Levels of whole runs, which take as long as they may.

    Parameters
    ----------
    remaining : callable; seconds that are left
    batches : callable, optional
        From the seed of a batch to its replicates and those of the seeds after it, by
        other processes; the first batch is made here.
    distributions : mapping of str to callable, optional
        What takes the step of each scene in another process.

    Yields
    ------
    level, title : str; of the next step
    callable; takes it
    """
    if lacks(backend, LOOP):
        return
    yield from _means(passes, backend, remaining, batches)
    for scene in DISTRIBUTION_SCENES:
        here = partial(distribution_step, passes, backend, scene)
        yield (
            "L4",
            f"distribution in {scene}",
            distributions[scene] if distributions else here,
        )


def golden_levels(
    passes: Passes, backend: Backend, probes: list[Probe]
) -> Iterator[Level]:
    """Levels of a golden folder.

    Parameters
    ----------
    backend : Backend; runs its cases, or has run them

    Yields
    ------
    level, title : str; of the next step
    callable; takes it
    """
    for level in sorted({probe.level for probe in probes}):
        chosen = [probe for probe in probes if probe.level == level]

        def take(level: str = level, chosen: list[Probe] = chosen) -> LevelStep:
            return asked(level, "golden", passes, backend, chosen)

        yield level, "golden", take


# The same frame for every backend.
@lru_cache(maxsize=16)
def scene_probes(
    scene: str, precision: Precision, seed: int = SEED
) -> tuple[Probe, ...]:
    """Replays of all passes in a frame of a scene, of level L3.

    Parameters
    ----------
    scene : str; built-in, of diffuse surfaces alone
    """
    at = prepare_frame(find_scene(scene), SIZE, seed)
    return tuple(replayed("L3", case) for case in frame_cases(at, precision))


def run_of(selection: Selection) -> Run:
    """Whole runs of a backend, as it has the passes."""
    usual = Run()
    spatial = Case("loop-spatial", "spatial", {"target": usual.target}, {})
    return Run(
        target=DATA if selection.takes_targets(spatial) else usual.target,
        mis=selection.mis,
        temporal_mis=selection.temporal_mis,
        neighbors=selection.neighbors,
        history=selection.history,
    )


def _spheres(passes: Passes, backend: Backend) -> LevelStep:
    precision, run = backend.precision, run_of(selection_of(backend))
    spheres = (furnace, half_lit) if run.counts else (furnace,)
    tests = [partial(test, precision=precision, run=run) for test in spheres]
    return taken("L2", "spheres", passes, backend, tests, THE_MEAN)


def _long_spheres(passes: Passes, backend: Backend) -> Iterator[Level]:
    """Two steps of one run, of which the second relies on how M is capped as well."""
    like, run = run_of(selection_of(backend)), list[list[LoopFrame]]()
    titles = [
        f"{sphere} of {LONG.frames} frames" for sphere in ("furnace", "half-lit sphere")
    ]

    def furnace_of_run(ask: Ask) -> Finding:
        run.append(long_run(ask, backend.precision, like))
        return long_furnace(run[0], backend.precision)

    def take_furnace() -> LevelStep:
        return taken("L2", titles[0], passes, backend, [furnace_of_run], THE_MEAN)

    def take_half_lit() -> LevelStep:
        findings = [long_half_lit(frames, backend.precision, like) for frames in run]
        relies_on: tuple[Departure, ...] = ("confidence", *THE_MEAN)
        return LevelStep("L2", titles[1], findings=findings, relies_on=relies_on)

    yield "L2", titles[0], take_furnace
    if like.counts:
        yield "L2", titles[1], take_half_lit


def _relations(passes: Passes, backend: SelectedBackend, seed: int) -> LevelStep:
    at = prepare_frame(find_scene(SCENES[0]), SIZE // 2, seed)
    # One by one: what a first test shows to be missing is not asked again.
    tests = (
        test
        for case in frame_cases(at, backend.precision)
        for test in relations_of(graded(fitted(case, backend.selection)))
        if not backend.lacks(case.pass_name)
    )
    departures: tuple[Departure, ...] = ("confidence", "target", "storage", "bias")
    return taken("L2", "relations", passes, backend, tests, departures)


def _means(
    passes: Passes,
    backend: Backend,
    remaining: Callable[[], float],
    batches: Batches | None,
) -> Iterator[Level]:
    """Two steps of the same runs; the second stands in where the bound is void."""
    found, run = list[Mean](), run_of(selection_of(backend))

    def test(ask: Ask) -> Finding:
        about = backend.precision, remaining, batches
        found.append(mean_over_runs(ask, *about, like=run))
        return found[0].finding

    def take_bets() -> LevelStep:
        step = taken("L4", "mean", passes, backend, [test], THE_MEAN)
        for mean in found:
            step = replace(
                step,
                title=f"mean of {mean.runs} runs",
                certified=mean.certified,
                more=mean.more,
                measured=MeasuredBias(mean.off, mean.error, mean.runs),
            )
        return step

    def take_variance() -> LevelStep:
        return LevelStep(
            "L4",
            "mean by its variance",
            findings=[mean.by_variance for mean in found],
            relies_on=("bias",),
            only_under=SUMS_OF_M,
        )

    yield "L4", "mean", take_bets
    yield "L4", "mean by its variance", take_variance


def distribution_step(passes: Passes, backend: Backend, scene: str) -> LevelStep:
    """Step of the distribution test in one scene, of level L4."""

    def test(ask: Ask) -> Finding:
        run = run_of(selection_of(backend))
        return same_distribution(ask, backend.precision, scene, like=run).finding

    title = f"distribution in {scene}"
    return taken("L4", title, passes, backend, [test], SAME_NUMBERS)

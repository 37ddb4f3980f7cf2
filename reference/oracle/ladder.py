"""The ladder: every level in turn, the cheap ones first."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache, partial

from restir_gi.reference.oracle.backends.backend import Backend
from restir_gi.reference.oracle.contract.fields import Passes, Precision
from restir_gi.reference.oracle.diagnosis.hypothesis import Departure
from restir_gi.reference.oracle.frames import frame_cases
from restir_gi.reference.oracle.levels.distribution import SCENES as DISTRIBUTION_SCENES
from restir_gi.reference.oracle.levels.distribution import same_distribution
from restir_gi.reference.oracle.levels.kernels import kernel_probes
from restir_gi.reference.oracle.levels.lattice import lattice_probes
from restir_gi.reference.oracle.levels.means import Batches, Mean, mean_over_runs
from restir_gi.reference.oracle.levels.probe import Finding, Probe
from restir_gi.reference.oracle.levels.relations import relations_of
from restir_gi.reference.oracle.levels.replayed import replayed
from restir_gi.reference.oracle.levels.spheres import furnace, half_lit
from restir_gi.reference.oracle.loop import Ask
from restir_gi.reference.oracle.parts import Frames, no_frames, parts
from restir_gi.reference.oracle.prepared_frame import SCENES, prepare_frame
from restir_gi.reference.oracle.steps import Level, LevelStep, asked, taken
from restir_gi.reference.scene.catalogue.registry import find_scene

SIZE, SEED = 48, 1


def ladder(passes: Passes, backend: Backend) -> Iterator[Level]:
    """Levels of a backend that can be asked.

    Yields
    ------
    level, title : str; of the next step
    callable; takes it
    """
    precision = backend.precision

    def level_of(
        level: str, title: str, probes: Callable[[], Sequence[Probe]]
    ) -> Level:
        return level, title, lambda: asked(level, title, passes, backend, probes())

    questions = [(part, part.probes(precision)) for part in parts()]

    def of_parts(level: str) -> Iterator[Level]:
        for part, probes in questions:
            chosen = [probe for probe in probes if probe.level == level]
            if chosen:
                more = part.frames if level == "L3" else no_frames
                about = level, part.title, chosen, more
                take = partial(_asked_of_part, passes, backend, *about)
                yield level, part.title, take

    yield level_of("L0", "kernels", partial(kernel_probes, precision))
    yield from of_parts("L0")
    yield level_of("L1", "lattices", partial(lattice_probes, precision))
    yield from of_parts("L1")
    yield "L2", "spheres", partial(_spheres, passes, backend)
    yield "L2", "relations", partial(_relations, passes, backend)
    yield from of_parts("L2")
    for scene in SCENES:
        yield level_of("L3", scene, partial(scene_probes, scene, precision))
    yield from of_parts("L3")


def _asked_of_part(
    passes: Passes,
    backend: Backend,
    level: str,
    title: str,
    probes: list[Probe],
    frames: Frames,
) -> LevelStep:
    """A step of a part: frames are made for a backend that has the passes alone."""
    step = asked(level, title, passes, backend, probes)
    names = {a.probe.case.pass_name for a in step.answers if a.finding is not None}
    more = frames(backend.precision, frozenset(names))
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
    yield "L4", "mean", partial(_mean, passes, backend, remaining, batches)
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


def _spheres(passes: Passes, backend: Backend) -> LevelStep:
    tests = [partial(test, precision=backend.precision) for test in (furnace, half_lit)]
    return taken("L2", "spheres", passes, backend, tests, ("target",))


def _relations(passes: Passes, backend: Backend) -> LevelStep:
    at = prepare_frame(find_scene(SCENES[0]), SIZE // 2, SEED)
    tests = [
        test
        for case in frame_cases(at, backend.precision)
        for test in relations_of(case)
    ]
    departures: tuple[Departure, ...] = ("confidence", "target")
    return taken("L2", "relations", passes, backend, tests, departures)


def _mean(
    passes: Passes,
    backend: Backend,
    remaining: Callable[[], float],
    batches: Batches | None,
) -> LevelStep:
    found: list[Mean] = []

    def test(ask: Ask) -> Finding:
        found.append(mean_over_runs(ask, backend.precision, remaining, batches))
        return found[0].finding

    step = taken("L4", "mean", passes, backend, [test], ("target",))
    if not found:
        return step
    title = f"mean of {found[0].runs} runs"
    return replace(step, title=title, certified=found[0].certified, more=found[0].more)


def distribution_step(passes: Passes, backend: Backend, scene: str) -> LevelStep:
    """Step of the distribution test in one scene, of level L4."""

    def test(ask: Ask) -> Finding:
        return same_distribution(ask, backend.precision, scene).finding

    departures: tuple[Departure, ...] = ("confidence", "target")
    return taken("L4", f"distribution in {scene}", passes, backend, [test], departures)

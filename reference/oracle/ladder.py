"""The ladder: every rung in turn, the cheap ones first."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache, partial

from reference.oracle.backends.backend import Backend
from reference.oracle.contract.fields import Passes, Precision
from reference.oracle.diagnosis.hypothesis import Departure
from reference.oracle.frames import frame_cases
from reference.oracle.loop import Ask
from reference.oracle.parts import Frames, no_frames, parts
from reference.oracle.rungs.kernels import kernel_probes
from reference.oracle.rungs.lattice import lattice_probes
from reference.oracle.rungs.law import SCENES as LAW_SCENES
from reference.oracle.rungs.law import same_law
from reference.oracle.rungs.means import Batches, Mean, mean_over_runs
from reference.oracle.rungs.probe import Finding, Probe
from reference.oracle.rungs.relations import relations_of
from reference.oracle.rungs.replayed import replayed
from reference.oracle.rungs.spheres import furnace, half_lit
from reference.oracle.stage import SCENES, stage
from reference.oracle.steps import Rung, Step, asked, taken
from reference.scene.catalogue.registry import find_scene

SIZE, SEED = 48, 1


def ladder(passes: Passes, backend: Backend) -> Iterator[Rung]:
    """Rungs of a backend that can be asked.

    Yields
    ------
    rung, title : str; of the next step
    callable; takes it
    """
    precision = backend.precision

    def rung_of(rung: str, title: str, probes: Callable[[], Sequence[Probe]]) -> Rung:
        return rung, title, lambda: asked(rung, title, passes, backend, probes())

    questions = [(part, part.probes(precision)) for part in parts()]

    def of_parts(rung: str) -> Iterator[Rung]:
        for part, probes in questions:
            chosen = [probe for probe in probes if probe.rung == rung]
            if chosen:
                more = part.frames if rung == "L3" else no_frames
                about = rung, part.title, chosen, more
                take = partial(_asked_of_part, passes, backend, *about)
                yield rung, part.title, take

    yield rung_of("L0", "kernels", partial(kernel_probes, precision))
    yield from of_parts("L0")
    yield rung_of("L1", "lattices", partial(lattice_probes, precision))
    yield from of_parts("L1")
    yield "L2", "spheres", partial(_spheres, passes, backend)
    yield "L2", "relations", partial(_relations, passes, backend)
    yield from of_parts("L2")
    for scene in SCENES:
        yield rung_of("L3", scene, partial(scene_probes, scene, precision))
    yield from of_parts("L3")


def _asked_of_part(
    passes: Passes,
    backend: Backend,
    rung: str,
    title: str,
    probes: list[Probe],
    frames: Frames,
) -> Step:
    """A step of a part: frames are made for a backend that has the passes alone."""
    step = asked(rung, title, passes, backend, probes)
    names = {a.probe.case.pass_name for a in step.answers if a.finding is not None}
    more = frames(backend.precision, frozenset(names))
    if not more:
        return step
    rest = asked(rung, title, passes, backend, more)
    return replace(
        step,
        answers=step.answers + rest.answers,
        unasked=step.unasked + rest.unasked,
    )


def statistical_rungs(
    passes: Passes,
    backend: Backend,
    remaining: Callable[[], float],
    batches: Batches | None = None,
    laws: Mapping[str, Callable[[], Step]] | None = None,
) -> Iterator[Rung]:
    """Rungs of whole runs, which take as long as they may.

    Parameters
    ----------
    remaining : callable; seconds that are left
    batches : callable, optional
        From the seed of a batch to its replicates and those of the seeds after it, by
        other processes; the first batch is made here.
    laws : mapping of str to callable, optional
        What takes the step of each scene elsewhere.

    Yields
    ------
    rung, title : str; of the next step
    callable; takes it
    """
    yield "L4", "mean", partial(_mean, passes, backend, remaining, batches)
    for scene in LAW_SCENES:
        here = partial(law_step, passes, backend, scene)
        yield "L4", f"law in {scene}", laws[scene] if laws else here


def golden_rungs(
    passes: Passes, backend: Backend, probes: list[Probe]
) -> Iterator[Rung]:
    """Rungs of a golden folder.

    Parameters
    ----------
    backend : Backend; runs its cases, or has run them

    Yields
    ------
    rung, title : str; of the next step
    callable; takes it
    """
    for rung in sorted({probe.rung for probe in probes}):
        chosen = [probe for probe in probes if probe.rung == rung]

        def take(rung: str = rung, chosen: list[Probe] = chosen) -> Step:
            return asked(rung, "golden", passes, backend, chosen)

        yield rung, "golden", take


# The same frame for every backend.
@lru_cache(maxsize=16)
def scene_probes(
    scene: str, precision: Precision, seed: int = SEED
) -> tuple[Probe, ...]:
    """Replays of all passes in a frame of a scene, of rung L3.

    Parameters
    ----------
    scene : str; built-in, of paint alone
    """
    at = stage(find_scene(scene), SIZE, seed)
    return tuple(replayed("L3", case) for case in frame_cases(at, precision))


def _spheres(passes: Passes, backend: Backend) -> Step:
    tests = [partial(test, precision=backend.precision) for test in (furnace, half_lit)]
    return taken("L2", "spheres", passes, backend, tests, ("target",))


def _relations(passes: Passes, backend: Backend) -> Step:
    at = stage(find_scene(SCENES[0]), SIZE // 2, SEED)
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
) -> Step:
    found: list[Mean] = []

    def test(ask: Ask) -> Finding:
        found.append(mean_over_runs(ask, backend.precision, remaining, batches))
        return found[0].finding

    step = taken("L4", "mean", passes, backend, [test], ("target",))
    if not found:
        return step
    title = f"mean of {found[0].runs} runs"
    return replace(step, title=title, certified=found[0].certified, more=found[0].more)


def law_step(passes: Passes, backend: Backend, scene: str) -> Step:
    """Step of the law in one scene, of rung L4."""

    def test(ask: Ask) -> Finding:
        return same_law(ask, backend.precision, scene).finding

    departures: tuple[Departure, ...] = ("confidence", "target")
    return taken("L4", f"law in {scene}", passes, backend, [test], departures)

"""The ladder: every rung in turn, the cheap ones first."""

from collections.abc import Callable, Iterator

from reference.oracle.backends.backend import Backend
from reference.oracle.contract.fields import Passes, Precision
from reference.oracle.frames import frame_cases
from reference.oracle.rungs.kernels import kernel_probes
from reference.oracle.rungs.lattice import lattice_probes
from reference.oracle.rungs.law import SCENES as LAW_SCENES
from reference.oracle.rungs.law import same_law
from reference.oracle.rungs.means import mean_over_runs
from reference.oracle.rungs.probe import Finding, Probe
from reference.oracle.rungs.relations import relations
from reference.oracle.rungs.replayed import replayed
from reference.oracle.rungs.spheres import furnace, half_lit
from reference.oracle.stage import SCENES, stage
from reference.oracle.steps import NoAnswer, Rung, Step, ask_all, asking
from reference.scene.catalogue.registry import find_scene

SIZE, SEED = 48, 1


def ladder(passes: Passes, backend: Backend) -> Iterator[Rung]:
    """Rungs of a backend that can be asked.

    Parameters
    ----------
    passes : mapping of str to Pass
        The contract.
    backend : Backend
        Runs cases.

    Yields
    ------
    rung, title : str
        Of the next step.
    callable
        Takes it.
    """
    precision = backend.precision

    def asked(rung: str, title: str, probes: Callable[[], list[Probe]]) -> Rung:
        return (
            rung,
            title,
            lambda: Step(rung, title, ask_all(passes, backend, probes())),
        )

    yield asked("L0", "kernels", lambda: kernel_probes(precision))
    yield asked("L1", "lattices", lambda: lattice_probes(precision))
    yield "L2", "spheres", lambda: _spheres(passes, backend)
    yield (
        "L2",
        "relations",
        lambda: _if_it_answers("L2", "relations", lambda: _relations(passes, backend)),
    )
    for scene in SCENES:
        yield asked("L3", scene, lambda scene=scene: scene_probes(scene, precision))  # type: ignore[misc]


def statistical_rungs(
    passes: Passes, backend: Backend, remaining: Callable[[], float]
) -> Iterator[Rung]:
    """Rungs of whole runs, which take as long as they may.

    Parameters
    ----------
    passes : mapping of str to Pass
        The contract.
    backend : Backend
        Runs cases.
    remaining : callable
        Seconds that are left.

    Yields
    ------
    rung, title : str
        Of the next step.
    callable
        Takes it.
    """
    ask, precision = asking(passes, backend), backend.precision

    def mean() -> Step:
        found = mean_over_runs(ask, precision, remaining)
        title = f"mean of {found.runs} runs"
        return Step("L4", title, [], [found.finding], found.certified, found.more)

    yield "L4", "mean", lambda: _if_it_answers("L4", "mean", mean)
    for scene in LAW_SCENES:

        def law(scene: str = scene) -> Step:
            found = same_law(ask, precision, scene)
            return Step("L4", f"law in {scene}", findings=[found.finding])

        title = f"law in {scene}"
        yield (
            "L4",
            title,
            lambda law=law, title=title: _if_it_answers(  # type: ignore[misc]
                "L4", title, law
            ),
        )


def _if_it_answers(rung: str, title: str, take: Callable[[], Step]) -> Step:
    try:
        return take()
    except NoAnswer as reason:
        return Step(rung, title, findings=[Finding(False, str(reason))])


def golden_rungs(
    passes: Passes, backend: Backend, probes: list[Probe]
) -> Iterator[Rung]:
    """Rungs of a golden folder.

    Parameters
    ----------
    passes : mapping of str to Pass
        The contract.
    backend : Backend
        Runs its cases, or has run them.
    probes : list of Probe
        As they stand in the folder.

    Yields
    ------
    rung, title : str
        Of the next step.
    callable
        Takes it.
    """
    for rung in sorted({probe.rung for probe in probes}):
        chosen = [probe for probe in probes if probe.rung == rung]

        def take(rung: str = rung, chosen: list[Probe] = chosen) -> Step:
            return Step(rung, "golden", ask_all(passes, backend, chosen))

        yield rung, "golden", take


def scene_probes(scene: str, precision: Precision) -> list[Probe]:
    """Replays of all passes in a frame of a scene.

    Parameters
    ----------
    scene : str
        Built-in, of paint alone.
    precision : 'float32' or 'float64'
        Of the backend.

    Returns
    -------
    list of Probe
        Of rung L3.
    """
    at = stage(find_scene(scene), SIZE, SEED)
    return [replayed("L3", case) for case in frame_cases(at, precision)]


def _relations(passes: Passes, backend: Backend) -> Step:
    at = stage(find_scene(SCENES[0]), SIZE // 2, SEED)
    cases = list(frame_cases(at, backend.precision))
    found = relations(asking(passes, backend), cases)
    return Step("L2", "relations", findings=found)


def _spheres(passes: Passes, backend: Backend) -> Step:
    ask = asking(passes, backend)
    found = []
    for test in (furnace, half_lit):
        try:
            found.append(test(ask, backend.precision))
        except NoAnswer as reason:
            found.append(Finding(False, str(reason)))
    return Step("L2", "spheres", findings=found)

"""An accumulation that survives Ctrl-C, kill, and power cuts."""

import time
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from restir_gi.reference.numerics.moments import no_samples
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.signals import Interrupted
from restir_gi.reference.transport.accumulate import Advance, in_batches
from restir_gi.reference.truth.checkpoint import (
    Checkpoint,
    load_checkpoint,
    save_checkpoint,
)


@dataclass(frozen=True, slots=True)
class SampleSource:
    """Where samples come from.

    Attributes
    ----------
    rows : int; pixels of the frame
    advance : callable; adds samples
    rays : callable
        Tells how many rays were traced so far, by kind: before the first sample those
        that all samples share.
    """

    rows: int
    advance: Advance
    rays: Callable[[], Mapping[str, int]]


def accumulate_resumably(
    source: SampleSource,
    spp: int,
    path: Path,
    run: Mapping[str, str],
    every: float,
    tick: Callable[[int], None],
) -> Checkpoint:
    """Accumulate from where the last run of the same kind was cut off.

    Its moments have ``spp`` samples, bit-identical to those of a run that was never cut
    off.

    Raises UsageError: the checkpoint there is of another run, damaged, has more samples
    than are asked for, or cannot be written.
    Raises Interrupted by Ctrl-C or SIGTERM, after the state was written.

    Parameters
    ----------
    spp : int; samples in the end
    path : Path
        Of the checkpoint.  It is left in place, complete in the end: whoever has
        written the result may delete it.
    run : mapping of str to str
        Everything that decides what a sample of a given number is.
    every : float, s; time between two checkpoints: what a kill may cost
    tick : callable; told the number of samples so far
    """
    state = load_checkpoint(path, run)
    if state is None:
        state = Checkpoint(no_samples(source.rows), 0.0, {})
    if len(state.moments.mean) != source.rows:
        raise UsageError(f"{path} is damaged; delete it to start over")
    if state.moments.count > spp:
        raise UsageError(
            f"{path} has {state.moments.count} samples already, more than --spp {spp};"
            " ask for at least as many, or delete it"
        )
    before, start = state, time.perf_counter()
    # Rays that all samples share are traced again, and counted once.
    again = Counter(source.rays()) if state.moments.count else Counter[str]()
    last = start if state.moments.count else 0.0  # the first state tests the disk
    saved = state
    tick(state.moments.count)
    try:
        for moments in in_batches(source.advance, state.moments, spp):
            spent = before.seconds + time.perf_counter() - start
            rays = Counter(before.rays) + (Counter(source.rays()) - again)
            state = Checkpoint(moments, spent, rays)
            tick(moments.count)
            if time.perf_counter() - last >= every or moments.count == spp:
                save_checkpoint(path, run, state)
                saved, last = state, time.perf_counter()
    except KeyboardInterrupt as stop:
        if state is not saved:
            save_checkpoint(path, run, state)
        raise Interrupted(
            _what_is_left(path, state.moments.count, spp),
            getattr(stop, "terminated", False),
        ) from None
    return state


def _what_is_left(path: Path, count: int, spp: int) -> str:
    if count == 0:
        return "interrupted before the first sample was complete; nothing was written"
    return (
        f"interrupted; {count} of {spp} samples are kept in {path}, and the same"
        " command goes on from there"
    )

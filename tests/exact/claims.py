"""What the kernels are claimed to do, each claim as a generator of the faults it finds.

``code`` is the production kernels or a mutant of them.  A fault is a line of text that
names pixel and cell; none at all is a proof on the toy domain, for every integrand at
once: E[W 1{y = x}] = mu_q(x) for every x that q sees and can reflect.
"""

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from tests.exact.domain import CELLS, HOLDS, MU, PIXELS
from tests.exact.explore import ONE, Law, explore

TRUST = (1, 3, 2)
"""Confidences of the three pixels: M is trust, so any constants must do."""


@dataclass(frozen=True, slots=True)
class Frame:
    """Reservoirs of three pixels, one row an outcome."""

    r0: Any
    r1: Any
    r2: Any

    def at(self, i):
        """Reservoirs of pixel i."""
        return (self.r0, self.r1, self.r2)[i]


NOWHERE = Law(np.array([None], object), np.array([ONE]))
"""Before the first frame: one outcome."""


def contributions(law, reservoirs):
    """E[W 1{y = x}] for every cell x."""
    weighted = law.probability * reservoirs.W
    return [sum(weighted[reservoirs.y == x], Fraction(0)) for x in CELLS]


def faults(i, found, expected, what=""):
    """Cells of pixel i where the contribution is not what it should be."""
    return [
        f"{what} pixel {i}, cell {x}: {a} instead of {b}"
        for x, (a, b) in enumerate(zip(found, expected, strict=True))
        if a != b
    ]


def wrong_confidence(law, expected):
    """Values that M takes although it has only one: M does not look at samples."""
    found = set(law.outcomes.M) - {expected}
    return [f"M is {value} instead of {expected}" for value in found]


def truth(i):
    """mu_i(x), and 0 where pixel i receives nothing from x."""
    return [MU[i][x] if HOLDS[i][x] else Fraction(0) for x in CELLS]


# ---------------------------------------------------------------- programs


def fresh_frame(code):
    """Law of three closed reservoirs with one sample each; M as in TRUST."""
    run, k = code.pipeline, code.reservoir

    def program(rows, uniform):
        new = [run.initial(code, i, uniform) for i in PIXELS]
        closed = [k.finalize(c, c.M) for c in new]
        return Frame(*(run.trust(r, M) for r, M in zip(closed, TRUST, strict=True)))

    return explore(program, NOWHERE)


def own_first(i, frame):
    """Donors of pixel i: itself, then the others."""
    return [(j, frame.at(j)) for j in (i, *(j for j in PIXELS if j != i))]


def resampled(code, frames, i, **settings):
    """Law of pixel i's reservoir after a spatial pass."""

    def program(frame, uniform):
        return code.pipeline.spatial(code, i, own_first(i, frame), uniform, **settings)

    return explore(program, frames)


def spatial_contributions(code, i, **settings):
    """E[W 1{y = x}] after one spatial pass over fresh samples."""
    law = resampled(code, fresh_frame(code), i, **settings)
    return contributions(law, law.outcomes)


# ---------------------------------------------------------------- claims


def several_candidates(code, count=3):
    """Resampled importance sampling: several candidates of one pixel, 1/M."""
    run, k = code.pipeline, code.reservoir
    for i in PIXELS:

        def program(rows, uniform, i=i):
            kept = run.initial(code, i, uniform)
            for _ in range(count - 1):
                kept = k.merge(kept, run.initial(code, i, uniform), uniform())
            return k.finalize(kept, kept.M)

        law = explore(program, NOWHERE)
        yield from faults(i, contributions(law, law.outcomes), truth(i))
        yield from wrong_confidence(law, count)


def temporal_chain(code, cap=2, frames=4, i=1):
    """Algorithm 3 over more frames than the cap, right after each of them."""
    run = code.pipeline
    law = NOWHERE
    for t in range(frames):

        def program(rows, uniform, first=(t == 0)):
            new = run.initial(code, i, uniform)
            return run.temporal(code, i, None if first else rows, new, cap, uniform)

        law = explore(program, law)
        what = f"frame {t},"
        yield from faults(i, contributions(law, law.outcomes), truth(i), what)
        yield from wrong_confidence(law, min(t + 1, cap))


def spatial_pass(code, **settings):
    """Algorithm 4 once over independent inputs, at every pixel."""
    frames = fresh_frame(code)
    for i in PIXELS:
        law = resampled(code, frames, i, **settings)
        yield from faults(i, contributions(law, law.outcomes), truth(i))
        yield from wrong_confidence(law, sum(TRUST))


def balance_pass(code):
    """The same with the generalized balance heuristic."""
    yield from spatial_pass(code, mis="balance")


def pairwise_pass(code):
    """The same with weights in pairs."""
    yield from spatial_pass(code, mis="pairwise")


def defensive_pass(code):
    """The same with weights in pairs, and a share for the canonical sample."""
    yield from spatial_pass(code, mis="defensive")


def pass_with_late_visibility(code):
    """The same where only the sample that was kept is tested for visibility."""
    yield from spatial_pass(code, visibility="chosen")


def pass_with_mirrored_limit(code):
    """The same where shifts with a large Jacobian are rejected, mirrored in Z."""
    yield from spatial_pass(code, limit=Fraction(2))


def two_passes(code, mis="1/Z"):
    """A second pass over the outputs of the first, which share their inputs."""

    def first_pass(frame, uniform):
        spatial = code.pipeline.spatial
        return Frame(
            *(spatial(code, i, own_first(i, frame), uniform, mis=mis) for i in PIXELS)
        )

    frames = explore(first_pass, fresh_frame(code))
    law = resampled(code, frames, 1, mis=mis)
    yield from faults(1, contributions(law, law.outcomes), truth(1))


def loop_of_two_frames(code, mis="1/Z", cap=2):
    """The frame loop of two pixels: temporal and spatial reservoirs, both reused."""
    run = code.pipeline
    pair = (1, 2)

    def spatial(i, frame, spatial_before, uniform):
        history = [] if spatial_before is None else [(i, spatial_before)]
        other = pair[1 - pair.index(i)]
        donors = [*history, (i, frame.at(i)), (other, frame.at(other))]
        return run.spatial(code, i, donors, uniform, mis=mis, cap=cap)

    def first(rows, uniform):
        new = {i: run.initial(code, i, uniform) for i in pair}
        at = [run.temporal(code, i, None, new[i], cap, uniform) for i in pair]
        kept = spatial(1, Frame(None, *at), None, uniform)
        return Frame(kept, *at)

    def second(last, uniform):
        new = {i: run.initial(code, i, uniform) for i in pair}
        at = [run.temporal(code, i, last.at(i), new[i], cap, uniform) for i in pair]
        return spatial(1, Frame(None, *at), last.r0, uniform)

    law = explore(second, explore(first, NOWHERE))
    yield from faults(1, contributions(law, law.outcomes), truth(1))


def one_law_of_all_associations(code):
    """(y, p̂, w, M) has one law for ((a b) c) d, (a b)(c d) and a (b (c d))."""
    run, k = code.pipeline, code.reservoir

    def candidates(uniform):
        return [run.initial(code, i, uniform) for i in (1, 2, 1, 2)]

    def left(rows, uniform):
        a, b, c, d = candidates(uniform)
        u, v, w = uniform(), uniform(), uniform()
        return k.merge(k.merge(k.merge(a, b, u), c, v), d, w)

    def paired(rows, uniform):
        a, b, c, d = candidates(uniform)
        u, v, w = uniform(), uniform(), uniform()
        return k.merge(k.merge(a, b, u), k.merge(c, d, v), w)

    def right(rows, uniform):
        a, b, c, d = candidates(uniform)
        u, v, w = uniform(), uniform(), uniform()
        return k.merge(a, k.merge(b, k.merge(c, d, u), v), w)

    first, second, third = (
        explore(program, NOWHERE).as_dict() for program in (left, paired, right)
    )
    if not first == second == third:
        yield "the law of merged candidates depends on the order"

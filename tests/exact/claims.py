"""What the passes and kernels are claimed to do, each as a generator of its faults.

A fault is a line of text that names pixel and cell; none at all is a proof on the toy
domain, for every integrand at once: E[W 1{y = x}] = mu_q(x) for every x that q sees and
can reflect.
"""

from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np

from restir_gi.reference.resampling import reservoir
from restir_gi.reference.settings import Settings
from tests.exact import pages
from tests.exact.domain import CELLS, HOLDS, MU, PIXELS
from tests.exact.explore import ONE, Law, explore
from tests.exact.pages import closed, drawn, on_the_domain, trust

TRUST = (1, 3, 2)
"""Confidences of the three pixels: M is trust, so any constants must do."""

PAST = 4
"""Confidence of what the last frame left."""


@dataclass(frozen=True, slots=True)
class ToyFrame:
    """Reservoirs of three pixels, one row an outcome."""

    r0: Any
    r1: Any
    r2: Any

    def at(self, i):
        """Reservoirs of pixel i."""
        return (self.r0, self.r1, self.r2)[i]

    def around(self, i):
        """Those of the others, by their number."""
        return {j: self.at(j) for j in PIXELS if j != i}


NOWHERE = Law(np.array([None], object), np.array([ONE]))
"""Before the first frame: one outcome."""


def explored(program, start):
    """Law of a program that runs passes."""
    with on_the_domain():
        return explore(program, start)


def contributions(law, kept):
    """E[W 1{y = x}] for every cell x."""
    weighted = law.probability * kept.W
    return [sum(weighted[kept.cell == x], Fraction(0)) for x in CELLS]


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


def candidate(i, uniform):
    """Algorithm 2 at pixel i, about to compete."""
    new = drawn(i, uniform)
    p_hat = pages.NOW.p_hat[i, new.y.cell]
    return reservoir.initial_candidates(new.y, p_hat, new.pdf, new.M)


def alone(i, uniform):
    """One new sample, closed."""
    c = candidate(i, uniform)
    return closed(reservoir.finalize(c, c.M))


def fresh_frame():
    """Law of three closed reservoirs with one sample each; M as in TRUST."""

    def program(rows, uniform):
        kept = [alone(i, uniform) for i in PIXELS]
        return ToyFrame(*(trust(r, M) for r, M in zip(kept, TRUST, strict=True)))

    return explored(program, NOWHERE)


def spatial_law(frames, i, largest=None, **settings):
    """Law of pixel i's reservoir after a spatial pass without a past."""

    def program(frame, uniform):
        own, others, s = frame.at(i), frame.around(i), Settings(**settings)
        return pages.spatial(i, None, own, others, uniform, settings=s, largest=largest)

    return explored(program, frames)


def spatial_contributions(i, **settings):
    """E[W 1{y = x}] after one spatial pass over fresh samples."""
    law = spatial_law(fresh_frame(), i, **settings)
    return contributions(law, law.outcomes)


# ---------------------------------------------------------------- claims


def several_candidates(count=3):
    """Resampled importance sampling: several candidates of one pixel, 1/M."""
    for i in PIXELS:

        def program(rows, uniform, i=i):
            kept = candidate(i, uniform)
            for _ in range(count - 1):
                kept = reservoir.merge(kept, candidate(i, uniform), uniform())
            return closed(reservoir.finalize(kept, kept.M))

        law = explored(program, NOWHERE)
        yield from faults(i, contributions(law, law.outcomes), truth(i))
        yield from wrong_confidence(law, count)


def temporal_chain(cap=2, frames=4, i=1, mis="1/Z"):
    """Algorithm 3 over more frames than the cap, right after each of them."""
    law = NOWHERE
    for t in range(frames):

        def program(rows, uniform, first=(t == 0)):
            past = None if first else rows
            return pages.temporal(i, past, uniform, cap, Settings(mis=mis))

        law = explored(program, law)
        what = f"frame {t},"
        yield from faults(i, contributions(law, law.outcomes), truth(i), what)
        yield from wrong_confidence(law, min(t + 1, cap))


def spatial_pass(**settings):
    """Algorithm 4 once over independent inputs, at every pixel."""
    frames = fresh_frame()
    for i in PIXELS:
        law = spatial_law(frames, i, **settings)
        yield from faults(i, contributions(law, law.outcomes), truth(i))
        yield from wrong_confidence(law, sum(TRUST))


def balance_pass():
    """The same with the generalized balance heuristic."""
    yield from spatial_pass(mis="balance")


def pairwise_pass():
    """The same with weights in pairs."""
    yield from spatial_pass(mis="pairwise")


def defensive_pass():
    """The same with weights in pairs, and a share for the canonical sample."""
    yield from spatial_pass(mis="defensive")


def pass_with_late_visibility(mis="1/Z"):
    """The same where only the sample that was kept is tested for visibility."""
    yield from spatial_pass(visibility="chosen", mis=mis)


def pass_with_mirrored_limit(mis="1/Z"):
    """The same where shifts with a large Jacobian are refused, mirrored in Z."""
    yield from spatial_pass(largest=Fraction(2), mis=mis)


def balance_pass_with_mirrored_limit():
    """The same with the balance heuristic, whose targets are 0 beyond the limit."""
    yield from pass_with_mirrored_limit("balance")


def two_passes(mis="1/Z"):
    """A second pass over the outputs of the first, which share their inputs."""
    s = Settings(mis=mis)

    def first_pass(frame, uniform):
        given = [(i, None, frame.at(i), frame.around(i)) for i in PIXELS]
        return ToyFrame(*(pages.spatial(*g, uniform, settings=s) for g in given))

    law = spatial_law(explored(first_pass, fresh_frame()), 1, mis=mis)
    yield from faults(1, contributions(law, law.outcomes), truth(1))


def loop_of_two_frames(mis="1/Z", cap=2):
    """The frame loop of two pixels: temporal and spatial reservoirs, both reused."""
    s = Settings(mis=mis)

    def temporal(i, past, uniform):
        return pages.temporal(i, past, uniform, cap, s)

    def first(rows, uniform):
        own, other = (temporal(i, None, uniform) for i in (1, 2))
        kept = pages.spatial(1, None, own, {2: other}, uniform, cap, s)
        return ToyFrame(kept, own, other)

    def second(last, uniform):
        own, other = (temporal(i, last.at(i), uniform) for i in (1, 2))
        return pages.spatial(1, last.r0, own, {2: other}, uniform, cap, s)

    law = explored(second, explored(first, NOWHERE))
    yield from faults(1, contributions(law, law.outcomes), truth(1))
    yield from wrong_confidence(law, cap)


def fused_pass(mis="1/Z", visibility="all"):
    """A new sample, the pixel's past, and another of the last frame, in one pass."""
    s = Settings(mis=mis, visibility=visibility, reuse="fused")
    for i in PIXELS:
        j = (i + 1) % len(PIXELS)

        def program(rows, uniform, i=i, j=j):
            past, other = (trust(alone(k, uniform), TRUST[k]) for k in (i, j))
            return pages.fused(i, past, {j: other}, uniform, s)

        law = explored(program, NOWHERE)
        yield from faults(i, contributions(law, law.outcomes), truth(i))
        yield from wrong_confidence(law, TRUST[i] + TRUST[j] + 1)


# ---------------------------------------------------------------- after a change


def frame_ago(uniform):
    """What pixel 0 kept before something moved."""
    return trust(pages.drawn_then(uniform), PAST)


def moved_temporal_law(i, **settings):
    """Law of pixel i, which goes on from pixel 0 of a frame ago."""

    def program(rows, uniform):
        past, s = frame_ago(uniform), Settings(**settings)
        return pages.temporal(i, past, uniform, settings=s, then=True)

    return explored(program, NOWHERE)


def moved_temporal_pass(**settings):
    """Algorithm 3 where something has moved: J, visibility and Z of the past."""
    for i in PIXELS:
        law = moved_temporal_law(i, **settings)
        yield from faults(i, contributions(law, law.outcomes), truth(i))
        yield from wrong_confidence(law, PAST + 1)


def moved_balance_pass():
    """The same with the generalized balance heuristic."""
    yield from moved_temporal_pass(mis="balance")


def moved_spatial_pass(**settings):
    """Algorithm 4 where something has moved: a past of then, neighbours of now."""
    for i in PIXELS:
        j = (i + 1) % len(PIXELS)

        def program(rows, uniform, i=i, j=j):
            past = frame_ago(uniform)
            own, other = (trust(alone(k, uniform), TRUST[k]) for k in (i, j))
            s = Settings(**settings)
            return pages.spatial(
                i, past, own, {j: other}, uniform, settings=s, then=True
            )

        law = explored(program, NOWHERE)
        yield from faults(i, contributions(law, law.outcomes), truth(i))
        yield from wrong_confidence(law, PAST + TRUST[i] + TRUST[j])


def moved_sources_pass(**settings):
    """Pass ``fused`` of the contract: own reservoirs, and two of a frame ago."""
    for i in PIXELS:

        def program(rows, uniform, i=i):
            own = trust(alone(i, uniform), TRUST[i])
            past = [frame_ago(uniform) for _ in range(2)]
            return pages.of_the_past(i, own, past, uniform, Settings(**settings))

        law = explored(program, NOWHERE)
        yield from faults(i, contributions(law, law.outcomes), truth(i))
        yield from wrong_confidence(law, TRUST[i] + 2 * PAST)


def moved_fused_pass(**settings):
    """All reuse in one pass, where something has moved."""
    s = Settings(reuse="fused", **settings)
    for i in PIXELS:

        def program(rows, uniform, i=i):
            past = [frame_ago(uniform) for _ in range(2)]
            return pages.fused(i, past[0], {0: past[1]}, uniform, s, then=True)

        law = explored(program, NOWHERE)
        yield from faults(i, contributions(law, law.outcomes), truth(i))
        yield from wrong_confidence(law, 2 * PAST + 1)


def one_law_of_all_associations():
    """(y, p̂, w, M) has one law for ((a b) c) d, (a b)(c d) and a (b (c d))."""
    merge = reservoir.merge

    def candidates(uniform):
        return [cells_of(candidate(i, uniform)) for i in (1, 2, 1, 2)]

    def cells_of(c):
        return replace(c, y=c.y.cell)

    def left(rows, uniform):
        a, b, c, d = candidates(uniform)
        u, v, w = uniform(), uniform(), uniform()
        return merge(merge(merge(a, b, u), c, v), d, w)

    def paired(rows, uniform):
        a, b, c, d = candidates(uniform)
        u, v, w = uniform(), uniform(), uniform()
        return merge(merge(a, b, u), merge(c, d, v), w)

    def right(rows, uniform):
        a, b, c, d = candidates(uniform)
        u, v, w = uniform(), uniform(), uniform()
        return merge(a, merge(b, merge(c, d, u), v), w)

    first, second, third = (
        explore(program, NOWHERE).as_dict() for program in (left, paired, right)
    )
    if not first == second == third:
        yield "the law of merged candidates depends on the order"

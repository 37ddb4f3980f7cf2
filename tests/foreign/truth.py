"""Whether a backend is biased: every outcome of a small world, every decision of it.

What a pass is given is drawn: which patch, or nothing, each reservoir holds.  All
outcomes go through the backend's own passes, and all its random numbers are integrated:
an answer changes with a number u at thresholds, which are found by bisection of the
answers themselves, whatever the backend does with u.  A pass is unbiased if

    E[W 1{y = x} | M] = mu(x) for each patch x that the pixel holds, 0 for others,

for each M that it may give, as M is what later passes weigh a reservoir by.  Nothing of
the project is used: neither its passes nor its oracle.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np

from tests.foreign.world import (
    BEFORE,
    EYE,
    LEFT,
    NULL,
    OUTCOMES,
    RECEIVER,
    RIGHT,
    SEES,
    density,
    patch_of,
    point,
    probability,
    samples,
    theory,
)

CONFIDENCE = {RECEIVER: 2, LEFT: 5, RIGHT: 1, BEFORE: 7}
"""M of reservoirs, as so many new samples would give."""

CAP = 6.0
"""Less than M of a past and its new sample, or of all that a pixel resamples."""

STEPS = 20
"""Of bisection: thresholds are known to 2^-20."""

TOLERANCE = 2e-4
"""Relative bias that is rounding: float32 operations round by 6e-8, a dozen of them in
sequence, magnified by at most 1 / 0.04 = 25 in J; thresholds by 1e-6, magnified by what
the rarest patch is drawn with, 1 / 0.02.  Together below 1e-4."""


@dataclass(frozen=True)
class Bias:
    """What is found of a pass.

    Attributes
    ----------
    relative : float; the largest over patches and M, of the patch's solid angle
    patch : int; where it is
    M : float; given which
    """

    relative: float
    patch: int
    M: float


PASSES = ("initial", "temporal", "moved", "spatial", "shade")


def biases(
    backend,
    passes=PASSES,
    nulls="ordinary",
    kind="scattered",
    lit=None,
    made_by="temporal",
):
    """The largest bias of each pass of a whole backend, by name.

    Parameters
    ----------
    passes : tuple of str; those that are looked at
    nulls : 'ordinary' or 'degenerate'; what stands where a ray met nothing
    kind : str; target that is asked for
    lit : (7,) bool, optional; patches that are looked at; all of them
    made_by : 'temporal' or 'initial'; the pass whose reservoirs the others are given
    """
    world = Enumeration(backend, nulls, kind, lit, made_by)
    found = {name: getattr(world, name)() for name in passes if name in PASSES}
    if "spatial" in passes:
        found["spatial with a past"] = world.spatial(with_past=True)
    return found


def worst(found):
    """Name of the pass with the largest bias, and the bias."""
    return max(found.items(), key=lambda item: abs(item[1].relative))


class Enumeration:
    """A backend in the small world.

    Parameters
    ----------
    backend : object; has all passes
    nulls, kind, lit, made_by : as of `biases`
    """

    def __init__(self, backend, nulls, kind, lit=None, made_by="temporal"):
        self._backend, self._nulls, self._kind = backend, nulls, kind
        self._made_by = made_by
        self._lit = np.ones(NULL, bool) if lit is None else lit
        self._made = {who: self._reservoirs(who) for who in CONFIDENCE}

    def initial(self):
        """A new sample alone."""
        cells = np.arange(OUTCOMES)
        given = point(RECEIVER, OUTCOMES) | samples(cells, self._nulls)
        pdf = density(RECEIVER)
        out = self._backend.initial(**given, pdf=pdf, target=self._kind)
        held = out | {"position": given["position"]}
        return bias(held, probability(RECEIVER), self._lit)

    def temporal(self):
        """The past of a pixel that stands still, and a new sample."""
        old, new = _every(2)
        given = point(RECEIVER, len(old)) | self._past(RECEIVER, old) | self._new(new)
        settings = {"target": self._kind, "cap": CAP}
        chance = probability(RECEIVER)[old] * probability(RECEIVER)[new]
        call = _Call(self._backend.temporal, given, settings, {"u": None})
        return bias(*call.integrated(chance), self._lit)

    def moved(self):
        """The past of another point, and a new sample."""
        old, new = _every(2)
        given = point(RECEIVER, len(old)) | point(BEFORE, len(old), "past_")
        given |= self._past(BEFORE, old) | self._new(new)
        given["visible"] = _bits([RECEIVER, BEFORE], [new, old])
        settings = {"target": self._kind, "cap": CAP, "mis": "1/Z"}
        chance = probability(BEFORE)[old] * probability(RECEIVER)[new]
        call = _Call(self._backend.moved, given, settings, {"u": None})
        return bias(*call.integrated(chance), self._lit)

    def spatial(self, with_past=False):
        """What a pixel holds, and two neighbours; or its past, one, and no other."""
        own, first, second = _every(3)
        sources = np.repeat([LEFT, RIGHT], OUTCOMES)
        held = np.concatenate([np.tile(np.arange(OUTCOMES), 2), own])
        rows, start = len(held), len(sources)
        who = np.concatenate([sources, np.full(len(own), RECEIVER)])
        given = _rows_of(lambda w: point(w, rows), who)
        given |= _rows_of(
            lambda w: {name: a[held] for name, a in self._made[w].items()}, who
        )
        past = np.full(rows, NULL)
        past[start:] = second if with_past else NULL
        given |= self._past(RECEIVER, past)
        given["past_M"] = given["past_M"] * (with_past & (np.arange(rows) >= start))
        given["past_W"] = given["past_W"] * (given["past_M"] > 0)
        neighbors = np.full((rows, 2), -1, np.int32)
        neighbors[start:, 0] = first
        neighbors[start:, 1] = -1 if with_past else OUTCOMES + second
        given["neighbors"] = neighbors
        visible = np.zeros((rows, 3), np.uint32)
        other = np.full(len(own), NULL) if with_past else second
        seen = [own, first, other, past[start:]]
        visible[start:] = _bits([RECEIVER, LEFT, RIGHT], seen)
        given["visible"] = visible
        settings = {"target": self._kind, "cap": CAP, "mis": "1/Z"}
        chance = probability(RECEIVER)[own] * probability(LEFT)[first]
        chance *= probability(RECEIVER if with_past else RIGHT)[second]
        numbers = {"u_own": None, "u_neighbors": 2}
        call = _Call(self._backend.spatial, given, settings, numbers, start)
        return bias(*call.integrated(chance), self._lit)

    def shade(self):
        """The color of each patch that the receiver holds, with W = 1."""
        cells = np.flatnonzero(theory().held[RECEIVER])
        rows = len(cells)
        given = point(RECEIVER, rows) | samples(cells) | {"W": np.ones(rows, "f4")}
        color = self._backend.shade(**given)["color"].astype(float)
        f = theory().integrand[RECEIVER, cells]
        off = (color - f).sum(axis=1) / f.sum(axis=1)
        row = int(np.abs(off).argmax())
        return Bias(float(off[row]), int(cells[row]), 1.0)

    def _new(self, cells):
        found = {"new_" + n: a for n, a in samples(cells, self._nulls).items()}
        return found | {"new_pdf": density(RECEIVER)[cells]}

    def _past(self, who, cells):
        return {"past_" + name: a[cells] for name, a in self._made[who].items()}

    def _reservoirs(self, who):
        """What a pixel holds after its first frame, for each outcome, with more M."""
        y = samples(np.arange(OUTCOMES), self._nulls)
        if self._made_by == "initial":
            pdf = density(who)
            given = point(who, OUTCOMES) | y
            out = y | self._backend.initial(**given, pdf=pdf, target=self._kind)
        else:
            out = self._first_frame(who, y)
        found = {n: np.array(out[n]) for n in ("position", "normal", "radiance", "W")}
        return found | {"M": np.asarray(out["M"]) * np.float32(CONFIDENCE[who])}

    def _first_frame(self, who, y):
        """New samples that meet an empty past."""
        nothing = samples(np.full(OUTCOMES, NULL), "degenerate")
        zero = np.zeros(OUTCOMES, "f4")
        given = point(who, OUTCOMES) | {"new_pdf": density(who), "u": zero}
        given |= {"new_" + name: a for name, a in y.items()}
        given |= {"past_" + name: a for name, a in nothing.items()}
        given |= {"past_W": zero, "past_M": zero}
        return self._backend.temporal(**given, target=self._kind, cap=99.0)


def _every(count):
    return np.array(list(product(range(OUTCOMES), repeat=count))).T


def _rows_of(of, who):
    """Buffers of which each row is that of its pixel."""
    all_ = {w: of(w) for w in np.unique(who)}
    names = next(iter(all_.values()))
    return {
        name: np.choose(
            who.reshape(-1, *[1] * (names[name].ndim - 1)),
            [all_.get(w, names)[name] for w in range(len(EYE))],
        )
        for name in names
    }


def _bits(viewers, cells):
    """Who sees which sample: a column each, and a bit each."""
    sees = np.column_stack([SEES, np.zeros(len(SEES), bool)])
    words = np.zeros((len(cells[0]), len(viewers)), np.uint32)
    for column, viewer in enumerate(viewers):
        for bit, cell in enumerate(cells):
            words[:, column] |= sees[viewer][cell].astype(np.uint32) << np.uint32(bit)
    return words


def bias(out, chance, lit):
    """The largest bias of reservoirs, given their M.

    Parameters
    ----------
    out : dict of str to array; position, W and M of N rows
    chance : (N,); of each row, 1 together
    lit : (7,) bool; patches that are looked at
    """
    known, patch = theory(), patch_of(out["position"])
    W, M = out["W"].astype(float), np.round(out["M"].astype(float), 3)
    size, held = known.size[RECEIVER], known.held[RECEIVER]
    found = []
    for m in np.unique(M):
        share = chance * (m == M)
        here = np.bincount(patch, share * W, minlength=OUTCOMES)[:NULL] / share.sum()
        # Confidence 0 is no reservoir at all, and has to bring nothing.
        off = (here / size - (held & (m > 0))) * lit
        x = int(np.abs(off).argmax())
        found.append(Bias(float(off[x]), x, float(m)))
    return max(found, key=lambda one: abs(one.relative))


class _Call:
    """A pass whose random numbers are integrated.

    Parameters
    ----------
    run : callable; the pass
    given, settings : dict; what it is given, but for the numbers
    numbers : dict of str to int or None; how many a row, of each buffer of them
    start : int; first row that is looked at; those before are only read
    """

    def __init__(self, run, given, settings, numbers, start=0):
        self._run, self._given, self._settings = run, given, settings
        self._numbers, self._start = numbers, start
        self._count = sum(n or 1 for n in numbers.values())
        self._rows = len(next(iter(given.values()))) - start

    def integrated(self, chance):
        """Outputs of all outcomes and decisions, and the chance of each."""
        # Most decisions do not depend on those before: one corner shows a threshold.
        boxes = self._boxes(every_corner=False)
        if not self._constant(*boxes):
            boxes = self._boxes(every_corner=True)
        row, low, high = boxes
        out = self._outputs(row, (low + high) / 2)
        return out, chance[row] * (high - low).prod(axis=1)

    def _boxes(self, every_corner):
        """Boxes of numbers that give one answer: their rows, (L,), and (L, D) twice."""
        row, size = np.arange(self._rows), (self._rows, self._count)
        low, high = np.zeros(size), np.ones(size)
        for d in range(self._count):
            edges = self._thresholds(d, every_corner)
            row, low, high = _split(row, low, high, d, *edges)
        return row, low, high

    @cached_property
    def _corners(self):
        """The corners of all numbers, (2^D, D), and the answers there, (N, 2^D, 3)."""
        corners = np.array(list(product([0.0, 1.0], repeat=self._count)))
        row = np.repeat(np.arange(self._rows), len(corners))
        found = self._signature(row, np.tile(corners, (self._rows, 1)))
        return corners, found.reshape(self._rows, len(corners), 3)

    def _constant(self, row, low, high):
        """Whether a box has one answer, as far as four places near its corners show."""
        odd = np.arange(self._count) % 2
        near = np.where([0 * odd, 0 * odd + 1, odd, 1 - odd], 2.0**-6, 1 - 2.0**-6)
        a, *more = (self._signature(row, low + (high - low) * at) for at in near)
        narrow = ((high - low) < 2.0 ** (8 - STEPS)).any(axis=1)
        return not any((_differ(a, b) & ~narrow).any() for b in more)

    def _thresholds(self, d, every_corner):
        """Rows and places where the number d changes an answer."""
        corners, answers = self._corners
        at_low = np.flatnonzero(corners[:, d] == 0)
        at_high = at_low + 2 ** (self._count - 1 - d)
        row = np.repeat(np.arange(self._rows), len(at_low))
        u = np.tile(corners[at_low], (self._rows, 1))
        a, b = (answers[:, at].reshape(-1, 3) for at in (at_low, at_high))
        lows, highs = np.zeros(len(row)), np.ones(len(row))

        def answer(row, u, at):
            v = u.copy()
            v[:, d] = at
            return self._signature(row, v)

        shows = np.flatnonzero(_differ(a, b))
        if not every_corner:
            shows = shows[np.unique(row[shows], return_index=True)[1]]
        row, u, lows, highs, a, b = (v[shows] for v in (row, u, lows, highs, a, b))
        for _ in range(STEPS):
            middle = (lows + highs) / 2
            c = answer(row, u, middle)
            left, right = _differ(a, c), _differ(c, b)

            def halves(first, second, left=left, right=right):
                return np.concatenate([first[left], second[right]])

            row, u = halves(row, row), halves(u, u)
            lows, highs = halves(lows, middle), halves(middle, highs)
            a, b = halves(a, c), halves(c, b)
        found = np.unique(np.stack([row, (lows + highs) / 2], axis=1), axis=0)
        return found[:, 0].astype(int), found[:, 1]

    def _signature(self, row, u):
        out = self._outputs(row, u)
        patch = np.where(out["W"] > 0, patch_of(out["position"]), NULL)
        return np.stack([patch, out["M"], out["W"]], axis=1).astype(float)

    def _outputs(self, row, u):
        """Outputs of so many rows."""
        start = self._start
        take = np.concatenate([np.arange(start), start + row])
        given = {name: array[take] for name, array in self._given.items()}
        u = np.concatenate([np.zeros((start, self._count)), u])
        u, first = np.minimum(u, 1 - 2.0**-24).astype("f4"), 0
        for name, count in self._numbers.items():
            last = first + (count or 1)
            given[name] = u[:, first] if count is None else u[:, first:last]
            first = last
        out = self._run(**given, **self._settings)
        return {name: np.asarray(out[name])[start:] for name in ("position", "W", "M")}


def _differ(a, b):
    """Whether another sample is kept, or with another W or M, than by rounding."""
    weight = np.abs(a[:, 2] - b[:, 2]) > 1e-5 * np.maximum(a[:, 2], b[:, 2])
    return (a[:, :2] != b[:, :2]).any(axis=1) | weight


def _split(row, low, high, d, rows, places):
    """Boxes, cut along the number d at the places of their rows.

    Parameters
    ----------
    rows, places : (E,); sorted by row, then by place
    """
    count = np.bincount(rows, minlength=row.max() + 1)
    first = np.concatenate([[0], np.cumsum(count)[:-1]])
    pieces = count[row] + 1
    box = np.repeat(np.arange(len(row)), pieces)
    n = np.arange(len(box)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    start, edges = first[row[box]] + n, np.append(places, 1.0)
    low, high = low[box], high[box]
    low[:, d] = np.where(n > 0, edges[start - 1], 0.0)
    high[:, d] = np.where(
        n < pieces[box] - 1, edges[np.minimum(start, len(places))], 1.0
    )
    return row[box], low, high

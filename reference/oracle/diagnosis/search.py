"""Which sets of known differences reproduce what a backend gave.

Renderers make several choices at once, and mistakes may come on top.  All sets are too
many to try, but an output hangs on some of the choices alone: M on confidences, W on
these and on target, MIS weights and domain, and the kept sample on the order of the
stream, too.  So a set is found factor by factor: what explains M of a few rows is
widened until it explains W, and that until it explains the choice.  What a set leaves
unexplained of all rows joins the few, and the search begins again.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

from restir_gi.reference.oracle.contract.fields import Precision
from restir_gi.reference.oracle.diagnosis.hypothesis import (
    Hypothesis,
    changes,
    combined,
    compatible,
)
from restir_gi.reference.oracle.diagnosis.sample_rows import EVERYTHING, SampleRows
from restir_gi.reference.oracle.diagnosis.subsets import AskedRows, explained, judged
from restir_gi.reference.oracle.replay.mis import CHAINED
from restir_gi.reference.oracle.replay.reuse import STREAMS
from restir_gi.reference.oracle.replay.rules import Rules
from restir_gi.reference.oracle.replay.target_rules import TargetRules

Set = tuple[Hypothesis, ...]

EMPTY: Set = ()

WIDTHS = (5, 3, 2, 2, 2)
"""Sets that are widened by a first departure, by a second one, and so on."""

FORMULAS = 6
"""Times as many where a pass reuses nothing: its replay takes no time."""

BASES, LIKELY, WIDENED = 3, 12, 3
"""Best sets that a mistake is put on top of; mistakes that may be a second one; and how
many of the sets that come of it are widened once more."""

OPENED = 3
"""Times that sets which make other choices show are widened, whatever they explain."""

ROUNDS, MOST = 4, 4
"""Times that rows are added, and sets that are held against every row each time."""


@dataclass(frozen=True, slots=True, eq=False)
class SetSearch:
    """The answers of a pass, a few of their rows, and what may explain them.

    Attributes
    ----------
    given : sequence of AskedRows; all, those that refute soonest first
    able : sequence of Hypothesis; differences that can show in the pass
    seeds : sequence of tuple of Hypothesis; what explained other passes of the backend
    """

    given: Sequence[AskedRows]
    sample: SampleRows
    able: Sequence[Hypothesis]
    seeds: Sequence[Set] = ()

    @property
    def precision(self) -> Precision:
        """In which the backend calculates."""
        return self.sample.precision

    @property
    def of_stream(self) -> bool:
        """Whether the pass reuses samples."""
        return self.given[0].case.pass_name in STREAMS

    def explains(self, chosen: Set) -> bool:
        """Whether a set reproduces every row of every case."""
        rules = combined(chosen)
        if not self.sample.complete(self.sample.score(rules, (EVERYTHING,))):
            return False
        return all(explained(one, rules, self.precision) for one in self.given)

    def right(self, chosen: Set) -> int:
        """Rows that a set reproduces."""
        rules = combined(chosen)
        found = (judged(one, rules, self.precision)[1] & one.rows for one in self.given)
        return sum(int(right.sum()) for right in found)

    def with_what_is_left(self, chosen: Set) -> "SetSearch | None":
        """The same with rows that a set does not explain; ``None`` if it does."""
        rules = combined(chosen)
        for one in self.given:
            wrong = ~judged(one, rules, self.precision)[1] & one.rows
            if wrong.any():
                return replace(self, sample=self.sample.with_rows(one, wrong))
        return None


def single(search: SetSearch) -> list[Set]:
    """Differences that reproduce every row by themselves."""
    return [(h,) for h in search.able if search.explains((h,))]


def beside(search: SetSearch, base: Set) -> list[Set]:
    """Sets of one difference and all of a base that can hold with it, that explain all.

    A renderer that says what it does has most often one mistake on top: it stands in
    the place of what it was to do, or beside it.
    """
    found = [
        (h, *(b for b in base if compatible((h, b))))
        for h in search.able
        if h not in base
    ]
    return _smallest([one for one in found if compatible(one) and search.explains(one)])


def sets_that_explain(search: SetSearch) -> tuple[list[Set], Set]:
    """Smallest sets that reproduce every row: of departures, or with mistakes on top.

    Beside them, where there is none, the set that was nearest to it.
    """
    nearest = EMPTY
    for _ in range(ROUNDS):
        sets, nearest = _by_factors(search)
        # W of weights that ask who made a sample hangs on the choice, too.
        right = [one for one in (*sets, nearest) if search.explains(one)]
        if right:
            found = _smallest([_needed(search, one) for one in right])
            return found + _twins(search, found), nearest
        closer = search.with_what_is_left(sets[0]) if sets else None
        if closer is None:
            break
        search = closer
    return [], nearest


def _by_factors(search: SetSearch) -> tuple[list[Set], Set]:
    """Sets that explain the few rows, some of the smallest; and the best of all."""
    bases, best = _stored(search), EMPTY
    outputs = (*search.sample.numbers, EVERYTHING)
    for place, output in enumerate(outputs):
        factor = Factor(search, output, outputs[: place + 1])
        bases = factor.widened(bases)
        best = factor.best(1)[0]
        if not bases:
            return [], Factor(search, EVERYTHING, (EVERYTHING,)).nearest(best)
    return bases, best


def _stored(search: SetSearch) -> list[Set]:
    """Sets to begin with: the formats in which reservoirs may be stored.

    No chance makes numbers fit a format: of those that explain as much the one counts
    that says most.
    """
    if not search.of_stream:
        return [()]
    formats: list[Set] = [(h,) for h in search.able if h.departure == "storage"]
    held = {one: search.sample.held(combined(one)) for one in ((), *formats)}
    most = max(held.values())
    return [one for one, share in held.items() if share == most]


@dataclass(slots=True)
class Factor:
    """Sets that are widened until they explain one more output.

    Attributes
    ----------
    output : str; the one that is new
    outputs : tuple of str; those that have to be right
    ranked : dict; sets that were tried, and their scores
    """

    search: SetSearch
    output: str
    outputs: tuple[str, ...]
    ranked: dict[frozenset[str], tuple[float, Set]] = field(default_factory=dict)

    def widened(self, bases: Sequence[Set]) -> list[Set]:
        """Sets that explain the outputs, from those that explain all but the new one.

        Departures come first, then a mistake on top of the best of them, then two.
        """
        departures = [h for h in self.search.able if h.departure and self._hangs_on(h)]
        found = self._tried(bases) or self._tried(self._seeded(bases, departures))
        found = found or self._with_departures(departures)
        found = found or self._with_mistakes(bases, departures)
        found = sorted(found, key=len)
        # All are told that explain everything, though few rows do not tell them apart.
        return found[:MOST] if self.output == EVERYTHING else self._unlike(found, MOST)

    def _seeded(
        self, bases: Sequence[Set], departures: Sequence[Hypothesis]
    ) -> Iterator[Set]:
        """Sets with what explained other passes; orders are soon tried."""
        if self.output != EVERYTHING:
            for seed in self.search.seeds:
                more = tuple(h for h in seed if h in departures)
                yield from ((*base, *more) for base in bases)

    def nearest(self, base: Set) -> Set:
        """The best of a set and of those with one departure more."""
        departures = [h for h in self.search.able if h.departure and self._hangs_on(h)]
        self._tried([base, *((*base, h) for h in departures)])
        return self.best(1)[0]

    def best(self, count: int) -> list[Set]:
        """The best sets, of these the smallest."""
        ranked = sorted(self.ranked.values(), key=lambda s: (-s[0], len(s[1])))
        return self._unlike((one for _, one in ranked), count)

    def _unlike(self, sets: Iterable[Set], count: int) -> list[Set]:
        """The first of sets, and others that are not the same in all the few rows."""
        found: dict[tuple[bytes, ...], Set] = {}
        for one in sets:
            answer = self.search.sample.answer(combined(one), self.outputs)
            found.setdefault(answer, one)
            if len(found) == count:
                break
        return list(found.values())

    def _tried(self, sets: Iterable[Set]) -> list[Set]:
        """Those of sets that explain the few rows."""
        complete = []
        for one in sets:
            key = frozenset(h.name for h in one)
            if key in self.ranked or not compatible(one):
                continue
            score = self.search.sample.score(combined(one), self.outputs)
            self.ranked[key] = score, one
            if self.search.sample.complete(score):
                complete.append(one)
        return complete

    def _top(self) -> float:
        return max(score for score, _ in self.ranked.values())

    def _hangs_on(self, h: Hypothesis) -> bool:
        """Whether the new output hangs on a choice."""
        sample, of_stream = self.search.sample, self.search.of_stream
        if h.departure == "storage":
            return False
        if of_stream and h.departure == "order":
            return self.output == EVERYTHING
        if self.output == EVERYTHING:
            return not any(sample.acts(h.rules, name) for name in sample.numbers)
        return sample.acts(h.rules, self.output)

    def _also(self, base: Set) -> Iterator[Hypothesis]:
        """Departures that a set makes show.

        Merges one by one hang on the order; a scale moves a floor, and factors are in
        one of two targets.
        """
        rules = combined(base)
        chained, other = _is_chained(rules), _shows_more(rules)
        if self.output == EVERYTHING or not _opening(rules):
            return
        for h in self.search.able:
            idle = h.departure == "target" and not self._hangs_on(h)
            if (chained and h.departure == "order") or (other and idle):
                yield h

    def _with_departures(self, departures: Sequence[Hypothesis]) -> list[Set]:
        closer = True
        for place, width in enumerate(WIDTHS):
            before = self._top()
            parents = self.best(self._width(place, width)) if closer else []
            if place < OPENED:
                parents = [*parents, *self._best_that_open()]
            found = self._tried(
                (*s, h) for s in parents for h in (*departures, *self._also(s))
            )
            if found:
                return found
            closer = not place or self._top() > before
        return []

    def _best_that_open(self) -> list[Set]:
        """The best sets that make other choices show, one for each way to do so.

        They may explain less than they hide, until the others are with them.
        """
        found: dict[str, tuple[float, Set]] = {}
        for score, one in self.ranked.values():
            way = _opening(combined(one))
            if way and score > found.get(way, (-1.0, EMPTY))[0]:
                found[way] = score, one
        return [one for _, one in found.values()]

    def _width(self, place: int, width: int) -> int:
        """How many sets are widened for the next time."""
        if not self.search.of_stream:
            return FORMULAS * width
        # A side of u is seen in its own order alone, and there are few of both.
        return len(self.ranked) if self.output == EVERYTHING and place < 2 else width

    def _with_mistakes(
        self, bases: Sequence[Set], departures: Sequence[Hypothesis]
    ) -> list[Set]:
        able = [h for h in self.search.able if not h.departure and self._hangs_on(h)]
        bases, before = (*bases, *self.best(BASES)), self._top()
        found = self._tried((*s, m) for s in bases for m in able)
        if found or self._top() <= before:
            return found
        before, likely = self._top(), self._likely(able)
        mixed = self.best(WIDENED)
        found = self._tried((*s, h) for s in mixed for h in (*departures, *likely))
        if found or self._top() <= before:
            return found
        return self._tried((*s, h) for s in self.best(WIDENED) for h in departures)

    def _likely(self, mistakes: Sequence[Hypothesis]) -> list[Hypothesis]:
        """Mistakes that explain most."""
        score = {h.name: 0.0 for h in mistakes}
        for found, one in self.ranked.values():
            for h in one:
                if h.name in score:
                    score[h.name] = max(score[h.name], found)
        return sorted(mistakes, key=lambda h: -score[h.name])[:LIKELY]


def _is_chained(rules: Rules) -> bool:
    """Whether weights hang on the order."""
    return rules.normalization in CHAINED


def _shows_more(rules: Rules) -> bool:
    """Whether choices show that change nothing in the target that is asked for."""
    return isinstance(rules.target, TargetRules) and rules.target.shows_more


def _opening(rules: Rules) -> str:
    """What makes choices show that do not show without it; empty: nothing."""
    if _is_chained(rules):
        measure = "one measure" if rules.mis_jacobian else "each its own"
        return f"{rules.normalization}, {measure}"
    target = rules.target
    if not isinstance(target, TargetRules) or not target.shows_more:
        return ""
    return "floor" if target.kind == "asked" else target.kind


def _needed(search: SetSearch, chosen: Set) -> Set:
    """A set without what changes nothing in it."""
    for h in chosen:
        rest = tuple(one for one in chosen if one is not h)
        if search.explains(rest):
            return _needed(search, rest)
    return chosen


def _twins(search: SetSearch, sets: Sequence[Set]) -> list[Set]:
    """Sets with one choice exchanged for another value, where that explains all too.

    The cases do not tell them apart then.
    """
    found: dict[frozenset[str], Set] = {}
    before = {frozenset(h.name for h in one) for one in sets}
    for chosen in sets:
        for k, known in enumerate(chosen):
            fields = set(changes(known.rules))
            for h in search.able:
                if h is known or not fields & set(changes(h.rules)):
                    continue
                other = (*chosen[:k], h, *chosen[k + 1 :])
                key = frozenset(one.name for one in other)
                if key in before or key in found or not compatible(other):
                    continue
                if search.explains(other):
                    found[key] = other
    return list(found.values())


def _smallest(sets: Sequence[Set]) -> list[Set]:
    """Those of the least size, each once."""
    least = min(map(len, sets), default=0)
    found = {frozenset(h.name for h in s): s for s in sets if len(s) == least}
    return list(found.values())

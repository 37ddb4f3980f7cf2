"""Differences of pixels by pairs of paths are unbiased: proved by enumeration.

For each sample (x, k) of the paired-pixel domain E[W 1{y = (x, k)}] is its measure, for
reservoirs of both signs and of magnitudes; so that the sum of what they say is
F_i − F_j, in each channel.  Supports are partial, inner and outer shifts fail, and
there are two passes over samples that are shared.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from restir_gi.gradient_domain.after_restir import one_sided
from restir_gi.gradient_domain.gradient_restir import MINUS, PLUS, WHOLE, integrand
from tests.exact import paired as toy
from tests.exact.claims import NOWHERE
from tests.exact.explore import explore
from tests.exact.paired import A, B

UNBIASED = ("1/Z", "balance", "pairwise", "defensive")
each_weight = pytest.mark.parametrize("mis", UNBIASED)
TRUST = {A: 2, B: 5}


@dataclass(frozen=True, slots=True)
class Both:
    """What both pairs keep, for both signs."""

    a_plus: Any
    a_minus: Any
    b_plus: Any
    b_minus: Any

    def of(self, p, sign):
        """Reservoirs of a pair and a sign."""
        name = f"{'ab'[p]}_{'plus' if sign == PLUS else 'minus'}"
        return getattr(self, name).opened(p, sign)


def fresh():
    """New samples of both pairs."""

    def program(rows, uniform):
        kept = []
        for p in (A, B):
            for r in toy.fresh(p, uniform):
                kept.append(toy.closed(p, toy.with_trust(r, TRUST[p])))
        return Both(*kept)

    return explore(program, NOWHERE)


@pytest.fixture(scope="module", name="start")
def _start():
    return fresh()


def faults(law, p, kept):
    """Samples whose measure is not what it should be, and wrong differences."""
    opened = []
    for sign, r in kept:
        found, expected = toy.measured(law, p, sign, r)
        for at, (a, b) in enumerate(zip(found, expected, strict=True)):
            if a != b:
                k, cell = divmod(at, 4)
                yield f"pair {p}, sign {sign}, k = {k}, cell {cell}: {a}, not {b}"
        opened.append(r.opened(p, sign))
    found = toy.expected_difference(law, p, opened)
    if list(found) != list(toy.difference(p)):
        yield f"pair {p}: difference {found}, not {toy.difference(p)}"


# ------------------------------------------------------------ the domain itself


def integral(values_of, p):
    """Over the paired-pixel domain."""
    total = 0
    for k in (0, 1):
        for cell in toy.CELLS:
            s = toy.samples(p, np.array([k]), np.array([cell]), WHOLE)
            measure = toy.MU[s.base.pixel[0], cell]
            total = total + measure * values_of(s.value)[0]
    return list(total)


@pytest.mark.parametrize("p", [A, B])
def test_the_integrand_is_that_of_the_difference(p):
    """Equation 14, with densities."""
    assert integral(integrand, p) == list(toy.difference(p))


@pytest.mark.parametrize("p", [A, B])
def test_targets_in_place_of_densities_make_the_same_difference(p, monkeypatch):
    """Equation 13: any weights that sum to one over both ways do."""
    monkeypatch.setattr(
        "restir_gi.gradient_domain.after_restir.luminance",
        lambda f: f[:, 0] + 2 * f[:, 1],
    )
    assert integral(one_sided, p) == list(toy.difference(p))


def test_the_domain_has_what_it_is_to_have():
    """Both signs, channels of both, inner and outer shifts that fail."""
    delta = [toy.difference(p) for p in (A, B)]
    assert len({tuple(np.sign(d)) for d in delta}) == 2
    s = toy.samples(A, np.zeros(4, int), np.arange(4), WHOLE)
    assert (integrand(s.value)[1] > 0).any()
    assert (integrand(s.value)[1] < 0).any()
    assert s.inner[2] == 0
    lit = toy.F.any(axis=2)
    assert lit[1, 3]
    assert not lit[3, 3]


# ------------------------------------------------------------ passes


SIGN_NAMES = ((PLUS, "plus"), (MINUS, "minus"))


def new_samples(p, law):
    """Faults of what a pair keeps at first."""
    name = "ab"[p]
    kept = [(s, getattr(law.outcomes, f"{name}_{n}")) for s, n in SIGN_NAMES]
    return faults(law, p, kept)


@pytest.mark.parametrize("p", [A, B])
def test_new_samples(p, start):
    """Parts k = 0 and 1 of the domain are disjoint: each has the weight 1."""
    assert list(new_samples(p, start)) == []


def spatial(law, mis, reused, sign):
    """Pair A takes over samples of pair B, for one sign."""

    def program(rows, uniform):
        neighbors = [toy.neighbor(A, A, rows.of(A, sign), sign, sign, same_domain=True)]
        for sign_from in reused(sign):
            neighbors.append(toy.neighbor(A, B, rows.of(B, sign_from), sign, sign_from))
        return toy.closed(A, toy.merged(neighbors, uniform, mis))

    return explore(program, law)


def halves(law, mis, reused):
    """Faults of both signs, and of the difference that they make together."""
    delta = 0
    for sign in (PLUS, MINUS):
        after = spatial(law, mis, reused, sign)
        found, expected = toy.measured(after, A, sign, after.outcomes)
        yield from (
            f"{sign}: {pair}"
            for pair in zip(found, expected, strict=True)
            if pair[0] != pair[1]
        )
        delta = delta + toy.expected_difference(
            after, A, [after.outcomes.opened(A, sign)]
        )
    if list(delta) != list(toy.difference(A)):
        yield f"difference {delta}, not {toy.difference(A)}"


def within(sign):
    return (sign,)


def across(sign):
    return sign, -sign


@each_weight
@pytest.mark.parametrize("reused", [within, across])
def test_one_pass(mis, reused, start):
    assert list(halves(start, mis, reused)) == []


def without_signs(mis):
    """One reservoir of magnitudes a pair."""

    def program(rows, uniform):
        (own,), (other,) = (toy.fresh(p, uniform, (WHOLE,)) for p in (A, B))
        neighbors = [
            toy.neighbor(A, A, own, WHOLE, WHOLE, same_domain=True),
            toy.neighbor(A, B, toy.with_trust(other, 3), WHOLE, WHOLE),
        ]
        return toy.closed(A, toy.merged(neighbors, uniform, mis))

    return explore(program, NOWHERE)


@each_weight
def test_magnitudes(mis):
    law = without_signs(mis)
    assert list(faults(law, A, [(WHOLE, law.outcomes)])) == []


@dataclass(frozen=True, slots=True)
class Pair:
    """What two pairs keep for one sign."""

    a: Any
    b: Any


def chain(mis, sign, frames=3, cap=2):
    """New samples of a pair meet those of its past, over more frames than the cap."""
    law = NOWHERE
    for frame in range(frames):

        def program(rows, uniform, first=(frame == 0)):
            (new,) = toy.fresh(A, uniform, (sign,))
            if not first:
                own = toy.neighbor(A, A, new, sign, sign, same_domain=True)
                before = toy.neighbor(
                    A, A, rows.opened(A, sign), sign, sign, same_domain=True
                )
                new = toy.merged([before, own], uniform, mis, cap)
            return toy.closed(A, new)

        law = explore(program, law)
        yield law


@each_weight
@pytest.mark.parametrize("sign", [PLUS, MINUS])
@pytest.mark.few(1)
def test_a_chain_of_frames(mis, sign):
    for law in chain(mis, sign):
        found, expected = toy.measured(law, A, sign, law.outcomes)
        assert found == expected


def two_passes(mis, sign):
    """A takes over samples of B, and B those that A has now: they share them."""

    def first(rows, uniform):
        new = [toy.fresh(p, uniform, (sign,))[0] for p in (A, B)]
        return Pair(*(toy.closed(p, r) for p, r in zip((A, B), new, strict=True)))

    def swap(rows, uniform, p, q):
        own, other = rows.a.opened(A, sign), rows.b.opened(B, sign)
        mine, theirs = (own, other) if p == A else (other, own)
        neighbors = [
            toy.neighbor(p, p, mine, sign, sign, same_domain=True),
            toy.neighbor(p, q, theirs, sign, sign),
        ]
        kept = toy.closed(p, toy.merged(neighbors, uniform, mis))
        return Pair(kept, rows.b) if p == A else Pair(rows.a, kept)

    law = explore(first, NOWHERE)
    for p, q in ((A, B), (B, A)):
        law = explore(lambda rows, u, p=p, q=q: swap(rows, u, p, q), law)
        yield p, law


@each_weight
@pytest.mark.parametrize("sign", [PLUS, MINUS])
def test_two_passes(mis, sign):
    for p, law in two_passes(mis, sign):
        kept = law.outcomes.a if p == A else law.outcomes.b
        found, expected = toy.measured(law, p, sign, kept)
        assert found == expected


def test_weights_1_m_are_biased_where_signs_differ(start):
    """Who reuses within the sign must ask who could have made a sample."""
    assert list(halves(start, "1/M", within)) != []

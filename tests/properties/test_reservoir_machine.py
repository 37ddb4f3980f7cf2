"""Reservoirs through any history: float64 beside a model in fractions.

The model is Algorithm 1 written out for one row, in plain Python.  Both see the same
inputs, exactly: every float is a fraction.  Where u S and w are closer than their
roundings, either sample may be kept, and the model follows; nowhere else.
"""

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import Phase, settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    invariant,
    precondition,
    rule,
    run_state_machine_as_test,
)

from restir_gi.reference.resampling.reservoir import (
    Candidates,
    cap_confidence,
    finalize,
    initial_candidates,
    merge,
    reused_candidates,
)

U = Fraction(1, 2**53)
"""Largest relative error of one rounding."""

positive = st.floats(2.0**-8, 2.0**8)
maybe_zero = st.one_of(st.just(0.0), positive)
unit = st.integers(0, 2**24 - 1).map(lambda k: k * 2.0**-24)


@dataclass
class Model:
    """One reservoir in fractions; ``steps`` counts the roundings in w of the other."""

    y: int
    p_hat: Fraction
    w: Fraction
    M: Fraction
    steps: int


def row(*numbers):
    return (np.array([number]) for number in numbers)


class Histories(RuleBasedStateMachine):
    """A reservoir that is fed, merged, closed, capped and opened again."""

    merge = staticmethod(merge)

    @initialize(p_hat=maybe_zero, pdf=positive)
    def begin(self, p_hat, pdf):
        """Start with one sample, which may be a null."""
        self.made, self.lit = 0, set()
        self.real, self.model = self.fresh(p_hat, pdf)
        self.closed = None

    def fresh(self, p_hat, pdf):
        """One new sample in both worlds, numbered."""
        y = self.made
        self.made += 1
        if p_hat > 0:
            self.lit.add(y)
        real = initial_candidates(*row(y, p_hat, pdf))
        w = Fraction(p_hat) / Fraction(pdf)
        return real, Model(y, Fraction(p_hat), w, Fraction(1), 1)

    def follow(self, real, model, u):
        """Merge in both worlds; the roles of stream and newcomer as in the kernel."""
        merged = self.merge(self.real, real, np.array([u]))
        a, b = self.model, model
        w, steps = a.w + b.w, max(a.steps, b.steps) + 1
        took_b = merged.y[0] == b.y
        if a.y != b.y:
            margin = abs(Fraction(u) * w - b.w)
            free = margin <= 2 * (steps + 1) * U * max(Fraction(u) * w, b.w)
            if not free or min(a.w, b.w) == 0:
                assert took_b == (Fraction(u) * w < b.w)
        kept = b if took_b else a
        self.real = merged
        self.model = Model(kept.y, kept.p_hat, w, a.M + b.M, steps)

    @precondition(lambda self: self.closed is None)
    @rule(p_hat=maybe_zero, pdf=positive, u=unit)
    def feed(self, p_hat, pdf, u):
        """Update: a new sample competes."""
        self.follow(*self.fresh(p_hat, pdf), u)

    @precondition(lambda self: self.closed is None)
    @rule(p_hats=st.lists(maybe_zero, min_size=1, max_size=3), u=unit, v=unit)
    def feed_a_stream(self, p_hats, u, v):
        """Merge: samples that have competed elsewhere come as one."""
        stream, model = self.fresh(p_hats[0], 1.0)
        mine = self.real, self.model
        self.real, self.model = stream, model
        for p_hat in p_hats[1:]:
            self.follow(*self.fresh(p_hat, 0.5), v)
        other = self.real, self.model
        self.real, self.model = mine
        self.follow(*other, u)

    @precondition(lambda self: self.closed is None)
    @rule(M=st.integers(1, 20))
    def feed_nothing(self, M):
        """A null: M trials that found nothing."""
        null = Candidates(*row(-1, 0.0, 0.0, float(M)))
        self.follow(null, Model(-1, Fraction(0), Fraction(0), Fraction(M), 0), 0.0)

    @precondition(lambda self: self.closed is None)
    @rule()
    def close(self):
        """Finalize with 1/M."""
        self.closed = finalize(self.real, self.real.M)
        m = self.model
        self.W = m.w / m.p_hat / m.M if m.p_hat else Fraction(0)

    @precondition(lambda self: self.closed is not None)
    @rule(cap=st.integers(1, 40))
    def cap(self, cap):
        """Limit M; W stays."""
        self.closed = cap_confidence(self.closed, float(cap))
        self.model.M = min(self.model.M, Fraction(cap))

    @precondition(lambda self: self.closed is not None)
    @rule(p_hat=positive)
    def open_again(self, p_hat):
        """Compete once more, under another target: three more roundings a product."""
        m = self.model
        self.real = reused_candidates(self.closed, np.array([p_hat]))
        m.p_hat, m.w = Fraction(p_hat), Fraction(p_hat) * self.W * m.M
        m.steps += 5
        self.closed = None

    @invariant()
    def both_hold_the_same(self):
        """M exactly, weights to their roundings, and a sample that was fed."""
        if not hasattr(self, "model"):
            return
        m = self.model
        if self.closed is not None:
            assert Fraction(self.closed.M[0]) == m.M
            error = abs(Fraction(self.closed.W[0]) - self.W)
            assert error <= 2 * (m.steps + 2) * U * self.W
            return
        c = self.real
        assert Fraction(c.M[0]) == m.M
        assert abs(Fraction(c.w[0]) - m.w) <= 2 * m.steps * U * m.w
        assert (c.w[0] > 0) == (m.w > 0)
        if m.w > 0:
            assert c.y[0] in self.lit
            assert c.y[0] == m.y
            assert Fraction(c.p_hat[0]) == m.p_hat


SETTINGS = settings(max_examples=40, stateful_step_count=25)

TestHistories = Histories.TestCase
TestHistories.settings = SETTINGS


def by_ratio_to_the_old_sum(a, b, u):
    """Merge that compares with what was there before, not with both together."""
    c = merge(a, b, u)
    kept = b if (u * a.w < b.w).all() else a
    return Candidates(kept.y, kept.p_hat, c.w, c.M)


def counting_hits(a, b, u):
    """Merge that does not count nulls."""
    c = merge(a, b, u)
    return Candidates(c.y, c.p_hat, c.w, np.where(b.w > 0, c.M, a.M))


@pytest.mark.parametrize("wrong", [by_ratio_to_the_old_sum, counting_hits])
def test_control_a_wrong_merge_is_found(wrong):
    class Wrong(Histories):
        merge = staticmethod(wrong)

    # Any counterexample will do: it need not be the simplest.
    quickly = settings(SETTINGS, phases=[Phase.generate], max_examples=2000)
    with pytest.raises(AssertionError):
        run_state_machine_as_test(Wrong, settings=quickly)
